// The picture in the window: bone, tool, plan, pieces and the panels over them.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kerf/geometry.h"
#include "kerf/material.h"
#include "kerf/tool.h"
#include "view/live/bone_chunks.h"
#include "view/live/camera.h"
#include "view/live/ct_slices.h"
#include "view/live/hud.h"
#include "view/live/inner_surfaces.h"
#include "view/picture/colours.h"
#include "view/picture/image.h"

class vtkRenderWindow;

namespace kerf {

/// A plane of the plan, or one that was achieved, as a rectangle.
struct PlaneOverlay {
  std::string name;
  Vec3 p_W{0};  // the rectangle's middle
  Vec3 normal_W{0, 0, 1};
  double width_mm = 40;
  double height_mm = 40;
  Vec3 up_W{0, 0, 1};  // the height's direction, where it is not along the normal
  Rgb8 colour{0, 114, 178};
  bool selected = false;

  bool operator==(const PlaneOverlay&) const = default;
};

/// How deep the tool may go: a plane of its own look, hatched at the side that is kept.
struct DepthStopOverlay {
  std::string name;
  Vec3 p_W{0};
  Vec3 normal_W{0, 0, 1};  // towards where the tool comes from
  double radius_mm = 12;
  bool reached = false;

  bool operator==(const DepthStopOverlay&) const = default;
};

/// A line that is to be followed.
struct GuideOverlay {
  std::vector<Vec3> points_W;

  bool operator==(const GuideOverlay&) const = default;
};

/// A distance (two points) or an angle (three, the second is the corner), with what it says.
struct MeasureOverlay {
  std::vector<Vec3> points_W;
  std::string label;

  bool operator==(const MeasureOverlay&) const = default;
};

/// A piece that came off, drawn by itself. Its mesh stays in the place where it was cut; `X_WP` moves it.
struct PieceShape {
  int id = 0;
  std::shared_ptr<const TriangleMesh> mesh_W;
  Pose X_WP;
  Rgb8 colour = kBoneColour;
  std::shared_ptr<const std::vector<Rgb8>> point_colours;  // one for each point of the mesh; null: `colour` throughout
  bool selected = false;                                   // framed by a box, and tinted where it has one colour
  bool hidden = false;
};

struct ForceArrow {
  Vec3 p_W{0};    // where it acts
  Vec3 f_W_N{0};  // drawn 8 mm a newton at most 60 mm, but at least as long as its head
};

/// What the last picture cost.
struct ViewStats {
  std::size_t chunks = 0;         // held
  std::size_t drawn = 0;          // of them, in the last picture
  std::size_t triangles = 0;      // likewise
  std::size_t surface_bytes = 0;  // of all chunks held, on the graphics card
  int step = 1;                   // of uncut chunks in the last picture: what SurfaceWorker::Want() needs at least
};

/// Draws into a window that somebody else made and gives a size; everything in the thread that owns its OpenGL context.
/// Setters cost little when nothing has changed; nothing is drawn before Render().
class Viewport {
 public:
  explicit Viewport(vtkRenderWindow& window);
  ~Viewport();  // while the context is still there
  Viewport(const Viewport&) = delete;
  Viewport& operator=(const Viewport&) = delete;

  /// In framebuffer pixels; of none, as of a minimised window, nothing changes. `scale`: of words and lines, 1 to 4, 2
  /// on a display of twice the density. Throws Error for another scale.
  void Resize(int width, int height, double scale);
  int width() const;
  int height() const;
  double scale() const;

  // ---- the bone
  /// Before the first chunk of a bone: forgets the chunks before. `origin_W`: SurfaceWorker::origin_W().
  void BeginBone(const MaterialTable& materials, const Vec3& origin_W, const Box3& bounds_W, double voxel_mm);
  /// Uploads a chunk in place of the one that it was; the first one or the newer.
  void SetChunk(const ChunkMesh& mesh);
  void SetInnerSurfaces(const InnerSurfaces& surfaces);
  void set_colour_by(ColourBy by);
  ColourBy colour_by() const;
  void set_translucent(bool translucent);  // shows nerve canal and roots
  bool translucent() const;
  void set_bone_hidden(bool hidden);
  /// What colours mean now; empty in plain mode while nothing is cut.
  std::vector<LegendEntry> legend() const;

  // ---- tool, plan, pieces
  void SetTool(const Tool& tool);
  void ClearTool();
  /// `angle_rad`: how far it has turned; teeth are drawn one by one below a speed at which they could be seen.
  void SetToolPose(const Pose& X_WT, double rpm, double angle_rad);
  /// Of the tool that is there now: steel until it is told so.
  void SetToolColour(const Rgb8& colour);
  /// The handle's own place where it leads the tool; none: not shown.
  void SetGhost(const std::optional<Pose>& X_WH);
  void SetForce(const std::optional<ForceArrow>& force);
  void SetPlanes(const std::vector<PlaneOverlay>& planes);
  void SetDepthStops(const std::vector<DepthStopOverlay>& stops);
  void SetGuides(const std::vector<GuideOverlay>& guides);
  void SetMeasures(const std::vector<MeasureOverlay>& measures);
  void SetPieces(const std::vector<PieceShape>& pieces);
  /// None: not shown.
  void SetSlices(const std::optional<CtSlices>& slices);

  // ---- panels
  /// The legend of the colours is filled in when `state.legend` is empty.
  void SetHud(const HudState& state);
  void set_show_scale_bar(bool show);
  void set_show_orientation(bool show);

  // ---- camera and mouse
  ViewCamera& camera();
  const ViewCamera& camera() const;
  /// The whole bone (and pieces) between the panels.
  void FitAll();
  /// The piece under a pixel (0: none) and where; hidden ones are not hit.
  struct PieceHit {
    int id = 0;
    Vec3 p_W{0};
  };
  std::optional<PieceHit> PickPiece(const ScreenPoint& at) const;
  /// Whether a pixel lies on a panel, so that the mouse there is not meant for the scene.
  bool IsOnPanel(const ScreenPoint& at) const;
  /// The row of the menu, or of the list of pieces, under a pixel.
  std::optional<int> PickMenuRow(const ScreenPoint& at) const;
  std::optional<int> PickPieceRow(const ScreenPoint& at) const;

  /// Draws everything into the window's frame buffer; the owner shows it.
  void Render();
  /// The last picture, read back.
  Image Grab();
  const ViewStats& stats() const;
  std::string renderer_name() const;  // the driver's, "llvmpipe (...)"
  /// Edges without stairs; by itself only with a graphics card.
  void set_smooth_edges(bool smooth);
  /// How fine bone that was not cut is drawn: cells of at least and at most so many points of the screen, and in
  /// between at most so many triangles in all. By itself: 1.5 to 3 and six million with a graphics card, 1.5 to 14 and
  /// 150 000 without.
  void SetFineness(double cell_points, double coarsest_cell_points, std::size_t triangles);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
