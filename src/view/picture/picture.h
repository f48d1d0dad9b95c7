// Still pictures of bones and the saw, drawn by VTK without a display (EGL; software rendering will do).
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

/// From where the patient is seen (world = LPS: x to the patient's left, y to the back, z to the head).
enum class View { kFront, kBack, kLeft, kRight, kTop, kBottom, kThreeQuarter };
const char* ToString(View view);  // "front", ... "three-quarter"
std::optional<View> ViewFromString(const std::string& name);

/// Parallel projection, so that a mm is a mm everywhere in the picture.
struct Camera {
  Vec3 toward_eye_W{0, -1, 0};   // from what is looked at to the eye; any length
  Vec3 up_W{0, 0, 1};            // not parallel to toward_eye_W
  std::optional<Vec3> target_W;  // in the picture's middle; none: everything is fitted into the picture
  double height_mm = 0;          // what the picture's height shows, > 0 when target_W is given
};
Camera MakeCamera(View view);
/// Looks at `target_W` from near.
Camera MakeCamera(const Vec3& toward_eye_W, const Vec3& up_W, const Vec3& target_W, double height_mm);

/// A surface to draw.
struct Shape {
  TriangleMesh mesh_W;
  Rgb8 colour = kBoneColour;
  std::vector<Rgb8> point_colours;  // one for each point, or empty: `colour` throughout
  double opacity = 1;               // 0 to 1
  bool shiny = false;               // metal
};

/// The tool at a pose: a disc with its teeth or a ball with its flutes, and a short end of the spindle.
struct ToolInPicture {
  Tool tool;
  Pose X_WT;
  double opacity = 1;
};

/// From tail to tip.
struct Arrow {
  Vec3 tail_W{0};
  Vec3 tip_W{0};
  Rgb8 colour = kForceColour;
  std::string label;  // beside the tail; may be empty
};

enum class Orientation { kNone, kPatient, kAxes };  // a cube with L R A P S I, or axes x y z, in the corner

struct PictureSpec {
  int width = 1280;  // 64 to 8192 pixels
  int height = 720;
  std::vector<Shape> shapes;
  std::vector<ToolInPicture> tools;
  std::vector<Arrow> arrows;
  Camera camera = MakeCamera(View::kThreeQuarter);
  bool dark = false;    // background
  std::string title;    // one line
  std::string caption;  // smaller, below the title; may have line breaks
  std::vector<LegendEntry> legend;
  bool scale_bar = true;
  Orientation orientation = Orientation::kPatient;
  bool fit_to_tool = true;  // a camera without target also takes in the tool and the arrows
  bool axes = false;        // patient coordinates in mm around the shapes, and a grid; for a camera without target
};

/// How world points come to lie in the picture.
struct ViewFrame {
  Vec3 centre_W;  // at the picture's middle
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
/// What the axes are drawn around: the shapes.
Box3 CalcShapeBox(const PictureSpec& spec);
/// Throws Error when there is nothing to fit or a value is out of range.
ViewFrame CalcViewFrame(const PictureSpec& spec);

/// Throws Error when the spec is out of range or this machine can't draw (no EGL).
Image RenderPicture(const PictureSpec& spec);
/// Whether this build can draw: KERF_WITH_PICTURES.
extern const bool kPicturesBuilt;
/// RenderPicture as a PNG.
void WritePicture(const PictureSpec& spec, const std::string& path);

/// The saw as closed surfaces in its own frame: the toothed disc, `thickness_mm` thick between z = +-thickness/2, and a
/// short end of the spindle.
TriangleMesh MakeToolMesh(const Tool& tool);

}  // namespace kerf
