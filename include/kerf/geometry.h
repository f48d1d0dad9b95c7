// Points, poses, boxes and meshes. Lengths are in mm. Frames: W world (for an imported CT the patient frame, LPS: x to
// the patient's left, y to the back, z to the head), T tool, V voxel index space.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace kerf {

using Vec3 = glm::dvec3;
using Quat = glm::dquat;  // w, x, y, z; unit length
inline constexpr double kDegreesPerRad = 180 / std::numbers::pi;

/// Rigid transform X_AB: maps coordinates in frame B to frame A. Tick-safe.
struct Pose {
  Quat R_AB{1, 0, 0, 0};
  Vec3 p_AB{0, 0, 0};  // origin of B in A, mm

  Vec3 Point(const Vec3& p_B) const { return R_AB * p_B + p_AB; }
  Vec3 Vector(const Vec3& v_B) const { return R_AB * v_B; }
  Vec3 InversePoint(const Vec3& p_A) const { return glm::conjugate(R_AB) * (p_A - p_AB); }
  Vec3 InverseVector(const Vec3& v_A) const { return glm::conjugate(R_AB) * v_A; }
  Pose Inverse() const { return {glm::conjugate(R_AB), InversePoint(Vec3(0))}; }
};

/// Returns true if all components are finite and the quaternion has unit length to within 1e-6. Tick-safe.
bool IsValid(const Pose& X);

/// Valid world coordinates lie between -kWorldReach_mm and kWorldReach_mm. Points outside this range are rejected.
inline constexpr double kWorldReach_mm = 1e6;
/// Returns true if the point is finite and its coordinates are valid world coordinates.
bool IsInWorld(const Vec3& p_W);

/// Returns `v` scaled to unit length, even if its length is as extreme as 1e-300 or 1e300. Returns nullopt if `v` is
/// zero or not finite.
std::optional<Vec3> CalcDirection(const Vec3& v);

/// Axis-aligned box, mm. Empty until the first Include().
struct Box3 {
  Vec3 lower{std::numeric_limits<double>::infinity()};
  Vec3 upper{-std::numeric_limits<double>::infinity()};

  bool empty() const { return !(lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z); }
  Vec3 size() const { return empty() ? Vec3{0} : upper - lower; }
  Vec3 centre() const { return 0.5 * (lower + upper); }
  void Include(const Vec3& p);
  Box3 Grown(double margin_mm) const { return {lower - Vec3{margin_mm}, upper + Vec3{margin_mm}}; }
};

/// Plane of a cut. Its "left" side is the one that the normal points away from and its "right" side the one that the
/// normal points to, regardless of the patient's left and right.
struct CutPlane {
  Vec3 p_W{0};
  Vec3 normal_W{1, 0, 0};  // unit length
};

/// Indexed triangle surface, mm, with triangles counter-clockwise as seen from outside.
struct TriangleMesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Computes the volume enclosed by a closed, outward-oriented surface, mm^3 (divergence theorem; negative if the
/// surface is oriented inwards).
double CalcEnclosedVolume(const TriangleMesh& mesh);
/// Counts the edges that do not lie between exactly two oppositely directed triangles; 0 for a closed, consistently
/// oriented surface.
std::size_t CountOpenEdges(const TriangleMesh& mesh);

}  // namespace kerf
