// Menu entries of the plan, and the menu for a place in the picture.
#pragma once

#include <functional>
#include <optional>

#include "app/window/mark_import.h"
#include "app/window/plan_document.h"
#include "app/window/plan_gestures.h"

namespace kerf {

class PlanActions {
 public:
  PlanActions(ViewerApp& viewer, PlanDocument& document, PlanGestures& gestures, MarkImport& marks)
      : viewer_(viewer), document_(document), gestures_(gestures), marks_(marks) {}

  /// `idle`: returns true if the plan may be edited now.
  void Add(ActionList& actions, const std::function<bool()>& idle);
  /// Sets x of the patient's midsagittal plane, at which planes are mirrored.
  void set_middle_mm(double x_mm) { middle_mm_ = x_mm; }
  void OpenContextMenu(const ScreenPoint& at);
  void DrawContextMenu(Ui& ui);

 private:
  void Align();
  std::vector<Pose> FindWay(const Pose& X_WT, const Tool& tool) const;
  void AskFile();
  void Write();

  ViewerApp& viewer_;
  PlanDocument& document_;
  PlanGestures& gestures_;
  MarkImport& marks_;
  std::optional<Vec3> context_W_;  // place of the context menu on the bone
  bool opens_context_ = false;
  double middle_mm_ = 0;
};

}  // namespace kerf
