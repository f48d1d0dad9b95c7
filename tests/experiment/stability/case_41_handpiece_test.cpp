// Hard case 41: what holds the tool presses on bone: the hub of a disc on both edges of a slot, the handle on a wall.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "bone/grid/build.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "cut/tool/disc_saw.h"
#include "cut/tool/handpiece.h"
#include "experiment/stability/held_block.h"
#include "experiment/stability/held_tool.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::Verdict;

constexpr double kHolderVoxel = 0.2;

/// A disc in a slot that is wider than the disc, with its hub just above both edges, or far from all bone but for a
/// wall beside the widest place of its handle, where the hand grips it.
struct Holder {
  DiscSaw saw;
  Bone bone;
  Pose X_WT;
  Vec3 push_W{0};
};

Holder OverSlot() {
  SolidField field;
  field.value = [](const Vec3& p) {
    return std::max(test::BoxDistance(p, {8, 3, 14}), 0.5 * kSaw.thickness_mm + 0.1 - std::abs(p.y));
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  return {kSaw,
          MakeBone(field, Box3{{-8, -3, -14}, {8, 3, 14}}.Grown(6 * kHolderVoxel), {kHolderVoxel, kHolderVoxel, {}},
                   test::OneRegionTable()),
          test::DiscPose({}, {0, 0, 14 + CalcHub(kSaw).radius_mm + 0.02}),
          {0, 0, -1}};
}

Holder BesideWall() {
  const DiscSaw saw{.p_TG_mm = {0, 0, 52}};
  const std::vector<HolderSection> sections = MakeHandpiece(saw).sections;
  const HolderSection widest = *std::max_element(
      sections.begin(), sections.end(), [](const auto& a, const auto& b) { return a.radius_mm < b.radius_mm; });
  return {saw,
          test::MakeBox({{1, 0, 0, 0}, {widest.radius_mm + 5.02, 0, widest.middle_T.z}}, {10, 16, 40}, kHolderVoxel),
          {},
          {1, 0, 0}};
}

CoupledParams HolderParams(const Holder& holder) {
  CoupledParams params;
  params.tool = holder.saw;
  params.effects.emplace_back("handpiece");
  return params;
}

double HolderChannel(const CoupledSimulation& simulation, std::size_t i) {
  std::array<double, 3> channels{};
  EffectsOf(simulation).Report(channels);
  return channels[i];
}

// As for the margins of the tool on bone: friction and encoder steps, which can only damp, are left out.
TEST(HardCase41, HasAGainOfTwoAndATickOfDelayOnEveryDeviceInEveryHand) {
  Verdict verdict("holds");
  double worst_gain = -1e300, worst_delay = -1e300;
  int tried = 0;
  for (const bool hub : {true, false}) {
    const Holder holder = hub ? OverSlot() : BesideWall();
    const HeldTool held{.bone = holder.bone, .X_WT = holder.X_WT, .push_W = holder.push_W, .push_N = 5};
    ClosedLoopSetup asked;
    asked.coupled = HolderParams(holder);
    asked.coupled.spare_leaves = 1000;
    for (const DeviceProfile& profile : DeviceProfiles()) {
      for (const HandModel& hand : HandModels()) {
        ClosedLoopSetup setup = FitSetup(asked, profile, hand, hand);
        setup.loop_gain = 2;
        const std::string what = fmt::format("{} {} {}", hub ? "hub" : "handle", profile.name, hand.name);
        const std::optional<double> gain = FindGrowth(held, setup);
        setup.loop_gain = 1;
        setup.delay_ticks = 1;
        const std::optional<double> delay = FindGrowth(held, setup);
        ASSERT_TRUE(gain && delay) << what;
        EXPECT_LT(*gain, 0) << what << " at twice the gain";
        EXPECT_LT(*delay, 0) << what << " with a tick of delay";
        worst_gain = std::max(worst_gain, *gain);
        worst_delay = std::max(worst_delay, *delay);
        ++tried;
      }
    }
  }
  verdict.Note("combinations of contact, device and hand", tried);
  verdict.AtMost("growth rate at twice the gain, worst", worst_gain, 0, "1/s");
  verdict.AtMost("growth rate with a tick of delay, worst", worst_delay, 0, "1/s");
}

TEST(HardCase41, RestsOnBoneWithoutNoise) {
  Verdict verdict("holds");
  double noise_mN = 0, depth_mm = 0, toggles = 0, error_N = 0;
  for (const bool hub : {true, false}) {
    const Holder holder = hub ? OverSlot() : BesideWall();
    for (const double rpm : {0.0, 7500.0}) {
      CoupledSimulation tool(holder.bone, HolderParams(holder), holder.X_WT);
      std::vector<Vec3> f;
      std::vector<double> along;
      for (int i = 0; i < 2500; ++i) {
        Pose X_WH = holder.X_WT;
        X_WH.p_AB += std::min(5.0, 0.01 * i) * holder.push_W;  // 5 N at 1 N/mm
        const CoupledOutput out = tool.Tick({.X_WH = X_WH, .rpm = rpm});
        f.push_back(out.f_H_W_N);
        along.push_back(-glm::dot(out.f_H_W_N, holder.push_W));
        depth_mm = std::max(depth_mm, HolderChannel(tool, 2));
      }
      const std::vector<Vec3> rest(f.end() - 1000, f.end());
      noise_mN = std::max(noise_mN, 1000 * CalcNoise(rest, 0.001));
      toggles = std::max(toggles,
                         CountToggles(std::vector<double>(along.end() - 1000, along.end()), 0.001, 0.01).turns_per_s);
      error_N = std::max(error_N, std::abs(HolderChannel(tool, 0) - along.back()));
      EXPECT_EQ(tool.UpdateBone().CalcHash(), holder.bone.CalcHash()) << hub;
    }
  }
  verdict.AtMost("C1", noise_mN, 2, "mN");
  verdict.AtMost("C4", toggles, 0, "1/s");
  verdict.AtMost("depth in the bone", 1000 * depth_mm, 50, "um");
  verdict.AtMost("force of the bone against the force on the hand, difference", error_N, 0.2, "N");
}

TEST(HardCase41, ClosedPathsInAndOutOfContactReturnNoEnergy) {
  Verdict verdict("holds");
  std::mt19937_64 random(41);
  const auto draw = [&random](double largest) {
    return largest * (static_cast<double>(random() >> 11) / 4503599627370496.0 - 1);
  };
  const int orbits = std::max(4, static_cast<int>(30 * test::Effort()));
  double lowest_mJ = 1e9, exchanged_mJ = 0, force_N = 0, depth_mm = 0;
  for (int n = 0; n < orbits; ++n) {
    const Holder holder = n % 2 == 0 ? OverSlot() : BesideWall();
    CoupledParams params = HolderParams(holder);
    SetEffect(params.effects, "handpiece", "friction", n % 4 < 2 ? 0.2 : 0.0);
    params.coupling.p_TC_mm = {0, 0, n % 3 == 0 ? 80.0 : 0.0};
    const Pose start{holder.X_WT.R_AB, holder.X_WT.p_AB - 0.5 * holder.push_W};
    CoupledSimulation tool(holder.bone, params, start);
    double hand_mJ = 0;
    Pose X_from = start;
    for (int leg = 0; leg < 5; ++leg) {
      Pose X_to = start;
      if (leg < 4) {
        X_to.p_AB += (3 + draw(4)) * holder.push_W + Vec3(draw(2), n % 2 == 0 ? 0 : draw(2), 0);
        X_to.R_AB = glm::normalize(X_to.R_AB * glm::angleAxis(n % 2 == 0 ? 0 : draw(0.05), Vec3(0, 1, 0)));
      }
      const int ticks = 50 + static_cast<int>(random() % 200);
      for (int i = 1; i <= ticks; ++i) {
        const CoupledOutput out =
            tool.Tick({.X_WH = Interpolate(X_from, X_to, static_cast<double>(i) / ticks), .rpm = 0});
        hand_mJ += out.hand_mJ;
        exchanged_mJ += std::abs(out.hand_mJ);
        force_N = std::max(force_N, HolderChannel(tool, 0));
        depth_mm = std::max(depth_mm, HolderChannel(tool, 2));
      }
      X_from = X_to;
    }
    for (int i = 0; i < 300; ++i) hand_mJ += tool.Tick({.X_WH = start, .rpm = 0}).hand_mJ;
    EXPECT_NEAR(glm::length(tool.Tick({.X_WH = start, .rpm = 0}).f_H_W_N), 0, 1e-6) << n;
    lowest_mJ = std::min(lowest_mJ, hand_mJ);
  }
  EXPECT_GT(force_N, 3);
  verdict.AtLeast("minimum work of a hand on a closed path", lowest_mJ, -1e-6, "mJ");
  verdict.AtMost("depth in the bone", depth_mm, 0.5 * kHolderVoxel, "mm");
  verdict.Note("energy exchanged along the paths", exchanged_mJ, "mJ");
}

}  // namespace
}  // namespace kerf
