// kerf score: computes the score of a recording.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/message.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "session/run/run_scene.h"
#include "session/run/session_recorder.h"
#include "session/score/score.h"

namespace kerf::cli {
namespace {

struct ScoreArguments {
  std::string file;
  std::string bone_file;
  std::string page;
  bool json = false;
  bool csv = false;
  bool measures = false;
};

void Run(const ScoreArguments& options) {
  if (options.measures) {
    fmt::print("{}", FormatMeasuresMarkdown());
    return;
  }
  if (options.file.empty()) throw CLI::RequiredError("FILE");
  if (!options.page.empty()) {
    CheckInputsNotOverwritten({options.file, options.bone_file}, {options.page});
    CheckWritable(options.page);
  }
  RecordingReader recording(options.file);
  if (!options.page.empty()) {
    CheckInputsNotOverwritten(ListInputs(OpenRecordedScene(recording, options.bone_file).scene, options.file),
                              {options.page});
  }
  ScoreOptions score;
  score.bone_file = options.bone_file;
  score.stop = &CatchInterrupt();
  ScoreSheet sheet;
  {
    StageBars bars;
    sheet = ScoreRecording(recording, score, [&](const std::string& now, double f) { bars.Show(now, f); });
  }
  for (const std::string& warning : sheet.warnings) {
    SayWarning("{}: {}", options.file, warning);
  }
  if (!options.page.empty()) WriteTextFile(options.page, FormatSheetHtml(sheet));
  fmt::print("{}", options.json ? FormatSheetJson(sheet) : options.csv ? FormatSheetCsv(sheet) : FormatSheet(sheet));
  if (recording.damage().state != RecordingState::kWhole) throw ReadDamaged();
}

}  // namespace

void AddScoreCommand(CLI::App& app) {
  const auto options = std::make_shared<ScoreArguments>();
  CLI::App* command = app.add_subcommand("score",
                                         "Measure the cut of a recording, and score it if its scene is an exercise "
                                         "(docs/practise.md). Exit code 3: the recording is damaged or cut short");
  command->add_option("FILE", options->file, "Recording (made by --record)");
  command->add_option("--bone", options->bone_file, "Bone file of the recording, if it was moved (.vdb)");
  command->add_option("-o,--output", options->page, "File for a report to open in a browser (.html)");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--csv", options->csv, "Print as CSV: key,name,unit,value,scored,weight,points")->excludes(json);
  command->add_flag("--measures", options->measures,
                    "Print the definitions of the measures as Markdown: formula and evidence");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
