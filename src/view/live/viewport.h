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
#include "view/live/overlays.h"
#include "view/picture/colours.h"
#include "view/picture/image.h"

class vtkProp;
class vtkRenderWindow;

namespace kerf {

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
  Rgb8 colour{0, 130, 95};

  bool operator==(const GuideOverlay&) const = default;
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
  Vec3 f_W_N{0};  // drawn 8 mm long per newton, but at least as long as its head, at most 60 mm, and at most a third of
                  // the view
  std::string label = {};  // beside the tail; empty: the magnitude

  bool operator==(const ForceArrow&) const = default;
};

/// Label of something in the picture.
struct SceneLabel {
  std::string text;
  double x = 0;  // position of the labelled spot, pixels
  double y = 0;
  Rgb8 colour{40, 44, 52};
  bool matters = false;  // during a cut: an alarm, the force, or the largest part of a plane that still holds
};

/// Ring of an alarm in the picture.
struct SceneRing {
  double x = 0;  // pixels
  double y = 0;
  AlarmLevel level = AlarmLevel::kNone;
};

/// Rectangle in pixels from the top left of the window.
struct ScreenBox {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;

  bool empty() const { return !(width > 0 && height > 0); }
  bool operator==(const ScreenBox&) const = default;
};

/// Cost of the last picture.
struct ViewStats {
  std::size_t chunks = 0;         // stored
  std::size_t drawn = 0;          // of these, drawn in the last picture
  std::size_t triangles = 0;      // drawn in the last picture
  std::size_t surface_bytes = 0;  // of the buffers for chunks on the graphics card
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
  /// Must be called before the first chunk of a bone; removes all earlier chunks. `origin_W`
  /// and `bounds_W`: SurfaceWorker::origin_W() and drawn_bounds_W().
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
  void SetToolPose(const Pose& X_WT, double rpm, double angle_rad, double displacement_mm = 0);
  /// Sets the colour of the current tool; steel by default.
  void SetToolColour(const Rgb8& colour);
  /// Sets the pose of the handle in a coupled simulation; unset: not shown.
  void SetGhost(const std::optional<Pose>& X_WH);
  void SetForce(const std::optional<ForceArrow>& force);
  /// Shows the handpiece behind the tool; on by default.
  void set_show_handpiece(bool show);
  bool show_handpiece() const;
  /// Draws the handpiece translucent, because it passes through bone.
  void SetHandpieceInBone(bool in_bone);
  /// Sets where the tool cuts: handpiece and disc become translucent where they hide this place, and the guard is on
  /// the other side of the disc. Unset: the tool does not cut.
  void SetContact(const std::optional<Vec3>& p_W);
  /// Adds the dust of a removed volume; `v_W`: velocity of the teeth, mm/s. Ignored while dust is switched off.
  void AddDust(const Vec3& p_W, const Vec3& v_W, double volume_mm3);
  /// Moves the dust; call it once per picture.
  void AdvanceDust(double dt_s);
  /// On by default. Switching it off removes the dust.
  void set_show_dust(bool show);
  bool show_dust() const;
  void SetPlanes(const std::vector<PlaneOverlay>& planes);
  void SetDepthStops(const std::vector<DepthStopOverlay>& stops);
  void SetGuides(const std::vector<GuideOverlay>& guides);
  void SetMeasures(const std::vector<MeasureOverlay>& measures);
  void SetPieces(const std::vector<PieceShape>& pieces);
  void SetBridges(const std::vector<BridgeOverlay>& bridges);
  void SetPoints(const std::vector<PointOverlay>& points);
  void SetPlaneHandles(const std::vector<PlaneHandleOverlay>& handles);
  void SetPlaneLines(const std::vector<PlaneLineOverlay>& lines);
  void SetMarks(const std::vector<MarkOverlay>& marks);
  void SetAlarms(const std::vector<AlarmOverlay>& alarms);

  // ---- panels
  /// Adds the panels, which are drawn over everything else. The prop must live longer than the viewport.
  void SetPanels(vtkProp& panels);
  void set_panels_shown(bool shown);
  /// Sets the area of the window that panels leave free for the bone, and that of the orientation cube (empty: not
  /// shown).
  void SetAreas(const ScreenBox& scene, const ScreenBox& cube);
  /// Returns the labels of everything shown, the most important first, at their places in pixels, for the owner of the
  /// panels to draw.
  std::vector<SceneLabel> ListLabels() const;
  /// Returns the place of SetContact() in pixels; unset: the tool does not cut.
  std::optional<ScreenPoint> FindCut() const;
  /// Returns the rings of alarms, at their places in pixels.
  std::vector<SceneRing> ListRings() const;
  /// Returns the points of distances and angles on the screen, pixels, which labels should avoid.
  std::vector<ScreenPoint> ListMeasuredPoints() const;
  /// Returns the area of the tool on the screen, pixels, which labels should avoid; empty if there is no tool.
  ScreenBox CalcToolBox() const;
  /// Returns true if a pixel lies within the outline of the tool's disc or ball.
  bool IsOnTool(const ScreenPoint& at) const;
  /// Sets the brightness of the background; light by default.
  void set_theme(Theme theme);
  Theme theme() const;

  // ---- camera and mouse
  ViewCamera& camera();
  const ViewCamera& camera() const;
  /// Fits the whole bone and the pieces into the area between the panels.
  void FitAll();
  /// Fits points into an area of the picture, pixels. Keeps the direction of the view.
  void FitPoints(const std::vector<Vec3>& points_W, const ScreenBox& area);
  /// Returns the index of the point, or of the plane's handle, that is nearest to a pixel on the screen and at most a
  /// radius away; of two at the same place, the later one.
  std::optional<int> PickPoint(const ScreenPoint& at, double radius_px) const;
  /// On the tool, which a handle may lie in front of, only the symbol itself counts: beside it, the tool is meant.
  std::optional<int> PickHandle(const ScreenPoint& at) const;

  /// Returns true if something has changed since the last Render(): the camera or anything in the picture except the
  /// panels.
  bool has_changed() const;
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
