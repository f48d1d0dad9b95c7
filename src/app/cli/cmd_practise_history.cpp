#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/exit_codes.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/practise_history.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/temporary.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/practise/agents.h"
#include "session/practise/exercises.h"
#include "session/practise/history.h"
#include "session/score/score.h"

namespace kerf::cli {
namespace {

void PrintList(bool json) {
  if (json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const auto exercises : {ListExercises(), ListProcedures()}) {
      for (const Exercise& e : exercises) {
        list.push_back({{"id", e.id}, {"difficulty", e.difficulty}, {"title", e.title}, {"goal", e.goal}});
      }
    }
    fmt::print("{}\n", list.dump(2));
    return;
  }
  for (const Exercise& e : ListExercises()) fmt::print("{}  {:<20} {}: {}\n", e.difficulty, e.id, e.title, e.goal);
  for (const Exercise& e : ListProcedures()) fmt::print("-  {:<20} {}: {}\n", e.id, e.title, e.goal);
}

ScoreSheet Score(const std::string& file, const std::string& bone_file) {
  RecordingReader recording(file);
  ScoreOptions options;
  options.bone_file = bone_file;
  options.stop = &CatchInterrupt();
  StageBars bars;
  return ScoreRecording(recording, options, [&](const std::string& now, double f) { bars.Show(now, f); });
}

/// Scores the recording and adds it to the history. Returns false if the recording is incomplete.
bool HandIn(const PractiseOptions& options) {
  if (options.student.empty()) throw CLI::ValidationError("--hand-in", "requires --student NAME");
  History history(FindHistoryFile());  // opened before the long computation
  const ScoreSheet sheet = Score(options.hand_in, options.bone_file);
  for (const std::string& warning : sheet.warnings) {
    SayWarning("{}: {}", options.hand_in, warning);
  }
  const Attempt attempt = MakeAttempt(sheet, options.student);
  const bool is_new = history.Add(attempt);
  fmt::print("{}", options.json ? FormatSheetJson(sheet) : FormatSheet(sheet));
  Say("{} {}", is_new ? "the attempt was added to" : "this attempt was handed in before; nothing was added to",
      history.file());
  for (const Attempt& kept : history.List(options.student)) {
    if (kept.hash != attempt.hash || kept.student != attempt.student) continue;
    for (const std::string& mark : FindMarks(kept)) SayWarning("{}: marked: {}", options.hand_in, mark);
  }
  return sheet.state == RecordingState::kWhole;
}

/// Returns the keys in `file` and those of the installation.
std::vector<KnownKey> FindKnownKeys(const std::string& file) {
  std::vector<KnownKey> known;
  if (!file.empty()) known = ReadPublicKeys(file);
  try {
    if (const std::optional<SealKey> own = ReadKeyFile()) known.push_back({own->public_key(), "this installation"});
  } catch (const Error& e) {
    SayWarning("{}", e.what());
  }
  return known;
}

/// Runs an agent. `done` is set to true if the agent finished.
LoopSummary RunExercise(const std::string& agent, std::uint64_t seed, const std::string& exercise, int level,
                        double seconds, const std::string& record, std::atomic<bool>& done) {
  const AgentParams params = MakeAgentParams(agent, seed);
  const Exercise done_one = OpenExercise(exercise);
  const Scene scene = MakeExerciseScene(done_one, level);
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = std::min(seconds > 0 ? seconds : CalcAgentTime(params, scene), kMaxLoop_s);
  loop.output.log = LoopLog::kNone;
  loop.output.record = record;
  loop.output.scene_file = done_one.file;
  loop.stop = &done;
  loop.driver.make_hand = MakeAgent(params, scene, &done);
  if (!record.empty()) CheckNewRecording(record);
  StageBars bars;
  return RunLoop(scene, loop, [&](const std::string& now, double f) { bars.Show(now, f); });
}

/// Prints the table of docs/practise.md. For each agent in each exercise, it lists the scored measures and the total,
/// averaged over the seeds.
void PrintAgents(const PractiseOptions& options) {
  const TemporaryFolder folder("kerf_agents");
  fmt::print("| exercise | agent | total | {} |\n|---|---|---|---|\n", "scored measures");
  for (const Exercise& exercise : ListExercises()) {
    if (!options.exercise.empty() && exercise.id != options.exercise) continue;
    for (const std::string_view agent : AgentNames()) {
      std::vector<ScoreSheet> sheets;
      for (int seed = 1; seed <= options.agents; ++seed) {
        const std::string file = fmt::format("{}/{}_{}_{}.kerf", folder.path(), exercise.id, agent, seed);
        std::atomic<bool> done{false};
        RunExercise(std::string(agent), static_cast<std::uint64_t>(seed), exercise.id, options.level, 0, file, done);
        sheets.push_back(Score(file, ""));
        std::filesystem::remove(file);
      }
      const auto mean = [&](const auto& get) {
        double sum = 0;
        for (const ScoreSheet& sheet : sheets) sum += std::abs(get(sheet).value_or(0));
        return sum / static_cast<double>(sheets.size());
      };
      const SceneExercise& e = MakeExerciseScene(exercise.id, 1).exercise;
      std::string values =
          fmt::format("cut_share {:.2f}", mean([](const ScoreSheet& s) { return s.Get("cut_share"); }));
      for (const Goal& goal : GoalsOf(e.kind)) {
        values += fmt::format(", {} {:.3g}", goal.key, mean([&](const ScoreSheet& s) { return s.Get(goal.key); }));
      }
      fmt::print("| {} | {} | {:.1f} | {} |\n", exercise.id, agent, mean([](const ScoreSheet& s) { return s.total; }),
                 values);
      std::fflush(stdout);
    }
  }
}

void RunAgent(const PractiseOptions& options) {
  if (options.exercise.empty()) throw CLI::ValidationError("--agent", "requires --exercise ID");
  std::atomic<bool> done{false};
  const LoopSummary summary =
      RunExercise(options.agent, options.seed, options.exercise, options.level, options.seconds, options.record, done);
  if (summary.recorded && !summary.recorded->failure.empty()) throw Error(summary.recorded->failure);
  for (const std::string& warning : summary.warnings) SayWarning("{}", warning);
  if (!done) SayWarning("the agent did not finish within {:.1f} s", summary.simulated_s);
  fmt::print("{} did {} at level {} in {:.1f} s and removed {:.2f} mm3\n", options.agent, options.exercise,
             options.level, summary.simulated_s, summary.removed_mm3);
}

}  // namespace

void AddPractiseHistoryOptions(CLI::App& command, PractiseOptions& options) {
  command.add_flag("--list", options.list, "List the exercises");
  command.add_flag("--history", options.history, "List the attempts that were handed in");
  command.add_option("--student", options.student, "Name of the student");
  CLI::Option* report =
      command.add_option("--report", options.report, "Write the teacher's page: curves and attempts (.html)");
  command
      .add_option("--keys", options.keys,
                  "With --report: file of public keys, one per line, each followed by its owner's name")
      ->needs(report);
  CLI::Option* hand_in =
      command.add_option("--hand-in", options.hand_in, "Score a recording and keep it as an attempt of --student");
  command.add_option("--bone", options.bone_file, "With --hand-in: bone file of the recording, if it was moved (.vdb)")
      ->needs(hand_in);
  command.add_option("--exercise", options.exercise,
                     "Id of the exercise (see --list), or a scene with [exercise] (.toml)");
  AddNumberOption(command, "--level", options.level, "level", FindRange<SceneExercise>("level"),
                  "level of the exercise, from all aids to none")
      ->capture_default_str();
  CLI::Option* agent = command.add_option(
      "--agent", options.agent, "Let a synthetic novice, intermediate or expert do the exercise in virtual time");
  AddNumberOption(command, "--agents", options.agents, "agents", Range{1, 100},
                  "let all three agents do every exercise, or --exercise, with this many seeds each; print a Markdown "
                  "table");
  AddNumberOption(command, "--seed", options.seed, "seed", Range{0, 1e9}, "seed of the agent's errors and tremor")
      ->needs(agent)
      ->capture_default_str();
  AddNumberOption(command, "--seconds", options.seconds, "seconds", Range{0, kMaxLoop_s},
                  "time limit of the agent; 0: until it has finished")
      ->needs(agent);
  command
      .add_option("--record", options.record,
                  "With --agent: record the session into this file, which must not exist yet (see 'kerf replay')")
      ->needs(agent);
  CLI::Option* json = command.add_flag("--json", options.json, "Print as JSON");
  command.add_flag("--csv", options.csv, "Print as CSV: the history")->excludes(json);
}

bool WantsPractiseHistory(const PractiseOptions& options) {
  return options.list || options.history || !options.report.empty() || !options.hand_in.empty() ||
         !options.agent.empty() || options.agents > 0;
}

int RunPractiseHistory(const PractiseOptions& options) {
  if (!options.report.empty()) {
    if (std::filesystem::path(options.report).extension() != ".html") {
      throw CLI::ValidationError("--report", fmt::format("'{}' must end in .html", options.report));
    }
    CheckInputsNotOverwritten({FindHistoryFile(), options.hand_in}, {options.report});
  }
  if (options.list) PrintList(options.json);
  if (options.agents > 0) PrintAgents(options);
  if (!options.agent.empty()) RunAgent(options);
  const bool is_whole = options.hand_in.empty() || HandIn(options);
  if (options.history) {
    const std::vector<Attempt> attempts = History(FindHistoryFile()).List(options.student);
    fmt::print("{}", options.json  ? FormatHistoryJson(attempts)
                     : options.csv ? FormatHistoryCsv(attempts)
                                   : FormatHistory(attempts));
  }
  if (!options.report.empty()) {
    CheckWritable(options.report);
    WriteTextFile(options.report,
                  FormatTeacherPage(History(FindHistoryFile()).List(options.student), FindKnownKeys(options.keys)));
  }
  if (!is_whole) throw ReadDamaged();
  return 0;
}

}  // namespace kerf::cli
