// An exercise while it is done: goal, gauge, advice and alarms.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <utility>

#include "app/window/nerve_alarm.h"
#include "app/window/practice.h"
#include "app/window/practice_widgets.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// The gauge asks the student to slow down from kSlow_mm before the goal on, and to stop from kStop_mm on.
constexpr double kSlow_mm = 1.0;
constexpr double kStop_mm = 0.3;

HudLevel LevelOf(double to_goal_mm) {
  return to_goal_mm < -kSlow_mm   ? HudLevel::kBad
         : to_goal_mm < -kStop_mm ? HudLevel::kWarn
         : to_goal_mm < kStop_mm  ? HudLevel::kGood
         : to_goal_mm < kSlow_mm  ? HudLevel::kWarn
                                  : HudLevel::kPlain;
}

/// Returns the colour of the blade. The colours are distinguishable with red-green colour blindness.
Rgb8 ColourOf(HudLevel level) {
  switch (level) {
    case HudLevel::kGood:
      return {0, 158, 115};
    case HudLevel::kWarn:
      return {230, 159, 0};
    case HudLevel::kBad:
      return {170, 40, 60};
    default:
      return kSteelColour;
  }
}

}  // namespace

void Practice::Began() {
  const std::shared_ptr<const Bone> bone = viewer_->bone_at_start();
  gauge_ = std::make_unique<DepthGauge>(*bone, MakeWantedCut(scene_.exercise, MakeTool(scene_)));
  deepest_mm_.assign(gauge_->columns().size(), -kAbove_mm);
  touched_at_.reset();
  making_nerve_ =
      std::async(std::launch::async, [bone] { return std::make_unique<RegionDistance>(*bone, Tissue::kCanal); });
  ShowGoal();
  // View from the side and a little from above, with the line across the picture. Motion is restricted to the blade's
  // plane, so that cuts are straight.
  const WantedCut& cut = gauge_->cut();
  const Vec3 side_W = glm::cross(cut.along_W, -cut.into_W);  // the line points to the right
  const Vec3 middle_W = cut.ToWorld({0.5 * cut.length_mm, 0, 0});
  // Look at the cut from outside the bone.
  const bool inside = glm::dot(side_W, middle_W - viewer_->bone_at_start()->CalcBounds().centre()) < -1;
  ViewCamera& camera = viewer_->view().camera();
  camera.Look((inside ? -side_W : side_W) - 0.6 * cut.into_W, -cut.into_W);
  viewer_->view().FitAll();
  camera.set_target_W(middle_W - 0.25 * cut.radius_mm * cut.into_W);
  camera.set_height_mm(std::min(camera.height_mm(), 3.2 * cut.radius_mm + cut.length_mm));
  viewer_->controls().set_in_blade_plane(true);
  begun_ = false;
}

void Practice::ShowGoal() {
  const WantedCut& cut = gauge_->cut();
  GuideOverlay line;
  line.points_W = {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})};
  viewer_->view().SetGuides({line});
  if (exercise_->toml.find("\"osteotomy\"") == std::string::npos) return viewer_->view().SetPlanes({});
  viewer_->view().SetPlanes({{.name = Tr("plan"),
                              .p_W = cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}),
                              .normal_W = cut.across_W,
                              .width_mm = cut.length_mm + 20,
                              .height_mm = cut.depth_mm + 20,
                              .up_W = -cut.into_W}});
}

std::optional<DepthReading> Practice::Read() const {
  return gauge_ && viewer_->is_running() ? gauge_->Calc(viewer_->figures().coupled.X_WT) : std::nullopt;
}

/// Returns the time since the saw was first moved or the spindle was switched on; 0 before that.
double Practice::CalcElapsed_s() const {
  const double begun_s = meter_ ? meter_->begun_s() : -1;
  return begun_s < 0 ? 0 : std::max(0.0, viewer_->figures().time_s - begun_s);
}

void Practice::UpdateCutting() {
  const double limit_s = scene_.exercise.time_limit_s;
  if (limit_s > 0 && CalcElapsed_s() > limit_s) {
    viewer_->Say(Tr("Time is up"));
    Finish(true);
  }
  const std::optional<DepthReading> reading = Read();
  const bool in_bone = reading && reading->depth_mm > 0;
  if (scene_.exercise.sound) {
    viewer_->sound().SetAlarm(AlarmKind::kDepth, in_bone ? std::optional(reading->to_goal_mm) : std::nullopt);
  }
  if (scene_.exercise.colour) {
    viewer_->view().SetToolColour(in_bone ? ColourOf(LevelOf(reading->to_goal_mm)) : kSteelColour);
  }
  const CoachInput input = MakeCoachInput();
  coach_ = UpdateCoach(coach_, gauge_->cut(), input);
  // The saw has also been between the places of two frames.
  constexpr double kStep_mm = 0.1;
  if (input.touches) {
    const Pose from = touched_at_.value_or(input.X_WT);
    const double steps = std::clamp(std::ceil(glm::distance(from.p_AB, input.X_WT.p_AB) / kStep_mm), 1.0, 100.0);
    for (int i = 1; i <= static_cast<int>(steps); ++i) {
      const double f = i / steps;
      gauge_->TakeDepths(
          {glm::normalize(glm::slerp(from.R_AB, input.X_WT.R_AB, f)), glm::mix(from.p_AB, input.X_WT.p_AB, f)},
          deepest_mm_);
    }
  }
  touched_at_ = input.touches ? std::optional(input.X_WT) : std::nullopt;
}

void Practice::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  std::optional<AlarmOverlay> nerve =
      MakeNerveAlarm(viewer_->bone(), nerve_.get(), MakeTool(scene_), viewer_->figures().coupled.X_WT);
  if (nerve) alarms.push_back(std::move(*nerve));
}

CoachInput Practice::MakeCoachInput() const {
  const LiveFigures& figures = viewer_->figures();
  CoachInput input;
  input.kind = scene_.exercise.kind;
  input.time_s = figures.time_s;
  input.X_WT = figures.coupled.X_WT;
  input.depth = Read();
  const bool is_near = IsMeaningful(FindMeasure("nerve_distance_mm"), scene_.exercise.kind);
  if (is_near && nerve_ && !nerve_->empty() && viewer_->spindle_on()) {
    input.nerve_mm = nerve_->Calc(MakeTool(scene_), input.X_WT);
  }
  input.touches = figures.coupled.engaged_teeth > 0 || glm::length(figures.coupled.f_face_W_N) > 0;
  return input;
}

std::optional<CoachLine> Practice::MakeCoach() const {
  // The last level has no aids.
  if (state_ != State::kCutting || !viewer_->is_running() || !gauge_ || !scene_.exercise.gauge) return {};
  return MakeCoachLine(coach_, gauge_->cut(), MakeCoachInput());
}

std::optional<Message> Practice::MakeStep() const {
  if (state_ != State::kCutting || !viewer_->is_running() || !gauge_ || scene_.exercise.level > 1) return {};
  const double done = CalcLineDone(*gauge_, deepest_mm_);
  return DescribeStep(FindStep(MakeCoachInput(), viewer_->spindle_on(), done), scene_.exercise.kind, gauge_->cut(),
                      done);
}

std::vector<Aid> Practice::MakeAids() const {
  return ListAids(scene_.exercise, viewer_->controls().in_blade_plane(), viewer_->view().translucent());
}

HudGauge Practice::MakeGauge(const std::optional<DepthReading>& reading) const {
  HudGauge gauge;
  gauge.title = Tr("Depth");
  gauge.upper = scene_.exercise.depth_mm + 1.8 * kSlow_mm;
  gauge.good = kStop_mm;
  gauge.warn = kSlow_mm;
  gauge.goal = scene_.exercise.depth_mm;
  if (!reading) return gauge;
  gauge.value = reading->depth_mm;
  gauge.level = LevelOf(reading->to_goal_mm);
  gauge.word = reading->depth_mm < 0             ? Tr("above the bone")
               : reading->to_goal_mm < -kStop_mm ? Tr("too deep")
               : reading->to_goal_mm < kStop_mm  ? Tr("stop: deep enough")
               : reading->to_goal_mm < kSlow_mm  ? Tr("slow down")
                                                 : Tr("continue");
  return gauge;
}

void Practice::FillCutting(HudState& hud) {
  const std::optional<DepthReading> reading = Read();
  // Without the gauge the depth is not shown either.
  if (scene_.exercise.gauge) {
    hud.gauge = MakeGauge(reading);
    if (reading) hud.values.depth_mm = reading->depth_mm;
    const ToolDeviation deviation = CalcDeviation(gauge_->cut(), viewer_->figures().coupled.X_WT);
    hud.values.plan_angle_deg = deviation.tilt_deg;
    hud.values.plan_offset_mm = std::abs(deviation.beside_mm);
  }
  hud.values.has_plan = scene_.exercise.gauge;
  hud.values.nerve_is_marked = !nerve_ || !nerve_->empty();
  if (nerve_ && !nerve_->empty()) {
    hud.values.nerve_mm = nerve_->Calc(MakeTool(scene_), viewer_->figures().coupled.X_WT);
  }
  const double goal_s = CalcUnhurriedTime_s(gauge_->cut(), scene_.exercise);
  begun_ = begun_ || viewer_->spindle_on();
  if (!begun_) {
    hud.banner = HudBanner{
        .kind = HudBanner::Kind::kNotice,
        .text = fmt::format(fmt::runtime(Tr("{0} An unhurried cut takes {1} s; the clock starts when you move the saw "
                                            "or switch the spindle on.")),
                            Translate(exercise_->goal_message), ShowNumber(goal_s, 0)),
        .answers = Tr("Space: spindle   Arrows or left drag: move   Enter: finish   F1: help")};
  } else if (const std::optional<CoachLine> line = MakeCoach()) {
    hud.banner = HudBanner{.kind = line->urgent ? HudBanner::Kind::kWarning : HudBanner::Kind::kNotice,
                           .text = Translate(line->message),
                           .answers = ""};
  } else if (const std::optional<Message> step = MakeStep()) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                           .text = Translate(*step),
                           .answers = Tr("Space: spindle   Arrows or left drag: move   Enter: finish")};
  }
  const double limit_s = scene_.exercise.time_limit_s;
  if (limit_s > 0) {
    hud.status.right = fmt::format(fmt::runtime(Tr("time {0} of {1} s, goal {2} s")), ShowNumber(CalcElapsed_s(), 0),
                                   ShowNumber(limit_s, 0), ShowNumber(goal_s, 0));
  }
}

}  // namespace kerf
