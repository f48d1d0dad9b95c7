#include "cut/tool/round_solid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace kerf {
namespace {

struct ProfilePoint {
  double r, z;
};

constexpr double kRadPerDegree = std::numbers::pi / 180;

/// Returns the corners of the half section, from the tip to the middle of the top.
std::array<ProfilePoint, 4> GetCorners(const RoundSolid& solid) {
  return {{{0, 0},
           {solid.corner_radius_mm, solid.corner_z_mm},
           {solid.top_radius_mm, solid.top_z_mm},
           {0, solid.top_z_mm}}};
}

/// Returns the line through two corners, with the solid to its left.
RoundSolid::Face MakeFace(const ProfilePoint& a, const ProfilePoint& b) {
  const double length = std::hypot(b.r - a.r, b.z - a.z);
  const double r = (b.z - a.z) / length;
  const double z = (a.r - b.r) / length;
  return {r, z, r * a.r + z * a.z};
}

}  // namespace

std::array<RoundSolid::Face, 3> RoundSolid::CalcFaces() const {
  const auto corners = GetCorners(*this);
  return {MakeFace(corners[0], corners[1]), MakeFace(corners[1], corners[2]), MakeFace(corners[2], corners[3])};
}

double RoundSolid::CalcCornerFactor() const {
  const auto faces = CalcFaces();
  // At a corner where the normals enclose the angle t, the furthest such point lies on their bisector.
  const auto factor = [](double cosine) { return std::sqrt(2 / (1 + cosine)); };
  const auto cosine = [](const Face& a, const Face& b) { return a.r * b.r + a.z * b.z; };
  // At the tip the normals are those of opposite generatrices.
  const double at_tip = faces[0].z * faces[0].z - faces[0].r * faces[0].r;
  return std::max({factor(at_tip), factor(cosine(faces[0], faces[1])), factor(cosine(faces[1], faces[2]))});
}

Vec3 RoundSolid::FindNearest(const Vec3& p) const {
  const double radius = std::hypot(p.x, p.y);
  const auto faces = CalcFaces();
  if (std::all_of(faces.begin(), faces.end(), [&](const Face& f) { return f.CalcDistance(radius, p.z) <= 0; }))
    return p;
  const auto corners = GetCorners(*this);
  ProfilePoint nearest{0, 0};
  double least = 1e300;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const ProfilePoint& a = corners[i];
    const ProfilePoint& b = corners[i + 1];
    const double dr = b.r - a.r;
    const double dz = b.z - a.z;
    const double t = std::clamp(((radius - a.r) * dr + (p.z - a.z) * dz) / (dr * dr + dz * dz), 0.0, 1.0);
    const ProfilePoint q{a.r + t * dr, a.z + t * dz};
    const double distance = std::hypot(radius - q.r, p.z - q.z);
    if (distance < least) {
      least = distance;
      nearest = q;
    }
  }
  const double in = radius > 0 ? nearest.r / radius : 0;
  return {in * p.x, in * p.y, nearest.z};
}

double RoundSolid::CalcSignedDistance(const Vec3& p) const {
  const double radius = std::hypot(p.x, p.y);
  double largest = -1e300;
  for (const Face& face : CalcFaces()) largest = std::max(largest, face.CalcDistance(radius, p.z));
  return largest > 0 ? glm::length(p - FindNearest(p)) : largest;
}

Vec3 RoundSolid::FindDeepest(const Vec3& n) const {
  const double across = std::hypot(n.x, n.y);
  const Vec3 e = across > 1e-9 * glm::length(n) ? Vec3(n.x / across, n.y / across, 0) : Vec3(0);
  Vec3 deepest(0);
  const auto corners = GetCorners(*this);
  for (std::size_t i = 1; i < (side_cuts ? corners.size() : 2); ++i) {
    const Vec3 p = corners[i].r * e + Vec3(0, 0, corners[i].z);
    if (glm::dot(p, n) > glm::dot(deepest, n)) deepest = p;
  }
  return deepest;
}

RoundSolid MakeRoundSolid(double diameter_mm, double length_mm, double taper, double point_angle_deg) {
  RoundSolid solid;
  solid.top_radius_mm = 0.5 * diameter_mm;
  solid.top_z_mm = length_mm;
  solid.corner_radius_mm = taper * solid.top_radius_mm;
  const double half = 0.5 * point_angle_deg * kRadPerDegree;
  if (point_angle_deg < 180) solid.corner_z_mm = solid.corner_radius_mm * std::cos(half) / std::sin(half);
  return solid;
}

}  // namespace kerf
