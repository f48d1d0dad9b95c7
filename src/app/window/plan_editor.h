// Editing of the plan and of marked structures in the window: points that are clicked, handles that are dragged, and
// fields in the left column.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/viewer_app.h"
#include "session/marks/mark.h"
#include "session/marks/mark_tube.h"
#include "session/marks/undo_stack.h"
#include "session/plan/edit_plane.h"
#include "session/plan/plan.h"
#include "session/watch/cut_watch.h"

namespace kerf {

class PlanEditor {
 public:
  explicit PlanEditor(ViewerApp& viewer) : viewer_(viewer) {}

  /// `idle`: returns true if the plan may be edited now.
  void AddActions(ActionList& actions, const std::function<bool()>& idle);
  /// Replaces the plan and the marks, and forgets earlier steps.
  void Load(Plan plan, std::vector<Mark> marks);
  void Add(std::vector<PlannedPlane> planes);

  const Plan& plan() const { return steps_.now().plan; }
  const std::vector<Mark>& marks() const { return steps_.now().marks; }
  const std::vector<MarkTube>& mark_tubes() const { return tubes_; }
  /// Returns the selected plane; null if there is none.
  const PlannedPlane* plane() const;
  /// Returns true if the plan was changed after the bone was last changed, and the change can be undone.
  bool is_latest_change() const;
  bool is_unsaved() const { return unsaved_; }
  void set_saved() { unsaved_ = false; }
  /// Returns true while points are clicked.
  bool is_placing() const { return placing_.has_value(); }
  /// Sets x of the patient's midsagittal plane, at which planes are mirrored.
  void set_middle_mm(double x_mm) { middle_mm_ = x_mm; }

  bool Take(const WindowEvent& event);
  /// Takes a point that was clicked in a slice. Returns true if a point was asked for.
  bool TakePoint(const Vec3& p_W);
  void OpenContextMenu(const ScreenPoint& at);
  /// Shows planes, handles, marks, points and bridges in the picture. `report`: of the cuts made so far; null if there
  /// is none.
  void Show(const PlanesReport* report);
  /// Hides the handles, points and bridges, for example while pieces are shown.
  void Hide();
  void DrawSections(Ui& ui, const PlanesReport* report);
  void DrawWindows(Ui& ui, ActionList& actions);
  void Fill(HudState& hud) const;
  void Describe(nlohmann::json& state) const;

 private:
  struct Content {
    Plan plan;
    std::vector<Mark> marks;
  };
  enum class Placing { kPlane, kStop, kMark };
  struct Placement {
    Placing what = Placing::kPlane;
    MarkKind kind = MarkKind::kNerve;
    std::vector<Vec3> points_W;
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

  void Change(Content next, const std::string& what);
  void Amend(Content next);
  void Changed();
  void Place(Placing what, MarkKind kind = MarkKind::kNerve);
  void FinishPlacing();
  bool TakePress(const ScreenPoint& at);
  void TakeMotion(const ScreenPoint& at);
  void AskDepth(const Vec3& p_W);
  void Align();
  void AskFile();
  void Write();
  void DrawPlane(Ui& ui, std::size_t i, const PlanesReport* report);
  void DrawFields(Ui& ui);
  void DrawMarks(Ui& ui);
  std::optional<Vec3> PickBone(const ScreenPoint& at) const;
  /// Points that can be picked: those being placed, or those of the selected mark.
  std::vector<Vec3> ListPoints() const;

  ViewerApp& viewer_;
  UndoStack<Content> steps_;
  std::vector<MarkTube> tubes_;
  std::size_t plane_ = 0;
  std::optional<std::size_t> mark_;  // the selected mark
  std::optional<Placement> placing_;
  std::optional<Drag> drag_;
  std::vector<PlaneHandle> handles_;
  std::optional<PatientPlane> reference_;  // of the fields that are being edited
  std::optional<Vec3> context_W_;          // place of the context menu on the bone
  bool opens_context_ = false;
  std::uint64_t changes_at_edit_ = 0;  // changes of the bone at the last change of the plan
  double middle_mm_ = 0;
  bool unsaved_ = false;
};

}  // namespace kerf
