// Clicks and drags in the picture with which planes, depth stops and marks are made and changed.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "app/window/plan_document.h"
#include "session/plan/edit_plane.h"

namespace kerf {

class PlanGestures {
 public:
  PlanGestures(ViewerApp& viewer, PlanDocument& document) : viewer_(viewer), document_(document) {}

  enum class Placing { kPlane, kStop, kMark };
  /// Asks for points of something new. `kind`: of a mark.
  void Place(Placing what, MarkKind kind = MarkKind::kNerve);
  /// Returns true while points are clicked.
  bool is_placing() const { return placing_.has_value(); }
  /// Returns the point that was clicked last, or is being dragged; none if none is being placed.
  std::optional<Vec3> latest_point_W() const;
  /// Asks for the depth of a new depth stop at a point of the bone.
  void AskDepth(const Vec3& p_W);
  /// Ends what is in progress.
  void Reset();

  bool Take(const WindowEvent& event);
  /// Takes a point that was clicked on the bone or in a slice. Returns true if a point was asked for.
  bool TakePoint(const Vec3& p_W);
  /// Moves a point of ListPointOverlays(). `first`: with the first motion of a drag, which is one step of undo.
  void MoveListed(std::size_t i, const Vec3& p_W, bool first);
  /// Takes back the last point, unless it was the last one that was asked for.
  void TakeBackPoint();
  /// Returns the points that can be dragged, as they are shown.
  std::vector<PointOverlay> ListPointOverlays() const;
  std::optional<Vec3> PickBone(const ScreenPoint& at) const;

  /// Shows the handles of the selected plane, and points that can be dragged.
  void Show();
  void Hide();
  /// Says what the handle under the mouse does.
  void DrawHint(const Ui& ui) const;
  /// Adds what the user is asked to click.
  void Fill(HudState& hud) const;
  void Describe(nlohmann::json& state) const;

 private:
  struct Placement {
    Placing what = Placing::kPlane;
    MarkKind kind = MarkKind::kNerve;
    std::vector<Vec3> points_W;
    bool was_enlarged = false;  // a slice was already enlarged when placing began
  };
  struct Drag {
    enum class What { kHandle, kPlacedPoint, kMarkPoint };
    What what = What::kHandle;
    std::size_t index = 0;  // of the point
    PlaneHandle handle;
    PlannedPlane plane;  // at the beginning
    ScreenPoint from;
    bool moved = false;
  };

  void FinishPlacing();
  void SayPlace(MarkKind kind, std::size_t number, const Vec3& p_W);
  bool TakePress(const ScreenPoint& at);
  void TakeMotion(const ScreenPoint& at);
  /// Points that can be picked: those being placed, or those of the selected mark.
  std::vector<Vec3> ListPoints() const;
  const PlaneHandle* FindHovered() const;

  ViewerApp& viewer_;
  PlanDocument& document_;
  std::optional<Placement> placing_;
  std::optional<Drag> drag_;
  std::optional<ScreenPoint> mouse_;
  std::vector<PlaneHandle> handles_;
};

}  // namespace kerf
