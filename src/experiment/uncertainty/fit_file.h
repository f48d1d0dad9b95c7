// The intervals of a fit that kerf calibrate wrote, for kerf run --uncertain.
#pragma once

#include <string>
#include <vector>

#include "experiment/uncertainty/drawing.h"

namespace kerf {

/// Returns the 95 % intervals of the fitted parameters in a calibrate.json, within the ranges of the parameters: those
/// of the bootstrap if whole specimens were resampled, otherwise those of the t distribution. Parameters that were kept
/// or not determined, or that have no interval, are left out. `file` is used in messages. Throws kerf::Error if the
/// text is not a calibrate.json, the fit is of another law, or a fitted value is not that of `law` to 1e-5: law.toml
/// states six digits.
std::vector<FitInterval> ParseFit(const std::string& text, const std::string& file, const ForceLaw& law);

}  // namespace kerf
