// Slices through the bone in any plane, with what is planned and marked in them, and the mapping between their pixels
// and the world. Pure.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/tool.h"
#include "view/live/inner_surfaces.h"
#include "view/live/overlays.h"
#include "view/picture/overlay.h"

namespace kerf {

/// Plane of a slice. The first three are seen as radiologists see them: axial from the feet, with the front up; coronal
/// from the front; sagittal from the patient's left. The last is the plane of the disc, with the patient's upright up
/// as far as possible.
enum class SliceKind : std::uint8_t { kAxial, kCoronal, kSagittal, kBlade };
const char* ToString(SliceKind kind);  // "axial", "coronal", "sagittal", "blade"

inline constexpr Range kSliceSide_px{8, 1024};

/// Window of CT numbers that is mapped from black to white.
struct CtWindow {
  double level_HU = 600;
  double width_HU = 2400;  // > 0
};

/// Wanted slice.
struct SliceSpec {
  SliceKind kind = SliceKind::kAxial;
  Vec3 centre_W{0};       // point in the middle of the image, before the offset
  double offset_mm = 0;   // of the plane: towards the head, the back, the patient's left, or along the spindle
  double width_mm = 100;  // of the image, above 0; a smaller width zooms in
  int width_px = 256;     // 8 to 1024
  int height_px = 256;    // 8 to 1024; pixels are square
  CtWindow window = {};
  Pose X_WT = {};  // of the disc; for kBlade

  bool operator==(const SliceSpec& other) const;
};

/// Position of an image in the world. Its frame S has its origin in the middle of the image, x to the right, y up and z
/// towards the viewer. Pixel positions count from the top left corner; whole numbers are pixel corners.
struct SliceFrame {
  Pose X_WS;
  double mm_per_pixel = 1;
  int width = 0;
  int height = 0;

  Vec3 PointOf(const OverlayPoint& px) const;
  /// Returns the pixel position of a point's projection into the plane.
  OverlayPoint PixelOf(const Vec3& p_W) const;
  /// Returns the signed distance of a point from the plane, mm, positive towards the viewer.
  double DistanceOf(const Vec3& p_W) const;
};
/// Throws Error if a value of the spec is out of range.
SliceFrame CalcSliceFrame(const SliceSpec& spec);

enum class SliceLineKind : std::uint8_t { kBone, kNerve, kTooth, kMark, kPoint, kPlane, kTool, kCursor };

/// Line in a slice, in pixel positions of its image.
struct SliceLine {
  SliceLineKind kind = SliceLineKind::kBone;
  std::vector<OverlayPoint> points;  // the first again at the end if the line is closed
  Rgb8 colour{255, 200, 40};
  double width_points = 1.5;
  bool dashed = false;
  std::string name;  // of a plane, a mark or a point
};

struct SliceImage {
  SliceSpec spec;
  SliceFrame frame;
  Image image;                   // grey, without lines: CT numbers, or the tissues if the bone has no CT numbers
  bool has_ct = false;           // what the image shows
  std::vector<SliceLine> lines;  // bone, and nerve and teeth within it
  // Patient's sides closest to the edges: L, R, A, P, S or I.
  std::string left_letter, right_letter, up_letter, down_letter;
};

/// CT number at a point of the world, mm; may be called by several threads at once.
using CtSource = std::function<double(const Vec3& p_W)>;

/// Computes a slice of the bone's current state. `inner`: nerve canal and teeth, or null. `ct`: the whole CT of the
/// bone; null: the CT numbers that the bone has itself, near it. Uses several threads if the caller runs in a TBB arena
/// that has them. Throws Error if a value of the spec is out of range.
SliceImage CalcSlice(const Bone& bone, const SliceSpec& spec, const InnerSurfaces* inner = nullptr,
                     const CtSource* ct = nullptr);

/// What is drawn in a slice besides the bone.
struct SliceScene {
  std::optional<Tool> tool;  // none: there is no slice in its plane either
  Pose X_WT;
  double displacement_mm = 0;  // of a blade with a stroke, whose whole stroke is shown too
  std::string note{};          // about the slices, shown above them
  std::vector<PlaneOverlay> planes;
  std::vector<MarkOverlay> marks;
  std::vector<PointOverlay> points;  // circles, dashed if they lie more than a millimetre away from the plane
  std::optional<Vec3> cursor_W;      // a cross, dashed if it lies more than a millimetre away from the plane
};
/// Computes the lines in which planes, tool and marks meet a slice, the points and the cursor. Takes about 0.1 ms.
std::vector<SliceLine> CalcSliceLines(const SliceFrame& frame, const SliceScene& scene);

/// Draws lines into an image. `scale`: pixels per point.
void DrawSliceLines(const std::vector<SliceLine>& lines, double scale, Image& image);

/// Returns the lines in which a surface meets the plane z = 0 of the frame, joined as far as possible.
std::vector<std::vector<Vec3>> SliceMesh(const TriangleMesh& mesh_W, const Pose& X_WS);

/// Computes the lines in which the rectangle of a plane meets the bone's surface, in the world frame. `step_mm`:
/// spacing of the samples of the level set, above 0.
std::vector<std::vector<Vec3>> CalcSectionLines(const Bone& bone, const PlaneOverlay& plane, double step_mm);

}  // namespace kerf
