// Numbers in messages as a person writes them.
#pragma once

#include <cstddef>
#include <string>

namespace kerf {

/// "27.00 cm3", "115 mm3", "0.0042 mm3".
std::string FormatVolume(double mm3);

/// Whole millimetres: "118 mm", never "-0 mm"; "more than 1 km" for what no file means to say.
std::string FormatLength(double mm);

/// "1 slice", "3 slices".
std::string FormatCount(std::size_t count, const std::string& one, const std::string& many);

}  // namespace kerf
