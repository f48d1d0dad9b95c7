// Tests of a tool that is pressed on the bone and held there, with devices without friction.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "experiment/stability/held_block.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched_loop.h"

namespace kerf {
namespace {

using test::HeldBlock;
using test::Verdict;
using test::WatchedLoop;

struct Place {
  const char* name;
  Vec3 size_mm;
  Vec3 over_mm;  // the disc's lowest point, relative to the top
  bool layered;
};
// In each place, the disc lies in the plane y = 0. With 20 N the saw cuts 40 mm deep.
const Place kPlaces[] = {
    {"face", Vec3(26, 6, 80), Vec3(0, 0, 0), false},        {"edge", Vec3(26, 6, 80), Vec3(12.8, 0, 0), false},
    {"corner", Vec3(26, 6, 80), Vec3(12.8, 2.6, 0), false}, {"lamella", Vec3(26, 0.4, 80), Vec3(0, 0, 0), false},
    {"border", Vec3(26, 6, 80), Vec3(0, 0, 0), true},
};

Bone MakePlace(const Place& place) {
  MaterialTable table;
  table.Add({24, "cortical", Tissue::kCortical, 19300, 0.28, true, "test"});
  table.Add({32, "cancellous", Tissue::kCancellous, 300, 0.3, true, "test"});
  BlockParams block;
  block.size_mm = place.size_mm;
  block.voxel_mm = 0.2;
  if (place.layered) block.layers = {{1, 24}, {1, 32}, {1, 24}, {1, 32}, {100, 24}};
  return MakeBlock(block, table);
}

struct Held {
  double noise_mN = 0;  // of the simulation's force, like mean_N
  double mean_N = 0;
  double taken_N = 0;          // of the push, by the hand itself; mean
  double late_over_early = 0;  // ratio of the noise late in the push to that early in it
  bool limit_cycle = false;
  std::uint32_t faults = 0;
};

/// Presses with `push_N` (of the simulation) for `seconds` and measures everything after the first `settle_s`.
Held Press(const Place& place, const ClosedLoopSetup& setup, double push_N, double rpm, double settle_s,
           double seconds) {
  // A saw that cuts exactly on the edge slides off it, because the edge crosses the arc next to its lowest point.
  const double inwards_mm = rpm != 0 && place.over_mm.x > 0 ? 5 : 0;
  const Pose start = test::Upright(place.over_mm + Vec3(-inwards_mm, 0, 11.1));
  WatchedLoop saw(MakePlace(place), setup, start);
  const double scale = ForceMap(setup.profile, setup.force_map).force_scale();
  Intention push;
  push.X_WH = start;
  push.yield_s = 0.5;
  test::YieldingHand hand(setup, push.yield_s, start);
  std::vector<Vec3> f;
  std::vector<double> f_z;
  Held held;
  const int settle = static_cast<int>(settle_s / setup.period_s);
  const int all = static_cast<int>(seconds / setup.period_s);
  for (int i = 0; i < all; ++i) {
    push.push_W_N = Vec3(0, 0, -push_N * scale * std::min(1.0, i * setup.period_s / 0.3));
    saw.loop.device().SetIntention(push);
    const ClosedLoopTick tick = saw.Step(rpm);
    held.faults |= tick.out.faults;
    const double taken_N = hand.Add(tick, setup.hand) / scale;
    if (i < settle) continue;
    held.taken_N += taken_N / (all - settle);
    f.push_back(tick.out.force.f_H_W_N / scale);
    f_z.push_back(f.back().z);
    held.mean_N += f.back().z / (all - settle);
  }
  const std::size_t third = f.size() / 3;
  const std::span<const Vec3> span(f);
  held.noise_mN = 1000 * CalcNoise(span, setup.period_s);
  const double early = 1000 * CalcNoise(span.first(third), setup.period_s);
  const double late = 1000 * CalcNoise(span.last(third), setup.period_s);
  held.late_over_early = late / std::max(early, 5.0);  // below 5 mN it is occasional encoder noise
  held.limit_cycle = FindOscillation(f_z, setup.period_s, 0.02).is_limit_cycle;
  return held;
}

ClosedLoopSetup WithoutFriction(const char* profile, const char* hand) {
  ClosedLoopSetup setup = HeldBlock(profile, hand);
  setup.profile.friction_N = 0;
  setup.coupled.spare_leaves = 20000;
  return setup;
}

/// Returns the catalogue's bound: 20 mN or 1 % of the force.
double CalcBound_mN(const Held& held) {
  return std::max(20.0, 10 * std::abs(held.mean_N));
}

// The tool is pressed for 20 s with the saw stopped, which is the stiffest possible wall. Friction is disabled because
// it would hold the handle.
TEST(ClosedLoopST5, StoppedSawPressedAndHeldDoesNotTremble) {
  Verdict verdict("holds");
  double noise = 0;
  double growth = 0;
  int cycles = 0;
  std::string table;
  for (const Place& place : kPlaces) {
    for (const double push_N : {1.0, 5.0, 20.0}) {
      const char* hand = push_N == 1 ? "H2" : push_N == 5 ? "H3" : "H4";
      const double seconds = push_N == 5 ? 20 : 8;
      const Held held = Press(place, WithoutFriction("omega_6", hand), push_N, 0, 3, seconds);
      noise = std::max(noise, held.noise_mN / CalcBound_mN(held));
      growth = std::max(growth, held.late_over_early);
      cycles += held.limit_cycle ? 1 : 0;
      EXPECT_EQ(held.faults, 0u);
      EXPECT_NEAR(held.mean_N + held.taken_N, push_N, 0.02 * push_N) << place.name;
      table += fmt::format("{} {} N {}: noise {:.2f} mN, mean {:.2f} N, late/early {:.2f}\n", place.name, push_N, hand,
                           held.noise_mN, held.mean_N, held.late_over_early);
    }
  }
  std::puts(table.c_str());
  verdict.AtMost("noise above 20 Hz relative to its bound (20 mN or 1 %), worst", noise, 1);
  verdict.AtMost("noise of the last third relative to that of the first, worst", growth, 1.2);
  verdict.Equal("limit cycles", cycles, 0);
}

// The spindle turns, so the saw cuts steadily.
TEST(ClosedLoopST5, RunningSawPressedAndHeldCutsWithoutNoise) {
  Verdict verdict("holds");
  double noise = 0;
  std::string table;
  for (const Place& place : kPlaces) {
    for (const double push_N : {1.0, 5.0, 20.0}) {
      const char* hand = push_N == 1 ? "H2" : push_N == 5 ? "H3" : "H4";
      const Held held = Press(place, WithoutFriction("omega_6", hand), push_N, 7500, 0.6, push_N == 1 ? 2.6 : 1.2);
      noise = std::max(noise, held.noise_mN / CalcBound_mN(held));
      EXPECT_EQ(held.faults, 0u);
      EXPECT_NEAR(held.mean_N + held.taken_N, push_N, 0.02 * push_N) << place.name;
      table += fmt::format("{} {} N {}: noise {:.2f} mN, mean {:.2f} N, {:.2f} N taken by the hand\n", place.name,
                           push_N, hand, held.noise_mN, held.mean_N, held.taken_N);
    }
  }
  std::puts(table.c_str());
  verdict.AtMost("noise above 20 Hz relative to its bound (20 mN or 1 %), worst", noise, 1);
}

}  // namespace
}  // namespace kerf
