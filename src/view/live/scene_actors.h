// Everything in the scene except the bone: tool, plan, measures, pieces.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "view/live/viewport.h"

class vtkRenderer;

namespace kerf {

class SceneActors {
 public:
  /// `scene`: for objects that the bone can hide; `over`: for objects above everything else.
  SceneActors(vtkRenderer& scene, vtkRenderer& over);
  ~SceneActors();
  SceneActors(const SceneActors&) = delete;
  SceneActors& operator=(const SceneActors&) = delete;

  void SetScale(double scale);  // pixels per point
  void SetInner(const InnerSurfaces& surfaces, bool shown);
  void ShowInner(bool shown);
  void SetTool(const Tool& tool);
  void ClearTool();
  void SetToolPose(const Pose& X_WT, double rpm, double angle_rad);
  void SetToolColour(const Rgb8& colour);
  void SetGhost(const std::optional<Pose>& X_WH);
  /// `mm_per_point`, at the arrow, is used to draw the arrow equally thick at every zoom.
  void SetForce(const std::optional<ForceArrow>& force, double mm_per_point);
  void SetPlanes(const std::vector<PlaneOverlay>& planes);
  void SetDepthStops(const std::vector<DepthStopOverlay>& stops);
  void SetGuides(const std::vector<GuideOverlay>& guides);
  void SetMeasures(const std::vector<MeasureOverlay>& measures);
  void SetPieces(const std::vector<PieceShape>& pieces);
  const std::vector<PieceShape>& pieces() const;

  /// Returns a box that contains everything shown.
  Box3 CalcBounds() const;
  /// Returns the labels of the objects, with positions in pixels.
  std::vector<SceneLabel> MakeLabels(const ViewCamera& camera) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
