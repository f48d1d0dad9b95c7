// Everything in the scene except the bone: tool, plan, measures, pieces.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "view/live/viewport.h"
#include "view/live/xray_list.h"

class vtkRenderer;

namespace kerf {

class SceneActors {
 public:
  /// `scene`: for objects that the bone can hide; `over`: for objects above everything else.
  SceneActors(vtkRenderer& scene, vtkRenderer& over);
  ~SceneActors();
  SceneActors(const SceneActors&) = delete;
  SceneActors& operator=(const SceneActors&) = delete;

  /// Number of changes so far that are visible in a picture.
  std::uint64_t changes() const;
  void SetScale(double scale);  // pixels per point
  void SetInner(const InnerSurfaces& surfaces, bool shown);
  void ShowInner(bool shown);
  void SetTool(const Tool& tool);
  void ClearTool();
  /// `displacement_mm`: of a blade with a stroke. If its strokes are too fast to be seen one by one, all that it passes
  /// is shown too, faintly.
  void SetToolPose(const Pose& X_WT, double rpm, double angle_rad, double displacement_mm);
  void SetToolColour(const Rgb8& colour);
  void SetGhost(const std::optional<Pose>& X_WH);
  void SetHandpieceShown(bool shown);
  void SetHandpieceInBone(bool in_bone);
  /// Where the tool cuts; unset: nowhere.
  void SetContact(const std::optional<Vec3>& p_W);
  /// Makes tool and handpiece translucent where they hide the place of contact. `depth`: of the place on the screen, 0
  /// to 1.
  void UpdateSightHoles(const ViewCamera& camera, double depth);
  const std::optional<Vec3>& contact() const;
  /// Draws the tool after everything else in the scene, so that its translucent parts show what is behind them.
  void MoveToolLast();
  /// `camera`: makes the arrow equally thick at every zoom, and at most a third of the view long.
  /// `area`: where the arrow is seen, pixels; empty: in the whole view.
  void SetForce(const std::optional<ForceArrow>& force, const ViewCamera& camera, const ScreenBox& area);
  void SetPlanes(const std::vector<PlaneOverlay>& planes);
  void SetDepthStops(const std::vector<DepthStopOverlay>& stops);
  void SetGuides(const std::vector<GuideOverlay>& guides);
  void SetMeasures(const std::vector<MeasureOverlay>& measures);
  void SetPieces(const std::vector<PieceShape>& pieces);
  const std::vector<PieceShape>& pieces() const;
  void SetBridges(const std::vector<BridgeOverlay>& bridges);
  void SetPoints(const std::vector<PointOverlay>& points);
  const std::vector<PointOverlay>& points() const;
  void SetPlaneHandles(const std::vector<PlaneHandleOverlay>& handles);
  const std::vector<PlaneHandleOverlay>& plane_handles() const;
  void SetPlaneLines(const std::vector<PlaneLineOverlay>& lines);
  void SetMarks(const std::vector<MarkOverlay>& marks);
  void SetAlarms(const std::vector<AlarmOverlay>& alarms);
  const std::vector<AlarmOverlay>& alarms() const;

  /// Returns what remains visible through bone. `surface_mm`: how far the drawn surface of the bone may lie in front of
  /// the true one.
  XrayList MakeXrayList(double surface_mm, Theme theme) const;

  /// Returns a box that contains everything shown.
  Box3 CalcBounds() const;
  /// Returns the labels of the objects, with positions in pixels.
  std::vector<SceneLabel> MakeLabels(const ViewCamera& camera) const;
  /// Returns the area of the tool on the screen, pixels, which labels avoid if possible; empty if there is no tool.
  ScreenBox CalcToolBox(const ViewCamera& camera) const;
  /// Returns true if a pixel lies within the outline of the tool's disc or ball.
  bool IsOnTool(const ViewCamera& camera, const ScreenPoint& at) const;
  const std::vector<MeasureOverlay>& measures() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

inline constexpr double kArrow_mm_per_N = 8;
inline constexpr double kMaxArrow_mm = 60;
/// Returns the length of an arrow with its tip at `tip_W` and its tail in the unit direction `back_W` from there:
/// `wanted_mm`, or less, so that it spans at most a third of the view's smaller side on the screen, and its tail lies
/// in `area` if its tip does (pixels; empty: anywhere).
double CalcArrowLength(const ViewCamera& camera, const Vec3& tip_W, const Vec3& back_W, double wanted_mm,
                       const ScreenBox& area = {});

}  // namespace kerf
