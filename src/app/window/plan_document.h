// Plan and marked structures of the bone in the window, with what is selected in them, and undo.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/window/viewer_app.h"
#include "session/marks/mark.h"
#include "session/marks/mark_tube.h"
#include "session/marks/undo_stack.h"
#include "session/plan/plan.h"

namespace kerf {

struct PlanContent {
  Plan plan;
  std::vector<Mark> marks;
};

/// Changes are passed on to the viewer's watch of the cut.
class PlanDocument {
 public:
  explicit PlanDocument(ViewerApp& viewer) : viewer_(viewer) {}

  const PlanContent& now() const { return steps_.now(); }
  const Plan& plan() const { return now().plan; }
  const std::vector<Mark>& marks() const { return now().marks; }
  const std::vector<MarkTube>& mark_tubes() const { return tubes_; }
  const UndoStack<PlanContent>& steps() const { return steps_; }

  /// Replaces the plan and the marks, and forgets earlier steps.
  void Load(Plan plan, std::vector<Mark> marks);
  /// Adds planes, with names that are not in use yet, and selects the last one.
  void Add(std::vector<PlannedPlane> planes);
  /// Adds a plane that is as large as the bone near the points, so that its handles are in view.
  void AddFitted(const PlannedPlane& plane, const std::vector<Vec3>& near_W);
  /// Makes `next` the current content, as a step that can be undone. `what`: its translated name. Throws Error if
  /// `next` is invalid.
  void Change(PlanContent next, const std::string& what);
  /// Replaces the content without a new step, for a gesture that changes it many times.
  void Amend(PlanContent next);
  void Undo();
  void Redo();

  /// Returns the selected plane; null if there is none.
  const PlannedPlane* plane() const;
  std::size_t plane_index() const { return plane_; }
  void set_plane_index(std::size_t i) { plane_ = i; }
  /// Returns the index of the selected mark.
  const std::optional<std::size_t>& mark_index() const { return mark_; }
  void set_mark_index(std::optional<std::size_t> i) { mark_ = i; }

  /// Returns true if the plan was changed after the bone was last changed, and the change can be undone.
  bool is_latest_change() const;
  /// Counts the changes, undo and redo included.
  std::uint64_t changes() const { return changes_; }
  bool is_unsaved() const { return unsaved_; }
  void set_unsaved(bool unsaved) { unsaved_ = unsaved; }
  void Describe(nlohmann::json& state) const;

 private:
  void Changed();

  ViewerApp& viewer_;
  UndoStack<PlanContent> steps_;
  std::vector<MarkTube> tubes_;
  std::size_t plane_ = 0;
  std::optional<std::size_t> mark_;
  std::uint64_t changes_at_edit_ = 0;  // changes of the bone at the last change of the plan
  std::uint64_t changes_ = 0;
  bool unsaved_ = false;
};

}  // namespace kerf
