#include "cut/tool/disc_saw.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace kerf {
namespace {

constexpr int kCoverRings = 3;

void AddFaceRing(const DiscSaw& disc, double radius, double spacing_mm, double phase, bool while_stopped,
                 ToolShape& shape) {
  const int points = std::max(6, static_cast<int>(std::ceil(2 * std::numbers::pi * radius / spacing_mm)));
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * (i + phase) / points;
    for (const double side : {-1.0, 1.0}) {
      shape.faces.push_back({{radius * std::cos(angle), radius * std::sin(angle), side * 0.5 * disc.thickness_mm},
                             {0, 0, side},
                             while_stopped ? Touching::kStopped : Touching::kAlways});
    }
  }
}

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

std::string ToolKind<DiscSaw>::Name(const DiscSaw& disc) {
  return fmt::format("disc {:g} x {:g} mm, {} teeth", disc.diameter_mm, disc.thickness_mm, disc.teeth);
}

std::string ToolKind<DiscSaw>::ShortName(const DiscSaw& disc) {
  return fmt::format("{:g} mm disc with {} teeth", disc.diameter_mm, disc.teeth);
}

double ToolKind<DiscSaw>::CalcReach(const DiscSaw& disc) {
  return std::hypot(disc.radius_mm(), 0.5 * disc.thickness_mm);
}

Tooth ToolKind<DiscSaw>::CalcTooth(const DiscSaw& disc) {
  return {disc.radius_mm(), disc.pitch_mm(), disc.thickness_mm, disc.rake_deg, 1e-3 * disc.edge_radius_um};
}

double ToolKind<DiscSaw>::CalcSideStiffness(const DiscSaw& disc) {
  const double t = disc.thickness_mm;
  return 0.45 * disc.E_MPa * t * t * t / (disc.radius_mm() * disc.radius_mm());
}

Vec3 ToolKind<DiscSaw>::FindNearest(const DiscSaw& disc, const Vec3& p_T) {
  const double rho = std::hypot(p_T.x, p_T.y);
  const double in = rho > disc.radius_mm() ? disc.radius_mm() / rho : 1;
  const double half_mm = 0.5 * disc.thickness_mm;
  return {in * p_T.x, in * p_T.y, std::clamp(p_T.z, -half_mm, half_mm)};
}

double ToolKind<DiscSaw>::CalcSignedDistance(const DiscSaw& disc, const Vec3& p_T) {
  const double out = std::hypot(p_T.x, p_T.y) - disc.radius_mm();
  const double across = std::abs(p_T.z) - 0.5 * disc.thickness_mm;
  return out > 0 && across > 0 ? std::hypot(out, across) : std::max(out, across);
}

Vec3 ToolKind<DiscSaw>::FindDeepest(const DiscSaw& disc, const Vec3& n_T) {
  const Vec3 in_plane(n_T.x, n_T.y, 0);
  const double length = glm::length(in_plane);
  return length > 1e-9 ? disc.radius_mm() / length * in_plane : Vec3(0);
}

ToolShape ToolKind<DiscSaw>::MakeShape(const DiscSaw& disc, const ShapeSampling& sampling) {
  ToolShape shape;
  shape.passes_per_turn = disc.teeth;
  shape.edge_form = EdgeForm::kRing;
  const int count = std::max(64, disc.teeth * sampling.samples_per_pitch);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    const Vec3 e_T(std::cos(angle), std::sin(angle), 0);
    shape.edge.push_back({disc.radius_mm() * e_T, e_T, static_cast<double>(disc.teeth) / count});
  }
  const double outermost = disc.radius_mm() - std::min(sampling.rim_margin_mm, 0.5 * disc.radius_mm());
  const double stopped = disc.radius_mm() - std::min(sampling.stopped_margin_mm, 0.5 * disc.radius_mm());
  if (stopped > outermost) AddFaceRing(disc, stopped, sampling.face_spacing_mm, 0, true, shape);
  // Rings are twice as close along the radius as points along a ring: in a shallow kerf only a few rings hold the disc
  // against tilting.
  const int rings = std::max(1, static_cast<int>(std::ceil(outermost / (0.5 * sampling.face_spacing_mm))));
  for (int ring = rings; ring >= 1; --ring) {
    AddFaceRing(disc, outermost * ring / rings, (ring == rings ? 1 : 2) * sampling.face_spacing_mm, 0.5 * (ring % 2),
                false, shape);
  }
  return shape;
}

std::vector<CoverPlate> ToolKind<DiscSaw>::MakeCover(const DiscSaw& disc) {
  const double R = disc.radius_mm();
  const double half_thickness = 0.5 * disc.thickness_mm;
  // The middle plate is about as large as the plates around it.
  const double middle = 0.2 * R;
  std::vector<CoverPlate> plates{{Vec3{0}, middle, half_thickness}};
  const double width = (R - middle) / kCoverRings;
  for (int ring = 1; ring <= kCoverRings; ++ring) {
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
