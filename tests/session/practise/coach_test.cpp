// Tests of the advice during a cut: limits, hysteresis and order.
#include "session/practise/coach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "session/practise/exercises.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

WantedCut MakeCut() {
  SceneExercise exercise;
  exercise.start_mm = {-8, 0, 0};
  exercise.end_mm = {8, 0, 0};
  exercise.into = {0, 0, -1};
  exercise.depth_mm = 2;
  exercise.margin_mm = 0.5;
  return MakeWantedCut(exercise, DiscSaw{});
}

/// Returns the input for a disc in the wanted plane that is displaced and turned.
CoachInput Place(const WantedCut& cut, double s_mm, double depth_mm, double beside_mm = 0, double tilt_rad = 0,
                 double time_s = 0) {
  CoachInput input;
  input.time_s = time_s;
  input.X_WT = cut.CalcToolPose(s_mm, depth_mm);
  input.X_WT.R_AB = glm::angleAxis(tilt_rad, cut.into_W) * input.X_WT.R_AB;
  input.X_WT.p_AB += beside_mm * cut.across_W;
  input.depth = DepthReading{depth_mm, cut.depth_mm - depth_mm};
  input.touches = true;
  return input;
}

std::optional<CoachTopic> TopicOf(const WantedCut& cut, const CoachInput& input) {
  return UpdateCoach({}, cut, input).shown;
}

TEST(CalcDeviation, MatchesTheDisplacement) {
  const WantedCut cut = MakeCut();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 100; ++i) {
    const double beside_mm = 3 * any(random), s_mm = 8 + 12 * any(random), yaw_rad = 0.3 * any(random);
    const ToolDeviation d = CalcDeviation(cut, Place(cut, s_mm, 1, beside_mm, yaw_rad).X_WT);
    EXPECT_NEAR(d.beside_mm, beside_mm, 1e-9);
    EXPECT_NEAR(d.beyond_mm, std::max({-s_mm, s_mm - cut.length_mm, 0.0}), 1e-9);
    EXPECT_NEAR(d.tilt_deg, std::abs(yaw_rad) * kDegreesPerRad, 1e-5);  // acos near 1
  }
}

TEST(CalcDeviation, LeaningDiscIsBesideByItsRadiusTimesTheSine) {
  const WantedCut cut = MakeCut();
  Pose X_WT = cut.CalcToolPose(5, 1);
  const double lean_rad = 0.1;
  X_WT.R_AB = glm::angleAxis(lean_rad, cut.along_W) * X_WT.R_AB;
  const ToolDeviation d = CalcDeviation(cut, X_WT);
  EXPECT_NEAR(std::abs(d.beside_mm), cut.radius_mm * std::sin(lean_rad), 1e-9);
  EXPECT_NEAR(d.tilt_deg, lean_rad * kDegreesPerRad, 1e-5);
}

TEST(Coach, SaysNothingWithinTheLimits) {
  const WantedCut cut = MakeCut();
  EXPECT_FALSE(TopicOf(cut, Place(cut, 0, 1)));
  EXPECT_FALSE(TopicOf(cut, Place(cut, 16, 2.2, 0.45, 0.09)));
  // In the air, the position does not matter yet.
  CoachInput air = Place(cut, -5, -3, 4, 0.5);
  EXPECT_FALSE(TopicOf(cut, air));
  air = Place(cut, -5, 1, 4);
  air.touches = false;
  EXPECT_FALSE(TopicOf(cut, air));
}

TEST(Coach, NamesEachFaultBeyondItsLimit) {
  const WantedCut cut = MakeCut();
  EXPECT_EQ(TopicOf(cut, Place(cut, 8, 1, 0.55)), CoachTopic::kBesideLine);
  EXPECT_EQ(TopicOf(cut, Place(cut, 8, 1, -0.55)), CoachTopic::kBesideLine);
  // Far beside the line, the gauge has no depth.
  CoachInput far = Place(cut, 8, 1, 9.3);
  far.depth.reset();
  EXPECT_EQ(TopicOf(cut, far), CoachTopic::kBesideLine);
  far.touches = false;
  EXPECT_FALSE(TopicOf(cut, far));
  EXPECT_EQ(TopicOf(cut, Place(cut, 8, 2.35)), CoachTopic::kTooDeep);
  EXPECT_EQ(TopicOf(cut, Place(cut, 16.6, 1)), CoachTopic::kBeyondEnd);
  EXPECT_EQ(TopicOf(cut, Place(cut, -0.6, 1)), CoachTopic::kBeyondEnd);
  EXPECT_EQ(TopicOf(cut, Place(cut, 8, 1, 0, 0.12)), CoachTopic::kTilted);
  CoachInput near = Place(cut, 8, 1);
  near.nerve_mm = 1.9;
  EXPECT_EQ(TopicOf(cut, near), CoachTopic::kNearNerve);
  near.nerve_mm = -0.1;
  EXPECT_EQ(TopicOf(cut, near), CoachTopic::kInNerve);
}

TEST(Coach, MostUrgentComesFirst) {
  const WantedCut cut = MakeCut();
  CoachInput input = Place(cut, 17, 2.6, 0.9, 0.2);
  EXPECT_EQ(TopicOf(cut, input), CoachTopic::kTooDeep);
  input.nerve_mm = 1;
  EXPECT_EQ(TopicOf(cut, input), CoachTopic::kNearNerve);
  EXPECT_EQ(TopicOf(cut, Place(cut, 17, 1, 0.9, 0.2)), CoachTopic::kBesideLine);
}

TEST(Coach, LineHasTheFigure) {
  const WantedCut cut = MakeCut();
  const CoachInput input = Place(cut, 8, 1, 0.82);
  const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
  ASSERT_TRUE(line);
  EXPECT_EQ(FormatMessage(line->message), "You leave the line: the blade is 0.8 mm beside it.");
  EXPECT_FALSE(line->urgent);
  EXPECT_FALSE(MakeCoachLine({}, cut, input));
}

TEST(Coach, FarBesideTheLineIsUrgent) {
  const WantedCut cut = MakeCut();
  for (const auto& [beside_mm, urgent] : {std::pair{0.95, false}, {1.05, true}, {9.3, true}}) {
    CoachInput input = Place(cut, 8, 1, beside_mm);
    if (beside_mm > 8) input.depth.reset();  // the gauge has no depth there
    const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
    ASSERT_TRUE(line) << beside_mm;
    EXPECT_EQ(line->urgent, urgent) << beside_mm;
  }
}

// The plane of an osteotomy crosses the canal, so the advice mentions it without a warning. There is no line.
TEST(Coach, OsteotomyHasAPlaneThatCrossesTheNerve) {
  const WantedCut cut = MakeCut();
  const auto say = [&](CoachInput input) {
    input.kind = ExerciseKind::kOsteotomy;
    return MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
  };
  CoachInput near = Place(cut, 8, 1);
  near.nerve_mm = 1.2;
  std::optional<CoachLine> line = say(near);
  ASSERT_TRUE(line);
  EXPECT_EQ(line->topic, CoachTopic::kCrossesNerve);
  EXPECT_FALSE(line->urgent);
  EXPECT_EQ(FormatMessage(line->message), "The planned plane crosses the nerve canal, which is 1.2 mm away.");
  near.nerve_mm = -0.4;
  line = say(near);
  ASSERT_TRUE(line);
  EXPECT_FALSE(line->urgent);
  EXPECT_EQ(FormatMessage(line->message), "The blade is in the nerve canal, which the planned plane crosses.");
  // A fault that can be corrected is more urgent.
  near = Place(cut, 8, 1, 0.82);
  near.nerve_mm = 1.2;
  line = say(near);
  ASSERT_TRUE(line);
  EXPECT_EQ(FormatMessage(line->message), "You leave the planned plane: the blade is 0.8 mm beside it.");
  for (const CoachInput& input : {Place(cut, 17, 1), Place(cut, 8, 1, 0.82), near}) {
    line = say(input);
    ASSERT_TRUE(line);
    EXPECT_EQ(FormatMessage(line->message).find("line"), std::string::npos) << FormatMessage(line->message);
  }
  CoachInput planned = Place(cut, 8, 1);
  planned.kind = ExerciseKind::kOsteotomy;
  for (const ExerciseStep step : {ExerciseStep::kReturn, ExerciseStep::kSwitchOn, ExerciseStep::kLower,
                                  ExerciseStep::kDeepen, ExerciseStep::kFollow, ExerciseStep::kFinish}) {
    const std::string text = FormatMessage(DescribeStep(step, cut, planned, true, 0.5, 0.5));
    EXPECT_EQ(text.find("line"), std::string::npos) << text;
  }
}

// The deviation is known in the world; the student sees it in a picture, and the keys move the saw in the picture.
TEST(Coach, SaysTheWayBackAsTheStudentSeesIt) {
  const WantedCut cut = MakeCut();
  const auto say = [&](CoachInput input, const PictureDirections& picture) -> std::string {
    input.picture = picture;
    const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
    return line && line->way_back ? FormatMessage(*line->way_back) : "";
  };
  const std::string left = "It is too far to the right: go left (Left key).";
  const std::string right = "It is too far to the left: go right (Right key).";
  const Vec3 up = -cut.into_W;
  const CoachInput beside = Place(cut, 8, 1, 0.8);
  const CoachInput other_side = Place(cut, 8, 1, -0.8);
  EXPECT_EQ(say(beside, {cut.across_W, up}), left);
  EXPECT_EQ(say(beside, {-cut.across_W, up}), right);
  EXPECT_EQ(say(other_side, {cut.across_W, up}), right);
  EXPECT_EQ(say(beside, {cut.along_W, cut.across_W}), "It is too high: go down (Down key).");
  EXPECT_EQ(say(beside, {cut.along_W, -cut.across_W}), "It is too low: go up (Up key).");
  // The picture's right, its up, and the direction towards the eye are a right-handed frame.
  const bool eye_at_across = glm::dot(glm::cross(cut.along_W, up), cut.across_W) > 0;
  EXPECT_EQ(say(beside, {eye_at_across ? cut.along_W : -cut.along_W, up}),
            "It is too close to you: move it away from you (Page Up key).");
  EXPECT_EQ(say(beside, {eye_at_across ? -cut.along_W : cut.along_W, up}),
            "It is too far from you: bring it towards you (Page Down key).");
  // A view between the axes: the larger component counts.
  const Vec3 oblique = glm::normalize(2.0 * cut.across_W + cut.along_W);
  EXPECT_EQ(say(beside, {oblique, up}), left);
  // Beyond the ends.
  EXPECT_EQ(say(Place(cut, 16.8, 1), {cut.along_W, up}), left);
  EXPECT_EQ(say(Place(cut, -0.8, 1), {cut.along_W, up}), right);
  // Other advice has no way back, and without a picture there is none.
  EXPECT_EQ(say(Place(cut, 8, 2.5), {cut.along_W, up}), "");
  const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, beside), cut, beside);
  ASSERT_TRUE(line);
  EXPECT_FALSE(line->way_back);
}

// A block of 20 mm, cut over a line of 16 mm to a depth of 2 mm.
TEST(CalcCutDone, IsTheShareOfTheWantedArea) {
  const WantedCut cut = MakeCut();
  BlockParams params;
  params.size_mm = {40, 20, 20};
  params.voxel_mm = 0.5;
  const DepthGauge gauge(MakeBlock(params, DefaultMandibleTable()), cut);
  std::vector<double> deepest_mm(gauge.columns().size(), -kAbove_mm);
  EXPECT_EQ(CalcCutDone(gauge, deepest_mm), 0);
  EXPECT_EQ(CalcCutDone(gauge, {}), 0);
  std::fill(deepest_mm.begin(), deepest_mm.end(), 0.5);
  EXPECT_NEAR(CalcCutDone(gauge, deepest_mm), 0.25, 1e-9);
  std::fill(deepest_mm.begin(), deepest_mm.end(), 3);  // deeper than wanted: not more than all of it
  EXPECT_NEAR(CalcCutDone(gauge, deepest_mm), 1, 1e-9);
  // One half of the line at full depth: a half, to within a column of 0.5 mm of 16 mm.
  for (std::size_t i = 0; i < deepest_mm.size(); ++i) deepest_mm[i] = gauge.columns()[i].s_mm < 8 ? 2 : 0;
  EXPECT_NEAR(CalcCutDone(gauge, deepest_mm), 0.5, 0.5 / 16);
}

// A planned cut has no line, so its progress is that of the plane.
TEST(ExerciseSteps, OsteotomySaysHowMuchOfThePlaneIsCut) {
  const WantedCut cut = MakeCut();
  CoachInput planned = Place(cut, 8, 1);
  planned.kind = ExerciseKind::kOsteotomy;
  for (const ExerciseStep step : {ExerciseStep::kLower, ExerciseStep::kDeepen, ExerciseStep::kFollow}) {
    const std::string text = FormatMessage(DescribeStep(step, cut, planned, true, 0.1, 0.37));
    EXPECT_NE(text.find("37 % of it is cut."), std::string::npos) << text;
  }
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kLower, cut, planned, true, 0, 0)),
            "Lower the blade into the bone in the planned plane.");
}

TEST(Coach, DoesNotFlickerAtTheLimit) {
  const WantedCut cut = MakeCut();
  std::mt19937 random(9);
  std::uniform_real_distribution<double> noise(-0.06, 0.06);
  CoachState state;
  int changes = 0;
  for (int i = 0; i < 5000; ++i) {
    // Trembling about the limit of 0.5 mm, by less than the distance to the release at 0.35 mm.
    const CoachState next = UpdateCoach(state, cut, Place(cut, 8, 1, 0.5 + noise(random), 0, 0.01 * i));
    changes += next.shown != state.shown ? 1 : 0;
    state = next;
  }
  EXPECT_EQ(changes, 1);
  EXPECT_EQ(state.shown, CoachTopic::kBesideLine);
}

TEST(Coach, LineStaysForItsTimeAndEndsWhenTheFaultDoes) {
  const WantedCut cut = MakeCut();
  CoachState state = UpdateCoach({}, cut, Place(cut, 8, 1, 0.6, 0, 10));
  ASSERT_EQ(state.shown, CoachTopic::kBesideLine);
  state = UpdateCoach(state, cut, Place(cut, 8, 1, 0.4, 0, 10.1));
  EXPECT_EQ(state.shown, CoachTopic::kBesideLine) << "between release and limit";
  state = UpdateCoach(state, cut, Place(cut, 8, 1, 0.1, 0, 10.3));
  EXPECT_EQ(state.shown, CoachTopic::kBesideLine) << "held";
  state = UpdateCoach(state, cut, Place(cut, 8, 1, 0.1, 0, 10 + kCoachHold_s + 0.01));
  EXPECT_FALSE(state.shown);
}

TEST(Coach, MoreUrgentLineReplacesAnotherAtOnce) {
  const WantedCut cut = MakeCut();
  CoachState state = UpdateCoach({}, cut, Place(cut, 8, 1, 0.6, 0, 10));
  state = UpdateCoach(state, cut, Place(cut, 8, 2.5, 0.6, 0, 10.01));
  EXPECT_EQ(state.shown, CoachTopic::kTooDeep);
}

TEST(ExerciseSteps, LeadFromTheSpindleToTheEnd) {
  const WantedCut cut = MakeCut();
  const CoachInput above = Place(cut, 0, -3);
  EXPECT_EQ(FindStep(cut, above, false, 0), ExerciseStep::kSwitchOn);
  EXPECT_EQ(FindStep(cut, above, true, 0), ExerciseStep::kLower);
  EXPECT_EQ(FindStep(cut, Place(cut, 0, 1), true, 0), ExerciseStep::kDeepen);
  EXPECT_EQ(FindStep(cut, Place(cut, 0, 1.8), true, 0.1), ExerciseStep::kFollow);
  EXPECT_EQ(FindStep(cut, Place(cut, 16, 2), true, 1), ExerciseStep::kFinish);
  EXPECT_EQ(FindStep(cut, above, false, 1), ExerciseStep::kFinish);
  EXPECT_EQ(
      FormatMessage(DescribeStep(ExerciseStep::kFollow, cut, above, true, 0.42, 0.3)),
      "Deep enough: move along the line to its other end, and keep pressing down (Down key). 42 % of it is done.");
}

// The blade climbs if it is moved along without being pressed down; the card says how to avoid it.
TEST(ExerciseSteps, BothStepsInTheBoneSayToKeepPressingDown) {
  const WantedCut cut = MakeCut();
  const CoachInput input = Place(cut, 4, 1.6);
  for (const ExerciseStep step : {ExerciseStep::kDeepen, ExerciseStep::kFollow}) {
    const std::string text = FormatMessage(DescribeStep(step, cut, input, true, 0.4, 0.3));
    EXPECT_NE(text.find("(Down key)"), std::string::npos) << text;
  }
}

TEST(ExerciseSteps, LostSawIsLedBack) {
  const WantedCut cut = MakeCut();
  // The distance is 0 wherever the blade may be in the cut, or just touches the surface.
  for (const auto& [s_mm, depth_mm] : {std::pair{0.0, 0.0}, {8.0, 1.0}, {16.0, 2.0}}) {
    EXPECT_NEAR(CalcDistanceFromCut(cut, cut.CalcToolPose(s_mm, depth_mm)), 0, 1e-9);
  }
  EXPECT_NEAR(CalcDistanceFromCut(cut, cut.CalcToolPose(16 + 3, -4)), 5, 1e-9);
  EXPECT_NEAR(CalcDistanceFromCut(cut, Place(cut, 8, 1, 7).X_WT), 7, 1e-9);
  CoachInput lost = Place(cut, 0, -kStepFar_mm - 1);
  lost.depth.reset();
  lost.touches = false;
  EXPECT_EQ(FindStep(cut, Place(cut, 0, -kStepFar_mm + 1), true, 0), ExerciseStep::kLower);
  EXPECT_EQ(FindStep(cut, lost, true, 0), ExerciseStep::kReturn);
  EXPECT_EQ(FindStep(cut, lost, false, 0), ExerciseStep::kReturn);
  EXPECT_EQ(FindStep(cut, lost, true, 1), ExerciseStep::kFinish);
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kReturn, cut, lost, true, 0, 0)),
            "The saw is 31 mm away from the cut. Switch the spindle off (Space) and press R: the saw returns to its "
            "start.");
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kReturn, cut, lost, false, 0, 0)),
            "The saw is 31 mm away from the cut. Press R: the saw returns to its start.");
}

TEST(ExerciseSteps, SawIsNotLostAtTheStartOfAnExercise) {
  for (const Exercise& exercise : ListExercises()) {
    const Scene scene = MakeExerciseScene(exercise.id, 1);
    const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
    CoachInput input;
    input.kind = scene.exercise.kind;
    input.X_WT = MakePath(scene).CalcPose(0, 0);
    EXPECT_EQ(FindStep(cut, input, false, 0), ExerciseStep::kSwitchOn) << exercise.id;
  }
}

TEST(DepthZone, ChangesAtItsLimitsAndSaysWhatToDo) {
  struct ZoneCase {
    double to_goal_mm;
    DepthZone zone;
    const char* moving;
    const char* resting;
  };
  // The goal is a depth of 2 mm.
  for (const ZoneCase& c : {ZoneCase{2.1, DepthZone::kAbove, "above the bone", "above the bone"},
                            {1.1, DepthZone::kFar, "continue", "continue"},
                            {0.9, DepthZone::kNear, "slow down", "nearly deep enough"},
                            {0.2, DepthZone::kReached, "stop: deep enough", "stop: deep enough"},
                            {-0.2, DepthZone::kReached, "stop: deep enough", "stop: deep enough"},
                            {-0.4, DepthZone::kDeep, "too deep", "too deep"},
                            {-1.1, DepthZone::kTooDeep, "too deep", "too deep"}}) {
    const DepthZone zone = FindDepthZone({.depth_mm = 2 - c.to_goal_mm, .to_goal_mm = c.to_goal_mm});
    EXPECT_EQ(zone, c.zone) << c.to_goal_mm;
    EXPECT_STREQ(DescribeZone(zone, false), c.moving);
    EXPECT_STREQ(DescribeZone(zone, true), c.resting);
  }
}

TEST(Coach, LinesAreCompleteSentences) {
  const WantedCut cut = MakeCut();
  struct LineCase {
    CoachTopic topic;
    bool urgent;
    const char* text;
  };
  CoachInput input = Place(cut, -2, 2.9, 0.75, 0.2);
  input.nerve_mm = 1.5;
  for (const LineCase& c : {LineCase{CoachTopic::kInNerve, true, "Stop: the blade is in the nerve canal. Lift it out."},
                            {CoachTopic::kNearNerve, true, "The nerve canal is 1.5 mm away: do not go deeper."},
                            {CoachTopic::kTooDeep, true, "Too deep by 0.9 mm: lift the blade."},
                            {CoachTopic::kTilted, false, "The blade is tilted by 11°: turn it into the wanted plane."},
                            {CoachTopic::kBesideLine, false, "You leave the line: the blade is 0.8 mm beside it."}}) {
    CoachState state;
    state.shown = c.topic;
    const std::optional<CoachLine> line = MakeCoachLine(state, cut, input);
    ASSERT_TRUE(line);
    EXPECT_EQ(line->urgent, c.urgent);
    EXPECT_EQ(FormatMessage(line->message), c.text);
  }
}

TEST(ExerciseSteps, FractionOfTheLineIsThatOfTheWay) {
  BlockParams block;
  block.size_mm = {30, 16, 8};
  block.voxel_mm = 0.25;
  const WantedCut cut = MakeCut();
  const DepthGauge gauge(MakeBlock(block, DefaultMandibleTable()), cut);
  std::vector<double> deepest_mm(gauge.columns().size(), -5);
  EXPECT_EQ(CalcLineDone(gauge, deepest_mm), 0);
  // A disc at the wanted depth has that depth, to within kStepDepth_mm, over its chord there.
  const double chord_mm =
      std::sqrt(cut.radius_mm * cut.radius_mm - (cut.radius_mm - kStepDepth_mm) * (cut.radius_mm - kStepDepth_mm));
  for (const double s_mm : {4.0, 8.0, 12.0}) {
    for (double s = std::max(0.0, s_mm - 4); s <= s_mm; s += 0.1) {
      gauge.TakeDepths(cut.CalcToolPose(s, cut.depth_mm), deepest_mm);
    }
    // The points of the rim are 3 degrees apart.
    EXPECT_NEAR(CalcLineDone(gauge, deepest_mm), (s_mm + chord_mm) / cut.length_mm,
                0.0524 * cut.radius_mm / cut.length_mm);
  }
}

}  // namespace
}  // namespace kerf
