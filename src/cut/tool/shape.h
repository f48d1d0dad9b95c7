// A tool as points: where it cuts and where it only touches. What looks at a tool's form in the tick looks here, so
// that it need not know which tool it is; only the sweep (src/cut/removal) has a formula for each.
#pragma once

#include <algorithm>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// A point of the cutting edge. Tool frame T.
struct EdgePoint {
  Vec3 p_T{0};       // mm
  Vec3 e_T{0};       // outward, unit length
  double teeth = 0;  // how many teeth it stands for, a real number
};

/// A point of a face that does not cut.
struct FacePoint {
  Vec3 p_T{0};                 // mm
  Vec3 n_T{0};                 // outward, unit length
  bool while_stopped = false;  // it lies where the turning edge cuts: it holds only while the spindle stands still
};

struct ToolShape {
  double reach_mm = 0;         // as CalcReach()
  double passes_per_turn = 0;  // teeth that pass a point of the edge in one turn of the spindle
  /// Disc: once round the rim, in the middle of its thickness; neighbours in the list are neighbours on the rim, the
  /// last and the first too. Ball: all over it.
  std::vector<EdgePoint> edge;
  bool edge_is_ring = false;
  /// Disc: rings on both flats, from near the spindle to `rim_margin_mm` inside the rim. Ball: none.
  std::vector<FacePoint> faces;
};

/// How far inside the rim a turning disc's teeth cut with their sides, mm: no further than there is disc. In a grid at
/// least so many voxels, for the kerf's corner to be clear of the flats.
inline constexpr double kToothSide_mm = 0.3;
inline constexpr double kMostToothSide = 0.45;  // of the radius
inline constexpr double kToothSideVoxels = 3;
inline double CalcToothSide(double radius_mm, double voxel_mm) {
  return std::max(std::min(kToothSide_mm, kMostToothSide * radius_mm), kToothSideVoxels * voxel_mm);
}

/// `samples_per_pitch`: of the edge, 1 to 256. `face_spacing_mm` > 0: of the flats' points, half of it along the
/// radius and twice of it around.
/// `rim_margin_mm` >= 0: how far inside the rim the outermost of them lie, and `stopped_margin_mm` <= that those which
/// hold only while the spindle stands still.
ToolShape MakeToolShape(const Tool& tool, int samples_per_pitch, double face_spacing_mm, double rim_margin_mm,
                        double stopped_margin_mm);

/// A bound of how far any point of a ball of radius `reach_mm` about the tool's origin moves from one pose to another,
/// mm. Tick-safe.
double CalcTravel(const Pose& from, const Pose& to, double reach_mm);

}  // namespace kerf
