#include "app/window/nerve_alarm.h"

#include <fmt/format.h>

#include "view/live/nearest.h"
#include "view/ui/translate.h"

namespace kerf {

std::optional<AlarmOverlay> MakeNerveAlarm(const ShownBone& bone, const RegionDistance* nerve, const Tool& tool,
                                           const Pose& X_WT) {
  if (bone.inner() == nullptr) return {};
  const std::optional<NearestPlace> place = FindNearest(tool, X_WT, bone.inner()->canal_W);
  if (!place) return {};
  const double distance_mm = nerve != nullptr && !nerve->empty() ? nerve->Calc(tool, X_WT) : place->distance_mm;
  return AlarmOverlay{.p_W = place->p_W,
                      .level = AlarmLevelFor(distance_mm),
                      .label = fmt::format("{}: {}", Tr("nerve"), ShowDistance(distance_mm))};
}

}  // namespace kerf
