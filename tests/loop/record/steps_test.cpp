#include "loop/record/step.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "device/devices/lattice.h"
#include "kerf/error.h"

namespace kerf {
namespace {

bool SameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

bool IsSame(const RecordedStep& a, const RecordedStep& b) {
  return SameBits(a.X.p_AB.x, b.X.p_AB.x) && SameBits(a.X.p_AB.y, b.X.p_AB.y) && SameBits(a.X.p_AB.z, b.X.p_AB.z) &&
         SameBits(a.X.R_AB.w, b.X.R_AB.w) && SameBits(a.X.R_AB.x, b.X.R_AB.x) && SameBits(a.X.R_AB.y, b.X.R_AB.y) &&
         SameBits(a.X.R_AB.z, b.X.R_AB.z) && a.buttons == b.buttons && SameBits(a.dt_s, b.dt_s) &&
         a.skipped == b.skipped && SameBits(a.rpm, b.rpm) && a.flags == b.flags && a.fidelity == b.fidelity &&
         a.piece == b.piece && a.checkpoint == b.checkpoint && a.force_check == b.force_check &&
         a.bone_check == b.bone_check;
}

/// Returns the motion of a hand as a device with this resolution reports it.
RecordedBlock MakeHand(std::size_t ticks, double resolution_mm, unsigned seed) {
  std::mt19937_64 dice(seed);
  std::normal_distribution<double> tremor(0, 0.02);
  RecordedBlock block;
  block.first_step = 250;
  Vec3 p(12.3, -45.6, 7.8);
  for (std::size_t i = 0; i < ticks; ++i) {
    const double t = 1e-3 * static_cast<double>(i);
    p += 1e-3 * Vec3(3 * std::sin(t) + tremor(dice), 3 * std::cos(t) + tremor(dice), tremor(dice));
    Pose X;
    for (int axis = 0; axis < 3; ++axis) X.p_AB[axis] = std::round(p[axis] / resolution_mm) * resolution_mm;
    X.R_AB = glm::normalize(Quat{0.7 + 0.1 * std::sin(t), 0.7, 0.05 * std::cos(t), 0.1});
    RecordedStep step;
    step.X = MakePose(FindNearestOnLattice(X));
    step.rpm = 7500;
    step.force_check = static_cast<std::uint16_t>(dice());
    step.bone_check = static_cast<std::uint16_t>(dice());
    block.steps.push_back(step);
  }
  return block;
}

TEST(RecordedSteps, RoundTripOfAHandsMotionIsBitIdentical) {
  RecordedBlock block = MakeHand(1000, 0.03, 1);
  block.states.push_back({259, 1.25, {1.5, -2.25, 3}, {0.125, 0, -7.5}, 12.5, 3.25});
  block.hashes.push_back({1249, 0x0123456789abcdef, 0xfedcba9876543210});
  const RecordedBlock back = DecodeBlock(EncodeBlock(block));
  ASSERT_EQ(back.steps.size(), block.steps.size());
  for (std::size_t i = 0; i < block.steps.size(); ++i) ASSERT_TRUE(IsSame(back.steps[i], block.steps[i])) << i;
  ASSERT_EQ(back.states.size(), 1u);
  EXPECT_EQ(back.states[0].step, 259u);
  // The values are stored in thousandths and millionths. These are exact multiples, except for the rounding of doubles.
  EXPECT_NEAR(back.states[0].time_s, 1.25, 1e-12);
  EXPECT_NEAR(back.states[0].p_WT_mm.y, -2.25, 1e-12);
  EXPECT_NEAR(back.states[0].f_N.z, -7.5, 1e-12);
  EXPECT_NEAR(back.states[0].removed_mm3, 12.5, 1e-12);
  ASSERT_EQ(back.hashes.size(), 1u);
  EXPECT_EQ(back.hashes[0].bone, 0xfedcba9876543210u);
}

// The doubles may have any value: NaN with any payload, infinities, denormals, invalid poses.
RC_GTEST_PROP(RecordedSteps, RoundTripOfAnyStepsIsBitIdentical, (std::uint64_t seed)) {
  std::mt19937_64 dice(seed);
  RecordedBlock block;
  block.first_step = dice() >> 20;
  const std::size_t count = dice() % 40;
  for (std::size_t i = 0; i < count; ++i) {
    const auto any = [&] {
      switch (dice() % 4) {
        case 0:
          return std::bit_cast<double>(dice());
        case 1:
          return static_cast<double>(dice() % 1000) / 7;
        case 2:
          return -0.0;
        default:
          return std::numeric_limits<double>::quiet_NaN();
      }
    };
    RecordedStep step;
    step.X = {Quat{any(), any(), any(), any()}, Vec3{any(), any(), any()}};
    if (dice() % 3 == 0) step.X = {Quat{1, 0, 0, 0}, Vec3{1, 2, 3}};
    step.dt_s = any();
    step.rpm = any();
    step.skipped = static_cast<std::uint32_t>(dice());
    step.buttons = static_cast<std::uint32_t>(dice());
    step.flags = static_cast<std::uint32_t>(dice()) & kRecordedFlags;
    step.fidelity = static_cast<std::uint8_t>(dice() % 3);
    step.piece = static_cast<std::uint32_t>(dice());
    step.checkpoint = static_cast<std::uint32_t>(dice());
    step.force_check = static_cast<std::uint16_t>(dice());
    step.bone_check = static_cast<std::uint16_t>(dice());
    block.steps.push_back(step);
  }
  const RecordedBlock back = DecodeBlock(EncodeBlock(block));
  RC_ASSERT(back.first_step == block.first_step);
  RC_ASSERT(back.steps.size() == block.steps.size());
  for (std::size_t i = 0; i < count; ++i) RC_ASSERT(IsSame(back.steps[i], block.steps[i]));
}

TEST(RecordedSteps, DecodingAnyBytesDoesNotCrash) {
  const std::string good = EncodeBlock(MakeHand(50, 0.03, 2));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_THROW(DecodeBlock(good.substr(0, size)), Error) << size;
  }
  std::mt19937_64 dice(3);
  for (int i = 0; i < 20'000; ++i) {
    std::string bad = good;
    for (int k = 0; k < 3; ++k) bad[dice() % bad.size()] = static_cast<char>(dice());
    try {
      EXPECT_LE(DecodeBlock(bad).steps.size(), kMaxStepsInBlock);
    } catch (const Error&) {
      // A refusal is equally acceptable.
    }
  }
}

TEST(Lattice, RoundingIsFinerThanAnyDevice) {
  std::mt19937_64 dice(4);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 100'000; ++i) {
    const Pose X{glm::normalize(Quat{any(dice), any(dice), any(dice), any(dice)}),
                 1000.0 * Vec3{any(dice), any(dice), any(dice)}};
    const Pose on = MakePose(FindNearestOnLattice(X));
    EXPECT_NEAR(glm::length(on.p_AB - X.p_AB), 0, 0.5 * std::sqrt(3.0) * kLatticePosition_mm);
    // The error is at most half a step in each of the three stored components. The fourth is at least one half and
    // changes by at most the sum of their changes.
    EXPECT_NEAR(1 - std::abs(glm::dot(on.R_AB, X.R_AB)), 0, 1e-15);
    EXPECT_NEAR(glm::length(on.R_AB), 1, 4e-16);
    // A pose that is on the lattice is found again unchanged.
    const std::optional<LatticePose> again = FindOnLattice(on);
    ASSERT_TRUE(again);
    EXPECT_EQ(MakePose(*again).R_AB, on.R_AB);
    EXPECT_EQ(MakePose(*again).p_AB, on.p_AB);
  }
}

TEST(Lattice, WorksWithTwoNearlyEqualComponents) {
  // In some of these cases, rounding makes the omitted component the smaller of the two.
  const double half = std::sqrt(0.5);
  for (int i = -20; i < 20; ++i) {
    const Pose on = MakePose(FindNearestOnLattice({glm::normalize(Quat{half + i * 1e-10, 0, half, 0}), Vec3{0}}));
    ASSERT_TRUE(FindOnLattice(on)) << i;
    EXPECT_EQ(MakePose(*FindOnLattice(on)).R_AB, on.R_AB);
  }
}

}  // namespace
}  // namespace kerf
