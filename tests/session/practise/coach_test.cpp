// Tests of the advice during a cut: limits, hysteresis and order.
#include "session/practise/coach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bone/material/region_table.h"
#include "bone/models/block.h"

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
  for (const ExerciseStep step : {ExerciseStep::kSwitchOn, ExerciseStep::kLower, ExerciseStep::kDeepen,
                                  ExerciseStep::kFollow, ExerciseStep::kFinish}) {
    const std::string text = FormatMessage(DescribeStep(step, ExerciseKind::kOsteotomy, cut, 0.5));
    EXPECT_EQ(text.find("line"), std::string::npos) << text;
  }
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
  EXPECT_EQ(FindStep(above, false, 0), ExerciseStep::kSwitchOn);
  EXPECT_EQ(FindStep(above, true, 0), ExerciseStep::kLower);
  EXPECT_EQ(FindStep(Place(cut, 0, 1), true, 0), ExerciseStep::kDeepen);
  EXPECT_EQ(FindStep(Place(cut, 0, 1.8), true, 0.1), ExerciseStep::kFollow);
  EXPECT_EQ(FindStep(Place(cut, 16, 2), true, 1), ExerciseStep::kFinish);
  EXPECT_EQ(FindStep(above, false, 1), ExerciseStep::kFinish);
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kFollow, ExerciseKind::kGroove, cut, 0.42)),
            "Deep enough: move along the line to its other end. 42 % of it is done.");
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
