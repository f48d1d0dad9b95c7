#include "view/picture/handpiece.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr std::uint32_t kAround = 40;
constexpr double kBehindGrip_mm = 25;
// Of a solid of revolution, which has a long shank: its visible length and the least radius of the neck that holds it.
constexpr double kShank_mm = 5;
constexpr double kLeastNeck_mm = 1.2;

struct Section {
  Vec3 middle{0};
  double radius = 1;
};

// Makes a closed tube through circular sections, each perpendicular to the z axis or, from `bend` on, to `axis`.
TriangleMesh MakeTube(const std::vector<Section>& sections, std::size_t bend, const Vec3& axis) {
  TriangleMesh mesh;
  const Vec3 turn = glm::cross(Vec3{0, 0, 1}, axis);
  const double angle = std::atan2(glm::length(turn), axis.z);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    Quat R{1, 0, 0, 0};
    if (i >= bend && glm::length(turn) > 1e-9) R = glm::angleAxis(angle, glm::normalize(turn));
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const double a = 2 * std::numbers::pi * j / kAround;
      mesh.points.push_back(sections[i].middle + R * (sections[i].radius * Vec3{std::cos(a), std::sin(a), 0}));
    }
  }
  for (std::uint32_t i = 0; i + 1 < sections.size(); ++i) {
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const std::uint32_t a = i * kAround + j;
      const std::uint32_t b = i * kAround + (j + 1) % kAround;
      mesh.triangles.push_back({a, b, b + kAround});
      mesh.triangles.push_back({a, b + kAround, a + kAround});
    }
  }
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.push_back(sections.front().middle);
  mesh.points.push_back(sections.back().middle);
  const std::uint32_t last = static_cast<std::uint32_t>(sections.size() - 1) * kAround;
  for (std::uint32_t j = 0; j < kAround; ++j) {
    const std::uint32_t next = (j + 1) % kAround;
    mesh.triangles.push_back({first, next, j});
    mesh.triangles.push_back({first + 1, last + j, last + next});
  }
  return mesh;
}

/// In a frame H whose z axis is that of the neck.
struct Proportions {
  Pose X_TH;         // that of the tool for a tool that turns; of a blade with a stroke behind it
  double start_mm;   // where the neck begins, along z
  double neck_mm;    // radius of the neck at its start
  double collar_mm;  // where the handle begins, along z
  Vec3 end_H{0};     // end of the handle
};

Proportions CalcProportions(const Tool& tool) {
  const double radius = CalcReach(tool);
  const bool blade = IsBlade(tool);
  Proportions p{};
  p.start_mm = blade ? 0.45 * radius : 1.6 * radius;
  p.neck_mm = blade ? 0.17 * radius : 0.55 * radius;
  p.collar_mm = p.start_mm + std::clamp(2 * radius, 10.0, 24.0);
  if (const std::optional<RoundSolid> solid = CalcRoundSolid(tool)) {
    p.start_mm = solid->top_z_mm + kShank_mm;
    p.neck_mm = std::max(solid->top_radius_mm, kLeastNeck_mm);
    p.collar_mm = p.start_mm + 10;
  }
  Vec3 grip = CalcGrip(tool);
  if (const ConvexOutline outline = MakeStrokeOutline(tool); !outline.empty()) {
    Box3 box;
    for (int i = 0; i < outline.size(); ++i) box.Include({outline.corner(i).x, outline.corner(i).y, 0});
    // The handle follows a blade with a tip at its end: z of H is -y of T. Other blades it follows at their back: -x.
    const bool at_end = FindPlanarBlade(tool)->has_tip;
    const double quarter_rad = 0.5 * std::numbers::pi;
    p.X_TH = {at_end ? glm::angleAxis(quarter_rad, Vec3{1, 0, 0}) : glm::angleAxis(-quarter_rad, Vec3{0, 1, 0}),
              box.centre()};
    p.start_mm = 0.5 * (at_end ? box.size().y : box.size().x);
    p.neck_mm = 0.4 * (at_end ? box.size().x : box.size().y);
    p.collar_mm = p.start_mm + 12;
    grip = p.X_TH.InversePoint(grip);
  }
  // The axis from the collar through the grip, unless the grip lies beside or before the collar.
  const Vec3 from{0, 0, p.collar_mm};
  const Vec3 to_grip = grip - from;
  const bool on_side = to_grip.z > 10 && to_grip.z > 0.4 * glm::length(to_grip);
  const Vec3 axis = on_side ? glm::normalize(to_grip) : Vec3{0, 0, 1};
  const double length = on_side ? std::min(glm::length(to_grip), 150.0) : 60.0;
  p.end_H = from + (length + kBehindGrip_mm) * axis;
  return p;
}

}  // namespace

TriangleMesh MakeHandpieceMesh(const Tool& tool) {
  Validate(tool);
  const Proportions p = CalcProportions(tool);
  const Vec3 from{0, 0, p.collar_mm};
  const Vec3 along = p.end_H - from;
  const double handle = std::clamp(0.07 * glm::length(along), 4.0, 6.5);
  const double collar = std::max(0.62 * handle, 1.15 * p.neck_mm);
  const double neck = std::min(1.3 * p.neck_mm, collar);
  const auto on_z = [](double z) { return Vec3{0, 0, z}; };
  const double rise = p.collar_mm - p.start_mm;
  std::vector<Section> sections{{on_z(p.start_mm), p.neck_mm},
                                {on_z(p.start_mm + 0.55 * rise), neck},
                                {on_z(p.start_mm + 0.62 * rise), collar},
                                {on_z(p.collar_mm), collar}};
  const std::size_t bend = sections.size();
  // Fractions of the handle's length and radius: a waist, a grip and a rounded end.
  constexpr double kProfile[][2] = {{0.06, 0.78}, {0.1, 0.7},   {0.16, 0.82}, {0.3, 0.97}, {0.5, 1.0},
                                    {0.78, 0.94}, {0.94, 0.88}, {0.98, 0.7},  {1.0, 0.42}};
  for (const auto& [fraction, width] : kProfile) sections.push_back({from + fraction * along, width * handle});
  TriangleMesh mesh = MakeTube(sections, bend, glm::normalize(along));
  if (CalcStroke(tool) > 0) {
    for (Vec3& point : mesh.points) point = p.X_TH.Point(point);
  }
  return mesh;
}

std::vector<Vec3> SampleHandpiece(const Tool& tool, double step_mm) {
  const TriangleMesh mesh = MakeHandpieceMesh(tool);
  std::vector<Vec3> points = mesh.points;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangle[i];
      const std::uint32_t b = triangle[(i + 1) % 3];
      if (a > b) continue;  // the next triangle has the same edge
      const Vec3 along = mesh.points[b] - mesh.points[a];
      const int parts = static_cast<int>(std::ceil(glm::length(along) / step_mm));
      for (int k = 1; k < parts; ++k) points.push_back(mesh.points[a] + along * (static_cast<double>(k) / parts));
    }
  }
  return points;
}

double CalcHandpieceReach(const Tool& tool) {
  const Proportions p = CalcProportions(tool);
  return std::max(1.2 * CalcReach(tool), glm::length(p.X_TH.Point(p.end_H)) + 10);
}

}  // namespace kerf
