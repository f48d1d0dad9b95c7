#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <numbers>

#include "cut/tool/disc_saw.h"
#include "cut/tool/solids.h"

namespace kerf {
namespace {

constexpr int kRimCorners = 128;

double CalcGulletDepth(const DiscSaw& saw) {
  return std::min(0.45 * saw.pitch_mm(), 0.1 * saw.radius_mm());
}

/// Returns the outline with radial tooth fronts, which face the positive sense, and sloping backs, with tips at the
/// full radius.
std::vector<Vec3> MakeToothedCircle(const DiscSaw& saw) {
  const double radius = saw.radius_mm();
  const double gullet = CalcGulletDepth(saw);
  struct Knot {
    double fraction_of_pitch;
    double fraction_of_gullet;
  };
  // Up the back of a tooth to its tip, down its front, and along the floor of the gullet.
  constexpr Knot kProfile[] = {{0.25, 1.0}, {0.4, 0.8},  {0.65, 0.35}, {0.88, 0.03},
                               {1.0, 0.0},  {1.03, 0.6}, {1.12, 0.95}};
  std::vector<Vec3> outline;
  for (int tooth = 0; tooth < saw.teeth; ++tooth) {
    for (const Knot& knot : kProfile) {
      const double angle = 2 * std::numbers::pi * (tooth + knot.fraction_of_pitch) / saw.teeth;
      const double r = radius - gullet * knot.fraction_of_gullet;
      outline.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
  }
  return outline;
}

TriangleMesh MakeDiscMesh(const DiscSaw& saw) {
  TriangleMesh mesh;
  const double half = 0.5 * saw.thickness_mm;
  AddPrism(MakeToothedCircle(saw), -half, half, mesh);
  // The hub, and the end of the spindle on the side of the handle.
  const auto [flange, outer] = CalcHub(saw);
  AddPrism(MakeCircle(flange, 64), -outer, -half, mesh);
  AddPrism(MakeCircle(flange, 64), half, outer, mesh);
  AddPrism(MakeCircle(0.6 * flange, 64), outer, outer + 1.1 * saw.radius_mm(), mesh);
  return mesh;
}

/// Makes a cover over the rim, which spans 110 degrees about the x axis.
TriangleMesh MakeGuard(const DiscSaw& saw) {
  constexpr std::uint32_t kSteps = 36;
  constexpr double kHalfSpan_rad = 55 * std::numbers::pi / 180;
  const double radius = saw.radius_mm();
  const double above = 0.5 * saw.thickness_mm + 0.03 * radius + 0.2;
  const double plate = 0.05 * radius + 0.3;
  const double wall = 0.06 * radius;
  // Cross-section (distance from the axis, height), counter-clockwise: a plate above the disc, and a wall around its
  // rim that reaches to the other side.
  const std::array<glm::dvec2, 6> outline{{{0.3 * radius, above},
                                           {1.05 * radius, above},
                                           {1.05 * radius, -above},
                                           {1.05 * radius + wall, -above},
                                           {1.05 * radius + wall, above + plate},
                                           {0.3 * radius, above + plate}}};
  constexpr auto kCorners = static_cast<std::uint32_t>(std::tuple_size_v<decltype(outline)>);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= kSteps; ++i) {
    const double a = kHalfSpan_rad * (2.0 * i / kSteps - 1);
    for (const glm::dvec2& c : outline) mesh.points.emplace_back(c.x * std::cos(a), c.x * std::sin(a), c.y);
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    for (std::uint32_t j = 0; j < kCorners; ++j) {
      const std::uint32_t a = i * kCorners + j;
      const std::uint32_t b = i * kCorners + (j + 1) % kCorners;
      mesh.triangles.push_back({a, b + kCorners, b});
      mesh.triangles.push_back({a, a + kCorners, b + kCorners});
    }
  }
  // The ends: an L-shape, as two quadrangles that share the edge between corners 1 and 4.
  constexpr std::array<std::array<std::uint32_t, 3>, 4> kEnd{{{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}}};
  const std::uint32_t last = kSteps * kCorners;
  for (const auto& [a, b, c] : kEnd) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({last + a, last + c, last + b});
  }
  return mesh;
}

/// Returns the disc with its teeth cut off at the floor of the gullets.
TriangleMesh CutTeethOff(TriangleMesh mesh, const DiscSaw& saw) {
  const double round = saw.radius_mm() - CalcGulletDepth(saw);
  for (Vec3& p : mesh.points) {
    const double r = std::hypot(p.x, p.y);
    if (r > round) p = {p.x * round / r, p.y * round / r, p.z};
  }
  return mesh;
}

/// Returns the outline of the disc's cross-section with the plane z = 0 of frame S. `R`: radius, `t`: thickness. In
/// frame S; empty if they do not meet.
std::vector<Vec3> SliceDisc(const Pose& X_ST, double R, double t) {
  const Vec3 axis = X_ST.Vector({0, 0, 1});  // of the disc
  const Vec3& middle = X_ST.p_AB;
  const double tilt = std::hypot(axis.x, axis.y);  // 0: the disc is parallel to the slice
  std::vector<Vec3> outline;
  if (tilt < 1e-4) {
    if (std::abs(middle.z) > 0.5 * t) return {};
    for (int i = 0; i <= 96; ++i) {
      const double a = 2 * std::numbers::pi * i / 96;
      outline.emplace_back(middle.x + R * std::cos(a), middle.y + R * std::sin(a), 0);
    }
    return outline;
  }
  // Along `across` in the slice, the height above the disc's plane changes fastest; along `level`, not at all.
  const Vec3 across = Vec3{axis.x, axis.y, 0} / tilt;
  const Vec3 level{-across.y, across.x, 0};
  // Distance in the disc from its diameter along `level`, of the slice's point at v across.
  const auto beside = [&](double v) { return v * axis.z + middle.z * tilt; };
  double from = (middle.z * axis.z - 0.5 * t) / tilt;
  double to = (middle.z * axis.z + 0.5 * t) / tilt;
  // The part of this range within the disc's radius.
  if (std::abs(axis.z) > 1e-9) {
    const double a = (-R - middle.z * tilt) / axis.z;
    const double b = (R - middle.z * tilt) / axis.z;
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  } else if (std::abs(middle.z * tilt) > R) {
    return {};
  }
  if (!(from < to)) return {};
  constexpr int kSteps = 48;
  const auto at = [&](int i, double side) {
    // Denser towards the ends, where the width changes fastest.
    const double v = from + (to - from) * (0.5 - 0.5 * std::cos(std::numbers::pi * i / kSteps));
    const double w = beside(v);
    const double u = side * std::sqrt(std::max(0.0, R * R - w * w));
    return Vec3{middle.x, middle.y, 0} + v * across + u * level;
  };
  for (int i = 0; i <= kSteps; ++i) outline.push_back(at(i, 1));
  for (int i = kSteps; i >= 0; --i) outline.push_back(at(i, -1));
  outline.push_back(outline.front());
  return outline;
}

}  // namespace

DiscHub CalcHub(const DiscSaw& disc) {
  return {0.22 * disc.radius_mm(), 0.5 * disc.thickness_mm + std::max(0.04 * disc.radius_mm(), disc.thickness_mm)};
}

ToolLooks ToolKind<DiscSaw>::MakeLooks(const DiscSaw& disc) {
  const double radius = disc.radius_mm();
  ToolLooks looks;
  looks.whole = MakeDiscMesh(disc);
  looks.turning = CutTeethOff(looks.whole, disc);
  looks.blur = ToolBlur{radius - CalcGulletDepth(disc), radius, 0.5 * disc.thickness_mm};
  looks.guard = MakeGuard(disc);
  const DiscHub hub = CalcHub(disc);
  for (const Vec3& p : MakeCircle(hub.radius_mm, 64)) {
    for (const double z : {-hub.outer_z_mm, hub.outer_z_mm}) looks.hub.emplace_back(p.x, p.y, z);
  }
  looks.outline = MakeCircle(radius, kRimCorners);
  return looks;
}

std::vector<Vec3> ToolKind<DiscSaw>::MakeSection(const DiscSaw& disc, const Pose& X_ST, double least_mm) {
  return SliceDisc(X_ST, disc.radius_mm(), std::max(disc.thickness_mm, least_mm));
}

std::vector<Vec3> ToolKind<DiscSaw>::SampleSurface(const DiscSaw& disc, double step_mm) {
  std::vector<Vec3> points;
  const double half = 0.5 * disc.thickness_mm;
  const int rings = static_cast<int>(std::ceil(disc.radius_mm() / step_mm));
  for (int i = rings; i >= 0; --i) {
    const double radius = disc.radius_mm() * i / rings;
    const int count = std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi * radius / step_mm)));
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * std::numbers::pi * k / count;
      for (const double z : {0.0, half, -half}) {
        points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
      }
    }
  }
  return points;
}

}  // namespace kerf
