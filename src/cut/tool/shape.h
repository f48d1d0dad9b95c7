// Shape of a tool as sample points: the edge, which cuts, and the faces, which only touch. Contact uses these points
// and so does not depend on the kind of tool. Only the sweep (src/cut/removal) has a separate formula for each kind.
#pragma once

#include <algorithm>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// Point of the cutting edge, in the tool frame T.
struct EdgePoint {
  Vec3 p_T{0};       // position, mm
  Vec3 e_T{0};       // outward direction, unit length
  double teeth = 0;  // number of teeth that the point represents, a real number
};

/// Point of a face that does not cut, in the tool frame T.
struct FacePoint {
  Vec3 p_T{0};                 // position, mm
  Vec3 n_T{0};                 // outward normal, unit length
  bool while_stopped = false;  // in the zone that a turning edge cuts: in contact only while the spindle is stopped
};

/// Sample points of a tool, in the tool frame T, and the quantities that contact needs of its shape.
struct ToolShape {
  double reach_mm = 0;         // result of CalcReach()
  double passes_per_turn = 0;  // teeth that pass a point of the edge per turn of the spindle
  /// Disc: one turn of the rim, in the disc's middle plane; neighbours in the list are neighbours on the rim, including
  /// the last and the first. Ball: the whole surface.
  std::vector<EdgePoint> edge;
  bool edge_is_ring = false;
  /// Disc: rings on both flats, from near the spindle to `rim_margin_mm` inside the rim. Ball: empty.
  std::vector<FacePoint> faces;
};

/// Distance inside the rim over which the sides of a turning disc's teeth cut, mm. It is limited to a fraction of the
/// radius, and is at least three voxels so that the flats stay clear of the kerf's corner on the grid.
inline constexpr double kToothSide_mm = 0.3;
inline constexpr double kMaxToothSide = 0.45;  // fraction of the radius
inline constexpr double kToothSideVoxels = 3;
inline double CalcToothSide(double radius_mm, double voxel_mm) {
  return std::max(std::min(kToothSide_mm, kMaxToothSide * radius_mm), kToothSideVoxels * voxel_mm);
}

/// Samples the shape of a tool.
///
/// `samples_per_pitch`: samples of the edge per tooth pitch, 1 to 256.
/// `face_spacing_mm`: spacing of the points on the flats, > 0. It is halved along the radius and doubled along all
/// rings but the outermost.
/// `rim_margin_mm`: distance of the outermost ring from the rim, >= 0.
/// `stopped_margin_mm`: distance from the rim of the ring that is in contact only while the spindle is stopped, at most
/// `rim_margin_mm`.
ToolShape MakeToolShape(const Tool& tool, int samples_per_pitch, double face_spacing_mm, double rim_margin_mm,
                        double stopped_margin_mm);

/// Returns the distance of a point from the tool's body, tool frame, mm; 0 inside. The body is a flat cylinder or a
/// ball, which are convex, so that the distance is a convex function of the point. Tick-safe.
double CalcToolDistance(const Tool& tool, const Vec3& p_T);

/// Returns an upper bound on the distance that any point of a ball of radius `reach_mm` about the tool's origin moves
/// between two poses, mm. Tick-safe.
double CalcTravel(const Pose& from, const Pose& to, double reach_mm);

}  // namespace kerf
