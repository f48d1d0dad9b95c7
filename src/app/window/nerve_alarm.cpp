#include "app/window/nerve_alarm.h"

#include <fmt/format.h>

#include <algorithm>

#include "view/live/nearest.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// A saw that is further away from a tooth passes it, as most cuts between teeth do.
constexpr double kNearTooth_mm = 1;

}  // namespace

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

std::optional<AlarmOverlay> MakeToothAlarm(const TriangleMesh& teeth_W, bool cuts, const Tool& tool, const Pose& X_WT) {
  const std::optional<NearestPlace> place = FindNearest(tool, X_WT, teeth_W);
  if (!place) return {};
  if (cuts) return AlarmOverlay{.p_W = place->p_W, .level = AlarmLevel::kDanger, .label = Tr("the blade cuts a tooth")};
  if (place->distance_mm > kNearTooth_mm) return {};
  return AlarmOverlay{.p_W = place->p_W,
                      .level = AlarmLevel::kNotice,
                      .label = fmt::format("{}: {}", Tr("tooth"), ShowDistance(std::max(0.0, place->distance_mm)))};
}

}  // namespace kerf
