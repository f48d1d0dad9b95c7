#include "cut/tool/round_tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>

#include "cut/tool/solids.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kShank = 0.6;   // radius of the shank in pictures, as a fraction of the tool's
constexpr double kShank_mm = 6;  // its visible length

/// Adds the points of a cone between two circles, in rings that have the same number of points and teeth each.
void AddCone(const RoundEdges& edges, double r_a, double z_a, double r_b, double z_b, int meridians, int parallels,
             ToolShape& shape) {
  const double slant_mm = std::hypot(r_b - r_a, z_b - z_a);
  const double e_r = (z_b - z_a) / slant_mm;
  const double e_z = (r_a - r_b) / slant_mm;
  const double teeth = edges.flutes * slant_mm / edges.tooth_width_mm / (meridians * parallels);
  for (int j = 0; j < parallels; ++j) {
    const double t = (j + 0.5) / parallels;
    const double chisel = r_a == 0 ? std::clamp(edges.chisel_radius_mm / r_b * parallels - j, 0.0, 1.0) : 0;  // part
    const double r = r_a + t * (r_b - r_a);
    const double z = z_a + t * (z_b - z_a);
    for (int i = 0; i < meridians; ++i) {
      const double turn = 2 * std::numbers::pi * (i + 0.5 * (j % 2)) / meridians;
      const double c = std::cos(turn);
      const double s = std::sin(turn);
      shape.edge.push_back({{r * c, r * s, z}, {e_r * c, e_r * s, e_z}, teeth * (1 + chisel * edges.chisel_excess)});
    }
  }
}

/// Adds rings of points on the side at which contact holds a tool whose side does not cut, in pairs.
void AddSide(const RoundSolid& solid, const ShapeSampling& sampling, ToolShape& shape) {
  const double first_mm = solid.corner_z_mm + sampling.rim_margin_mm;
  const auto add_ring = [&](double z, int pairs, bool while_stopped) {
    const double radius = solid.corner_radius_mm;
    for (int i = 0; i < pairs; ++i) {
      const double turn = std::numbers::pi * i / pairs;
      const Vec3 e(std::cos(turn), std::sin(turn), 0);
      for (const double side : {-1.0, 1.0}) {
        shape.faces.push_back(
            {side * radius * e + Vec3(0, 0, z), side * e, while_stopped ? Touching::kStopped : Touching::kAlways});
      }
    }
  };
  const int pairs =
      std::max(4, static_cast<int>(std::ceil(std::numbers::pi * solid.corner_radius_mm / sampling.face_spacing_mm)));
  if (sampling.stopped_margin_mm < sampling.rim_margin_mm) {
    add_ring(std::min(solid.corner_z_mm + sampling.stopped_margin_mm, solid.top_z_mm), pairs, true);
  }
  const int rings =
      std::max(1, static_cast<int>(std::ceil((solid.top_z_mm - first_mm) / (0.5 * sampling.face_spacing_mm))));
  for (int i = 0; i <= rings; ++i) {
    add_ring(std::min(first_mm + (solid.top_z_mm - first_mm) * i / rings, solid.top_z_mm), pairs, false);
  }
}

}  // namespace

void CheckHeadLength(const RoundSolid& solid, double point_angle_deg) {
  constexpr double kLeastSide = 0.05;  // as a fraction of the length
  const double length_mm = solid.top_z_mm;
  if (length_mm - solid.corner_z_mm >= kLeastSide * length_mm) return;
  throw Error(
      fmt::format("length_mm = {} is too short for point_angle_deg = {} and diameter_mm = {}: the tip alone is "
                  "{:.3g} mm long",
                  length_mm, point_angle_deg, 2 * solid.top_radius_mm, solid.corner_z_mm));
}

ToolShape MakeRoundShape(const RoundSolid& solid, const RoundEdges& edges, const ShapeSampling& sampling) {
  ToolShape shape;
  shape.passes_per_turn = edges.flutes;
  const int meridians = std::max(32, 2 * sampling.samples_per_pitch);
  const double spacing_mm = 2 * std::numbers::pi * solid.top_radius_mm / meridians;
  const auto count = [&](double length_mm, double apart_mm) {
    return std::max(4, static_cast<int>(std::ceil(length_mm / apart_mm)));
  };
  if (solid.side_cuts) {
    // Along the straight side, contact changes less than across the end.
    const double side_mm = std::hypot(solid.top_radius_mm - solid.corner_radius_mm, solid.top_z_mm - solid.corner_z_mm);
    AddCone(edges, solid.corner_radius_mm, solid.corner_z_mm, solid.top_radius_mm, solid.top_z_mm, meridians,
            count(side_mm, 2 * spacing_mm), shape);
  } else {
    AddSide(solid, sampling, shape);
  }
  AddCone(edges, 0, 0, solid.corner_radius_mm, solid.corner_z_mm, meridians,
          count(std::hypot(solid.corner_radius_mm, solid.corner_z_mm), spacing_mm), shape);
  return shape;
}

std::vector<CoverPlate> MakeRoundCover(const RoundSolid& solid) {
  const double radius_mm = solid.top_radius_mm;
  const int slices = std::max(1, static_cast<int>(std::ceil(solid.top_z_mm / (2 * radius_mm))));
  const double half_mm = 0.5 * solid.top_z_mm / slices;
  std::vector<CoverPlate> plates;
  for (int i = 0; i < slices; ++i) plates.push_back({{0, 0, (2 * i + 1) * half_mm}, radius_mm, half_mm * (1 + 1e-12)});
  return plates;
}

std::vector<Vec3> MakeRoundSection(const RoundSolid& solid, const Pose& X_ST) {
  // The section of a convex solid is convex, so its points in the order of their angle about one of them are its
  // outline. They lie where the plane meets the generatrices and the edges of end and top.
  std::vector<Vec3> points;
  const auto add = [&](const Vec3& a_T, const Vec3& b_T) {
    const Vec3 a = X_ST.Point(a_T);
    const Vec3 b = X_ST.Point(b_T);
    if ((a.z > 0) == (b.z > 0)) return;
    const Vec3 p = glm::mix(a, b, a.z / (a.z - b.z));
    points.emplace_back(p.x, p.y, 0);
  };
  constexpr int kTurns = 512;
  const auto at = [](double radius, double z, int i) {
    const double turn = 2 * std::numbers::pi * i / kTurns;
    return Vec3(radius * std::cos(turn), radius * std::sin(turn), z);
  };
  for (int i = 0; i < kTurns; ++i) {
    const Vec3 corner = at(solid.corner_radius_mm, solid.corner_z_mm, i);
    const Vec3 top = at(solid.top_radius_mm, solid.top_z_mm, i);
    add(Vec3(0), corner);
    add(corner, top);
    add(top, Vec3(0, 0, solid.top_z_mm));
    add(corner, at(solid.corner_radius_mm, solid.corner_z_mm, i + 1));
    add(top, at(solid.top_radius_mm, solid.top_z_mm, i + 1));
  }
  if (points.size() < 3) return {};
  Vec3 middle(0);
  for (const Vec3& p : points) middle += p / static_cast<double>(points.size());
  std::sort(points.begin(), points.end(), [&](const Vec3& a, const Vec3& b) {
    return std::atan2(a.y - middle.y, a.x - middle.x) < std::atan2(b.y - middle.y, b.x - middle.x);
  });
  points.push_back(points.front());
  return points;
}

std::vector<Vec3> SampleRoundSurface(const RoundSolid& solid, double step_mm) {
  std::vector<Vec3> points;
  const auto add_cone = [&](double r_a, double z_a, double r_b, double z_b) {
    const int rings = std::max(1, static_cast<int>(std::ceil(std::hypot(r_b - r_a, z_b - z_a) / step_mm)));
    for (int j = 0; j <= rings; ++j) {
      const double t = static_cast<double>(j) / rings;
      const double r = r_a + t * (r_b - r_a);
      const int count = std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * r / step_mm)));
      for (int i = 0; i < count; ++i) {
        const double turn = 2 * std::numbers::pi * i / count;
        points.emplace_back(r * std::cos(turn), r * std::sin(turn), z_a + t * (z_b - z_a));
      }
    }
  };
  add_cone(solid.top_radius_mm, solid.top_z_mm, solid.corner_radius_mm, solid.corner_z_mm);
  add_cone(solid.corner_radius_mm, solid.corner_z_mm, 0, 0);
  add_cone(solid.top_radius_mm, solid.top_z_mm, 0, solid.top_z_mm);
  return points;
}

TriangleMesh MakeRoundMesh(const RoundSolid& solid, const FluteLooks& looks) {
  constexpr int kRingsOfEnd = 4;
  const double side_mm = solid.top_z_mm - solid.corner_z_mm;
  const int rings_of_side = std::max(2, static_cast<int>(std::ceil(looks.rings_per_mm * side_mm)));
  const int meridians = looks.flutes * std::max(12, 48 / looks.flutes);
  TriangleMesh mesh;
  const auto add_ring = [&](double radius, double z, double fraction) {
    for (int i = 0; i < meridians; ++i) {
      const double turn = 2 * std::numbers::pi * i / meridians + looks.twist_rad_per_mm * z;
      const double phase = static_cast<double>(i * looks.flutes % meridians) / meridians;
      const double r = radius * (1 - fraction * looks.depth(phase));
      mesh.points.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
    }
  };
  for (int k = 1; k <= kRingsOfEnd; ++k) {
    const double t = static_cast<double>(k) / kRingsOfEnd;
    add_ring(t * solid.corner_radius_mm, t * solid.corner_z_mm, t);
  }
  for (int k = 1; k <= rings_of_side; ++k) {
    const double t = static_cast<double>(k) / rings_of_side;
    add_ring(solid.corner_radius_mm + t * (solid.top_radius_mm - solid.corner_radius_mm),
             solid.corner_z_mm + t * side_mm, 1);
  }
  const auto tip = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, 0);
  mesh.points.emplace_back(0, 0, solid.top_z_mm);
  const auto n = static_cast<std::uint32_t>(meridians);
  const auto rings = static_cast<std::uint32_t>(kRingsOfEnd + rings_of_side);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({tip, next, i});
    for (std::uint32_t j = 0; j + 1 < rings; ++j) {
      const std::uint32_t a = j * n;
      mesh.triangles.push_back({a + i, a + next, a + n + next});
      mesh.triangles.push_back({a + i, a + n + next, a + n + i});
    }
    const std::uint32_t last = (rings - 1) * n;
    mesh.triangles.push_back({tip + 1, last + i, last + next});
  }
  AddPrism(MakeCircle(kShank * solid.top_radius_mm, 48), 0.98 * solid.top_z_mm, solid.top_z_mm + kShank_mm, mesh);
  return mesh;
}

}  // namespace kerf
