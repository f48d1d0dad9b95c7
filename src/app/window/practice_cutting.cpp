// An exercise while it is done: gauge, advice and alarms.
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

bool Touches(const LiveFigures& figures) {
  return figures.coupled.engaged_teeth > 0 || glm::length(figures.coupled.f_face_W_N) > 0;
}

std::string DescribeWithWay(const Message& message, const std::optional<Message>& way) {
  return Translate(message) + (way ? " " + Translate(*way) : "");
}

}  // namespace

void Practice::Began() {
  const std::shared_ptr<const Bone> bone = viewer_->bone_at_start();
  cuts_ = MakeWantedCuts(scene_.exercise, MakeTool(scene_));
  deepest_mm_.clear();
  for (const WantedCut& wanted : cuts_) {
    gauges_.emplace_back(*bone, wanted);
    deepest_mm_.emplace_back(DrillsHoles() ? 1 : gauges_.back().columns().size(), -kAbove_mm);
  }
  shown_made_ = 0;
  SawControls& controls = viewer_->controls();
  controls.set_in_blade_plane(!DrillsHoles());
  controls.set_feed_mm_per_s(scene_.exercise.feed_mm_per_s);
  TakeUpCut(0);
  if (const auto watch = viewer_->cut_watch()) {
    watch->Fetch();  // the last one of the attempt before
    watch->SetMeasure(nullptr);
    watch->SetWanted(nullptr);
    if (IsPlanned()) {
      watch->SetWanted([cuts = cuts_](const Vec3& p_W) { return FindNearestCut(cuts, p_W).IsNear(p_W); });
    }
    if (!DrillsHoles()) {
      // The share of each cut, and that of all.
      watch->SetMeasure([cuts = cuts_](const Bone& before, const Bone& now) {
        std::vector<double> shares;
        CutArea all;
        for (const WantedCut& cut : cuts) {
          const CutArea area = CalcCutArea(before, now, cut);
          shares.push_back(area.share());
          all.bone_mm2 += area.bone_mm2;
          all.cut_mm2 += area.cut_mm2;
        }
        shares.push_back(all.share());
        return shares;
      });
    }
  }
  making_nerve_ =
      std::async(std::launch::async, [bone] { return std::make_unique<RegionDistance>(*bone, Tissue::kCanal); });
  // View from the side and a little from above, with the line, or that from the first hole to the last, across the
  // picture.
  const WantedCut& first = cut();
  const Vec3 into_W = first.into_W;
  const Vec3 end_W = cuts_.back().start_W;
  const Vec3 row_W = end_W - first.start_W - glm::dot(end_W - first.start_W, into_W) * into_W;
  const Vec3 along_W = DrillsHoles() && glm::length(row_W) > 1 ? glm::normalize(row_W) : first.along_W;
  const Vec3 side_W = glm::cross(along_W, -into_W);  // the line points to the right
  const Vec3 middle_W = first.ToWorld({0.5 * first.length_mm, 0, 0});
  // Look at the cut from outside the bone.
  const Vec3 outward_W = middle_W - bone->CalcBounds().centre();
  const bool inside = glm::dot(side_W, outward_W) < -1;
  Vec3 from_W = inside ? -side_W : side_W;
  // A planned cut is seen from the bone's outer side, so that the rest of the bone does not hide it.
  if (IsPlanned()) from_W += glm::dot(outward_W, along_W) < 0 ? -along_W : along_W;
  viewer_->view().camera().Look(from_W - 0.6 * into_W, -into_W);
  ShowCutAndSaw();
  begun_ = false;
  kept_bone_ = bone;
  kept_source_ = scene_.bone;
}

/// Makes a cut the one that the keys, the lock and the advice are about.
void Practice::TakeUpCut(std::size_t i) {
  current_ = i;
  feed_.emplace(cut());
  feed_mm_per_s_.reset();
  coach_ = {};
  touched_at_.reset();
  viewer_->controls().set_lock_plane(cut().plane());
  viewer_->trace().Write("cut", {{"number", i + 1}});
  ShowGoal();
}

std::optional<Pose> Practice::FindRetreat(const Pose& X_start) const {
  if (gauges_.empty() || current_ == 0) return X_start;  // the scene begins at its first cut
  // Above the highest place of the bone that the tool may meet there.
  constexpr double kClear_mm = 3;
  double near_mm = 0;
  for (const CutColumn& column : gauge().columns()) {
    if (column.s_mm <= cut().radius_mm) near_mm = std::min(near_mm, column.near_mm);
  }
  return cut().CalcToolPose(0, near_mm - kClear_mm);
}

ViewBasis Practice::MakeKeyBasis(const ViewBasis& picture) const {
  if (gauges_.empty()) return picture;
  if (!DrillsHoles()) return AlignWithCut(picture, cut().along_W, cut().into_W);
  // Across a hole, no direction is better than that of the picture.
  const Vec3 right_W = picture.right_W - glm::dot(picture.right_W, cut().into_W) * cut().into_W;
  const bool is_seen_along = glm::length(right_W) < 1e-3;
  return AlignWithCut(picture, is_seen_along ? cut().along_W : glm::normalize(right_W), cut().into_W);
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

bool Practice::IsPlanned() const {
  return scene_.exercise.kind == ExerciseKind::kOsteotomy;
}

bool Practice::DrillsHoles() const {
  return scene_.exercise.kind == ExerciseKind::kDrillHoles;
}

std::optional<DepthReading> Practice::Read() const {
  return !gauges_.empty() && viewer_->is_running() ? gauge().Calc(viewer_->figures().coupled.X_WT) : std::nullopt;
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
  const Pose& X_WT = viewer_->figures().coupled.X_WT;
  std::optional<DepthReading> reading = Read();
  if (HasSeveralCuts()) {
    std::vector<bool> made;
    for (std::size_t i = 0; i < cuts_.size(); ++i) made.push_back(IsMade(i));
    // In its own kerf or hole, a tool need not touch.
    const bool in_bone = Touches(viewer_->figures()) || (reading && reading->depth_mm > 0);
    const std::size_t next = FindCurrentCut(cuts_, made, current_, X_WT, in_bone);
    if (next != current_) {
      TakeUpCut(next);
      reading = Read();
    }
  }
  const bool in_bone = reading && reading->depth_mm > 0;
  const std::size_t made = CountMade();
  if ((IsPlanned() && DescribePlan() != plan_label_) || made != shown_made_) {
    shown_made_ = made;
    ShowGoal();
  }
  if (scene_.exercise.sound) {
    viewer_->sound().SetAlarm(AlarmKind::kDepth, in_bone ? std::optional(reading->to_goal_mm) : std::nullopt);
  }
  feed_mm_per_s_ = feed_->Take(viewer_->figures().time_s, X_WT);
  if (const auto watch = viewer_->cut_watch()) {
    if (std::optional<PlanesReport> report = watch->Fetch()) report_ = std::move(report);
  }
  const CoachInput input = MakeCoachInput();
  coach_ = UpdateCoach(coach_, cut(), input);
  if (scene_.exercise.colour) viewer_->view().SetToolColour(ColourOf(LevelOf(MakeAdvice())));
  // The saw has also been between the places of two frames.
  constexpr double kStep_mm = 0.1;
  if (input.touches && DrillsHoles()) {
    if (reading && CalcDeviation(cut(), X_WT).beside_mm <= cut().margin_mm) {
      double& deepest_mm = deepest_mm_[current_].front();
      deepest_mm = std::max(deepest_mm, reading->depth_mm);
    }
  } else if (input.touches) {
    const Pose from = touched_at_.value_or(input.X_WT);
    const double steps = std::clamp(std::ceil(glm::distance(from.p_AB, input.X_WT.p_AB) / kStep_mm), 1.0, 100.0);
    for (int i = 1; i <= static_cast<int>(steps); ++i) {
      const double f = i / steps;
      gauge().TakeDepths(
          {glm::normalize(glm::slerp(from.R_AB, input.X_WT.R_AB, f)), glm::mix(from.p_AB, input.X_WT.p_AB, f)},
          deepest_mm_[current_]);
    }
  }
  touched_at_ = input.touches ? std::optional(input.X_WT) : std::nullopt;
}

void Practice::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  // A planned plane that crosses the nerve canal must cut it.
  if (crosses_nerve_) return;
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
  input.crosses_nerve = crosses_nerve_;
  input.touches = Touches(figures);
  input.is_last_cut = CountMade() + (IsMade(current_) ? 0 : 1) == gauges_.size();
  return input;
}

std::optional<CoachLine> Practice::MakeCoach() const {
  // The last level has no aids.
  if (state_ != State::kCutting || !viewer_->is_running() || gauges_.empty() || !scene_.exercise.gauge) return {};
  return MakeCoachLine(coach_, cut(), MakeCoachInput());
}

std::optional<StepLine> Practice::MakeStep() const {
  if (state_ != State::kCutting || !viewer_->is_running() || gauges_.empty()) return {};
  const double done = CalcDone(current_);
  const CoachInput input = MakeCoachInput();
  const ExerciseStep step = FindStep(cut(), input, coach_.zone, viewer_->spindle_on(), done);
  const bool with_gauge = step == ExerciseStep::kFinish || step == ExerciseStep::kBeside;
  const bool at_each_level = step == ExerciseStep::kReturn || (with_gauge && scene_.exercise.gauge);
  if (scene_.exercise.level > 1 && !at_each_level) return {};
  return DescribeStep(step, cut(), input, viewer_->spindle_on(), done);
}

/// Returns the beginning of a text for a saw that touches bone or leaves the wanted cut with the spindle off; otherwise
/// nothing.
std::string Practice::DescribeSpindleOff() const {
  if (viewer_->spindle_on() || !scene_.exercise.gauge || IsMade(current_)) return "";
  const CoachInput input = MakeCoachInput();
  const ExerciseStep step = FindStep(cut(), input, coach_.zone, false, CalcDone(current_));
  if (step != ExerciseStep::kBeside && !input.touches && !coach_.shown) return "";
  // The step says so itself.
  const bool is_said = !coach_.shown && step == ExerciseStep::kSwitchOn && MakeStep();
  return is_said ? "" : std::string(Tr("The spindle is off: Space.")) + " ";
}

std::vector<Aid> Practice::MakeAids() const {
  return ListAids(scene_.exercise, viewer_->controls().in_blade_plane(), viewer_->view().translucent());
}

std::string Practice::DescribeDepthStop() const {
  if (!gauges_.empty() && AllMade()) {
    return Tr("The depth stop holds the saw, and the wanted cut is made: lift the blade out (Up key).");
  }
  return Activity::DescribeDepthStop();
}

double Practice::CalcDone(std::size_t i) const {
  if (DrillsHoles()) return IsHoleMade(gauges_[i], deepest_mm_[i].front()) ? 1 : 0;
  return report_ && !report_->measured.empty() ? report_->measured[i] : 0;
}

bool Practice::IsMade(std::size_t i) const {
  return CalcDone(i) >= kWholeCut;
}

bool Practice::IsFinished() const {
  if (!DrillsHoles()) return CalcLineShare(gauges_, deepest_mm_).value_or(0) >= kFinishedShare;
  std::size_t begun = 0;  // to half of their depth
  for (std::size_t i = 0; i < gauges_.size(); ++i) begun += IsHoleMade(gauges_[i], 2 * deepest_mm_[i].front()) ? 1 : 0;
  return static_cast<double>(begun) >= kFinishedShare * static_cast<double>(gauges_.size());
}

std::size_t Practice::CountMade() const {
  std::size_t made = 0;
  for (std::size_t i = 0; i < gauges_.size(); ++i) made += IsMade(i) ? 1 : 0;
  return made;
}

/// Returns how much of the exercise is done, in full and in short; empty: it is not said.
std::pair<std::string, std::string> Practice::DescribeDone() const {
  if (DrillsHoles()) {
    return {fmt::format(fmt::runtime(Tr("{0} of {1} holes drilled")), CountMade(), gauges_.size()),
            fmt::format(fmt::runtime(Tr("{0} of {1} holes")), CountMade(), gauges_.size())};
  }
  if (!IsPlanned()) return {};
  const double done = report_ && !report_->measured.empty() ? report_->measured.back() : 0;
  const std::string percent = ShowNumber(100 * done, 0);
  return {fmt::format(fmt::runtime(HasSeveralCuts() ? Tr("{} % of the planned planes cut")
                                                    : Tr("{} % of the planned plane cut")),
                      percent),
          fmt::format(fmt::runtime(Tr("{} % cut")), percent)};
}

DepthAdvice Practice::MakeAdvice() const {
  return MakeDepthAdvice(coach_, viewer_->figures().feed_mm_per_s < kRest_mm_per_s);
}

HudGauge Practice::MakeGauge(const std::optional<DepthReading>& reading, const DepthAdvice& advice) const {
  HudGauge gauge;
  gauge.title = Tr("Depth");
  gauge.upper = cut().depth_mm + 1.8 * kZoneBad_mm;
  gauge.good = kZoneReached_mm;
  gauge.warn = CalcZoneNear_mm(cut().depth_mm);
  gauge.bad = kZoneBad_mm;
  gauge.goal = cut().depth_mm;
  if (!reading) return gauge;
  gauge.value = reading->depth_mm;
  gauge.level = LevelOf(advice);
  gauge.word = reading->bone_mm ? Tr("cut through") : Tr(advice.text);
  // A planned cut is done when the bone is cut through, wherever the blade is.
  if (IsPlanned() && IsMade(current_)) {
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
    const ToolDeviation deviation = CalcDeviation(cut(), viewer_->figures().coupled.X_WT);
    hud.values.plan_angle_deg = deviation.tilt_deg;
    hud.values.plan_offset_mm = std::abs(deviation.beside_mm);
    hud.values.plan_is_of_saw = true;
  }
  // The same number as in the advice and in the score. A planned cut and a hole have no line to follow.
  const bool has_line = !IsPlanned() && !DrillsHoles();
  if (has_line) hud.values.feed_mm_per_s = feed_mm_per_s_;
  hud.values.feed_is_along = has_line;
  if (scene_.exercise.kind == ExerciseKind::kFollowLine) {
    hud.values.key_feed_mm_per_s = viewer_->controls().feed_mm_per_s();
    if (scene_.exercise.gauge) hud.values.wanted_feed_mm_per_s = scene_.exercise.feed_mm_per_s;
  }
  hud.force_note.clear();  // a comparison of force laws says nothing to a student
  hud.values.has_plan = scene_.exercise.gauge;
  hud.values.nerve_is_marked = !nerve_ || !nerve_->empty();
  if (nerve_ && !nerve_->empty()) {
    hud.values.nerve_mm = nerve_->Calc(MakeTool(scene_), viewer_->figures().coupled.X_WT);
    hud.values.nerve_is_crossed = crosses_nerve_;
  }
  // What the planned plane crosses is injured by a perfect cut, too.
  if (report_ && !IsPlanned()) ShowInjuries(report_->injuries, hud);
  const double goal_s = CalcUnhurriedTime_s(cuts_, scene_.exercise);
  begun_ = begun_ || viewer_->spindle_on();
  if (viewer_->figures().removed_mm3 > 0) viewer_->EndTourStep("cut");
  const std::string keys = HasSeveralCuts() && DrillsHoles()
                               ? Tr("Space: spindle   Arrows or left drag: move   R: to the hole   Enter: finish")
                           : HasSeveralCuts()
                               ? Tr("Space: spindle   Arrows or left drag: move   R: to the cut   Enter: finish")
                               : Tr("Space: spindle   Arrows or left drag: move   Enter: finish");
  const bool made = IsMade(current_);
  const std::optional<CoachLine> line = MakeCoach();
  const std::optional<StepLine> step = MakeStep();
  const std::string off = DescribeSpindleOff();
  const char* const of_all = DrillsHoles() ? Tr("Hole {0} of {1}:") : Tr("Cut {0} of {1}:");
  const std::string number =
      HasSeveralCuts() ? fmt::format(fmt::runtime(of_all), current_ + 1, gauges_.size()) + " " : "";
  if (!begun_ && off.empty()) {
    hud.banner = HudBanner{
        .kind = HudBanner::Kind::kNotice,
        .text = fmt::format(fmt::runtime(Tr("{0} An unhurried cut takes {1} s; the clock starts when you move the saw "
                                            "or switch the spindle on.")),
                            Translate(exercise_->goal_message), ShowNumber(goal_s, 0)),
        .answers = Tr("Space: spindle   Arrows or left drag: move   Enter: finish   F1: help")};
    if (!IsPlanned() && !scene_.exercise.depth_stop) {
      hud.banner->text += std::string(" ") +
                          (DrillsHoles() ? Tr("This level has no depth stop: the drill goes as deep as you press it.")
                                         : Tr("This level has no depth stop: the blade goes as deep as you press it."));
    }
  } else if (line && (line->urgent || !made)) {
    hud.banner = HudBanner{.kind = line->urgent ? HudBanner::Kind::kWarning : HudBanner::Kind::kNotice,
                           .text = number + off + DescribeWithWay(line->message, line->way),
                           .answers = made ? keys : ""};
  } else if (step || !off.empty()) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                           .text = number + off + (step ? DescribeWithWay(step->message, step->way) : ""),
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
  const auto [done, short_done] = DescribeDone();
  if (!done.empty() && scene_.exercise.gauge) {
    hud.status.right = hud.status.right.empty() ? done : fmt::format("{}   |   {}", done, hud.status.right);
    hud.status.short_right = fmt::format("{}   {}", short_done, hud.status.short_right);
  }
}

}  // namespace kerf
