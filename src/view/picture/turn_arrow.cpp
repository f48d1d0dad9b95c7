#include "view/picture/turn_arrow.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace kerf {

TriangleMesh MakeTurnArrowMesh(double radius, double shaft_radius, double from_rad, double to_rad) {
  constexpr std::uint32_t kSectors = 24;
  constexpr int kSteps = 32;
  const double span = to_rad - from_rad;
  const double head = std::copysign(std::min(8 * shaft_radius / radius, 0.6 * std::abs(span)), span);
  // Sections of the arrow: angle and radius.
  std::vector<std::pair<double, double>> sections{{from_rad, 0}};
  for (int i = 0; i <= kSteps; ++i) sections.emplace_back(from_rad + (span - head) * i / kSteps, shaft_radius);
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    sections.emplace_back(to_rad - head * (1 - t), 3 * shaft_radius * (1 - t));
  }
  TriangleMesh mesh;
  for (const auto& [angle, r] : sections) {
    for (std::uint32_t j = 0; j < kSectors; ++j) {
      const double turn = std::copysign(2 * std::numbers::pi * j / kSectors, -span);  // outwards for either sense
      const double out = radius + r * std::cos(turn);
      mesh.points.emplace_back(out * std::cos(angle), out * std::sin(angle), r * std::sin(turn));
    }
  }
  for (std::uint32_t i = 0; i + 1 < sections.size(); ++i) {
    for (std::uint32_t j = 0; j < kSectors; ++j) {
      const std::uint32_t a = i * kSectors + j;
      const std::uint32_t b = i * kSectors + (j + 1) % kSectors;
      mesh.triangles.push_back({a, b, b + kSectors});
      mesh.triangles.push_back({a, b + kSectors, a + kSectors});
    }
  }
  return mesh;
}

}  // namespace kerf
