#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>

#include "cut/tool/planar_kind.h"

namespace kerf {
namespace {

/// Returns the points of the toothed edge from low to high y, and where each lies along the edge, 0 to 1: triangles
/// with tips on the edge. The last one may be cut off.
struct FrontPoint {
  Vec3 p_T;
  double along;
};
std::vector<FrontPoint> MakeTeeth(const PlanarBlade& blade) {
  const double half_mm = 0.5 * blade.edge_mm;
  const double gullet_mm = std::min(0.45 * blade.pitch_mm, 0.3 * std::min(-blade.back_low.x, -blade.back_high.x));
  std::vector<FrontPoint> points;
  const auto add = [&](double x, double along_mm) {
    points.push_back({blade.motion().Move({x, 0, 0}, along_mm), (along_mm + half_mm) / blade.edge_mm});
  };
  add(-gullet_mm, -half_mm);
  for (double from_mm = -half_mm; from_mm < half_mm; from_mm += blade.pitch_mm) {
    for (const double part : {0.5, 1.0}) {
      const double at = std::min(from_mm + part * blade.pitch_mm, half_mm);
      add(part == 0.5 ? 0 : -gullet_mm, at);
      if (at == half_mm) return points;
    }
  }
  return points;
}

/// Point of the back opposite to a point of the edge.
Vec3 FindBack(const PlanarBlade& blade, double along) {
  return {blade.back_low.x + along * (blade.back_high.x - blade.back_low.x),
          blade.back_low.y + along * (blade.back_high.y - blade.back_low.y), 0};
}

/// Makes a plate between a front and the back of the blade.
TriangleMesh MakePlate(const PlanarBlade& blade, const std::vector<FrontPoint>& front) {
  TriangleMesh mesh;
  for (const double z : {-0.5 * blade.thickness_mm, 0.5 * blade.thickness_mm}) {
    for (const FrontPoint& p : front) {
      mesh.points.push_back(p.p_T + Vec3(0, 0, z));
      mesh.points.push_back(FindBack(blade, p.along) + Vec3(0, 0, z));
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

ToolLooks MakePlanarLooks(const PlanarBlade& blade) {
  ToolLooks looks;
  looks.whole = MakePlate(blade, MakeTeeth(blade));
  const ConvexOutline outline = blade.SweepOutline({});
  for (int i = 0; i < outline.size(); ++i) looks.outline.emplace_back(outline.corner(i).x, outline.corner(i).y, 0);
  return looks;
}

namespace {

/// Returns the section of the plate within an outline.
std::vector<Vec3> MakeSection(const PlanarBlade& blade, const ConvexOutline& outline, const Pose& X_ST,
                              double least_mm) {
  // A square of the plane is cut by each face of the blade in turn (Sutherland and Hodgman).
  const double size_mm = 2 * (CalcPlanarReach(blade) + blade.stroke_mm + glm::length(X_ST.p_AB));
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

}  // namespace

std::vector<Vec3> MakePlanarSection(const PlanarBlade& blade, const Pose& X_ST, double least_mm) {
  return MakeSection(blade, blade.SweepOutline({}), X_ST, least_mm);
}

std::vector<Vec3> MakeStrokeSection(const Tool& tool, const Pose& X_ST, double least_mm) {
  const std::optional<PlanarBlade> blade = FindPlanarBlade(tool);
  if (!blade) return {};
  return MakeSection(*blade, MakeStrokeOutline(tool), X_ST, least_mm);
}

std::vector<Vec3> SamplePlanarSurface(const PlanarBlade& blade, double step_mm) {
  std::vector<Vec3> points;
  const double ends_mm = std::abs(blade.back_high.y - blade.back_low.y);
  const int columns = static_cast<int>(std::ceil(std::max(blade.edge_mm, ends_mm) / step_mm));
  const int rows = static_cast<int>(std::ceil(blade.length_mm() / step_mm));
  for (int i = columns; i >= 0; --i) {
    const double along = static_cast<double>(i) / columns;
    const Vec3 front = blade.motion().Move(Vec3(0), blade.edge_mm * (along - 0.5));
    const Vec3 to_back = FindBack(blade, along) - front;
    for (int k = 0; k <= rows; ++k) {
      for (const double z : {0.0, 0.5, -0.5}) {
        points.push_back(front + to_back * (static_cast<double>(k) / rows) + Vec3(0, 0, z * blade.thickness_mm));
      }
    }
  }
  std::stable_sort(points.begin(), points.end(),
                   [](const Vec3& a, const Vec3& b) { return glm::dot(a, a) > glm::dot(b, b); });
  return points;
}

}  // namespace kerf
