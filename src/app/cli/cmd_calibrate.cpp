// kerf calibrate: fits a force law to measured forces.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "experiment/calibration/calibration.h"
#include "experiment/calibration/calibration_files.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

struct CalibrateArguments {
  std::string data;
  std::string law = ListLinearLaws().front();
  std::vector<std::string> settings;
  std::string folder;
  CalibrationParams params;
  bool json = false;
};

/// Applies "key=value".
void ApplySetting(const std::string& setting, LinearLaw& law, CalibrationParams& params) {
  const std::size_t at = setting.find('=');
  const auto value = at == std::string::npos ? std::nullopt : ParseNumber(setting.substr(at + 1));
  if (!value) {
    throw CLI::ValidationError(
        "--set", fmt::format("'{}' must be key=value with a number, such as crossover_share=0.25", setting));
  }
  const std::string key = setting.substr(0, at);
  try {
    law.Set(key, *value);
  } catch (const Error& e) {
    throw CLI::ValidationError("--set", e.what());
  }
  if (key == "crossover_share") params.keep_crossover = true;
}

Calibration Calibrate(const LinearLaw& law, const Measurements& data, const CalibrationParams& params,
                      const std::string& name) {
  ProgressBar bar("bootstrap");
  return CalibrateLaw(law, data, params, name, [&bar](double fraction) { bar.Show(fraction); });
}

void Run(CalibrateArguments options) {
  LinearLaw law = MakeLinearLaw(options.law);  // CLI11 has checked the name
  for (const std::string& setting : options.settings) ApplySetting(setting, law, options.params);
  if (!options.folder.empty()) CheckCalibrationInputNotOverwritten(options.data, options.folder);
  const Measurements data = ParseMeasurements(ReadTextFile(options.data), options.data);
  const std::string name = std::filesystem::path(options.data).filename().string();
  const Calibration calibration = Calibrate(law, data, options.params, name);
  std::vector<std::string> files;
  if (!options.folder.empty()) {
    const FolderLock lock(options.folder);
    files = WriteCalibration(calibration, options.folder);
  }
  for (const std::string& warning : calibration.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatCalibrationJson(calibration));
    return;
  }
  fmt::print("{}", FormatCalibrationText(calibration));
  if (files.empty()) {
    fmt::print("\n{}", FormatLawBlock(calibration));
  } else {
    fmt::print("  results   {}/: {}\n", options.folder, fmt::join(files, " "));
  }
}

}  // namespace

void AddCalibrateCommand(CLI::App& app) {
  const auto options = std::make_shared<CalibrateArguments>();
  CLI::App* command = app.add_subcommand(
      "calibrate",
      "Fit the parameters of a force law to measured forces, with their uncertainty, and print them for a "
      "scene");
  command
      ->add_option("DATA", options->data,
                   "Measured forces (CSV): bite_mm, width_mm, and thrust_N, cutting_N or torque_N_mm")
      ->required();
  command->add_option("--law", options->law, "The law")->check(CLI::IsMember(ListLinearLaws()))->capture_default_str();
  command->add_option("--set", options->settings,
                      "Value of a parameter that is not fitted, as key=value; may be given several times; keys: "
                      "crossover_share, edge_radius_um, reference_E_star_MPa; default: the law's");
  AddNumber(*command, "--bootstrap", options->params, "bootstrap")->capture_default_str();
  AddNumber(*command, "--seed", options->params, "seed")->capture_default_str();
  command->add_option("-o,--output", options->folder,
                      "Folder for law block, figure, report and JSON; created if missing; default: none");
  command->add_flag("--json", options->json, "Print as JSON (calibrate.json)");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
