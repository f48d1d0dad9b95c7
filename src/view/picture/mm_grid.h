// Round coordinates along the axes of a picture.
#pragma once

#include <vector>

namespace kerf {

/// Lines lie at multiples of `line_mm`, numbers stand at multiples of `number_mm`.
struct MmGrid {
  double line_mm;
  double number_mm;
};

/// The finest grid of 1, 2, 5, 10, 20, ... mm whose lines are at least `line_pixels` and whose numbers at least
/// `number_pixels` apart.
MmGrid ChooseMmGrid(double pixels_per_mm, double line_pixels, double number_pixels);

/// The multiples of `step_mm` from `lower_mm` to `upper_mm`.
std::vector<double> ListMultiples(double step_mm, double lower_mm, double upper_mm);
/// Whether `value_mm` is a multiple of `step_mm`, but for rounding.
bool IsMultiple(double value_mm, double step_mm);

/// "x (mm), right to left": what a patient's axis 0 to 2 (LPS) is called.
const char* NamePatientAxis(int axis);

}  // namespace kerf
