// Volumes as a person writes them.
#pragma once

#include <string>

namespace kerf {

/// "27.00 cm3", "115 mm3", "0.0042 mm3".
std::string FormatVolume(double mm3);

}  // namespace kerf
