#include <algorithm>
#include <cmath>
#include <numbers>

#include "view/picture/picture.h"

namespace kerf {
namespace {

// Adds a closed solid between z0 and z1 over a star-shaped outline (counter-clockwise around the z axis).
void AddPrism(const std::vector<Vec3>& outline, double z0, double z1, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const Vec3& p : outline) mesh.points.emplace_back(p.x, p.y, z0);
  for (const Vec3& p : outline) mesh.points.emplace_back(p.x, p.y, z1);
  const auto bottom = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, z0);
  mesh.points.emplace_back(0, 0, z1);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t a = first + i;
    const std::uint32_t b = first + (i + 1) % n;
    mesh.triangles.push_back({a, b, b + n});
    mesh.triangles.push_back({a, b + n, a + n});
    mesh.triangles.push_back({bottom, b, a});
    mesh.triangles.push_back({bottom + 1, a + n, b + n});
  }
}

std::vector<Vec3> MakeCircle(double radius, int corners) {
  std::vector<Vec3> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return outline;
}

// Makes radial tooth fronts and sloping backs, with tips at the full radius.
std::vector<Vec3> MakeToothedCircle(const DiscSaw& saw) {
  const double radius = saw.radius_mm();
  const double gullet = CalcGulletDepth(saw);
  struct Knot {
    double fraction_of_pitch;
    double fraction_of_gullet;
  };
  // From the tip backwards; then the floor of the gullet, and up the next tooth's front.
  constexpr Knot kProfile[] = {{0.0, 0.0},  {0.12, 0.03}, {0.35, 0.35}, {0.6, 0.8},
                               {0.75, 1.0}, {0.88, 0.95}, {0.97, 0.6}};
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

// A flange on each side of a disc.
struct Hub {
  double radius;
  double outer_z;  // of its outer face
};

Hub CalcHub(const DiscSaw& saw) {
  return {0.22 * saw.radius_mm(), 0.5 * saw.thickness_mm + std::max(0.04 * saw.radius_mm(), saw.thickness_mm)};
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

// Makes a sphere with grooves between its slightly twisted flutes, and the end of the shank.
TriangleMesh MakeBallMesh(const BallBurr& ball) {
  constexpr int kParallels = 48;
  constexpr double kGroove = 0.12;  // depth, as a fraction of the radius
  constexpr double kTwist = 0.6;    // rad from pole to pole
  const int meridians = 12 * std::max(4, ball.flutes);
  const double radius = ball.radius_mm();
  TriangleMesh mesh;
  for (int j = 1; j < kParallels; ++j) {
    const double colatitude = std::numbers::pi * j / kParallels;
    for (int i = 0; i < meridians; ++i) {
      const double longitude =
          2 * std::numbers::pi * i / meridians + kTwist * j / kParallels;  // points follow the flutes
      const double phase = static_cast<double>(i * ball.flutes % meridians) / meridians;
      // A sharp edge in front with a slope behind it; the grooves fade out towards the poles.
      const double groove = kGroove * std::sin(colatitude) * phase;
      const double r = radius * (1 - groove);
      mesh.points.emplace_back(r * std::sin(colatitude) * std::cos(longitude),
                               r * std::sin(colatitude) * std::sin(longitude), r * std::cos(colatitude));
    }
  }
  const auto top = static_cast<std::uint32_t>(mesh.points.size());
  mesh.points.emplace_back(0, 0, radius);
  mesh.points.emplace_back(0, 0, -radius);
  const auto n = static_cast<std::uint32_t>(meridians);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    mesh.triangles.push_back({top, i, next});
    for (std::uint32_t j = 0; j + 2 < kParallels; ++j) {
      const std::uint32_t a = j * n;
      mesh.triangles.push_back({a + i, a + n + i, a + n + next});
      mesh.triangles.push_back({a + i, a + n + next, a + next});
    }
    const std::uint32_t last = (kParallels - 2) * n;
    mesh.triangles.push_back({top + 1, last + next, last + i});
  }
  AddPrism(MakeCircle(0.45 * radius, 48), 0.85 * radius, 4 * radius, mesh);
  return mesh;
}

}  // namespace

double CalcGulletDepth(const DiscSaw& saw) {
  return std::min(0.45 * saw.pitch_mm(), 0.1 * saw.radius_mm());
}

TriangleMesh MakeToolMesh(const Tool& tool) {
  Validate(tool);
  if (const auto* disc = std::get_if<DiscSaw>(&tool)) return MakeDiscMesh(*disc);
  return MakeBallMesh(std::get<BallBurr>(tool));
}

std::vector<Vec3> SampleHub(const Tool& tool) {
  Validate(tool);
  const auto* disc = std::get_if<DiscSaw>(&tool);
  if (disc == nullptr) return {};
  const Hub hub = CalcHub(*disc);
  std::vector<Vec3> points;
  for (const Vec3& p : MakeCircle(hub.radius, 64)) {
    for (const double z : {-hub.outer_z, hub.outer_z}) points.emplace_back(p.x, p.y, z);
  }
  return points;
}

}  // namespace kerf
