// Planes, depth stops, marks and bridges in the picture.
#pragma once

#include "app/window/plan_document.h"
#include "session/watch/cut_watch.h"

namespace kerf {

Rgb8 MarkColour(MarkKind kind);

/// `report`: of the cuts made so far; null if there is none.
void ShowPlan(ViewerApp& viewer, const PlanDocument& document, const PlanesReport* report);
/// Returns the planes as they are drawn. `faint`: for pieces, whose cut faces keep their colours.
std::vector<PlaneOverlay> ListPlanes(const PlanDocument& document, bool faint = false);
/// Returns the marks as they are drawn on the uncut bone.
std::vector<MarkOverlay> ListMarks(const PlanDocument& document);
/// Removes plan and marks from the picture.
void HidePlan(ViewerApp& viewer);
/// Hides the bridges and the planes' lines on the bone, for example while pieces are shown.
void HidePlanOnBone(ViewerApp& viewer);

}  // namespace kerf
