// A tracked tool behind the rounds that every device has.
#include "session/link/tracked_tool.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "kerf/error.h"
#include "session/link/igtl_message.h"

namespace kerf {
namespace {

/// Rounds of 1 ms with poses that arrive as messages.
struct Tracked {
  Tracked() { rounds.Open(0); }
  void Send(const Pose& X_WH) { SendBytes(MakeIgtlTransform({"kerf_hand", 0}, X_WH)); }
  void SendBytes(const std::string& message) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(message.data());
    tool->Take({bytes + IgtlHeader::kBytes, message.size() - IgtlHeader::kBytes});
  }
  ServoState Pass(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_s += 0.001;
      // As DeviceServo does for a device without force.
      rounds.Step(driver, now_s, 0.001, {}, rounds.state() == ServoState::kWaiting);
    }
    return rounds.state();
  }

  std::shared_ptr<TrackedTool> tool = std::make_shared<TrackedTool>();
  TrackedToolDriver driver{tool};
  ServoRound rounds{driver.profile(), driver.traits(), MakeTrackedToolParams()};
  double now_s = 0;
};

Pose MakePose(int i) {
  return {glm::angleAxis(0.001 * i, Vec3(0, 0, 1)), {0.05 * i, -0.02 * i, 10}};
}

TEST(TrackedTool, FollowsAThousandPosesAndIsStaleAfterAFifthOfASecond) {
  Tracked tracked;
  EXPECT_EQ(tracked.Pass(500), ServoState::kHoming);  // no pose yet
  for (int i = 0; i < 1000; ++i) {
    tracked.Send(MakePose(i));
    tracked.Pass(10);
    const Pose& X_DH = tracked.rounds.sample().sample.X_DH;
    ASSERT_LT(glm::length(X_DH.p_AB - MakePose(i).p_AB), 1e-4) << i;  // float numbers are sent
    ASSERT_LT(glm::length(X_DH.Vector({1, 0, 0}) - MakePose(i).Vector({1, 0, 0})), 1e-5) << i;
  }
  EXPECT_EQ(tracked.rounds.state(), ServoState::kEngaged);
  EXPECT_EQ(tracked.rounds.sample().engagements, 1U);
  EXPECT_EQ(tracked.Pass(185), ServoState::kEngaged);
  EXPECT_EQ(tracked.Pass(20), ServoState::kSilent);
  EXPECT_EQ(tracked.rounds.counts().jumps, 0U);
  // It holds the saw again from where it is then: each engagement couples it again.
  tracked.Send(MakePose(5));
  tracked.Pass(10);
  tracked.Send(MakePose(6));
  EXPECT_EQ(tracked.Pass(10), ServoState::kEngaged);
  EXPECT_EQ(tracked.rounds.sample().engagements, 2U);
}

TEST(TrackedTool, RefusesNumbersThatAreNotFiniteAndALeapLetsGoOfTheSaw) {
  Tracked tracked;
  for (int i = 0; i < 10; ++i) {
    tracked.Send(MakePose(i));
    tracked.Pass(20);
  }
  ASSERT_EQ(tracked.rounds.state(), ServoState::kEngaged);
  std::string bad = MakeIgtlTransform({"kerf_hand", 0}, MakePose(9));
  bad.replace(bad.size() - 4, 2, "\x7f\xc0");  // the last coordinate is not a number
  EXPECT_THROW(tracked.SendBytes(bad), Error);
  tracked.Pass(1);
  EXPECT_EQ(tracked.rounds.counts().bad_answers, 1U);
  EXPECT_LT(glm::length(tracked.rounds.sample().sample.X_DH.p_AB - MakePose(9).p_AB), 1e-4);
  EXPECT_EQ(tracked.rounds.state(), ServoState::kEngaged);
  Pose outside = MakePose(9);
  outside.p_AB.x = 1e30;
  EXPECT_THROW(tracked.Send(outside), Error);
  tracked.Pass(1);
  EXPECT_EQ(tracked.rounds.counts().bad_answers, 2U);
  EXPECT_EQ(tracked.rounds.state(), ServoState::kEngaged);
  // 20 ms after the last pose, the limit is 3 mm and 1 m/s: 23 mm.
  tracked.Send(MakePose(9));
  tracked.Pass(20);
  Pose far = MakePose(9);
  far.p_AB.y += 30;
  tracked.Send(far);
  EXPECT_EQ(tracked.Pass(1), ServoState::kSilent);
  EXPECT_EQ(tracked.rounds.counts().jumps, 1U);
  EXPECT_EQ(tracked.rounds.sample().engagements, 1U);
  tracked.Pass(10);
  tracked.Send(far);
  EXPECT_EQ(tracked.Pass(1), ServoState::kEngaged);
  EXPECT_EQ(tracked.rounds.sample().engagements, 2U);  // the saw stays where it was
}

TEST(TrackedTool, GivesNoForce) {
  const Tracked tracked;
  EXPECT_FALSE(tracked.driver.traits().makes_force);
  EXPECT_TRUE(tracked.driver.traits().holds_tool());
  EXPECT_EQ(tracked.driver.profile().peak_force_N, 0);
}

TEST(ToolHolder, IsTheFirstPeerUntilItIsGoneOrSilent) {
  ToolHolder holder;
  using std::chrono::milliseconds;
  const auto at = [](int ms) { return ToolHolder::Clock::time_point(milliseconds(1'000'000 + ms)); };
  EXPECT_TRUE(holder.Accepts(1, at(0)));
  EXPECT_FALSE(holder.Accepts(2, at(10)));
  EXPECT_TRUE(holder.Accepts(1, at(400)));
  EXPECT_FALSE(holder.Accepts(2, at(899)));  // 499 ms after the last pose of the first one
  EXPECT_TRUE(holder.Accepts(2, at(900)));
  EXPECT_FALSE(holder.Accepts(1, at(901)));
  holder.Leave(1);  // does not hold it
  EXPECT_FALSE(holder.Accepts(1, at(902)));
  holder.Leave(2);
  EXPECT_TRUE(holder.Accepts(1, at(903)));
  // The saw has stopped before another tool is followed, so that it is not pulled there.
  EXPECT_GT(std::chrono::duration<double>(ToolHolder::kSilent).count(), 2 * MakeTrackedToolParams().silent_s);
}

}  // namespace
}  // namespace kerf
