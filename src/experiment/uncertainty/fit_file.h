// The intervals of a fit that kerf calibrate wrote, for kerf run --uncertain.
#pragma once

#include <string>
#include <vector>

#include "experiment/uncertainty/drawing.h"

namespace kerf {

/// Returns the 95 % intervals of the fitted parameters in a calibrate.json, within the ranges of the parameters: those
/// of the bootstrap if whole specimens were resampled, otherwise those of the t distribution. Parameters that were
/// kept, not determined or fitted as 0 are left out. `file` is used in messages; `edge_radius_um` is that of the
/// scene's tool. Throws kerf::Error if the text is not a calibrate.json, the fit is of another law or edge, a value is
/// not that of `law` to 1e-5 (law.toml states six digits), or an interval does not contain its value.
std::vector<FitInterval> ParseFit(const std::string& text, const std::string& file, const ForceLaw& law,
                                  double edge_radius_um);

}  // namespace kerf
