// Numbers as text for messages.
#pragma once

#include <cstddef>
#include <string>

namespace kerf {

/// Formats a volume: "27.00 cm3", "115 mm3", "0.0042 mm3".
std::string FormatVolume(double mm3);

/// A volume as users see it: cubic centimetres from 1 cm^3 on, cubic millimetres below.
struct ShownVolume {
  double value = 0;
  int decimals = 0;
  const char* unit = "";
};
ShownVolume ChooseVolumeUnit(double mm3);

/// Formats three significant digits, or a whole number from 100 on: "2.98", "0.0312", "1234". Uses an exponent only
/// below 1e-6.
std::string ShowThree(double value);

/// Formats whole millimetres: "118 mm", never "-0 mm"; "more than 1 km" or "less than -1 km" for implausible values.
std::string FormatLength(double mm);

/// Formats a count with its noun: "1 slice", "3 slices".
std::string FormatCount(std::size_t count, const std::string& one, const std::string& many);

}  // namespace kerf
