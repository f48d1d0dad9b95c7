// Tests of the advice during a cut: limits, hysteresis and order.
#include "session/practise/coach.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <span>
#include <string>
#include <vector>

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

/// Returns the step at the pose of `input`, in a state that begins there.
ExerciseStep StepOf(const WantedCut& cut, const CoachInput& input, bool spindle_on, double done) {
  return FindStep(cut, input, UpdateCoach({}, cut, input).zone, spindle_on, done);
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
  // High in the air, the position does not matter yet, and just above the bone only that beside the line does.
  CoachInput air = Place(cut, -5, -kCoachHover_mm - 1, 4, 0.5);
  air.touches = false;
  EXPECT_FALSE(TopicOf(cut, air));
  air = Place(cut, -5, -1, 0, 0.5);
  air.touches = false;
  EXPECT_FALSE(TopicOf(cut, air));
}

// A blade that will be lowered beside the line can still be moved.
TEST(Coach, SaysThatABladeAboveTheBoneIsBesideTheLine) {
  const WantedCut cut = MakeCut();
  const auto say = [&](double beside_mm) {
    CoachInput input = Place(cut, 8, -1.5, beside_mm);
    input.touches = false;
    input.keys = KeyDirections{cut.across_W, -cut.into_W};
    const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
    return line ? FormatMessage(line->message) + " " + FormatMessage(line->way.value()) : "";
  };
  EXPECT_EQ(say(0.4), "");
  EXPECT_EQ(say(1.4), "The blade is 1.4 mm beside the line. Left key: to the left.");
}

TEST(Coach, SaysThatTheFeedIsTooFastOrTooSlow) {
  const WantedCut cut = MakeCut();
  const auto say = [&](double feed_mm_per_s, double depth_mm = 2, double wanted = 3) {
    CoachInput input = Place(cut, 8, depth_mm);
    input.feed_mm_per_s = feed_mm_per_s;
    input.wanted_feed_mm_per_s = wanted;
    const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
    return line ? FormatMessage(line->message) : "";
  };
  EXPECT_EQ(say(3), "");
  EXPECT_EQ(say(3 * 1.24), "");
  EXPECT_EQ(say(10), "Slower: your feed is 10.0 mm/s, and 3.0 mm/s are wanted.");
  EXPECT_EQ(say(3 * 0.76), "");
  EXPECT_EQ(say(1), "Faster: your feed is 1.0 mm/s, and 3.0 mm/s are wanted.");
  // A blade that is still being lowered may be slow; one that is fast stays above the depth.
  EXPECT_EQ(say(1, 1.2), "");
  EXPECT_EQ(say(10, 1.2), "Slower: your feed is 10.0 mm/s, and 3.0 mm/s are wanted.");
  EXPECT_EQ(say(10, 2, 0), "");  // any feed is right
  // While the line stays, a feed that has become slow or is unknown is not said to be too fast.
  CoachInput input = Place(cut, 8, 2);
  input.wanted_feed_mm_per_s = 3;
  input.feed_mm_per_s = 10;
  const CoachState state = UpdateCoach({}, cut, input);
  for (const std::optional<double> feed : {std::optional(1.0), std::optional<double>()}) {
    input.feed_mm_per_s = feed;
    EXPECT_FALSE(MakeCoachLine(UpdateCoach(state, cut, input), cut, input));
  }
}

// A feed that is wrong has a cause: the speed of the keys, the force, or a key that is not pressed.
TEST(Coach, NamesTheKeyThatChangesTheFeed) {
  const WantedCut cut = MakeCut();
  const auto say = [&](double feed_mm_per_s, double key_feed_mm_per_s, double force_N) {
    CoachInput input = Place(cut, 8, 2);
    input.feed_mm_per_s = feed_mm_per_s;
    input.wanted_feed_mm_per_s = 3;
    input.key_feed_mm_per_s = key_feed_mm_per_s;
    input.force_N = force_N;
    const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
    return line && line->way ? FormatMessage(*line->way) : "";
  };
  EXPECT_EQ(say(5, 5, 2), "Keys move the saw at 5.0 mm/s: press the [ key.");
  EXPECT_EQ(say(5, 3, 2), "");  // with the mouse
  EXPECT_EQ(say(1.5, 1.5, 8.2), "Keys move the saw at 1.5 mm/s: press the ] key.");
  EXPECT_EQ(say(1.5, 3, 8.2), "Press less: 8 N slow the blade. Or press the ] key.");
  EXPECT_EQ(say(1.5, 3, 2), "Keep the key pressed that moves the saw along the line.");
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

TEST(Coach, SaysThatTheBoneIsCutThrough) {
  const WantedCut cut = MakeCut();
  CoachInput input = Place(cut, 8, 18);
  input.depth = DepthReading{13.5, 2 - 13.5, 13.5};
  const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
  ASSERT_TRUE(line);
  EXPECT_TRUE(line->urgent);
  EXPECT_EQ(FormatMessage(line->message), "Cut through: the bone is 13.5 mm thick here. Lift the blade.");
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

// Where the plane of an osteotomy crosses the canal, the advice mentions it without a warning; where it does not, a
// blade near the canal is a fault. There is no line.
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
  EXPECT_EQ(line->topic, CoachTopic::kNearNerve);
  EXPECT_TRUE(line->urgent);
  near.crosses_nerve = true;
  line = say(near);
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
  near.crosses_nerve = true;
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
  for (const ExerciseStep step :
       {ExerciseStep::kReturn, ExerciseStep::kSwitchOn, ExerciseStep::kLower, ExerciseStep::kDeepen,
        ExerciseStep::kFollow, ExerciseStep::kFinish, ExerciseStep::kBeside}) {
    const std::string text = FormatMessage(DescribeStep(step, cut, planned, true, 0.5).message);
    EXPECT_EQ(text.find("line"), std::string::npos) << text;
  }
}

// The deviation is known in the world; the student sees it in a picture, and the keys move the saw in the picture.
TEST(Coach, SaysTheWayBackAsTheStudentSeesIt) {
  const WantedCut cut = MakeCut();
  const auto say = [&](CoachInput input, const KeyDirections& picture) -> std::string {
    input.keys = picture;
    const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, input), cut, input);
    return line && line->way ? FormatMessage(*line->way) : "";
  };
  const std::string left = "Left key: to the left.";
  const std::string right = "Right key: to the right.";
  const Vec3 up = -cut.into_W;
  CoachInput beside = Place(cut, 8, -0.5, 0.8);
  CoachInput other_side = Place(cut, 8, -0.5, -0.8);
  beside.touches = other_side.touches = false;
  EXPECT_EQ(say(beside, {cut.across_W, up}), left);
  EXPECT_EQ(say(beside, {-cut.across_W, up}), right);
  EXPECT_EQ(say(other_side, {cut.across_W, up}), right);
  EXPECT_EQ(say(beside, {cut.along_W, cut.across_W}), "Down key: down.");
  EXPECT_EQ(say(beside, {cut.along_W, -cut.across_W}), "Up key: up.");
  // The picture's right, its up, and the direction towards the eye are a right-handed frame.
  const bool eye_at_across = glm::dot(glm::cross(cut.along_W, up), cut.across_W) > 0;
  EXPECT_EQ(say(beside, {eye_at_across ? cut.along_W : -cut.along_W, up}), "Page Up key: away from you.");
  EXPECT_EQ(say(beside, {eye_at_across ? -cut.along_W : cut.along_W, up}), "Page Down key: towards you.");
  // A view between the axes: the larger component counts.
  const Vec3 oblique = glm::normalize(2.0 * cut.across_W + cut.along_W);
  EXPECT_EQ(say(beside, {oblique, up}), left);
  // In the bone, the blade comes out before it moves sideways.
  EXPECT_EQ(say(Place(cut, 8, 1, 0.8), {cut.across_W, up}),
            "Lift the blade out first. Up key: up. Then move it over. Left key: to the left.");
  // Beyond the ends.
  EXPECT_EQ(say(Place(cut, 16.8, 1), {cut.along_W, up}), left);
  EXPECT_EQ(say(Place(cut, -0.8, 1), {cut.along_W, up}), right);
  EXPECT_EQ(say(Place(cut, 8, 2.5), {cut.along_W, up}), "Up key: up.");
  // Other advice has no way back, and without a picture there is none.
  EXPECT_EQ(say(Place(cut, 8, 1, 0, 0.2), {cut.along_W, up}), "");
  const std::optional<CoachLine> line = MakeCoachLine(UpdateCoach({}, cut, beside), cut, beside);
  ASSERT_TRUE(line);
  EXPECT_FALSE(line->way);
}

// A planned cut has no line, so its progress is that of the plane.
TEST(ExerciseSteps, OsteotomySaysHowMuchOfThePlaneIsCut) {
  const WantedCut cut = MakeCut();
  CoachInput planned = Place(cut, 8, 1);
  planned.kind = ExerciseKind::kOsteotomy;
  for (const ExerciseStep step : {ExerciseStep::kLower, ExerciseStep::kDeepen, ExerciseStep::kFollow}) {
    const std::string text = FormatMessage(DescribeStep(step, cut, planned, true, 0.37).message);
    EXPECT_NE(text.find("37 % of it is cut."), std::string::npos) << text;
  }
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kLower, cut, planned, true, 0).message),
            "Lower the blade into the bone in the planned plane (Down key).");
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
  EXPECT_EQ(StepOf(cut, above, false, 0), ExerciseStep::kSwitchOn);
  EXPECT_EQ(StepOf(cut, above, true, 0), ExerciseStep::kLower);
  EXPECT_EQ(StepOf(cut, Place(cut, 0, 1), true, 0), ExerciseStep::kDeepen);
  EXPECT_EQ(StepOf(cut, Place(cut, 0, 1.8), true, 0.1), ExerciseStep::kFollow);
  EXPECT_EQ(StepOf(cut, Place(cut, 16, 2), true, 1), ExerciseStep::kFinish);
  EXPECT_EQ(StepOf(cut, above, false, 1), ExerciseStep::kFinish);
  EXPECT_EQ(StepOf(cut, Place(cut, 15, 2), true, 0.97), ExerciseStep::kFollow);  // the review would name what lacks
  // It is pressed down only where it is not quite deep enough.
  const auto follow = [&](double depth_mm) {
    return FormatMessage(DescribeStep(ExerciseStep::kFollow, cut, Place(cut, 4, depth_mm), true, 0.42).message);
  };
  EXPECT_EQ(follow(2), "Deep enough: move along the line to its other end. 42 % of it is done.");
  EXPECT_EQ(follow(1.8),
            "Deep enough: move along the line to its other end, and press down (Down key). 42 % of it is done.");
}

TEST(Coach, StepsThatAskForAMovementNameItsKey) {
  const WantedCut cut = MakeCut();
  const auto way = [&](const std::optional<KeyDirections>& keys) {
    CoachInput input = Place(cut, 4, 2);
    input.keys = keys;
    const std::optional<Message> shown = DescribeStep(ExerciseStep::kFollow, cut, input, true, 0.4).way;
    return shown ? FormatMessage(*shown) : "";
  };
  EXPECT_EQ(way(KeyDirections{.right_W = cut.along_W, .up_W = -cut.into_W}), "Left or Right key.");
  EXPECT_EQ(way(KeyDirections{.right_W = -cut.along_W, .up_W = -cut.into_W}), "Left or Right key.");
  EXPECT_EQ(way(KeyDirections{.right_W = cut.across_W, .up_W = cut.along_W}), "Up or Down key.");
  EXPECT_EQ(way(KeyDirections{.right_W = cut.across_W, .up_W = -cut.into_W}), "Page Up or Page Down key.");
  EXPECT_EQ(way({}), "");
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kFinish, cut, Place(cut, 4, 2), true, 1).message),
            "The whole line is cut: lift the blade out (Up key) and finish the exercise (Enter).");
}

// The blade climbs if it is moved along without being pressed down; the card says how to avoid it.
TEST(ExerciseSteps, BothStepsInTheBoneSayToKeepPressingDown) {
  const WantedCut cut = MakeCut();
  const CoachInput input = Place(cut, 4, 1.6);
  for (const ExerciseStep step : {ExerciseStep::kDeepen, ExerciseStep::kFollow}) {
    const std::string text = FormatMessage(DescribeStep(step, cut, input, true, 0.4).message);
    EXPECT_NE(text.find("(Down key)"), std::string::npos) << text;
  }
}

// Beside, beyond or below the cut, lowering the blade is wrong: the way to the cut comes first.
TEST(ExerciseSteps, OutsideTheCutTheWayToItComesFirst) {
  const WantedCut cut = MakeCut();
  const auto say = [&](CoachInput input, ExerciseKind kind = ExerciseKind::kGroove) {
    input.kind = kind;
    input.depth.reset();
    input.touches = false;
    input.keys = KeyDirections{cut.along_W, -cut.into_W};
    std::string all;
    for (const bool spindle_on : {true, false}) {
      const ExerciseStep step = StepOf(cut, input, spindle_on, 0.3);
      if (step != ExerciseStep::kBeside) return std::string("another step");
      const StepLine line = DescribeStep(step, cut, input, spindle_on, 0.3);
      all = FormatMessage(line.message) + " " + FormatMessage(line.way.value());
    }
    return all;
  };
  const Vec3 near_W = glm::cross(cut.along_W, -cut.into_W);
  const double near = glm::dot(near_W, cut.across_W);
  EXPECT_EQ(say(Place(cut, 8, -6, 9.3 * near)), "The blade is 9.3 mm beside the line. Page Up key: away from you.");
  EXPECT_EQ(say(Place(cut, 8, 6, -9.3 * near), ExerciseKind::kOsteotomy),
            "The blade is 9.3 mm beside the planned plane. Page Down key: towards you.");
  EXPECT_EQ(say(Place(cut, 20, -6)), "The blade is 4.0 mm beyond the end of the line. Left key: to the left.");
  EXPECT_EQ(say(Place(cut, -3, 1), ExerciseKind::kOsteotomy),
            "The blade is 3.0 mm beyond the edge of the planned cut. Right key: to the right.");
  EXPECT_EQ(say(Place(cut, 8, 9)), "The blade is 7.0 mm below the wanted cut. Up key: up.");
  EXPECT_EQ(say(Place(cut, 8, -6, 0.4)), "another step");
}

/// Returns wanted cuts of a tool along x, `apart_mm` apart in y; holes for the kind of holes.
std::vector<WantedCut> MakeSeveral(ExerciseKind kind, const Tool& tool, int count, double apart_mm) {
  SceneExercise exercise;
  exercise.kind = kind;
  exercise.start_mm = {-8, 0, 0};
  exercise.end_mm = {8, 0, 0};
  exercise.depth_mm = 4;
  exercise.margin_mm = 0.5;
  for (int i = 1; i < count; ++i) {
    exercise.further.push_back(
        {.start_mm = {-8, i * apart_mm, 0}, .end_mm = {8, i * apart_mm, 0}, .into = {0, 0, -1}, .depth_mm = 4});
  }
  return MakeWantedCuts(exercise, tool);
}

CoachInput PlaceInHole(const WantedCut& hole, double depth_mm, const Vec3& beside_W = Vec3(0), double tilt_rad = 0) {
  CoachInput input;
  input.kind = ExerciseKind::kDrillHoles;
  input.X_WT = hole.CalcToolPose(0, depth_mm);
  input.X_WT.R_AB = glm::angleAxis(tilt_rad, Vec3(1, 0, 0)) * input.X_WT.R_AB;
  input.X_WT.p_AB += beside_W;
  input.depth = DepthReading{depth_mm, hole.depth_mm - depth_mm};
  input.touches = depth_mm > 0;
  return input;
}

TEST(CalcDeviation, OfAHoleIsTheDistanceFromItsAxisAndTheAngleToIt) {
  const WantedCut hole = MakeSeveral(ExerciseKind::kDrillHoles, TwistDrill{}, 1, 0).front();
  const ToolDeviation d = CalcDeviation(hole, PlaceInHole(hole, 1, {0.3, -0.4, 0}, 0.2).X_WT);
  EXPECT_NEAR(d.beside_mm, 0.5, 1e-9);
  EXPECT_NEAR(glm::distance(d.beside_W, Vec3(0.3, -0.4, 0)), 0, 1e-9);
  EXPECT_EQ(d.beyond_mm, 0);
  EXPECT_NEAR(d.tilt_deg, 0.2 * kDegreesPerRad, 1e-5);  // in any direction, not only out of a plane
}

TEST(Coach, SpeaksOfADrillAndItsHole) {
  const WantedCut hole = MakeSeveral(ExerciseKind::kDrillHoles, TwistDrill{}, 1, 0).front();
  const auto say = [&](CoachInput input) {
    input.keys = KeyDirections{.right_W = {1, 0, 0}, .up_W = {0, 0, 1}};
    const CoachState state = UpdateCoach({}, hole, input);
    const std::optional<CoachLine> line = MakeCoachLine(state, hole, input);
    if (line) return FormatMessage(line->message) + (line->way ? " " + FormatMessage(*line->way) : "");
    return FormatMessage(DescribeStep(FindStep(hole, input, state.zone, true, 0), hole, input, true, 0).message);
  };
  EXPECT_EQ(say(PlaceInHole(hole, -1)), "Set the tip of the drill on the place of the hole and press (Down key).");
  EXPECT_EQ(say(PlaceInHole(hole, -1, {2, 0.1, 0})),
            "The tip of the drill is 2.0 mm beside the axis of the hole. Left key: to the left.");
  EXPECT_EQ(say(PlaceInHole(hole, 1, {0.1, 0.8, 0})),
            "The tip of the drill is 0.8 mm beside the axis of the hole. Pull the drill out first. Up key: up. Then "
            "move it over. Page Down key: towards you.");
  EXPECT_EQ(say(PlaceInHole(hole, -1, Vec3(0), 0.2)),
            "The drill is tilted by 11°: turn it into the direction of the hole (W S, A D, Q E).");
  EXPECT_EQ(say(PlaceInHole(hole, 2)),
            "Drill on along the axis to the depth of 4.0 mm (Down key). Press less as soon as the bone resists less.");
  EXPECT_EQ(say(PlaceInHole(hole, 5)), "Too deep by 1.0 mm: pull the drill back. Up key: up.");
  CoachInput last = PlaceInHole(hole, 4);
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kFinish, hole, last, true, 1).message),
            "All holes are drilled: pull the drill out (Up key) and finish the exercise (Enter).");
  last.is_last_cut = false;
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kFinish, hole, last, true, 1).message).substr(0, 22),
            "This hole is drilled: ");
}

// A blade with a stroke has no teeth on its sides, so that no step may ask to move it along in the bone.
TEST(Coach, BladesWithAStrokePlunge) {
  for (const Tool& tool : {Tool{ReciprocatingBlade{}}, Tool{OscillatingBlade{}}, Tool{PiezoInsert{}}}) {
    for (const ExerciseKind kind : {ExerciseKind::kGroove, ExerciseKind::kOsteotomy}) {
      const WantedCut cut = MakeSeveral(kind, tool, 1, 0).front();
      ASSERT_GT(cut.plunges, 1);
      CoachInput input;
      input.kind = kind;
      input.X_WT = cut.CalcToolPose(4, 1);
      input.depth = DepthReading{1, cut.depth_mm - 1};
      input.touches = true;
      input.keys = KeyDirections{.right_W = {1, 0, 0}, .up_W = {0, 0, 1}};
      const auto say = [&](ExerciseStep step, double done) {
        return FormatMessage(DescribeStep(step, cut, input, true, done).message);
      };
      const std::string apart = FormatQuantity({16.0 / (cut.plunges - 1), 1, "mm"});
      EXPECT_EQ(say(ExerciseStep::kLower, 0),
                "Plunge the blade straight into the bone at one end of the cut (Down key).");
      EXPECT_EQ(say(ExerciseStep::kLower, 0.25), "Plunge the blade in again (Down key), at most " + apart +
                                                     " beside the last plunge. 25 % of the cut is made.");
      EXPECT_NE(say(ExerciseStep::kDeepen, 0.25).find("do not move it along. 25 % of"), std::string::npos);
      EXPECT_EQ(say(ExerciseStep::kFollow, 0.25),
                "Deep enough here: lift the blade out (Up key) and plunge it in "
                "again, at most " +
                    apart + " further along the cut. 25 % of the cut is made.");
    }
  }
}

// A drill of 1.5 mm with a tip of 118 degrees is 0.45 mm long up to its whole width.
TEST(IsHoleMade, AtItsDepthOrThroughTheBone) {
  BlockParams block;
  block.size_mm = {20, 20, 10};
  block.voxel_mm = 0.25;
  const TwistDrill drill{.diameter_mm = 1.5, .point_angle_deg = 118};
  const DepthGauge blind(MakeBlock(block), MakeSeveral(ExerciseKind::kDrillHoles, drill, 1, 0).front());
  EXPECT_FALSE(IsHoleMade(blind, 4 - kStepDepth_mm - 0.02));
  EXPECT_TRUE(IsHoleMade(blind, 4 - kStepDepth_mm + 0.02));
  block.size_mm.z = 3;
  const DepthGauge through(MakeBlock(block), MakeSeveral(ExerciseKind::kDrillHoles, drill, 1, 0).front());
  EXPECT_FALSE(IsHoleMade(through, 3 + 0.43));
  EXPECT_TRUE(IsHoleMade(through, 3 + 0.47));
}

TEST(FindCurrentCut, IsTheNearestInTheBoneAndTheNextInTheAir) {
  for (const ExerciseKind kind : {ExerciseKind::kDrillHoles, ExerciseKind::kOsteotomy}) {
    const Tool tool = kind == ExerciseKind::kDrillHoles ? Tool{TwistDrill{}} : Tool{DiscSaw{}};
    const std::vector<WantedCut> cuts = MakeSeveral(kind, tool, 3, 8);
    const auto find = [&](std::vector<bool> made, std::size_t current, double y_mm, bool in_bone) {
      Pose X_WT = cuts[0].CalcToolPose(0, in_bone ? 1 : -3);
      X_WT.p_AB.y += y_mm;
      return FindCurrentCut(cuts, made, current, X_WT, in_bone);
    };
    // Where the student works is current, in any order.
    EXPECT_EQ(find({false, false, false}, 0, 16, true), 2U);
    EXPECT_EQ(find({false, false, false}, 0, 15, false), 2U);
    EXPECT_EQ(find({false, false, true}, 0, 16, true), 2U) << "a made one, too";
    // Far from all, the one so far, or the next one if that is made.
    EXPECT_EQ(find({false, false, false}, 1, 40, false), 1U);
    EXPECT_EQ(find({true, false, false}, 0, 0, false), 1U);
    EXPECT_EQ(find({true, false, true}, 2, 16, false), 1U);
    EXPECT_EQ(find({true, true, true}, 2, 0, false), 2U);
    // Within the margin of the one so far, another one is not nearer, whatever their distances.
    EXPECT_EQ(find({false, false, false}, 1, 8.4, true), 1U);
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
  EXPECT_EQ(StepOf(cut, Place(cut, 0, -kStepFar_mm + 1), true, 0), ExerciseStep::kLower);
  EXPECT_EQ(StepOf(cut, lost, true, 0), ExerciseStep::kReturn);
  EXPECT_EQ(StepOf(cut, lost, false, 0), ExerciseStep::kReturn);
  EXPECT_EQ(StepOf(cut, lost, true, 1), ExerciseStep::kFinish);
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kReturn, cut, lost, true, 0).message),
            "The saw is 31 mm away from the cut. Switch the spindle off (Space) and press R: the saw returns to its "
            "start.");
  EXPECT_EQ(FormatMessage(DescribeStep(ExerciseStep::kReturn, cut, lost, false, 0).message),
            "The saw is 31 mm away from the cut. Press R: the saw returns to its start.");
}

TEST(ExerciseSteps, SawIsNotLostAtTheStartOfAnExercise) {
  for (const Exercise& exercise : ListExercises()) {
    const Scene scene = MakeExerciseScene(exercise.id, 1);
    const WantedCut cut = MakeWantedCut(scene.exercise, MakeTool(scene));
    CoachInput input;
    input.kind = scene.exercise.kind;
    input.X_WT = MakePath(scene).CalcPose(0, 0);
    EXPECT_EQ(StepOf(cut, input, false, 0), ExerciseStep::kSwitchOn) << exercise.id;
  }
}

TEST(DepthZone, ChangesAtItsLimits) {
  struct ZoneCase {
    double to_goal_mm;
    DepthZone zone;
  };
  // The goal is a depth of 2 mm, so that a quarter of it is 0.5 mm.
  for (const ZoneCase& c : {ZoneCase{2.1, DepthZone::kAbove},
                            {0.55, DepthZone::kFar},
                            {0.45, DepthZone::kNear},
                            {0.2, DepthZone::kReached},
                            {-0.2, DepthZone::kReached},
                            {-0.4, DepthZone::kDeep},
                            {-1.1, DepthZone::kTooDeep}}) {
    EXPECT_EQ(FindDepthZone({.depth_mm = 2 - c.to_goal_mm, .to_goal_mm = c.to_goal_mm}), c.zone) << c.to_goal_mm;
  }
  EXPECT_EQ(CalcZoneNear_mm(1), 0.5);
  EXPECT_EQ(CalcZoneNear_mm(3), 0.75);
  EXPECT_EQ(CalcZoneNear_mm(11), 1);
}

// The student sees both at once: the gauge's word, and the line or, without one, the step.
TEST(DepthAdvice, AgreesWithTheCoachAtEveryDepth) {
  const WantedCut cut = MakeCut();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  std::set<std::string> words;
  for (const double nerve_mm : {9.0, 1.5, -0.2}) {
    CoachState state;
    double time_s = 0;
    // Down from the air to far below the goal and up again, with a trembling hand.
    for (int i = -400; i <= 400; ++i) {
      const double depth_mm = 4 - 0.02 * std::abs(i) + 0.05 * any(random);
      CoachInput input = Place(cut, 8, depth_mm, 0, 0, time_s += 0.02);
      input.touches = depth_mm > 0;
      input.nerve_mm = nerve_mm;
      state = UpdateCoach(state, cut, input);
      const DepthAdvice advice = MakeDepthAdvice(state, false);
      const std::optional<CoachLine> line = MakeCoachLine(state, cut, input);
      const std::string word = advice.text;
      words.insert(word);
      const std::string where = word + " at " + std::to_string(depth_mm);
      EXPECT_EQ(word == "too deep", line && line->topic == CoachTopic::kTooDeep) << where;
      EXPECT_EQ(word == "no deeper: nerve canal", line && line->topic == CoachTopic::kNearNerve) << where;
      EXPECT_EQ(word == "stop: in the nerve canal", line && line->topic == CoachTopic::kInNerve) << where;
      EXPECT_EQ(advice.stop, line && line->topic <= CoachTopic::kNearNerve) << where;
      if (line) continue;
      const ExerciseStep step = FindStep(cut, input, state.zone, true, 0.4);
      const ExerciseStep expected = word == "above the bone" ? ExerciseStep::kLower
                                    : word == "deep enough"  ? ExerciseStep::kFollow
                                                             : ExerciseStep::kDeepen;
      EXPECT_EQ(step, expected) << where;
    }
  }
  EXPECT_EQ(words, (std::set<std::string>{"above the bone", "continue", "slow down", "deep enough", "too deep",
                                          "no deeper: nerve canal", "stop: in the nerve canal"}));
  EXPECT_STREQ(MakeDepthAdvice({.zone = DepthZone::kNear}, true).text, "nearly deep enough");
}

// A depth beside the line is not that of the wanted cut.
TEST(DepthAdvice, IsNotGoodBesideTheLine) {
  const WantedCut cut = MakeCut();
  const auto advice = [&](double depth_mm, double beside_mm) {
    return MakeDepthAdvice(UpdateCoach({}, cut, Place(cut, 8, depth_mm, beside_mm)), false);
  };
  EXPECT_FALSE(advice(2, 0).beside);
  EXPECT_TRUE(advice(2, 3.6).beside);
  EXPECT_STREQ(advice(2, 3.6).text, "beside the wanted cut");
  EXPECT_STREQ(advice(2.5, 3.6).text, "too deep");
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
  for (const LineCase& c :
       {LineCase{CoachTopic::kInNerve, true, "Stop: the blade is in the nerve canal. Lift it out."},
        {CoachTopic::kNearNerve, true, "The nerve canal is 1.5 mm away: do not go deeper."},
        {CoachTopic::kTooDeep, true, "Too deep by 0.9 mm: lift the blade."},
        {CoachTopic::kTilted, false, "The blade is tilted by 11°: turn it into the wanted plane (W S, A D, Q E)."},
        {CoachTopic::kBesideLine, false, "You leave the line: the blade is 0.8 mm beside it."}}) {
    CoachState state;
    state.shown = c.topic;
    const std::optional<CoachLine> line = MakeCoachLine(state, cut, input);
    ASSERT_TRUE(line);
    EXPECT_EQ(line->urgent, c.urgent);
    EXPECT_EQ(FormatMessage(line->message), c.text);
  }
}

// The advice, the score and the rule for an unfinished attempt use the same share of the line.
TEST(ExerciseSteps, ShareOfTheLineIsThatOfTheWay) {
  BlockParams block;
  block.size_mm = {30, 16, 8};
  block.voxel_mm = 0.25;
  const WantedCut cut = MakeCut();
  const DepthGauge gauge(MakeBlock(block, DefaultMandibleTable()), cut);
  std::vector<double> deepest_mm(gauge.columns().size(), -5);
  const auto share = [&] { return CalcLineShare(std::span(&gauge, 1), std::span(&deepest_mm, 1)).value(); };
  EXPECT_EQ(share(), 0);
  // A disc at the wanted depth is half as deep over its chord there.
  const double height_mm = (1 - kCoveredFraction) * cut.depth_mm;
  const double chord_mm = std::sqrt(height_mm * (2 * cut.radius_mm - height_mm));
  for (const double s_mm : {4.0, 8.0, 12.0}) {
    for (double s = std::max(0.0, s_mm - 4); s <= s_mm; s += 0.1) {
      gauge.TakeDepths(cut.CalcToolPose(s, cut.depth_mm), deepest_mm);
    }
    // The points of the rim are 3 degrees apart.
    EXPECT_NEAR(share(), std::min(1.0, (s_mm + chord_mm) / cut.length_mm), 0.0524 * cut.radius_mm / cut.length_mm);
  }
}

}  // namespace
}  // namespace kerf
