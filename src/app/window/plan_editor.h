// Editing of the plan and of marked structures in the window.
#pragma once

#include "app/window/mark_import.h"
#include "app/window/plan_actions.h"
#include "app/window/plan_document.h"
#include "app/window/plan_gestures.h"
#include "app/window/plan_panel.h"

namespace kerf {

/// What is edited, and the ways to edit it.
struct PlanEditor {
  explicit PlanEditor(ViewerApp& viewer)
      : document(viewer),
        gestures(viewer, document),
        panel(viewer, document),
        marks(viewer, document),
        actions(viewer, document, gestures, marks) {}
  PlanEditor(const PlanEditor&) = delete;
  PlanEditor& operator=(const PlanEditor&) = delete;

  PlanDocument document;
  PlanGestures gestures;
  PlanPanel panel;
  MarkImport marks;
  PlanActions actions;
};

}  // namespace kerf
