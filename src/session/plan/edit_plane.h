// Changes of a planned plane: by amounts, by values in fields, and by handles that the user drags. All functions are
// pure: they return the changed plane.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "session/plan/plan.h"

namespace kerf {

/// Axes of a plane's rectangle, world frame, unit length: across x up = normal.
struct PlaneAxes {
  Vec3 across_W{0};  // of the width
  Vec3 up_W{0};      // of the height: the part of the plane's up_W that lies in the plane
  Vec3 normal_W{0};
};
/// If the plane's up_W is parallel to its normal, the world's axis that is furthest from the normal is used instead.
PlaneAxes CalcPlaneAxes(const PlannedPlane& plane);
/// Returns the corners of the rectangle, world frame, in this order: lower left, lower right, upper right, upper left
/// (right: along the across axis).
std::array<Vec3, 4> CalcPlaneCorners(const PlannedPlane& plane);

/// Moves the plane along its own axes: x across, y up, z along the normal; mm.
PlannedPlane MovePlane(PlannedPlane plane, const Vec3& move_mm);
/// Rotates the plane about its centre: first about its across axis, then about its new up axis, each counter-clockwise
/// as seen against the axis. The rectangle rotates with it.
PlannedPlane TiltPlane(PlannedPlane plane, double about_across_deg, double about_up_deg);

/// Rotates the plane about its centre and one of its own axes, counter-clockwise as seen against the axis. The
/// rectangle rotates with it. Any angle is allowed, and the axis itself does not move.
enum class PlaneAxis : std::uint8_t { kAcross, kUp, kNormal };
PlannedPlane TurnPlane(PlannedPlane plane, PlaneAxis axis, double angle_deg);

/// Angles between the plane and the patient's planes, 0 to 90 degrees. They depend on nothing but its normal.
struct PatientAngles {
  double sagittal_deg = 0;
  double coronal_deg = 0;
  double axial_deg = 0;
};
PatientAngles CalcPatientAngles(const PlannedPlane& plane);
/// Rotates the plane about its centre until it is parallel to a plane of the patient, its normal to the side to which
/// it pointed before, and the rectangle's height along the patient's axis that was nearest.
PlannedPlane AlignPlane(PlannedPlane plane, PatientPlane with);

/// Returns the plane mirrored at the sagittal plane x = mid_x_mm (the patient's midsagittal plane), named "NAME
/// mirrored" or, if that name is taken in `plan`, "NAME mirrored 2" and so on. It is not yet cut (kPlanned).
PlannedPlane MirrorPlane(const Plan& plan, const PlannedPlane& plane, double mid_x_mm);

/// Returns `wanted` or, if it is taken, the first unused of "wanted 2", "wanted 3", ... At most 60 characters long.
std::string MakeUniquePlaneName(const Plan& plan, const std::string& wanted);
/// Renames plane `i`. Throws kerf::Error if the name is empty, longer than 60 characters, or that of another plane.
void RenamePlane(Plan& plan, std::size_t i, const std::string& name);
/// Moves plane `from` to place `to` in the order of the cuts; the others keep their order. Throws kerf::Error if there
/// is no such place.
void ReorderPlane(Plan& plan, std::size_t from, std::size_t to);

/// Points of a plane that the user drags.
enum class PlaneHandleKind : std::uint8_t {
  kCentre,      // moves the plane's rectangle within the plane
  kNormal,      // tip of an arrow from the centre: moves the plane along its normal
  kTiltAcross,  // middle of the upper edge: rotates the plane about its across axis
  kTiltUp,      // middle of the right edge: rotates the plane about its up axis
  kCorner,      // changes the size; the opposite corner stays
};
struct PlaneHandle {
  PlaneHandleKind kind = PlaneHandleKind::kCentre;
  int corner = 0;  // of a kCorner: its index in CalcPlaneCorners()
  Vec3 p_W{0};     // position, world frame, mm
};
/// Returns the eight handles: centre, normal, the two tilts and the four corners. `arrow_mm`: length of the arrow.
std::vector<PlaneHandle> PlaneHandles(const PlannedPlane& plane, double arrow_mm = 15);

/// Line of sight through a point of the picture, world frame.
struct SightLine {
  Vec3 p_W{0};
  Vec3 direction_W{0, 0, -1};  // any length except 0
};
/// Returns the plane after its handle was dragged from one line of sight to another. The part of the handle's motion
/// that the handle allows follows the mouse exactly: in the plane for the centre and the corners, along the normal
/// through the handle for the others. Returns the plane unchanged if the lines of sight do not determine that motion,
/// that is, if they are within 3 degrees of the plane or of the normal, respectively. Sizes stay in kPlaneSizeRange_mm.
/// Pass the plane and the handle as they were when the drag began.
PlannedPlane DragHandle(const PlannedPlane& plane, const PlaneHandle& handle, const SightLine& from,
                        const SightLine& to);

}  // namespace kerf
