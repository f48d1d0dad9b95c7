// Lists of planes and marks in the left column, with fields for the selected ones.
#pragma once

#include <cstddef>
#include <optional>

#include "app/window/plan_document.h"
#include "session/plan/edit_plane.h"
#include "session/watch/cut_watch.h"

namespace kerf {

class PlanPanel {
 public:
  PlanPanel(ViewerApp& viewer, PlanDocument& document) : viewer_(viewer), document_(document) {}

  /// `report`: of the cuts made so far; null if there is none.
  void Draw(Ui& ui, const PlanesReport* report);

 private:
  void DrawPlane(Ui& ui, std::size_t i, const PlanesReport* report);
  void DrawFields(Ui& ui);
  bool CheckNear(const Vec3& p_W, const Vec3& before_W);
  void DrawMarks(Ui& ui);

  ViewerApp& viewer_;
  PlanDocument& document_;
};

}  // namespace kerf
