// What the picture shows besides the bone, the tool and the pieces: plain values. Positions are in the world frame, mm.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/geometry.h"
#include "view/picture/colours.h"

namespace kerf {

/// Plane of the plan, or an achieved one, drawn as a rectangle.
struct PlaneOverlay {
  std::string name = {};
  Vec3 p_W{0};  // centre of the rectangle
  Vec3 normal_W{0, 0, 1};
  double width_mm = 40;
  double height_mm = 40;
  Vec3 up_W{0, 0, 1};  // direction of the height; its part perpendicular to the normal is used
  Rgb8 colour{0, 114, 178};
  bool selected = false;
  bool faint = false;  // hardly tints what is behind it, such as the colours of cut faces

  bool operator==(const PlaneOverlay&) const = default;
};

/// Bone that still joins two pieces, marked through the bone around it.
struct BridgeOverlay {
  std::vector<Vec3> points_W;                           // corners of the patch
  std::vector<std::array<std::uint32_t, 3>> triangles;  // empty: the points are the outline of a convex patch, in order
  Vec3 centre_W{0};
  std::string label = {};

  bool operator==(const BridgeOverlay&) const = default;
};

/// Meaning of a point that was clicked; each has a shape of its own.
enum class PointKind : std::uint8_t { kPlan, kMark, kMeasure };  // disc, diamond, square

/// Clicked point. It is visible through bone, but weaker.
struct PointOverlay {
  Vec3 p_W{0};
  PointKind kind = PointKind::kPlan;
  std::string label = {};  // optional
  bool selected = false;   // larger, with a ring

  bool operator==(const PointOverlay&) const = default;
};

/// Distance (two points) or angle (three points, the second is the corner), with its label.
struct MeasureOverlay {
  std::vector<Vec3> points_W;
  std::string label;

  bool operator==(const MeasureOverlay&) const = default;
};

/// What a handle of a plane does; each has a shape of its own.
enum class HandleKind : std::uint8_t { kMove, kTilt, kSize };  // disc with a cross, ring, square

struct PlaneHandleOverlay {
  Vec3 p_W{0};
  HandleKind kind = HandleKind::kMove;
  bool hot = false;  // under the mouse or held

  bool operator==(const PlaneHandleOverlay&) const = default;
};

/// Lines in which a plane meets the bone's surface, such as those of CalcSectionLines(). Weaker where bone hides them.
struct PlaneLineOverlay {
  std::vector<std::vector<Vec3>> lines_W;
  Rgb8 colour{0, 114, 178};
  bool selected = false;  // thicker

  bool operator==(const PlaneLineOverlay&) const = default;
};

/// Marked structure, such as a nerve: a tube along its points. It is hidden by solid bone and visible in translucent
/// bone; a selected mark has a centre line that is visible through bone.
struct MarkOverlay {
  std::vector<Vec3> points_W;
  double radius_mm = 1;
  Rgb8 colour{0, 114, 178};
  std::string label = {};  // optional; beside its first point
  bool selected = false;
  bool shows_through = false;  // its line is drawn also where bone hides it, as that of a selected one is

  bool operator==(const MarkOverlay&) const = default;
};

/// How near the tool is to something that it must not cut. Each level has its own colour, size and pattern.
enum class AlarmLevel : std::uint8_t { kNone, kNotice, kWarning, kDanger };

/// Ring around the place where the tool is nearest to something that it must not cut.
struct AlarmOverlay {
  Vec3 p_W{0};
  AlarmLevel level = AlarmLevel::kNone;  // kNone: not drawn
  std::string label = {};                // such as the name and the distance; optional

  bool operator==(const AlarmOverlay&) const = default;
};

}  // namespace kerf
