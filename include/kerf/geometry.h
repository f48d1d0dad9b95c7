// Points, poses, boxes and meshes. Lengths in mm. Frames: W world (for an imported CT the patient frame, LPS: x to the
// patient's left, y to the back, z to the head), T tool, V voxel index space.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/gtc/quaternion.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <optional>
#include <vector>

namespace kerf {

using Vec3 = glm::dvec3;
using Quat = glm::dquat;  // w, x, y, z; unit length

/// Rigid transform X_AB: takes coordinates in frame B to frame A. Tick-safe.
struct Pose {
  Quat R_AB{1, 0, 0, 0};
  Vec3 p_AB{0, 0, 0};  // origin of B in A, mm

  Vec3 Point(const Vec3& p_B) const { return R_AB * p_B + p_AB; }
  Vec3 Vector(const Vec3& v_B) const { return R_AB * v_B; }
  Vec3 InversePoint(const Vec3& p_A) const { return glm::conjugate(R_AB) * (p_A - p_AB); }
  Vec3 InverseVector(const Vec3& v_A) const { return glm::conjugate(R_AB) * v_A; }
};

/// All components finite and the quaternion of unit length to 1e-6. Tick-safe.
bool IsValid(const Pose& X);

/// Coordinates in W go from minus this to this, mm: a point beyond is a mistake.
inline constexpr double kWorldReach_mm = 1e6;
/// Finite and within the world.
bool IsInWorld(const Vec3& p_W);

/// `v` at unit length, whatever its own: from 1e-300 to 1e300 too. None when it has no direction.
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

/// A plane to cut along. Of the two sides, "left" is the one that the normal points away from, whatever the patient's
/// left; "right" the one that it points to.
struct CutPlane {
  Vec3 p_W{0};
  Vec3 normal_W{1, 0, 0};  // unit length
};

/// Indexed triangle surface, mm, triangles counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Volume enclosed by a closed, outward-oriented surface, mm^3 (divergence theorem; negative when turned inside out).
double CalcEnclosedVolume(const TriangleMesh& mesh);
/// Edges that do not lie between exactly two oppositely directed triangles; 0 for a closed, consistently oriented
/// surface.
std::size_t CountOpenEdges(const TriangleMesh& mesh);

}  // namespace kerf
