// What a surgeon means to cut: planes and depth stops, and how far the tool is off them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/files/markups.h"
#include "kerf/effects.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// A plane to cut along: of the disc's middle.
struct PlannedPlane {
  std::string name;
  CutPlane plane;        // its point: the middle of the cut that is meant
  double margin_mm = 1;  // the cut should stay so near; 0.01 to 100
};

/// The tool's deepest point should go `depth_mm` past the point along the direction, and no further.
struct DepthStop {
  std::string name;
  Vec3 p_W_mm{0};
  Vec3 direction_W{0, 0, -1};  // into the bone; unit length
  double depth_mm = 5;         // 0 to 1000
};

struct Plan {
  std::vector<PlannedPlane> planes;
  std::vector<DepthStop> stops;

  bool empty() const { return planes.empty() && stops.empty(); }
};

/// At most so many of each.
inline constexpr std::size_t kMostPlanned = 100;

/// Throws Error naming the first that has no name, the name of another, a direction that is not of unit length, or a
/// value out of range.
void CheckPlan(const Plan& plan);
/// "plane 1", "stop 2": the first that is free.
std::string MakePlaneName(const Plan& plan);
std::string MakeStopName(const Plan& plan);

/// Through three points, at their mean; seen from the side to which the normal points they go round
/// counter-clockwise. Throws Error when they lie on a line.
PlannedPlane PlacePlane(const std::string& name, const Vec3& a_W, const Vec3& b_W, const Vec3& c_W);
/// The disc's own plane where it is.
PlannedPlane PlacePlane(const std::string& name, const Pose& X_WT);
/// Each plane of a .mrk.json file of 3D Slicer, named as there. Throws Error as ReadPlaneMarkupList().
std::vector<PlannedPlane> ReadPlannedPlanes(const std::string& path);
/// For WritePlaneMarkups().
std::vector<PlaneMarkup> MakeMarkups(const Plan& plan);

/// Of a blade against a planned plane. The point of the blade that counts is the one nearest to the plane's point: of a
/// disc's mid-plane within its rim, of a ball the centre.
struct PlaneDeviation {
  Vec3 p_W_mm{0};                   // that point
  double offset_mm = 0;             // of it from the plane, to the side of the normal positive
  std::optional<double> angle_deg;  // between the planes, 0 to 90; none of a ball, here and below
  /// The angle's two parts, each -90 to 90, tan^2 angle = tan^2 pitch + tan^2 roll. The depth is the direction from
  /// the disc's centre to that point, in the planned plane. Roll: the lean; positive where the offset grows with depth.
  /// Pitch: the turn about the depth; positive where the offset grows along normal x depth.
  std::optional<double> pitch_deg;
  std::optional<double> roll_deg;
  bool within_margin = false;  // the offset is
};
/// Pure, a microsecond.
PlaneDeviation CalcDeviation(const PlannedPlane& planned, const Tool& tool, const Pose& X_WT);

/// Angles of one plane against another by the same definition. Both of unit length; `depth_W` any but along the first.
struct PlaneAngles {
  double angle_deg = 0;
  double pitch_deg = 0;
  double roll_deg = 0;
};
PlaneAngles CalcPlaneAngles(const Vec3& planned_normal_W, const Vec3& normal_W, const Vec3& depth_W);

struct StopDeviation {
  double depth_mm = 0;  // of the tool's deepest point (of a disc: of its mid-plane) past the stop's point
  double left_mm = 0;   // to the stop; negative: beyond it
};
StopDeviation CalcDeviation(const DepthStop& stop, const Tool& tool, const Pose& X_WT);

/// The effect "guide" that holds the tool to the plane, or at the stop, or both. Throws Error when both are null, or
/// the stop's direction is more than 20 degrees off the plane (less is turned into it).
EffectChoice MakeGuide(const PlannedPlane* plane, const DepthStop* stop);

}  // namespace kerf
