#include "cut/tool/fissure_bur.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kerf/error.h"

namespace kerf {
namespace {

/// Adds the points of a cone between two circles, in rings that have the same number of points and teeth each.
void AddCone(const FissureBur& bur, double r_a, double z_a, double r_b, double z_b, int meridians, int parallels,
             ToolShape& shape) {
  const double slant_mm = std::hypot(r_b - r_a, z_b - z_a);
  const double e_r = (z_b - z_a) / slant_mm;
  const double e_z = (r_a - r_b) / slant_mm;
  const double teeth = bur.flutes * slant_mm / bur.tooth_width_mm / (meridians * parallels);
  for (int j = 0; j < parallels; ++j) {
    const double t = (j + 0.5) / parallels;
    const double r = r_a + t * (r_b - r_a);
    const double z = z_a + t * (z_b - z_a);
    for (int i = 0; i < meridians; ++i) {
      const double turn = 2 * std::numbers::pi * (i + 0.5 * (j % 2)) / meridians;
      const double c = std::cos(turn);
      const double s = std::sin(turn);
      shape.edge.push_back({{r * c, r * s, z}, {e_r * c, e_r * s, e_z}, teeth});
    }
  }
}

}  // namespace

RoundSolid MakeBurSolid(const FissureBur& bur) {
  return MakeRoundSolid(bur.diameter_mm, bur.length_mm, bur.taper_deg, bur.point_angle_deg);
}

void FissureBur::Validate() const {
  CheckParameters(*this);
  constexpr double kLeast = 0.05;  // of the radius at the corner, and of the length of the side
  const RoundSolid solid = MakeBurSolid(*this);
  if (!(solid.corner_radius_mm >= kLeast * radius_mm())) {
    throw Error(
        fmt::format("taper_deg = {} is too large for length_mm = {} and diameter_mm = {}: the side would reach "
                    "the axis above the tip",
                    taper_deg, length_mm, diameter_mm));
  }
  if (!(length_mm - solid.corner_z_mm >= kLeast * length_mm)) {
    throw Error(
        fmt::format("length_mm = {} is too short for point_angle_deg = {} and diameter_mm = {}: the tip alone "
                    "is {:.3g} mm long",
                    length_mm, point_angle_deg, diameter_mm, solid.corner_z_mm));
  }
}

std::string ToolKind<FissureBur>::Name(const FissureBur& bur) {
  std::string name = fmt::format("bur {:g} x {:g} mm, {} flutes", bur.diameter_mm, bur.length_mm, bur.flutes);
  if (bur.taper_deg > 0) name += fmt::format(", taper {:g} degrees", bur.taper_deg);
  if (bur.point_angle_deg < 180) name += fmt::format(", point {:g} degrees", bur.point_angle_deg);
  return name;
}

std::string ToolKind<FissureBur>::ShortName(const FissureBur& bur) {
  return fmt::format("{:g} mm bur", bur.diameter_mm);
}

std::optional<RoundSolid> ToolKind<FissureBur>::CalcRoundSolid(const FissureBur& bur) {
  return MakeBurSolid(bur);
}

double ToolKind<FissureBur>::CalcReach(const FissureBur& bur) {
  return std::hypot(bur.radius_mm(), bur.length_mm);
}

Tooth ToolKind<FissureBur>::CalcTooth(const FissureBur& bur) {
  return {bur.radius_mm(), 2 * std::numbers::pi * bur.radius_mm() / bur.flutes, bur.tooth_width_mm, bur.rake_deg,
          1e-3 * bur.edge_radius_um};
}

Vec3 ToolKind<FissureBur>::FindNearest(const FissureBur& bur, const Vec3& p_T) {
  return MakeBurSolid(bur).FindNearest(p_T);
}

double ToolKind<FissureBur>::CalcSignedDistance(const FissureBur& bur, const Vec3& p_T) {
  return MakeBurSolid(bur).CalcSignedDistance(p_T);
}

Vec3 ToolKind<FissureBur>::FindDeepest(const FissureBur& bur, const Vec3& n_T) {
  return MakeBurSolid(bur).FindDeepest(n_T);
}

ToolShape ToolKind<FissureBur>::MakeShape(const FissureBur& bur, const ShapeSampling& sampling) {
  ToolShape shape;
  shape.passes_per_turn = bur.flutes;
  const RoundSolid solid = MakeBurSolid(bur);
  const int meridians = std::max(32, 2 * sampling.samples_per_pitch);
  const double spacing_mm = 2 * std::numbers::pi * solid.top_radius_mm / meridians;
  const auto count = [&](double length_mm, double apart_mm) {
    return std::max(4, static_cast<int>(std::ceil(length_mm / apart_mm)));
  };
  // Along the straight side, contact changes less than across the end.
  const double side_mm = std::hypot(solid.top_radius_mm - solid.corner_radius_mm, solid.top_z_mm - solid.corner_z_mm);
  AddCone(bur, solid.corner_radius_mm, solid.corner_z_mm, solid.top_radius_mm, solid.top_z_mm, meridians,
          count(side_mm, 2 * spacing_mm), shape);
  AddCone(bur, 0, 0, solid.corner_radius_mm, solid.corner_z_mm, meridians,
          count(std::hypot(solid.corner_radius_mm, solid.corner_z_mm), spacing_mm), shape);
  return shape;
}

std::vector<CoverPlate> ToolKind<FissureBur>::MakeCover(const FissureBur& bur) {
  const int slices = std::max(1, static_cast<int>(std::ceil(bur.length_mm / bur.diameter_mm)));
  const double half_mm = 0.5 * bur.length_mm / slices;
  std::vector<CoverPlate> plates;
  for (int i = 0; i < slices; ++i) {
    plates.push_back({{0, 0, (2 * i + 1) * half_mm}, bur.radius_mm(), half_mm * (1 + 1e-12)});
  }
  return plates;
}

}  // namespace kerf
