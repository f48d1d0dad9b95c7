// kerf validate: the force laws compared with published measurements.
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/progress.h"
#include "base/files/folder_lock.h"
#include "experiment/validation/measured_sets.h"
#include "experiment/validation/validation.h"
#include "experiment/validation/validation_files.h"
#include "kerf/error.h"
#include "session/run/run_scene.h"
#include "session/scene/scene.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

struct ValidateArguments {
  std::string folder = "out/validate";
  std::string scene;
  std::vector<std::string> laws;
  std::string sets;
  bool json = false;
};

void PrintValidation(const Validation& v, const std::vector<std::string>& files, const std::string& folder) {
  fmt::print("Force laws compared with {} of {} sets of published measurements; the others give no value or trend\n",
             v.CountComparedSets(), v.sets.size());
  const auto of = [](int part, int whole) { return whole > 0 ? fmt::format("{} of {}", part, whole) : "-"; };
  TextTable table({"law", "values that agree", "trends that are right", "calibration: values", "calibration: trends"});
  for (const LawCounts& c : v.counts) {
    table.Add({v.names[c.law], of(c.values_agree, c.values), of(c.trends_right, c.trends),
               of(c.calibration_values_agree, c.calibration_values),
               of(c.calibration_trends_right, c.calibration_trends)});
  }
  fmt::print("{}", table.FormatTerminal("  "));
  fmt::print(
      "  values: within 2 standard deviations or inside the range; calibration: sets from which the law's "
      "parameters were derived\n");
  if (!v.names.empty() && v.names.back() != v.laws.back().name()) {
    fmt::print("  {}: a law with values of its own counts as calibrated from no set\n", v.names.back());
  }
  fmt::print("  results   {}/:", folder);
  for (const std::string& file : files) fmt::print(" {}", file);
  fmt::print("\n");
}

void Run(const ValidateArguments& options) {
  RequirePictures();
  std::vector<ForceLaw> laws;
  try {
    laws = ChooseLaws(options.laws);
  } catch (const Error& e) {
    throw CLI::ValidationError("--laws", e.what());
  }
  std::optional<SceneLaw> scene_law;
  if (!options.scene.empty()) {
    const Scene scene = ReadScene(options.scene);
    scene_law = SceneLaw{scene.name, scene.force};
    CheckValidationInputsNotOverwritten(ListInputs(scene, options.scene), options.folder);
  }
  const std::vector<MeasuredSet> sets = options.sets.empty() ? BuiltInSets() : ReadSets(options.sets);
  const FolderLock lock(options.folder);  // taken before the long computation
  Validation validation;
  {
    ProgressBar bar("comparing");
    validation = CompareWithMeasurements(
        laws, sets, [&](double fraction) { bar.Show(fraction); }, scene_law);
  }
  const std::vector<std::string> files = WriteValidation(validation, options.folder);
  if (options.json) {
    fmt::print("{}", FormatValidationJson(validation));
  } else {
    PrintValidation(validation, files, options.folder);
  }
}

}  // namespace

void AddValidateCommand(CLI::App& app) {
  const auto options = std::make_shared<ValidateArguments>();
  CLI::App* command = app.add_subcommand(
      "validate", "Compare the force laws with published measurements, set by set; a report, not a verdict");
  command->add_option("scene", options->scene,
                      "Scene whose force law is compared too, with the values and the table of its [force]");
  command->add_option("-o,--output", options->folder, "Folder for report, figures, CSV and JSON; created if missing")
      ->capture_default_str();
  command
      ->add_option("--laws", options->laws,
                   "Force laws to compare, separated by commas, with their default parameters; default: all")
      ->delimiter(',')
      ->allow_extra_args(false);
  command->add_option("--sets", options->sets,
                      "Folder with further sets of measurements (NAME.toml, docs/formats.md); a set replaces the "
                      "built-in one of the same name");
  command->add_flag("--json", options->json, "Print as JSON (validate.json)");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
