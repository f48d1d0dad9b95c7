// A calibration as text, JSON, law block, report and figure.
#pragma once

#include <string>
#include <vector>

#include "experiment/calibration/calibration.h"
#include "view/picture/image.h"

namespace kerf {

/// Returns the tables of parameters, components and correlations for a terminal.
std::string FormatCalibrationText(const Calibration& calibration);
/// docs/schemas/calibrate.schema.json describes the keys.
std::string FormatCalibrationJson(const Calibration& calibration);
/// Returns the section [force] of a scene, with each parameter's interval as a comment.
std::string FormatLawBlock(const Calibration& calibration);
std::string FormatCalibrationReport(const Calibration& calibration);
/// Draws, for each fitted component, the data with the fit and its 95 % band above the residuals.
Image RenderCalibration(const Calibration& calibration);

/// Throws Error if a result in `folder` would overwrite the data.
void CheckCalibrationInputNotOverwritten(const std::string& data_file, const std::string& folder);
/// Writes law.toml, fit.png, report.md and calibrate.json into `folder` (created if missing), each completely or not at
/// all. Returns their names. Throws Error if a file cannot be written.
std::vector<std::string> WriteCalibration(const Calibration& calibration, const std::string& folder);

}  // namespace kerf
