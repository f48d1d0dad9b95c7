#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/log_columns.h"
#include "app/cli/message.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "loop/record/seal.h"

namespace kerf::cli {
namespace {

struct LogArguments {
  std::string file;
  std::string output;
  bool csv = false;
  bool ticks = false;
  bool json = false;
  bool make_key = false;
  bool show_key = false;
  std::string key_file;
};

/// Writes the CSV block by block, so that it need not fit in memory.
template <typename Put>
void WriteCsv(const LogArguments& options, RecordingReader& recording, Put&& put) {
  put((options.ticks ? CsvHeader(LogTickColumns()) : CsvHeader(LogStateColumns())) + "\n");
  const double rate_hz = recording.header().rate_hz;
  std::uint64_t step = 0;
  double time_s = 0;
  RecordedBlock block;
  for (std::size_t i = 0; recording.ReadBlock(i, block); ++i) {
    std::string csv;
    const auto add = [&csv](const auto& columns, const auto& row) {
      AppendCsv(columns, row, csv);
      csv += '\n';
    };
    if (options.ticks) {
      // If steps are missing, number and time continue after the gap.
      if (block.first_step != step) time_s = block.first_time_s;
      step = block.first_step;
      for (const RecordedStep& s : block.steps) {
        time_s += CalcElapsed(s, rate_hz);
        add(LogTickColumns(), LogTickRow{++step, time_s, s});
      }
    } else {
      for (const RecordedState& s : block.states) {
        add(LogStateColumns(), LogStateRow{s, block.steps[static_cast<std::size_t>(s.step - block.first_step)]});
      }
    }
    put(csv);
  }
}

/// Returns the keys whose signatures are recognised: those of this installation and those in the given file.
std::vector<KnownKey> ListKeys(const LogArguments& options) {
  std::vector<KnownKey> keys = ListOwnKeys();
  if (options.key_file.empty()) return keys;
  const std::vector<KnownKey> more = ReadPublicKeys(options.key_file);
  keys.insert(keys.begin(), more.begin(), more.end());
  return keys;
}

/// With --key, accepts only a recording that was signed by one of these keys and has not been changed since.
void CheckSigner(const LogArguments& options, const RecordingReader& recording) {
  if (options.key_file.empty()) return;
  const RecordingSeal& seal = recording.seal();
  for (const KnownKey& known : ReadPublicKeys(options.key_file)) {
    if (seal.is_whole && seal.signer == known.key) return;
  }
  throw Error(fmt::format("{}: is not signed by a key in {}: {}", options.file, options.key_file,
                          DescribeSeal(seal, ListOwnKeys())));
}

void PrintSummary(RecordingReader& recording, const std::vector<KnownKey>& keys) {
  const RecordingHeader& header = recording.header();
  fmt::print("{}\n", header.scene_name);
  fmt::print("  kind      {} of {}\n", ToString(header.kind),
             header.scene_file.empty() ? header.scene_name : header.scene_file);
  fmt::print("  recorded  {} by kerf {} ({}, {})\n", header.created, header.version, header.commit, header.compiler);
  if (!header.IsReplayable()) fmt::print("  replay    only by a build of that commit: forces have changed since\n");
  fmt::print("  machine   {}\n", header.machine);
  if (!header.taken_up_from.empty()) fmt::print("  resumed   from {}\n", header.taken_up_from);
  fmt::print("  bone      {:016x} at {:g} mm voxels\n", header.bone_hash, header.voxel_mm);
  fmt::print(
      "  holds     {:.3f} s at {:g} Hz, {} ticks, {:.1f} kB: {:.2f} MB a minute\n", recording.duration_s(),
      header.rate_hz, recording.steps(), 1e-3 * static_cast<double>(recording.file_bytes()),
      recording.duration_s() > 0 ? 60e-6 * static_cast<double>(recording.file_bytes()) / recording.duration_s() : 0);
  for (const auto& [name, bytes] : recording.ReadFiles()) {
    fmt::print("  file      {}: {} bytes\n", name, bytes.size());
  }
  for (const RecordedEvent& event : recording.events()) {
    fmt::print("  event     {:.3f} s: {} {}\n", event.time_s, event.what, event.name);
  }
  const std::string damage = recording.DescribeDamage();
  if (recording.end()) fmt::print("  end       {}\n", recording.end()->why);
  fmt::print("  seal      {}\n", DescribeSeal(recording.seal(), keys));
  if (!damage.empty()) fmt::print("  damage    {}\n", damage);
}

void PrintJson(RecordingReader& recording) {
  const RecordingHeader& header = recording.header();
  nlohmann::ordered_json json{{"file", recording.path()},
                              {"kind", ToString(header.kind)},
                              {"scene", header.scene_name},
                              {"scene_file", header.scene_file},
                              {"created", header.created},
                              {"version", header.version},
                              {"commit", header.commit},
                              {"machine", header.machine},
                              {"goes_on_from", header.taken_up_from},
                              {"bone_hash", fmt::format("{:016x}", header.bone_hash)},
                              {"voxel_mm", header.voxel_mm},
                              {"rate_hz", header.rate_hz},
                              {"duration_s", recording.duration_s()},
                              {"steps", recording.steps()},
                              {"bytes", recording.file_bytes()},
                              {"state", ToString(recording.damage().state)},
                              {"damage", recording.DescribeDamage()}};
  const RecordingDamage& damage = recording.damage();
  json["lost"] = {
      {"steps", damage.lost_steps}, {"blocks", damage.lost_blocks}, {"gaps", nlohmann::ordered_json::array()}};
  for (const LostSteps& gap : damage.gaps) {
    json["lost"]["gaps"].push_back(
        {{"first_step", gap.first_step}, {"steps", gap.count}, {"from_s", gap.from_s}, {"to_s", gap.to_s}});
  }
  const RecordingSeal& seal = recording.seal();
  json["seal"] = {
      {"chained", seal.is_chained}, {"broken", seal.is_broken}, {"whole", seal.is_whole}, {"signer", seal.signer}};
  json["inputs"] = nlohmann::ordered_json::array();
  for (const auto& [name, bytes] : recording.ReadFiles()) json["inputs"].push_back(name);
  json["events"] = nlohmann::ordered_json::array();
  for (const RecordedEvent& e : recording.events()) {
    json["events"].push_back(
        {{"time_s", e.time_s}, {"step", e.step}, {"what", e.what}, {"name", e.name}, {"number", e.number}});
  }
  if (const std::optional<RecordingEnd>& end = recording.end()) {
    json["end"] = {{"why", end->why}, {"force_hash", fmt::format("{:016x}", end->force_hash)}};
    if (end->bone_hash) json["end"]["bone_hash"] = fmt::format("{:016x}", *end->bone_hash);
  }
  fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void ShowKey(const LogArguments& options) {
  const std::optional<SealKey> key = options.make_key ? MakeKeyFile() : ReadKeyFile();
  if (!key) throw Error(fmt::format("{}: there is no key; 'kerf log --make-key' makes one", FindKeyFile()));
  fmt::print("{}\n", FormatPublicKey(key->public_key()));
  if (options.make_key) Say("recordings made from now on are signed with the key in {}", FindKeyFile());
}

void WriteCsv(const LogArguments& options, RecordingReader& recording) {
  if (options.output.empty()) {
    WriteCsv(options, recording, [](const std::string& text) { fmt::print("{}", text); });
    return;
  }
  CheckInputsNotOverwritten({options.file}, {options.output});
  CheckWritable(options.output);
  GrowingFile csv(options.output);
  WriteCsv(options, recording, [&](const std::string& text) { csv.Append(text); });
  csv.Commit();
}

void Run(const LogArguments& options) {
  if (options.make_key || options.show_key) {
    if (!options.file.empty()) throw CLI::ValidationError("--make-key and --show-key", "take no recording");
    ShowKey(options);
    return;
  }
  if (options.file.empty()) throw CLI::RequiredError("FILE");
  if (!options.csv && !options.output.empty()) throw CLI::ValidationError("-o", "requires --csv");
  RecordingReader recording(options.file);
  const std::vector<KnownKey> keys = ListKeys(options);  // read before any output
  if (options.json) {
    PrintJson(recording);
  } else if (options.csv) {
    WriteCsv(options, recording);
  } else {
    PrintSummary(recording, keys);
  }
  if (const std::string& damage = recording.DescribeDamage(); !damage.empty()) {
    SayWarning("{}: {}", options.file, damage);
  }
  CheckSigner(options, recording);
  if (recording.damage().state != RecordingState::kWhole) throw ReadDamaged();
}

}  // namespace

void AddLogCommand(CLI::App& app) {
  const auto options = std::make_shared<LogArguments>();
  CLI::App* command = app.add_subcommand("log",
                                         "Show the contents of a recording, as text, CSV or JSON. Exit code 3: the "
                                         "readable part is shown, but the recording is damaged or cut short");
  command->add_option("FILE", options->file, "Recording (made by --record)");
  CLI::Option* csv = command->add_flag("--csv", options->csv,
                                       "Print as CSV, a hundred rows a second: handle, tool, force, removed volume; "
                                       "'kerf replay -o' writes the forces of every tick");
  command->add_flag("--ticks", options->ticks, "With --csv: the exact inputs of each tick")->needs(csv);
  command->add_flag("--json", options->json, "Print as JSON: header, inputs, events and end")->excludes(csv);
  command->add_option("-o,--output", options->output, "File for the CSV; default: stdout");
  command->add_option("--key", options->key_file,
                      "File of public keys, one per line as --show-key prints it, optionally followed by a name; exit "
                      "with 1 if the recording is not sealed and signed by one of them");
  CLI::Option* make =
      command->add_flag("--make-key", options->make_key,
                        "Make this installation's key, which signs all its later recordings, in kerf/recording.key of "
                        "$XDG_CONFIG_HOME or ~/.config, and print its public half");
  command->add_flag("--show-key", options->show_key, "Print the public half of this installation's key")
      ->excludes(make);
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
