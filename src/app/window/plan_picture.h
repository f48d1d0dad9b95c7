// Planes, depth stops, marks and bridges in the picture.
#pragma once

#include "app/window/plan_document.h"
#include "session/watch/cut_watch.h"

namespace kerf {

Rgb8 MarkColour(MarkKind kind);

/// `report`: of the cuts made so far; null if there is none.
void ShowPlan(ViewerApp& viewer, const PlanDocument& document, const PlanesReport* report);
/// Hides the bridges and the planes' lines on the bone, for example while pieces are shown.
void HidePlanOnBone(ViewerApp& viewer);

}  // namespace kerf
