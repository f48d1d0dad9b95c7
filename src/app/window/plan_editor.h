// Editing of the plan and of marked structures in the window.
#pragma once

#include "app/window/plan_actions.h"
#include "app/window/plan_document.h"
#include "app/window/plan_gestures.h"
#include "app/window/plan_panel.h"

namespace kerf {

/// What is edited, and the ways to edit it.
struct PlanEditor {
  explicit PlanEditor(ViewerApp& viewer)
      : document(viewer), gestures(viewer, document), panel(viewer, document), actions(viewer, document, gestures) {}
  PlanEditor(const PlanEditor&) = delete;
  PlanEditor& operator=(const PlanEditor&) = delete;

  PlanDocument document;
  PlanGestures gestures;
  PlanPanel panel;
  PlanActions actions;
};

}  // namespace kerf
