#include "view/picture/handpiece.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

#include "cut/tool/handpiece.h"

namespace kerf {
namespace {

constexpr std::uint32_t kAround = 40;

}  // namespace

TriangleMesh MakeHandpieceMesh(const Tool& tool) {
  Validate(tool);
  const std::vector<HolderSection> sections = MakeHandpiece(tool).sections;
  TriangleMesh mesh;
  for (const HolderSection& section : sections) {
    for (std::uint32_t j = 0; j < kAround; ++j) {
      const double a = 2 * std::numbers::pi * j / kAround;
      mesh.points.push_back(section.middle_T + section.R_TS * (section.radius_mm * Vec3{std::cos(a), std::sin(a), 0}));
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
  mesh.points.push_back(sections.front().middle_T);
  mesh.points.push_back(sections.back().middle_T);
  const std::uint32_t last = static_cast<std::uint32_t>(sections.size() - 1) * kAround;
  for (std::uint32_t j = 0; j < kAround; ++j) {
    const std::uint32_t next = (j + 1) % kAround;
    mesh.triangles.push_back({first, next, j});
    mesh.triangles.push_back({first + 1, last + j, last + next});
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
  return std::max(1.2 * CalcReach(tool), glm::length(MakeHandpiece(tool).sections.back().middle_T) + 10);
}

}  // namespace kerf
