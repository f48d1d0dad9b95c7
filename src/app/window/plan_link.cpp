#include "app/window/plan_link.h"

#include <fmt/format.h>

#include <utility>

#include "kerf/error.h"
#include "session/link/slicer_link.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr double kPause_s = 0.5;

}  // namespace

void PlanLink::Begin(const Box3& bone_W) {
  if (const auto& link = viewer_.options().link) link->plan().Open(bone_W);
}

void PlanLink::End() {
  if (const auto& link = viewer_.options().link) link->plan().Close();
}

void PlanLink::Update(double dt_s) {
  const std::shared_ptr<SlicerLink>& link = viewer_.options().link;
  since_s_ += dt_s;
  if (link == nullptr || !viewer_.is_running()) return;
  PlanContent next = document_.now();
  bool changed = false;
  for (const PlanRequest& request : link->plan().Fetch()) {
    try {
      Apply(request, next.plan, next.marks);
      changed = true;
    } catch (const Error& e) {
      link->Refuse(e.what());
    }
  }
  if (!changed) return;
  if (since_s_ < kPause_s && changes_ == document_.changes()) {
    document_.Amend(std::move(next));
  } else {
    document_.Change(std::move(next), Tr("change by 3D Slicer"));
    viewer_.Say(fmt::format(fmt::runtime(Tr("3D Slicer has changed the plan; {} undoes that.")),
                            ShowShortcut(viewer_.actions().Find("plan.undo")->shortcut)));
  }
  since_s_ = 0;
  changes_ = document_.changes();
}

}  // namespace kerf
