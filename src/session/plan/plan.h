// A surgeon's plan: planes and depth stops, and the tool's deviation from them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/files/markups.h"
#include "kerf/describe.h"
#include "kerf/effects.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Progress of a planned cut, set by the user.
enum class PlaneState : std::uint8_t { kPlanned, kInProgress, kDone };
inline constexpr std::array<std::string_view, 3> kPlaneStateWords{"planned", "in_progress", "done"};

/// Planes of the patient. Their normals are the axes of the world frame: left, back and head.
enum class PatientPlane : std::uint8_t { kSagittal, kCoronal, kAxial };

/// A plane along which the disc's mid-plane should cut. The intended cut is a rectangle in it; its axes are those of
/// CalcPlaneAxes() (edit_plane.h).
struct PlannedPlane {
  std::string name;
  CutPlane plane{};  // its point: centre of the intended cut
  double margin_mm = 1;
  double width_mm = 50;   // of the rectangle, perpendicular to its height
  double height_mm = 50;  // of the rectangle, along the part of up_W that lies in the plane
  Vec3 up_W{0, 0, 1};     // any length except 0
  PlaneState state = PlaneState::kPlanned;
};

/// Limit of the cut's depth: the tool's deepest point should be at most `depth_mm` from the point along the direction.
struct DepthStop {
  std::string name;
  Vec3 p_W_mm{0};
  Vec3 direction_W{0, 0, -1};  // into the bone; unit length
  double depth_mm = 5;
};

inline constexpr TextLimit kPlanNameLimit{60};
inline constexpr Range kPlaneSizeRange_mm{1, 500};

template <typename V>
void Describe(PlannedPlane& p, V&& visit) {
  visit("name", p.name, kPlanNameLimit, "unique name, used in reports; by default \"plane 1\", \"plane 2\" and so on");
  visit("point_mm", p.plane.p_W, kCoordinateRange_mm, "middle of the planned cut, on the plane");
  visit("normal", p.plane.normal_W, kDirectionRange, "normal of the plane, world frame; any length but 0");
  visit("margin_mm", p.margin_mm, Range{0.01, 100}, "distance from the plane within which the cut should stay");
  visit("width_mm", p.width_mm, kPlaneSizeRange_mm, "width of the intended cut, in the plane and perpendicular to up");
  visit("height_mm", p.height_mm, kPlaneSizeRange_mm, "height of the intended cut, in the plane");
  visit("up", p.up_W, kDirectionRange,
        "direction of the height, world frame; its part in the plane is used; any length but 0");
  std::string state(kPlaneStateWords[static_cast<std::size_t>(p.state)]);
  visit("state", state, Choices{{kPlaneStateWords.begin(), kPlaneStateWords.end()}},
        "progress of the cut, as the user has marked it");
  for (std::size_t i = 0; i < kPlaneStateWords.size(); ++i) {
    if (state == kPlaneStateWords[i]) p.state = static_cast<PlaneState>(i);
  }
}

template <typename V>
void Describe(DepthStop& p, V&& visit) {
  visit("name", p.name, kPlanNameLimit, "unique name, used in reports; by default \"stop 1\", \"stop 2\" and so on");
  visit("point_mm", p.p_W_mm, kCoordinateRange_mm, "point from which the depth is measured, world frame");
  visit("direction", p.direction_W, kDirectionRange,
        "direction of the depth, into the bone, world frame; any length but 0");
  visit("depth_mm", p.depth_mm, Range{0, 1000}, "planned depth of the tool's deepest point beyond the point");
}

struct Plan {
  std::vector<PlannedPlane> planes;  // in the order in which they should be cut
  std::vector<DepthStop> stops;

  bool empty() const { return planes.empty() && stops.empty(); }
};

/// Maximum number of planes, and also of stops.
inline constexpr std::size_t kMaxPlanned = 100;

/// Throws kerf::Error naming the first item without a name, with a duplicate name, with a direction that is not of unit
/// length, or with a value out of range.
void CheckPlan(const Plan& plan);
/// Returns the first unused name: "plane 1", "stop 2".
std::string MakePlaneName(const Plan& plan);
std::string MakeStopName(const Plan& plan);

/// Returns the plane through three points, with their mean as its point. Seen from the side to which the normal points,
/// the three are in counter-clockwise order. Throws kerf::Error if they are collinear.
PlannedPlane PlacePlane(const std::string& name, const Vec3& a_W, const Vec3& b_W, const Vec3& c_W);
/// Returns the disc's plane at the pose.
PlannedPlane PlacePlane(const std::string& name, const Pose& X_WT);
/// End of the name of a plane as it was cut; before it stands the name of the planned plane.
inline constexpr const char* kAsCut = ", as cut";
/// Reads all planes that 3D Slicer has saved in a .mrk.json file (see ReadPlaneMarkupList()), in all such files of a
/// folder, in the order of their names, or in those that a scene (.mrml) refers to. In a folder and a scene, only
/// markups of type Plane count, and BoneReconstructionPlanner's planes of a fibula are skipped ("FibulaPlane0_A"). A
/// plane without a name gets that of its file, and a repeated name a number. Planes as they were cut, which 'kerf
/// assess' writes, are skipped if there is another plane; `skipped` receives their files and names. Throws kerf::Error,
/// also if there is none.
std::vector<PlannedPlane> ReadPlannedPlanes(const std::string& path, std::vector<std::string>* skipped = nullptr);
/// Returns the files that ReadPlannedPlanes() reads. Throws kerf::Error.
std::vector<std::string> ListPlaneFiles(const std::string& path);
/// Returns true if the path is one of these, or a bundle (.mrb), which kerf does not read, by its name or as a folder.
bool IsPlanesPath(const std::string& path);
/// Returns markups for WritePlaneMarkups().
std::vector<PlaneMarkup> MakeMarkups(const Plan& plan);

/// Deviation of a blade from a planned plane, measured at the point of the blade that is closest to the plane's point:
/// for a disc a point of its mid-plane within the rim, for a ball the centre.
struct PlaneDeviation {
  Vec3 p_W_mm{0};                   // that point
  double offset_mm = 0;             // its distance from the plane, positive on the side of the normal
  std::optional<double> angle_deg;  // between the planes, 0 to 90; all angles are unset for a ball
  /// The two components of the angle, each -90 to 90: tan^2 angle = tan^2 pitch + tan^2 roll. The depth direction
  /// points from the disc's centre to that point, within the planned plane. Roll: inclination; positive if the offset
  /// grows with depth. Pitch: rotation about the depth direction; positive if the offset grows along normal x depth.
  std::optional<double> pitch_deg;
  std::optional<double> roll_deg;
  bool within_margin = false;  // true if |offset_mm| is at most the margin
};
/// Has no side effects and takes about a microsecond.
PlaneDeviation CalcDeviation(const PlannedPlane& planned, const Tool& tool, const Pose& X_WT);

/// Angles between two planes, defined as in PlaneDeviation. Both normals have unit length; `depth_W` is any direction
/// that is not parallel to the planned normal.
struct PlaneAngles {
  double angle_deg = 0;
  double pitch_deg = 0;
  double roll_deg = 0;
};
PlaneAngles CalcPlaneAngles(const Vec3& planned_normal_W, const Vec3& normal_W, const Vec3& depth_W);

struct StopDeviation {
  double depth_mm = 0;  // of the tool's deepest point (for a disc: of its mid-plane) beyond the stop's point
  double left_mm = 0;   // remaining distance to the stop; negative if the tool is beyond it
};
StopDeviation CalcDeviation(const DepthStop& stop, const Tool& tool, const Pose& X_WT);

/// Distance from the plane within which a guide does not hold the saw. A saw guide made of metal has a similar play.
inline constexpr double kGuidePlay_mm = 0.1;
/// Returns the effect "guide" that keeps the tool on the plane, at the stop, or both. On the plane, it has the play
/// above, or the plane's margin if that is smaller. Throws kerf::Error if both are
/// null, or if the stop's direction is more than 20 degrees off the plane (if the angle is smaller, the direction is
/// rotated into the plane).
EffectChoice MakeGuide(const PlannedPlane* plane, const DepthStop* stop);
/// Returns whether `guide`, an effect "guide", keeps the tool on this plane, to 0.01 mm and 0.001 rad.
bool IsGuideOf(const EffectChoice& guide, const PlannedPlane& plane);

}  // namespace kerf
