#include "view/picture/mm_grid.h"

#include <array>
#include <cmath>

namespace kerf {

MmGrid ChooseMmGrid(double pixels_per_mm, double line_pixels, double number_pixels) {
  MmGrid grid{0, 0};
  for (double power = 1; grid.number_mm == 0 && power < 1e12; power *= 10) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double step_mm = factor * power;
      if (grid.line_mm == 0 && step_mm * pixels_per_mm >= line_pixels) grid.line_mm = step_mm;
      // Numbers must lie on lines: 5 is not a multiple of 2.
      if (grid.line_mm > 0 && step_mm * pixels_per_mm >= number_pixels && IsMultiple(step_mm, grid.line_mm)) {
        grid.number_mm = step_mm;
        break;
      }
    }
  }
  return grid;
}

std::vector<double> ListMultiples(double step_mm, double lower_mm, double upper_mm) {
  std::vector<double> multiples;
  for (double i = std::ceil(lower_mm / step_mm); i * step_mm <= upper_mm; i += 1) multiples.push_back(i * step_mm);
  return multiples;
}

bool IsMultiple(double value_mm, double step_mm) {
  return std::abs(std::remainder(value_mm, step_mm)) < 1e-6 * step_mm;
}

const char* NamePatientAxis(int axis) {
  return std::array{"x (mm), right to left", "y (mm), front to back",
                    "z (mm), feet to head"}[static_cast<std::size_t>(axis)];
}

}  // namespace kerf
