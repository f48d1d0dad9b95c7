// Picture in the window: bone, tool, plan, pieces and the panels over them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kerf/describe.h"
#include "kerf/geometry.h"
#include "kerf/material.h"
#include "kerf/tool.h"
#include "view/live/bone_chunks.h"
#include "view/live/camera.h"
#include "view/live/inner_surfaces.h"
#include "view/picture/colours.h"
#include "view/picture/image.h"

class vtkProp;
class vtkRenderWindow;

namespace kerf {

/// Plane of the plan, or an achieved one, drawn as a rectangle.
struct PlaneOverlay {
  std::string name;
  Vec3 p_W{0};  // centre of the rectangle
  Vec3 normal_W{0, 0, 1};
  double width_mm = 40;
  double height_mm = 40;
  Vec3 up_W{0, 0, 1};  // direction of the height; its part perpendicular to the normal is used
  Rgb8 colour{0, 114, 178};
  bool selected = false;

  bool operator==(const PlaneOverlay&) const = default;
};

/// Depth limit of the tool, drawn hatched to distinguish it from planes of the plan.
struct DepthStopOverlay {
  std::string name;
  Vec3 p_W{0};
  Vec3 normal_W{0, 0, 1};  // towards the side that the tool comes from
  double radius_mm = 12;
  bool reached = false;

  bool operator==(const DepthStopOverlay&) const = default;
};

/// Line to follow.
struct GuideOverlay {
  std::vector<Vec3> points_W;

  bool operator==(const GuideOverlay&) const = default;
};

/// Distance (two points) or angle (three points, the second is the corner), with its label.
struct MeasureOverlay {
  std::vector<Vec3> points_W;
  std::string label;

  bool operator==(const MeasureOverlay&) const = default;
};

/// Separated piece, drawn as an object of its own. Its mesh stays where the piece was cut; `X_WP` moves it.
struct PieceShape {
  int id = 0;
  std::shared_ptr<const TriangleMesh> mesh_W;
  Pose X_WP;
  Rgb8 colour = kBoneColour;
  std::shared_ptr<const std::vector<Rgb8>> point_colours;  // one for each point of the mesh; null: `colour` throughout
  bool selected = false;                                   // framed by a box, and tinted if it has one colour
  bool hidden = false;
};

struct ForceArrow {
  Vec3 p_W{0};    // point of application
  Vec3 f_W_N{0};  // drawn 8 mm long per newton, but at most 60 mm and at least as long as its head
};

/// Label of something in the picture.
struct SceneLabel {
  std::string text;
  double x = 0;  // position of the labelled spot, pixels
  double y = 0;
  Rgb8 colour{40, 44, 52};
};

/// Rectangle in pixels from the top left of the window.
struct ScreenBox {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  bool empty() const { return !(width > 0 && height > 0); }
};

/// Cost of the last picture.
struct ViewStats {
  std::size_t chunks = 0;         // stored
  std::size_t drawn = 0;          // of these, drawn in the last picture
  std::size_t triangles = 0;      // drawn in the last picture
  std::size_t surface_bytes = 0;  // all stored chunks, on the graphics card
  int step = 1;                   // of uncut chunks in the last picture
};

/// Enlargement of text and lines relative to a standard display.
inline constexpr Range kDisplayScaleRange{1, 4};

/// Draws into a window that is created and sized by the caller. All calls must come from the thread that owns its
/// OpenGL context. Setters are cheap if nothing has changed; nothing is drawn until Render().
class Viewport {
 public:
  explicit Viewport(vtkRenderWindow& window);
  ~Viewport();  // the context must still exist
  Viewport(const Viewport&) = delete;
  Viewport& operator=(const Viewport&) = delete;

  /// Sets the size in framebuffer pixels. An empty size, such as that of a minimised window, is ignored. `scale`: of
  /// text and lines, 1 to 4; 2 on a display with twice the usual density. Throws Error for another scale.
  void Resize(int width, int height, double scale);
  int width() const;
  int height() const;
  double scale() const;

  // ---- the bone
  /// Must be called before the first chunk of a bone; removes all earlier chunks. `origin_W`:
  /// SurfaceWorker::origin_W().
  void BeginBone(const MaterialTable& materials, const Vec3& origin_W, const Box3& bounds_W, double voxel_mm);
  /// Uploads a chunk, replacing the previous version if there is one.
  void SetChunk(const ChunkMesh& mesh);
  void SetInnerSurfaces(const InnerSurfaces& surfaces);
  void set_colour_by(ColourBy by);
  ColourBy colour_by() const;
  void set_translucent(bool translucent);  // shows the nerve canal and the roots
  bool translucent() const;
  void set_bone_hidden(bool hidden);
  /// Returns the legend of the current colours; empty in plain mode while nothing is cut.
  std::vector<LegendEntry> legend() const;

  // ---- tool, plan, pieces
  void SetTool(const Tool& tool);
  void ClearTool();
  /// `angle_rad`: angle by which the tool has turned. Individual teeth are drawn only at speeds at which they can be
  /// seen separately.
  void SetToolPose(const Pose& X_WT, double rpm, double angle_rad);
  /// Sets the colour of the current tool; steel by default.
  void SetToolColour(const Rgb8& colour);
  /// Sets the pose of the handle in a coupled simulation; unset: not shown.
  void SetGhost(const std::optional<Pose>& X_WH);
  void SetForce(const std::optional<ForceArrow>& force);
  void SetPlanes(const std::vector<PlaneOverlay>& planes);
  void SetDepthStops(const std::vector<DepthStopOverlay>& stops);
  void SetGuides(const std::vector<GuideOverlay>& guides);
  void SetMeasures(const std::vector<MeasureOverlay>& measures);
  void SetPieces(const std::vector<PieceShape>& pieces);

  // ---- panels
  /// Adds the panels, which are drawn over everything else. The prop must live longer than the viewport.
  void SetPanels(vtkProp& panels);
  void set_panels_shown(bool shown);
  /// Sets the area of the window that panels leave free for the bone, and that of the orientation cube (empty: not
  /// shown).
  void SetAreas(const ScreenBox& scene, const ScreenBox& cube);
  /// Returns the labels of everything shown, at their places in pixels, for the owner of the panels to draw.
  std::vector<SceneLabel> ListLabels() const;

  // ---- camera and mouse
  ViewCamera& camera();
  const ViewCamera& camera() const;
  /// Fits the whole bone and the pieces into the area between the panels.
  void FitAll();

  /// Draws everything into the window's frame buffer; the owner presents it.
  void Render();
  /// Reads back the last picture.
  Image Grab();
  const ViewStats& stats() const;
  std::string renderer_name() const;  // as reported by the driver: "llvmpipe (...)"
  /// Enables or disables antialiasing; by default it is enabled only with a graphics card.
  void set_smooth_edges(bool smooth);
  /// Sets the resolution of uncut bone: minimum and maximum cell size in points of the screen, and between these the
  /// maximum number of triangles in total. Defaults: 1.5 to 3 and six million with a graphics card, 1.5 to 14 and
  /// 150 000 without.
  void SetFineness(double cell_points, double coarsest_cell_points, std::size_t triangles);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
