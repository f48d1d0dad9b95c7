// Shape of a tool: sample points of the edge, which cuts, and of the faces, which only touch; its body; its cover. None
// of the callers depends on the kind of tool (tool_kind.h).
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cut/tool/convex_outline.h"
#include "cut/tool/edge_motion.h"
#include "cut/tool/round_solid.h"
#include "kerf/tool.h"

namespace kerf {

/// Point of the cutting edge, in the tool frame T.
struct EdgePoint {
  Vec3 p_T{0};       // position, mm
  Vec3 e_T{0};       // outward direction, unit length
  double teeth = 0;  // number of teeth that the point represents, a real number
};

/// When a point of a face may be in contact.
enum class Touching {
  kAlways,
  kStopped,  // in the zone that a moving edge cuts: only while the drive is stopped
  kMoving,  // only while the drive moves: the point is where the stroke takes it furthest, and does not take part in it
};

/// Point of a face that does not cut, in the tool frame T.
struct FacePoint {
  Vec3 p_T{0};  // position, mm
  Vec3 n_T{0};  // outward normal, unit length
  Touching touching = Touching::kAlways;
};

/// How the points of an edge are joined.
enum class EdgeForm {
  kSurface,  // not at all: they are spread over a surface; the first two are neighbours around the axis
  kRing,     // one turn of a rim, in the disc's middle plane; the last is a neighbour of the first
  kChain,    // a row at equal distances, of a multiple of 8 intervals; each point states the teeth of one interval
};

/// Sample points of a tool, in the tool frame T, and the quantities that contact needs of its shape.
struct ToolShape {
  double reach_mm = 0;         // result of CalcReach()
  double passes_per_turn = 0;  // teeth that pass a point of the edge per turn of the spindle
  /// Disc: the rim. Other blades: the row of teeth in the middle of the stroke. Any other tool: the whole surface that
  /// cuts.
  std::vector<EdgePoint> edge;
  EdgeForm edge_form = EdgeForm::kSurface;
  EdgeMotion motion;  // of the edge, the solids and the faces by a stroke
  /// Points that bone holds and that have no teeth: of the back and sides of a blade that is not round, and of its tip
  /// while stopped. Those that touch while it moves come last.
  std::vector<FacePoint> solids;
  /// Disc: rings on both flats, from near the spindle to `rim_margin_mm` inside the rim. Other blades: rows on both
  /// flats. Others: empty.
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

/// Words for the shapes of the tools in scenes ("disc"), in the order of the alternatives of Tool.
const std::vector<std::string_view>& GetToolShapes();
/// What the words mean: "disc: a saw that cuts with its rim; ...".
const std::string& DescribeToolShapes();
std::string_view GetShape(const Tool& tool);
/// Returns the tools of all shapes with their default values, in the same order.
const std::vector<Tool>& GetDefaultTools();

/// How finely a shape is sampled.
struct ShapeSampling {
  int samples_per_pitch = 16;    // samples of the edge per tooth pitch, 1 to 256
  double face_spacing_mm = 1;    // spacing of the points on the flats, > 0; halved along the radius and doubled along
                                 // all rings but the outermost
  double rim_margin_mm = 0;      // distance of the outermost ring from the rim, >= 0
  double stopped_margin_mm = 0;  // distance from the rim of the ring that is in contact only while the spindle is
                                 // stopped, at most rim_margin_mm
};
ToolShape MakeToolShape(const Tool& tool, const ShapeSampling& sampling);

/// Round plate perpendicular to the spindle axis that covers a part of a tool. Tool frame.
struct CoverPlate {
  Vec3 centre_T{0};
  double radius_mm = 0;
  double half_thickness_mm = 0;
};
/// Returns plates that cover all of a tool; none if the ball of radius CalcReach() is as good. Allocates.
std::vector<CoverPlate> MakeToolCover(const Tool& tool);

/// Returns the convex outline of a blade that is not round, in the middle of its stroke; empty for any other tool.
ConvexOutline MakeToolOutline(const Tool& tool);
/// Returns the convex outline of all that such a blade passes in a whole stroke; empty for any other tool.
ConvexOutline MakeStrokeOutline(const Tool& tool);

/// Returns points all over a tool's surface and, of a blade, its middle plane, about `step_mm` apart, the outermost
/// first. Tool frame. Allocates.
std::vector<Vec3> SampleToolSurface(const Tool& tool, double step_mm);

/// Returns the body of a tool of the form kRound; none for other forms.
std::optional<RoundSolid> CalcRoundSolid(const Tool& tool);

/// Returns the force at the rim of a blade per displacement of the rim out of its plane, N/mm; 0: rigid.
double CalcSideStiffness(const Tool& tool);

/// Returns the point of the tool's body nearest to a point, tool frame; the point itself inside. The body is convex.
/// The following are tick-safe, too.
Vec3 FindNearestOfTool(const Tool& tool, const Vec3& p_T);
/// Returns the distance of a point from the surface of the tool's body, tool frame, mm; negative inside.
double CalcSignedToolDistance(const Tool& tool, const Vec3& p_T);
/// Returns the distance of a point from the tool's body, mm; 0 inside: a convex function of the point.
inline double CalcToolDistance(const Tool& tool, const Vec3& p_T) {
  return std::max(CalcSignedToolDistance(tool, p_T), 0.0);
}
/// The same from all that the tool passes in a whole stroke, with the set of its teeth; of a tool that turns, the same.
double CalcPassedDistance(const Tool& tool, const Vec3& p_T);
/// Returns the point of the edge that lies furthest along a direction of any length, tool frame; the origin if the edge
/// lies across the direction.
Vec3 FindDeepest(const Tool& tool, const Vec3& n_T);

/// Returns an upper bound on the distance that any point of a ball of radius `reach_mm` about the tool's origin moves
/// between two poses, mm. Tick-safe.
double CalcTravel(const Pose& from, const Pose& to, double reach_mm);

}  // namespace kerf
