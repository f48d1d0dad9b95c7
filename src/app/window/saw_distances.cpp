#include "app/window/saw_distances.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "app/window/is_ready.h"
#include "app/window/nerve_alarm.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr double kToothCut_s = 0.5;  // a saw that has cut a tooth within this time still cuts it
constexpr double kOtherCut_mm = 6;   // a cut further beside a plane than this is not meant for it

/// Returns the side of the patient to which a direction mostly points.
const char* NameSide(const Vec3& direction_W) {
  const Vec3 size = glm::abs(direction_W);
  if (size.x >= size.y && size.x >= size.z) return direction_W.x > 0 ? Tr("left") : Tr("right");
  if (size.y >= size.z) return direction_W.y > 0 ? Tr("back") : Tr("front");
  return direction_W.z > 0 ? Tr("up") : Tr("down");
}

}  // namespace

void SawDistances::SetBone(const std::shared_ptr<const Bone>& before) {
  sampler_ = std::make_unique<PhiSampler>(*before);
  making_nerve_ =
      std::async(std::launch::async, [before] { return std::make_unique<RegionDistance>(*before, Tissue::kCanal); });
}

void SawDistances::Reset() {
  sampler_.reset();
  nerve_.reset();
  if (making_nerve_.valid()) unused_.push_back(std::move(making_nerve_));
}

void SawDistances::Update() {
  std::erase_if(unused_, [](const auto& making) { return IsReady(making); });
  if (IsReady(making_nerve_)) nerve_ = making_nerve_.get();
}

void SawDistances::Fill(HudState& hud) const {
  if (!viewer_.is_running()) return;
  const Tool tool = MakeTool(viewer_.session()->scene());
  const Pose& X_WT = viewer_.figures().coupled.X_WT;
  const NearestStructure nerve = FindNearestStructure(nerve_.get(), Tr("nerve"), document_.mark_tubes(), tool, X_WT);
  hud.values.nerve_mm = nerve.distance_mm;
  hud.values.nerve_is_marked = nerve.distance_mm.has_value() || !nerve_;
  if (sampler_) hud.values.depth_mm = CalcBladeDepth(*sampler_, tool, X_WT);
  if (const PlannedPlane* planned = document_.plane()) {
    const PlaneDeviation off = CalcDeviation(*planned, tool, X_WT);
    hud.values.plan_offset_mm = std::abs(off.offset_mm);
    if (std::abs(off.offset_mm) >= 0.005) hud.values.plan_side = NameSide(off.offset_mm * planned->plane.normal_W);
    hud.values.plan_angle_deg = off.angle_deg;
  }
  if (!document_.plan().stops.empty()) {
    const DepthStop& planned = document_.plan().stops.front();
    const StopDeviation stop = CalcDeviation(planned, tool, X_WT);
    HudGauge gauge;
    gauge.title = ShowName(planned.name);
    gauge.upper = std::max(1.0, 1.5 * planned.depth_mm);
    gauge.value = stop.depth_mm;
    gauge.goal = planned.depth_mm;
    gauge.level = stop.left_mm < -1     ? HudLevel::kBad
                  : stop.left_mm < -0.3 ? HudLevel::kWarn
                  : stop.left_mm < 0.3  ? HudLevel::kGood
                  : stop.left_mm < 1    ? HudLevel::kWarn
                                        : HudLevel::kPlain;
    gauge.word = stop.left_mm < -0.3  ? Tr("too deep")
                 : stop.left_mm < 0.3 ? Tr("stop")
                 : stop.left_mm < 1   ? Tr("slow down")
                                      : Tr("continue");
    hud.gauge = gauge;
  }
}

bool SawDistances::IsInBone() const {
  if (!sampler_ || !viewer_.is_running()) return false;
  return CalcBladeDepth(*sampler_, MakeTool(viewer_.session()->scene()), viewer_.figures().coupled.X_WT) > 0;
}

void SawDistances::SoundAlarms() const {
  std::optional<double> depth_mm;
  std::optional<double> nerve_mm;
  std::optional<double> margin_mm;
  if (viewer_.is_running() && viewer_.spindle_on() && viewer_.touches()) {
    const Tool tool = MakeTool(viewer_.session()->scene());
    const Pose& X_WT = viewer_.figures().coupled.X_WT;
    nerve_mm = FindNearestStructure(nerve_.get(), "", document_.mark_tubes(), tool, X_WT).distance_mm;
    if (!document_.plan().stops.empty()) {
      depth_mm = CalcDeviation(document_.plan().stops.front(), tool, X_WT).left_mm;
    }
    if (const PlannedPlane* planned = document_.plane()) {
      margin_mm = planned->margin_mm - std::abs(CalcDeviation(*planned, tool, X_WT).offset_mm);
    }
  }
  viewer_.sound().SetAlarm(AlarmKind::kDepth, depth_mm);
  viewer_.sound().SetAlarm(AlarmKind::kStructure, nerve_mm);
  viewer_.sound().SetAlarm(AlarmKind::kMargin, margin_mm);
}

void SawDistances::AddAlarms(std::vector<AlarmOverlay>& alarms) const {
  const Tool tool = MakeTool(viewer_.session()->scene());
  const Pose& X_WT = viewer_.figures().coupled.X_WT;
  if (std::optional<AlarmOverlay> nerve = MakeNerveAlarm(viewer_.bone(), nerve_.get(), tool, X_WT)) {
    alarms.push_back(std::move(*nerve));
  }
  for (const MarkTube& tube : document_.mark_tubes()) {
    const MarkTube::Nearest nearest = tube.Find(tool, X_WT);
    alarms.push_back({.p_W = nearest.p_W,
                      .level = AlarmLevelFor(nearest.distance_mm),
                      .label = fmt::format("{}: {}", ShowName(tube.name()), ShowDistance(nearest.distance_mm))});
  }
  if (!viewer_.spindle_on() || !viewer_.touches()) return;
  const LiveFigures& figures = viewer_.figures();
  if (figures.metal_touch_s && figures.time_s < *figures.metal_touch_s + kToothCut_s) {
    alarms.push_back(
        {.p_W = X_WT.p_AB, .level = AlarmLevel::kDanger, .label = Tr("the saw is on metal, which it does not cut")});
  }
  if (const InnerSurfaces* inner = viewer_.bone().inner()) {
    const bool cuts = figures.tooth_cut_s && figures.time_s < *figures.tooth_cut_s + kToothCut_s;
    if (std::optional<AlarmOverlay> tooth = MakeToothAlarm(inner->teeth_W, cuts, tool, X_WT)) {
      alarms.push_back(std::move(*tooth));
    }
  }
  // A saw that cuts beside the selected plane.
  const PlannedPlane* planned = document_.plane();
  if (planned == nullptr) return;
  const PlaneDeviation off = CalcDeviation(*planned, tool, X_WT);
  const double beyond_mm = std::abs(off.offset_mm) - planned->margin_mm;
  const std::vector<EffectChoice>& effects = viewer_.session()->scene().effects;
  const bool guided = std::any_of(effects.begin(), effects.end(),
                                  [](const EffectChoice& e) { return std::string_view(e.name()) == "guide"; });
  if (beyond_mm <= 0 || (beyond_mm > kOtherCut_mm && !guided)) return;
  alarms.push_back(
      {.p_W = off.p_W_mm,
       .level = beyond_mm > planned->margin_mm ? AlarmLevel::kDanger : AlarmLevel::kWarning,
       .label = fmt::format(fmt::runtime(Tr("{} mm beside the plan")), ShowNumber(std::abs(off.offset_mm), 1))});
}

bool SawDistances::WaitUntil(std::chrono::steady_clock::time_point until) const {
  const auto ends = [&](const auto& making) {
    return !making.valid() || making.wait_until(until) == std::future_status::ready;
  };
  return ends(making_nerve_) && std::all_of(unused_.begin(), unused_.end(), ends);
}

}  // namespace kerf
