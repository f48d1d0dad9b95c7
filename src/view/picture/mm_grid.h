// Round coordinates along the axes of a picture.
#pragma once

#include <vector>

namespace kerf {

/// Grid with lines at multiples of `line_mm` and numbers at multiples of `number_mm`.
struct MmGrid {
  double line_mm;
  double number_mm;
};

/// Returns the finest grid of 1, 2, 5, 10, 20, ... mm whose lines are at least `line_pixels` apart and whose numbers
/// are at least `number_pixels` apart.
MmGrid ChooseMmGrid(double pixels_per_mm, double line_pixels, double number_pixels);

/// Returns the multiples of `step_mm` from `lower_mm` to `upper_mm`.
std::vector<double> ListMultiples(double step_mm, double lower_mm, double upper_mm);
/// Returns true if `value_mm` is a multiple of `step_mm`, except for rounding.
bool IsMultiple(double value_mm, double step_mm);

/// Returns the name of a patient axis 0 to 2 (LPS): "x (mm), right to left".
const char* NamePatientAxis(int axis);

}  // namespace kerf
