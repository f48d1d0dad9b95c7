// An exercise while it is done: goal, gauge, advice and alarms.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <string>
#include <utility>

#include "app/window/injury_texts.h"
#include "app/window/nerve_alarm.h"
#include "app/window/practice.h"
#include "app/window/practice_widgets.h"
#include "session/score/cut_area.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Feed below which the saw rests, so that it is not asked to slow down.
constexpr double kRest_mm_per_s = 0.1;
/// Width of the planned plane around the wanted cut.
constexpr double kPlaneRim_mm = 10;
/// Height that is left to the exercise's card and to that of the replay, points, and its largest share of the scene.
constexpr double kCard = 110;
constexpr double kReplayCard = 66;
constexpr double kMaxCardShare = 0.38;
/// Time before the end of an attempt from which on the student is warned of it.
constexpr double kWarnTime_s = 10;

HudLevel LevelOf(const DepthAdvice& advice) {
  if (advice.stop) return HudLevel::kBad;
  if (advice.beside) return HudLevel::kWarn;
  switch (advice.zone) {
    case DepthZone::kTooDeep:
      return HudLevel::kBad;
    case DepthZone::kDeep:
    case DepthZone::kNear:
      return HudLevel::kWarn;
    case DepthZone::kReached:
      return HudLevel::kGood;
    case DepthZone::kAbove:
    case DepthZone::kFar:
      break;
  }
  return HudLevel::kPlain;
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

std::string DescribeWithWay(const Message& message, const std::optional<Message>& way) {
  return Translate(message) + (way ? " " + Translate(*way) : "");
}

}  // namespace

void Practice::Began() {
  const std::shared_ptr<const Bone> bone = viewer_->bone_at_start();
  gauge_ = std::make_unique<DepthGauge>(*bone, MakeWantedCut(scene_.exercise, MakeTool(scene_)));
  deepest_mm_.assign(gauge_->columns().size(), -kAbove_mm);
  touched_at_.reset();
  feed_.emplace(gauge_->cut());
  if (const auto watch = viewer_->cut_watch()) {
    watch->Fetch();  // the last one of the attempt before
    watch->SetMeasure(nullptr);
    watch->SetWanted(nullptr);
    if (IsPlanned()) {
      watch->SetWanted([cut = gauge_->cut()](const Vec3& p_W) { return cut.IsNear(p_W); });
      watch->SetMeasure(
          [cut = gauge_->cut()](const Bone& before, const Bone& now) { return CalcCutArea(before, now, cut).share(); });
    }
  }
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
  Vec3 from_W = inside ? -side_W : side_W;
  // A planned cut is seen from the bone's outer side, so that the rest of the bone does not hide it.
  const Vec3 outward_W = middle_W - viewer_->bone_at_start()->CalcBounds().centre();
  if (IsPlanned()) from_W += glm::dot(outward_W, cut.along_W) < 0 ? -cut.along_W : cut.along_W;
  camera.Look(from_W - 0.6 * cut.into_W, -cut.into_W);
  ShowCutAndSaw();
  SawControls& controls = viewer_->controls();
  controls.set_in_blade_plane(true);
  controls.set_lock_plane(cut.plane());
  controls.set_feed_mm_per_s(scene_.exercise.feed_mm_per_s);
  begun_ = false;
  kept_bone_ = bone;
  kept_source_ = scene_.bone;
}

/// Shows the wanted cut and the saw above it where neither the panels nor the card of the exercise cover them.
void Practice::ShowCutAndSaw() {
  const WantedCut& cut = gauge_->cut();
  const double rim_mm = IsPlanned() ? kPlaneRim_mm : 0;
  const double side_mm = std::max(cut.radius_mm, rim_mm);
  const double above_mm = 2 * std::max(cut.radius_mm, 0.5 * cut.reach_mm);
  std::vector<Vec3> corners_W;
  for (const double s_mm : {-side_mm, cut.length_mm + side_mm}) {
    for (const double t_mm : {-above_mm, cut.depth_mm + rim_mm}) corners_W.push_back(cut.ToWorld({s_mm, t_mm, 0}));
  }
  viewer_->ShowPlace({.points_W = std::move(corners_W), .free = [this](const UiBox& scene) {
                        UiBox free = scene;
                        const double points = state_ == State::kReplaying ? kReplayCard : kCard;
                        const double card =
                            std::min(points * static_cast<double>(viewer_->ui().scale()), kMaxCardShare * scene.height);
                        free.top += card;
                        free.height -= card;
                        if (state_ != State::kReplaying || replay_box_.empty()) return free;
                        if (replay_box_.width < 0.5 * scene.width) {  // beside it, otherwise above it
                          free.left = replay_box_.right();
                          free.width = scene.right() - free.left;
                        } else {
                          free.height = replay_box_.top - free.top;
                        }
                        return free;
                      }});
}

void Practice::ShowGoal() {
  const WantedCut& cut = gauge_->cut();
  GuideOverlay line;
  line.points_W = {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})};
  viewer_->view().SetGuides({line});
  if (!IsPlanned()) return viewer_->view().SetPlanes({});
  plan_label_ = DescribePlan();
  viewer_->view().SetPlanes({{.name = plan_label_,
                              .p_W = cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}),
                              .normal_W = cut.across_W,
                              .width_mm = cut.length_mm + 2 * kPlaneRim_mm,
                              .height_mm = cut.depth_mm + 2 * kPlaneRim_mm,
                              .up_W = -cut.into_W}});
}

/// Returns the text beside the planned plane, with the depth if the exercise shows it and the saw is in the plane.
std::string Practice::DescribePlan() const {
  const std::optional<DepthReading> reading =
      state_ == State::kCutting && scene_.exercise.gauge ? Read() : std::nullopt;
  if (!reading || reading->depth_mm <= 0) return Tr("plan");
  // Beside the plan, the depth is that of another cut.
  const ToolDeviation deviation = CalcDeviation(gauge_->cut(), viewer_->figures().coupled.X_WT);
  if (std::abs(deviation.beside_mm) > gauge_->cut().margin_mm) return Tr("plan");
  return fmt::format(fmt::runtime(Tr("plan: {0} of {1} mm deep")), ShowNumber(reading->depth_mm, 1),
                     ShowNumber(scene_.exercise.depth_mm, 0));
}

ViewBasis Practice::MakeKeyBasis(const ViewBasis& picture) const {
  return gauge_ ? AlignWithCut(picture, gauge_->cut().along_W, gauge_->cut().into_W) : picture;
}

HudKeyGroup Practice::saw_help() const {
  return {Tr("Moving the saw along the exercise's directions"),
          {{Tr("Down, Up"), Tr("into the bone, out of the bone")},
           {Tr("Left, Right"), Tr("to the left, to the right")},
           {Tr("PgUp, PgDn"), Tr("away from you, towards you")},
           {Tr("Shift + key"), Tr("fast, in the air only")},
           {Tr("left drag"), Tr("as the arrow keys; with Shift as PgUp and PgDn")},
           {Tr("Ctrl + left drag"), Tr("turn")},
           {"W S  A D  Q E", Tr("tilt, swing, roll")}}};
}

void Practice::Relabel() {
  if (state_ == State::kCutting && gauge_) ShowGoal();
}

std::vector<Vec3> Practice::kept_clear_W() const {
  if (!gauge_ || (state_ != State::kCutting && state_ != State::kReplaying)) return {};
  const WantedCut& cut = gauge_->cut();
  std::vector<Vec3> points_W{cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})};
  if (IsPlanned()) points_W.push_back(cut.ToWorld({0.5 * cut.length_mm, cut.depth_mm, 0}));
  return points_W;
}

bool Practice::IsPlanned() const {
  return scene_.exercise.kind == ExerciseKind::kOsteotomy;
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
  if (IsPlanned() && DescribePlan() != plan_label_) ShowGoal();
  if (scene_.exercise.sound) {
    viewer_->sound().SetAlarm(AlarmKind::kDepth, in_bone ? std::optional(reading->to_goal_mm) : std::nullopt);
  }
  feed_mm_per_s_ = feed_->Take(viewer_->figures().time_s, viewer_->figures().coupled.X_WT);
  if (const auto watch = viewer_->cut_watch()) {
    if (std::optional<PlanesReport> report = watch->Fetch()) report_ = std::move(report);
  }
  const CoachInput input = MakeCoachInput();
  coach_ = UpdateCoach(coach_, gauge_->cut(), input);
  if (scene_.exercise.colour) viewer_->view().SetToolColour(ColourOf(LevelOf(MakeAdvice())));
  // The saw has also been between the places of two frames.
  constexpr double kStep_mm = 0.1;
  constexpr double kReach_mm = 0.75;  // along the line from the lowest point
  if (input.touches) {
    const Pose from = touched_at_.value_or(input.X_WT);
    const double steps = std::clamp(std::ceil(glm::distance(from.p_AB, input.X_WT.p_AB) / kStep_mm), 1.0, 100.0);
    for (int i = 1; i <= static_cast<int>(steps); ++i) {
      const double f = i / steps;
      gauge_->TakeDepths(
          {glm::normalize(glm::slerp(from.R_AB, input.X_WT.R_AB, f)), glm::mix(from.p_AB, input.X_WT.p_AB, f)},
          gauge_->cut().margin_mm, kReach_mm, deepest_mm_);
    }
  }
  touched_at_ = input.touches ? std::optional(input.X_WT) : std::nullopt;
}

void Practice::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  // A planned plane that crosses the nerve canal must cut it.
  if (!SparesNerve(scene_.exercise.kind)) return;
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
  const ViewBasis keys = viewer_->MakeKeyBasis();
  input.keys = KeyDirections{.right_W = keys.right_W, .up_W = keys.up_W};
  input.feed_mm_per_s = feed_mm_per_s_;
  input.key_feed_mm_per_s = viewer_->controls().feed_mm_per_s();
  input.force_N = glm::length(figures.coupled.f_H_W_N);
  if (scene_.exercise.kind == ExerciseKind::kFollowLine) input.wanted_feed_mm_per_s = scene_.exercise.feed_mm_per_s;
  input.touches = figures.coupled.engaged_teeth > 0 || glm::length(figures.coupled.f_face_W_N) > 0;
  return input;
}

std::optional<CoachLine> Practice::MakeCoach() const {
  // The last level has no aids.
  if (state_ != State::kCutting || !viewer_->is_running() || !gauge_ || !scene_.exercise.gauge) return {};
  return MakeCoachLine(coach_, gauge_->cut(), MakeCoachInput());
}

std::optional<StepLine> Practice::MakeStep() const {
  if (state_ != State::kCutting || !viewer_->is_running() || !gauge_) return {};
  const double done = CalcDone();
  const CoachInput input = MakeCoachInput();
  const ExerciseStep step = FindStep(gauge_->cut(), input, coach_.zone, viewer_->spindle_on(), done);
  const bool with_gauge = step == ExerciseStep::kFinish || step == ExerciseStep::kBeside;
  const bool at_each_level = step == ExerciseStep::kReturn || (with_gauge && scene_.exercise.gauge);
  if (scene_.exercise.level > 1 && !at_each_level) return {};
  return DescribeStep(step, gauge_->cut(), input, viewer_->spindle_on(), done);
}

/// Returns the beginning of a text for a saw that touches bone or leaves the wanted cut with the spindle off; otherwise
/// nothing.
std::string Practice::DescribeSpindleOff() const {
  if (viewer_->spindle_on() || !scene_.exercise.gauge || CalcDone() >= kWholeCut) return "";
  const CoachInput input = MakeCoachInput();
  const ExerciseStep step = FindStep(gauge_->cut(), input, coach_.zone, false, CalcDone());
  if (step != ExerciseStep::kBeside && !input.touches && !coach_.shown) return "";
  // The step says so itself.
  const bool is_said = !coach_.shown && step == ExerciseStep::kSwitchOn && MakeStep();
  return is_said ? "" : std::string(Tr("The spindle is off: Space.")) + " ";
}

std::vector<Aid> Practice::MakeAids() const {
  return ListAids(scene_.exercise, viewer_->controls().in_blade_plane(), viewer_->view().translucent());
}

std::string Practice::DescribeDepthStop() const {
  if (gauge_ && CalcDone() >= kWholeCut) {
    return Tr("The depth stop holds the saw, and the wanted cut is made: lift the blade out (Up key).");
  }
  return Activity::DescribeDepthStop();
}

double Practice::CalcDone() const {
  if (!IsPlanned()) return CalcLineDone(*gauge_, deepest_mm_);
  return report_ ? report_->measured.value_or(0) : 0;
}

DepthAdvice Practice::MakeAdvice() const {
  return MakeDepthAdvice(coach_, viewer_->figures().feed_mm_per_s < kRest_mm_per_s);
}

HudGauge Practice::MakeGauge(const std::optional<DepthReading>& reading, const DepthAdvice& advice) const {
  HudGauge gauge;
  gauge.title = Tr("Depth");
  gauge.upper = scene_.exercise.depth_mm + 1.8 * kZoneBad_mm;
  gauge.good = kZoneReached_mm;
  gauge.warn = CalcZoneNear_mm(scene_.exercise.depth_mm);
  gauge.bad = kZoneBad_mm;
  gauge.goal = scene_.exercise.depth_mm;
  if (!reading) return gauge;
  gauge.value = reading->depth_mm;
  gauge.level = LevelOf(advice);
  gauge.word = reading->bone_mm ? Tr("cut through") : Tr(advice.text);
  // A planned cut is done when the bone is cut through, wherever the blade is.
  if (IsPlanned() && CalcDone() >= kWholeCut) {
    gauge.level = HudLevel::kGood;
    gauge.word = Tr("cut through");
    gauge.goal.reset();
  }
  return gauge;
}

void Practice::FillCutting(HudState& hud) {
  const std::optional<DepthReading> reading = Read();
  // Without the gauge the depth is not shown either.
  if (scene_.exercise.gauge) {
    hud.gauge = MakeGauge(reading, MakeAdvice());
    if (reading) hud.values.depth_mm = reading->depth_mm;
    const ToolDeviation deviation = CalcDeviation(gauge_->cut(), viewer_->figures().coupled.X_WT);
    hud.values.plan_angle_deg = deviation.tilt_deg;
    hud.values.plan_offset_mm = std::abs(deviation.beside_mm);
    hud.values.plan_is_of_saw = true;
  }
  // The same number as in the advice and in the score. A planned cut has no line to follow.
  if (!IsPlanned()) hud.values.feed_mm_per_s = feed_mm_per_s_;
  hud.values.feed_is_along = !IsPlanned();
  if (scene_.exercise.kind == ExerciseKind::kFollowLine) {
    hud.values.key_feed_mm_per_s = viewer_->controls().feed_mm_per_s();
    if (scene_.exercise.gauge) hud.values.wanted_feed_mm_per_s = scene_.exercise.feed_mm_per_s;
  }
  hud.force_note.clear();  // a comparison of force laws says nothing to a student
  hud.values.has_plan = scene_.exercise.gauge;
  hud.values.nerve_is_marked = !nerve_ || !nerve_->empty();
  if (nerve_ && !nerve_->empty()) {
    hud.values.nerve_mm = nerve_->Calc(MakeTool(scene_), viewer_->figures().coupled.X_WT);
    hud.values.nerve_is_crossed = IsPlanned();
  }
  // What the planned plane crosses is injured by a perfect cut, too.
  if (report_ && !IsPlanned()) ShowInjuries(report_->injuries, hud);
  const double goal_s = CalcUnhurriedTime_s({gauge_->cut()}, scene_.exercise);
  begun_ = begun_ || viewer_->spindle_on();
  if (viewer_->figures().removed_mm3 > 0) viewer_->EndTourStep("cut");
  const std::string keys = Tr("Space: spindle   Arrows or left drag: move   Enter: finish");
  const bool made = CalcDone() >= kWholeCut;
  const std::optional<CoachLine> line = MakeCoach();
  const std::optional<StepLine> step = MakeStep();
  const std::string off = DescribeSpindleOff();
  if (!begun_ && off.empty()) {
    hud.banner = HudBanner{
        .kind = HudBanner::Kind::kNotice,
        .text = fmt::format(fmt::runtime(Tr("{0} An unhurried cut takes {1} s; the clock starts when you move the saw "
                                            "or switch the spindle on.")),
                            Translate(exercise_->goal_message), ShowNumber(goal_s, 0)),
        .answers = Tr("Space: spindle   Arrows or left drag: move   Enter: finish   F1: help")};
    if (!IsPlanned() && !scene_.exercise.depth_stop) {
      hud.banner->text +=
          std::string(" ") + Tr("This level has no depth stop: the blade goes as deep as you press it.");
    }
  } else if (line && (line->urgent || !made)) {
    hud.banner = HudBanner{.kind = line->urgent ? HudBanner::Kind::kWarning : HudBanner::Kind::kNotice,
                           .text = off + DescribeWithWay(line->message, line->way),
                           .answers = made ? keys : ""};
  } else if (step || !off.empty()) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                           .text = off + (step ? DescribeWithWay(step->message, step->way) : ""),
                           .answers = keys};
  }
  const double limit_s = scene_.exercise.time_limit_s;
  const double left_s = limit_s - CalcElapsed_s();
  if (limit_s > 0 && left_s <= kWarnTime_s && !(hud.banner && hud.banner->kind == HudBanner::Kind::kWarning)) {
    hud.banner =
        HudBanner{.kind = HudBanner::Kind::kWarning,
                  .text = fmt::format(fmt::runtime(Tr("The attempt ends in {} s, and is then scored as it is.")),
                                      ShowNumber(std::ceil(std::max(left_s, 0.0)), 0)),
                  .answers = keys};
  }
  if (limit_s > 0) {
    hud.status.right = fmt::format(fmt::runtime(Tr("time {0} of {1} s, goal {2} s")), ShowNumber(CalcElapsed_s(), 0),
                                   ShowNumber(limit_s, 0), ShowNumber(goal_s, 0));
    hud.status.short_right =
        fmt::format(fmt::runtime(Tr("{0} of {1} s")), ShowNumber(CalcElapsed_s(), 0), ShowNumber(limit_s, 0));
  }
  if (IsPlanned() && scene_.exercise.gauge) {
    const std::string done =
        fmt::format(fmt::runtime(Tr("{} % of the planned plane cut")), ShowNumber(100 * CalcDone(), 0));
    hud.status.right = hud.status.right.empty() ? done : fmt::format("{}   |   {}", done, hud.status.right);
    hud.status.short_right = fmt::format(
        "{}   {}", fmt::format(fmt::runtime(Tr("{} % cut")), ShowNumber(100 * CalcDone(), 0)), hud.status.short_right);
  }
}

}  // namespace kerf
