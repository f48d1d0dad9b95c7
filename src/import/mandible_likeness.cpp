#include "import/mandible_likeness.h"

#include <fmt/format.h>

#include <algorithm>

namespace kerf {

namespace {

std::string Outside(const char* what, double value, double lower, double upper, const char* unit) {
  if (value < lower) return fmt::format("its {} of {:.0f} {} is below {:.0f}", what, value, unit, lower);
  if (value > upper) return fmt::format("its {} of {:.0f} {} is above {:.0f}", what, value, unit, upper);
  return "";
}

}  // namespace

MandibleLikeness CheckMandibleLikeness(const Volume& lattice, const std::vector<std::int32_t>& labels,
                                       std::int32_t label, const Component& component) {
  MandibleLikeness shape;
  const Vec3 size = component.box_W.size();
  const auto object = [&shape](const std::string& text) {
    if (shape.objection.empty()) shape.objection = text;
  };
  object(Outside("volume", component.volume_mm3 / 1000, 8, 120, "cm3"));
  object(Outside("width", size.x, 80, 150, "mm"));
  object(Outside("depth from front to back", size.y, 50, 130, "mm"));
  object(Outside("height", size.z, 40, 120, "mm"));
  if (!shape.objection.empty()) return shape;

  // The box of an oblique image is too large for the shares below, so take the true one.
  Box3 box;
  const auto for_each = [&](const auto& visit) {
    for (int k = component.lower[2]; k <= component.upper[2]; ++k) {
      for (int j = component.lower[1]; j <= component.upper[1]; ++j) {
        for (int i = component.lower[0]; i <= component.upper[0]; ++i) {
          if (labels[lattice.Index(i, j, k)] == label) visit(lattice.WorldFromVoxel({i, j, k}));
        }
      }
    }
  };
  for_each([&box](const Vec3& p_W) { box.Include(p_W); });
  double top = 0;
  for_each([&](const Vec3& p_W) {
    const Vec3 t = (p_W - box.lower) / box.size();  // 0 to 1: right to left, front to back, bottom to top
    const int third = std::min(2, static_cast<int>(3 * t.x));
    if (t.y > 0.5) (third == 0 ? shape.back_right : third == 1 ? shape.back_middle : shape.back_left) += 1;
    if (t.y < 0.4 && third == 1) shape.front_middle += 1;
    if (t.z > 0.75) {
      top += 1;
      (third == 0 ? shape.top_right : third == 1 ? shape.top_middle : shape.top_left) += 1;
    }
  });
  const auto n = static_cast<double>(component.voxels);
  for (double* share : {&shape.back_middle, &shape.back_left, &shape.back_right, &shape.front_middle}) *share /= n;
  for (double* share : {&shape.top_left, &shape.top_middle, &shape.top_right}) *share /= std::max(top, 1.0);

  if (shape.back_middle > 0.02) object("it is not open to the back, as the arch of a mandible is");
  if (shape.front_middle < 0.08) object("it has no chin in the middle of its front");
  if (std::min(shape.back_left, shape.back_right) < 0.08) object("it has no ramus at the back on one side");
  if (shape.top_middle > 0.05) object("its top reaches across the middle, as a skull's or an upper jaw's does");
  if (std::min(shape.top_left, shape.top_right) < 0.15) object("only one side reaches up to a condyle");
  shape.is_mandible = shape.objection.empty();
  return shape;
}

}  // namespace kerf
