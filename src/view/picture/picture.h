// Still pictures of bones and the saw, drawn by VTK without a display (EGL; software rendering is sufficient).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"
#include "view/picture/colours.h"
#include "view/picture/image.h"

namespace kerf {

/// Direction from which the patient is seen (world = LPS: x to the patient's left, y to the back, z to the head).
enum class View { kFront, kBack, kLeft, kRight, kTop, kBottom, kThreeQuarter };
const char* ToString(View view);  // "front", ... "three-quarter"
std::optional<View> ViewFromString(const std::string& name);

/// Camera with parallel projection: the scale is equal everywhere in the picture.
struct Camera {
  Vec3 toward_eye_W{0, -1, 0};   // from the target to the eye; any length
  Vec3 up_W{0, 0, 1};            // not parallel to toward_eye_W
  std::optional<Vec3> target_W;  // in the middle of what is below the title; unset: everything is fitted
  double height_mm = 0;          // height of the region visible there, > 0 if target_W is set
};
Camera MakeCamera(View view);
/// Returns a camera aimed at `target_W`.
Camera MakeCamera(const Vec3& toward_eye_W, const Vec3& up_W, const Vec3& target_W, double height_mm);
/// Returns a camera that looks into a cut: against `out_W` and a little along the cut, in the cut's plane, which
/// appears as a line. `out_W`: out of the bone; `normal_W`: of the plane; both of unit length and perpendicular.
Camera MakeCutCamera(const Vec3& out_W, const Vec3& normal_W, const Vec3& target_W, double height_mm);

/// Surface to draw.
struct Shape {
  TriangleMesh mesh_W;
  Rgb8 colour = kBoneColour;
  std::vector<Rgb8> point_colours;  // one for each point; empty: `colour` throughout
  double opacity = 1;               // 0 to 1
  bool shiny = false;               // metal
};

/// Tool at a pose: a disc with its teeth or a ball with its flutes, and the end of the spindle.
struct ToolInPicture {
  Tool tool;
  Pose X_WT;
  double opacity = 1;
  double rpm = 0;  // not 0: a bent arrow shows the sense in which it turns
};

/// Arrow from tail to tip.
struct Arrow {
  Vec3 tail_W{0};
  Vec3 tip_W{0};
  Rgb8 colour = kForceColour;
  std::string label;  // next to the tail; optional
};

enum class Orientation { kNone, kPatient, kAxes };  // a cube with L R A P S I, or axes x y z, in the corner

struct PictureSpec {
  int width = 1280;
  int height = 720;
  std::vector<Shape> shapes;
  std::vector<ToolInPicture> tools;
  std::vector<Arrow> arrows;
  Camera camera = MakeCamera(View::kThreeQuarter);
  bool dark = false;    // background
  std::string title;    // broken into lines that fit, as is the caption
  std::string caption;  // smaller, below the title
  std::vector<LegendEntry> legend;
  bool scale_bar = true;
  Orientation orientation = Orientation::kPatient;
  bool fit_to_tool = true;  // a camera without a target includes the tool and the arrows
  bool axes = false;        // patient coordinates in mm around the shapes, and a grid; for a camera without a target
};

/// Mapping from world points to the picture.
struct ViewFrame {
  Vec3 centre_W;  // at the picture's centre
  Vec3 right_W;   // unit
  Vec3 up_W;      // unit
  Vec3 toward_eye_W;
  double pixels_per_mm;
  int width;
  int height;

  struct Pixel {
    double column;  // from the left edge
    double row;     // from the top edge
  };
  Pixel Project(const Vec3& p_W) const;
};
/// Returns the box around the shapes; the axes are drawn around it.
Box3 CalcShapeBox(const PictureSpec& spec);
/// Throws Error if there is nothing to fit or a value is out of range.
ViewFrame CalcViewFrame(const PictureSpec& spec);

/// Throws Error if the spec is out of range or this machine cannot draw (no EGL).
Image RenderPicture(const PictureSpec& spec);
/// True if this build can draw, i.e. was built with KERF_WITH_PICTURES.
extern const bool kPicturesBuilt;
/// Returns a sentence that says why this build or this machine can't draw; empty if it can. Drawing itself
/// reports a lack of memory.
std::string FindLackOfPictures();
/// Throws Error with that sentence. For commands with figures in their report, before they compute.
void RequirePictures();
/// Writes RenderPicture() as a PNG.
void WritePicture(const PictureSpec& spec, const std::string& path);

}  // namespace kerf
