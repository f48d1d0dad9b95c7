#include "cut/proximity/cover.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kerf {
namespace {

constexpr int kRings = 3;

/// Plate that covers a sector of a ring: its centre lies on the sector's bisector at radius `at_mm`.
struct SectorPlate {
  double at_mm;
  double radius_mm;
};

/// Returns the smallest round plate over the sector of a ring from r_in to r_out, half_angle to either side of its
/// bisector. For any point of the bisector between the radii, the furthest points of the sector are its corners or the
/// middle of its outer arc.
SectorPlate FindSectorPlate(double r_in, double r_out, double half_angle) {
  const double c = std::cos(half_angle);
  const double s = std::sin(half_angle);
  SectorPlate best{r_out, r_out};
  constexpr int kSteps = 1000;
  for (int i = 0; i <= kSteps; ++i) {
    const double at = r_in + (r_out - r_in) * i / kSteps;
    const double radius =
        std::max({std::hypot(r_out * c - at, r_out * s), std::hypot(r_in * c - at, r_in * s), r_out - at});
    if (radius < best.radius_mm) best = {at, radius};
  }
  return best;
}

}  // namespace

std::vector<CoverPlate> MakeCover(const Tool& tool) {
  const auto* disc = std::get_if<DiscSaw>(&tool);
  if (!disc) return {};
  const double R = disc->radius_mm();
  const double half_thickness = 0.5 * disc->thickness_mm;
  // The middle plate is about as large as the plates around it.
  const double middle = 0.2 * R;
  std::vector<CoverPlate> plates{{Vec3{0}, middle, half_thickness}};
  const double width = (R - middle) / kRings;
  for (int ring = 1; ring <= kRings; ++ring) {
    const int sectors = 6 * ring;
    const double half_angle = std::numbers::pi / sectors;
    const SectorPlate plate = FindSectorPlate(middle + (ring - 1) * width, middle + ring * width, half_angle);
    for (int i = 0; i < sectors; ++i) {
      const double angle = 2 * half_angle * i;
      plates.push_back({{plate.at_mm * std::cos(angle), plate.at_mm * std::sin(angle), 0},
                        plate.radius_mm * (1 + 1e-12),
                        half_thickness});
    }
  }
  return plates;
}

}  // namespace kerf
