#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>

#include "cut/tool/reciprocating_blade.h"

namespace kerf {
namespace {

/// Returns the toothed edge from the handle's end to the tip: triangles with tips at x = 0. The last one may be cut
/// off.
std::vector<ConvexOutline::Point> MakeTeeth(const ReciprocatingBlade& blade) {
  const double half_mm = 0.5 * blade.length_mm;
  const double gullet_mm = std::min(0.45 * blade.pitch_mm, 0.3 * blade.taper * blade.width_mm);
  std::vector<ConvexOutline::Point> points{{-gullet_mm, -half_mm}};
  for (double y = -half_mm; y < half_mm; y += blade.pitch_mm) {
    for (const double part : {0.5, 1.0}) {
      const double at = std::min(y + part * blade.pitch_mm, half_mm);
      points.push_back({part == 0.5 ? 0 : -gullet_mm, at});
      if (at == half_mm) return points;
    }
  }
  return points;
}

/// Makes a plate between a front and the back of the blade. `front`: points with rising y.
TriangleMesh MakePlate(const ReciprocatingBlade& blade, const std::vector<ConvexOutline::Point>& front) {
  TriangleMesh mesh;
  const double half_mm = 0.5 * blade.length_mm;
  for (const double z : {-0.5 * blade.thickness_mm, 0.5 * blade.thickness_mm}) {
    for (const ConvexOutline::Point& p : front) {
      const double along = (p.y + half_mm) / blade.length_mm;
      mesh.points.emplace_back(p.x, p.y, z);
      mesh.points.emplace_back(-blade.width_mm * (1 + along * (blade.taper - 1)), p.y, z);
    }
  }
  const auto n = static_cast<std::uint32_t>(front.size());
  const std::uint32_t top = 2 * n;
  const auto quad = [&mesh](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    const std::uint32_t a = 2 * i, back = a + 1, b = a + 2, back_b = a + 3;
    quad(a, back, back_b, b);                          // lower flat
    quad(top + a, top + b, top + back_b, top + back);  // upper flat
    quad(a, b, top + b, top + a);                      // front
    quad(back, top + back, top + back_b, back_b);      // back
  }
  quad(0, top, top + 1, 1);                                      // handle's end
  quad(2 * n - 2, 2 * n - 1, top + 2 * n - 1, top + 2 * n - 2);  // tip
  return mesh;
}

}  // namespace

ToolLooks ToolKind<ReciprocatingBlade>::MakeLooks(const ReciprocatingBlade& blade) {
  ToolLooks looks;
  looks.whole = MakePlate(blade, MakeTeeth(blade));
  const ConvexOutline outline = MakeOutline(blade);
  for (int i = 0; i < outline.size(); ++i) looks.outline.emplace_back(outline.corner(i).x, outline.corner(i).y, 0);
  return looks;
}

std::vector<Vec3> ToolKind<ReciprocatingBlade>::MakeSection(const ReciprocatingBlade& blade, const Pose& X_ST,
                                                            double least_mm) {
  // A square of the plane is cut by each face of the blade in turn (Sutherland and Hodgman).
  const double size_mm = 2 * (CalcReach(blade) + glm::length(X_ST.p_AB));
  std::vector<Vec3> kept{
      {-size_mm, -size_mm, 0}, {size_mm, -size_mm, 0}, {size_mm, size_mm, 0}, {-size_mm, size_mm, 0}};
  const auto cut = [&](const Vec3& normal_T, double offset_mm) {
    const Vec3 normal = X_ST.Vector(normal_T);
    const double offset = offset_mm + glm::dot(normal, X_ST.p_AB);
    std::vector<Vec3> inside;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const Vec3& a = kept[i];
      const Vec3& b = kept[(i + 1) % kept.size()];
      const double out_a = glm::dot(normal, a) - offset, out_b = glm::dot(normal, b) - offset;
      if (out_a <= 0) inside.push_back(a);
      if ((out_a < 0 && out_b > 0) || (out_a > 0 && out_b < 0)) inside.push_back(a + out_a / (out_a - out_b) * (b - a));
    }
    kept = inside;
  };
  const ConvexOutline outline = MakeOutline(blade);
  for (int i = 0; i < outline.size(); ++i) {
    const ConvexOutline::Side side = outline.side(i);
    cut({side.normal.x, side.normal.y, 0}, side.offset_mm);
  }
  const double half_mm = 0.5 * std::max(blade.thickness_mm, least_mm);
  for (const double z : {-1.0, 1.0}) cut({0, 0, z}, half_mm);
  if (kept.size() < 3) return {};
  kept.push_back(kept.front());
  return kept;
}

std::vector<Vec3> ToolKind<ReciprocatingBlade>::SampleSurface(const ReciprocatingBlade& blade, double step_mm) {
  std::vector<Vec3> points;
  const double half_mm = 0.5 * blade.length_mm;
  const int columns = static_cast<int>(std::ceil(blade.length_mm / step_mm));
  const int rows = static_cast<int>(std::ceil(blade.width_mm / step_mm));
  for (int i = columns; i >= 0; --i) {
    const double along = static_cast<double>(i) / columns;
    const double width_mm = blade.width_mm * (1 + along * (blade.taper - 1));
    for (int k = 0; k <= rows; ++k) {
      for (const double z : {0.0, 0.5, -0.5}) {
        points.emplace_back(-width_mm * k / rows, along * blade.length_mm - half_mm, z * blade.thickness_mm);
      }
    }
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const Vec3& a, const Vec3& b) { return glm::dot(a, a) > glm::dot(b, b); });
  return points;
}

}  // namespace kerf
