// Hard cases 35 and 36: the bone is restored or replaced while the tool is in contact, and readers read it during a
// cut.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "base/core/triple_buffer.h"
#include "cut/hand_sim/hands.h"
#include "cut/hand_sim/internals.h"
#include "cut/undo/journal.h"
#include "experiment/stability/verdict.h"
#include "loop/haptics/bone_mirror.h"
#include "loop/haptics/held_saw.h"
#include "loop/haptics/leaf_stream.h"
#include "loop/haptics/step_body.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Effort;
using test::Handle;
using test::HeldSaw;
using test::HeldSawOptions;
using test::kDt_s;
using test::Upright;
using test::Verdict;

/// Device with a fixed handle pose.
struct HeldStill : Device {
  HeldStill(const DeviceProfile& the_profile, double height_mm) : own(the_profile), height(height_mm) {}
  const DeviceProfile& profile() const override { return own; }
  bool Read(DeviceSample& sample) noexcept override {
    sample.X_WH = Upright(Vec3(0, 0, height));
    return true;
  }
  bool Write(const Vec3& f, const Vec3&) noexcept override {
    worst_step_N = std::max(worst_step_N, glm::length(f - f_N));
    f_N = f;
    return true;
  }
  DeviceProfile own;
  double height;
  double worst_step_N = 0;
  Vec3 f_N{0};
};

TEST(HardCase35, SettingTheToolDownInContactRampsTheForce) {
  Verdict verdict("holds");
  // The tool is pressed on the bone with the spindle off. Then it is set down at a previous pose 3 mm away, as an undo
  // would do, with and without requesting the ramp.
  double worst_slew = 0;
  double first_N = 0;
  for (const bool ramp : {false, true}) {
    HeldSawOptions options;
    options.force_map.slew_N_per_s = 500;
    HeldSaw saw(options);
    HeldStill device(options.profile, 11.2);
    for (int i = 0; i < 800; ++i) {
      device.height = std::max(9.0, 11.2 - 0.01 * i);
      saw.step.Step(device, {.dt_s = kDt_s, .rpm = 0});
    }
    EXPECT_GT(device.f_N.z, 2);
    device.worst_step_N = 0;
    ASSERT_TRUE(saw.simulation.SetDown(Upright(Vec3(0, 0, 14))));
    if (ramp) {
      saw.step.RampIn();
      device.f_N = Vec3(0);  // the device exerted no force before
    }
    for (int i = 0; i < 600; ++i) {
      const HapticTick out = saw.step.Step(device, {.dt_s = kDt_s, .rpm = 0});
      if (ramp && i == 0) first_N = glm::length(out.force.f_H_W_N);
      ASSERT_EQ(out.faults, kHapticOk);
      ASSERT_TRUE(std::isfinite(glm::length(out.coupled.f_H_W_N)));
    }
    worst_slew = std::max(worst_slew, device.worst_step_N / 0.5);
    EXPECT_GT(device.f_N.z, 2);  // the tool is back on the bone
  }
  verdict.AtMost("largest step of the device force relative to the slew limit", worst_slew, 1 + 1e-9);
  verdict.AtMost("force in the first tick of the ramp", first_N, 0.01, "N");
}

TEST(HardCase35, BoneReplacedAroundTheToolBeginsWithoutForce) {
  Verdict verdict("holds: the tool cuts itself free, and the force ramps in");
  // The bone of another patient is loaded while the handle is 4 mm deep in it.
  HeldSaw saw;
  saw.simulation.SetDown(Upright(Vec3(0, 0, 7)));
  HeldStill device(saw.device.profile(), 7);
  double first_N = 0;
  double max_N = 0;
  for (int i = 0; i < 1000; ++i) {
    const HapticTick out = saw.step.Step(device, {.dt_s = kDt_s, .rpm = 7500});
    if (i == 0) first_N = glm::length(out.force.f_H_W_N);
    max_N = std::max(max_N, glm::length(out.coupled.f_H_W_N));
  }
  verdict.AtMost("force in the first tick", first_N, 1e-3, "N");
  // Nothing pulls at the tool, and it must not be thrown out.
  verdict.AtMost("largest simulated force", max_N, 0.5, "N");
}

struct Trace {
  std::vector<Vec3> f_N;
  std::vector<Vec3> p_mm;
  double removed_mm3 = 0;
  std::uint64_t hash = 0;
  bool operator==(const Trace&) const = default;
};

/// Cuts for 600 ticks with all stateful elements in the loop: friction, encoder, ramp and slew rate.
Trace CutInto(Bone bone, double x_mm) {
  HeldSawOptions options;
  options.damping_Ns_per_mm = 0.005;
  const Pose start = Upright(Vec3(x_mm, 0, 11.2));
  CoupledSimulation simulation(std::move(bone), test::MakeComparedParams(options), start);
  SimulatedDevice device(options.profile, FindHandModel("H2"), start);
  IntentionStep push;
  push.seconds = 4;
  push.X_WH = start;
  push.push_W_N = Vec3(0.5, 0.2, -8);
  push.yield_s = 0.3;
  device.SetScript(IntentionScript(start, {push}));
  HapticStep step(simulation, options.profile, {});
  Trace trace;
  for (int i = 0; i < 900; ++i) {
    const HapticTick out = step.Step(device, {.dt_s = kDt_s, .rpm = 7500});
    trace.f_N.push_back(out.force.f_H_W_N);
    trace.p_mm.push_back(out.coupled.X_WT.p_AB);
    trace.removed_mm3 += out.coupled.removed_mm3;
  }
  trace.hash = simulation.UpdateBone().CalcHash();
  return trace;
}

TEST(HardCase35, CopyOfTheBoneRestoresEverythingBitForBit) {
  Verdict verdict("holds: a copy of the bone is the complete state");
  const Bone bone = test::MakeBox(Pose{}, {26, 6, 22}, 0.2);
  // Saves after a cut, continues to cut, and restores. The bone is then the saved one and is cut as before.
  CoupledSimulation simulation(bone, test::DiscParams(), DiscPose(Pose{}, {-5, 0, 11.2 + kR}));
  for (int i = 0; i < 1500; ++i) simulation.Tick(Handle(DiscPose(Pose{}, {-5, 0, 11.2 + kR - 0.004 * i})));
  const Bone saved = simulation.UpdateBone();
  const std::uint64_t saved_hash = saved.CalcHash();
  const double saved_mm3 = saved.CalcVolume();
  const Trace once = CutInto(saved, 3);
  for (int i = 0; i < 500; ++i) simulation.Tick(Handle(DiscPose(Pose{}, {-5, 0, 5 + kR - 0.004 * i})));
  EXPECT_NE(simulation.UpdateBone().CalcHash(), saved_hash);
  verdict.Equal("saved bone bit-identical after further cutting", saved.CalcHash() == saved_hash, 1);
  EXPECT_EQ(saved.CalcVolume(), saved_mm3);
  const Trace again = CutInto(saved, 3);
  EXPECT_GT(once.removed_mm3, 0.5);
  EXPECT_NE(once.hash, saved_hash);
  verdict.Equal("repeated cut bit-identical in forces, poses, volume and bone", once == again, 1);
}

TEST(HardCase35, UndoAndRedoInContactRampTheForceAndRestoreTheBone) {
  Verdict verdict(
      "holds: the force falls at its slew rate, the tool is set down at the handle, and the force ramps in");
  struct NoReader : TickObserver {
    void Enter(TickStage) noexcept override {}
  } no_reader;
  double worst_slew = 0;
  double left_N = 0;
  double max_N = 0;
  double before_N = 1e9;
  std::size_t other_bits = 0;
  for (const double rpm : {7500.0, 0.0}) {
    HeldSawOptions options;
    options.force_map.slew_N_per_s = 500;
    HeldSaw saw(options);
    const std::uint64_t whole = saw.simulation.UpdateBone().CalcHash();
    UndoJournal journal(KeepHistory(saw.simulation));
    HeldStill device(options.profile, 11.2);
    GuardedDevice guarded(device);
    StepBodyParams params;
    params.force_map = options.force_map;
    StepBody body(saw.simulation, guarded, params);
    RestoreExchange restores(20);
    body.set_restores(&restores);
    LoopTick tick;
    const auto run = [&](int ticks) {
      for (int i = 0; i < ticks; ++i) {
        body.Tick(kDt_s, no_reader, tick);
        journal.Drain();
        ASSERT_TRUE(std::isfinite(glm::length(device.f_N)));
      }
    };
    // The saw is four millimetres deep, with a pushing hand.
    for (int i = 0; i < 1500; ++i) {
      device.height = 11.2 - 0.003 * i;
      run(1);
    }
    if (rpm == 0) {
      body.set_rpm(0);
      device.height -= 3;
      run(400);
    }
    const std::uint64_t cut = saw.simulation.UpdateBone().CalcHash();
    ASSERT_NE(cut, whole);
    before_N = std::min(before_N, glm::length(device.f_N));
    for (const bool redo : {false, true}) {
      if (redo && !journal.CanRedo()) continue;  // the turning saw has already cut again
      ASSERT_TRUE(restores.Send(*(redo ? journal.PrepareRedo() : journal.PrepareUndo(0))));
      do {
        body.Tick(kDt_s, no_reader, tick);
      } while (tick.stands);
      ASSERT_TRUE(journal.Finish());
      if (rpm == 0) other_bits += saw.simulation.UpdateBone().CalcHash() != (redo ? cut : whole) ? 1 : 0;
      double min_N = glm::length(device.f_N);
      for (int i = 0; i < 700; ++i) {
        device.height -= 0.002;  // the hand pushes again
        run(1);
        if (i < 60) min_N = std::min(min_N, glm::length(device.f_N));
        max_N = std::max(max_N, glm::length(tick.coupled.f_H_W_N));
      }
      left_N = std::max(left_N, min_N);
    }
    worst_slew = std::max(worst_slew, device.worst_step_N / 0.5);
  }
  EXPECT_GT(before_N, 0.2);
  EXPECT_GT(max_N, 0.2);
  verdict.Equal("restored bones that differ", static_cast<double>(other_bits), 0);
  verdict.AtMost("largest step of the device force relative to the slew limit", worst_slew, 1 + 1e-9);
  // After 60 of 500 ticks the ramp allows 4 % of the force that is simulated at that time.
  verdict.AtMost("force left before the ramp", left_N, 0.5, "N");
  verdict.AtMost("largest simulated force afterwards", max_N, 40, "N");
}

TEST(HardCase35, RefillingInContactChangesNothing) {
  Verdict verdict("holds");
  const Bone bone = test::MakeBox(Pose{}, {26, 6, 22}, 0.2);
  std::optional<std::uint64_t> hash;
  double worst_N = 0;
  std::vector<Vec3> forces;
  for (const bool refill : {false, true}) {
    CoupledSimulation simulation(bone, test::DiscParams(), DiscPose(Pose{}, {0, 0, 11.2 + kR}));
    for (int i = 0; i < 1200; ++i) {
      if (refill && i % 10 == 0) simulation.Refill();
      if (refill && i % 97 == 0) simulation.CalcRemovedByRegion();
      if (refill && i % 101 == 0) simulation.UpdateBone();
      const Vec3 f = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.0001 * i, 11.2 + kR - 0.006 * i}))).f_H_W_N;
      if (refill) {
        worst_N = std::max(worst_N, glm::length(f - forces[static_cast<std::size_t>(i)]));
      } else {
        forces.push_back(f);
      }
    }
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), hash.value_or(simulation.UpdateBone().CalcHash()));
    hash = simulation.UpdateBone().CalcHash();
  }
  verdict.Equal("force difference due to refilling, reading and counting during the cut", worst_N, 0, "N");
}

TEST(HardCase36, ReaderNeverReadsATornLeafOrState) {
  Verdict verdict("holds");
  // All values of a leaf are the same number, and so are all values of a state.
  struct Reported {
    std::array<std::uint64_t, 64> words{};
  };
  SpscRing<LeafMessage> ring(16);
  LeafPublisher publisher(ring, 64);
  TripleBuffer<Reported> state;
  std::vector<std::array<float, 512>> leaves(40);
  std::atomic<bool> done{false};
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  std::uint64_t read = 0;
  std::uint64_t states = 0;
  std::map<int, float> seen;
  const auto take = [&] {
    while (const LeafMessage* message = ring.Peek()) {
      for (const float v : message->values) torn += v != message->values[0];
      float& last = seen[message->index[0]];
      backwards += message->values[0] < last;
      last = message->values[0];
      ring.Pop();
      ++read;
    }
    if (!state.Update()) return;
    ++states;
    for (const std::uint64_t w : state.front().words) torn += w != state.front().words[0];
  };
  std::thread reader([&] {
    std::uint64_t last = 0;
    while (!done) {
      take();
      backwards += state.front().words[0] < last;
      last = state.front().words[0];
    }
  });
  std::mt19937_64 random(11);
  const int rounds = static_cast<int>(40000 * Effort());
  for (int tick = 1; tick <= rounds; ++tick) {
    for (int k = 0; k < 3; ++k) {
      const int leaf = static_cast<int>(random() % leaves.size());
      leaves[static_cast<std::size_t>(leaf)].fill(static_cast<float>(tick));
      ASSERT_TRUE(publisher.Mark({leaf, 0, 0}, leaves[static_cast<std::size_t>(leaf)].data()));
    }
    publisher.Send(4);
    state.back().words.fill(static_cast<std::uint64_t>(tick));
    state.Publish();
    if (tick % 64 == 0) std::this_thread::yield();
  }
  done = true;
  reader.join();
  while (publisher.waiting() > 0) {
    publisher.Send(8);
    take();
  }
  take();
  verdict.Equal("torn values", static_cast<double>(torn), 0);
  verdict.Equal("values older than those already seen", static_cast<double>(backwards), 0);
  EXPECT_GT(states, 0U);
  EXPECT_GE(read, leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) EXPECT_EQ(seen[static_cast<int>(i)], leaves[i][0]);
}

TEST(HardCase36, ReadersBoneEqualsTheLoopsAtRest) {
  Verdict verdict("holds");
  const Bone before = test::MakeBox(Pose{}, {26, 6, 12}, 0.2);
  CoupledSimulation simulation(before, test::DiscParams(), DiscPose(Pose{}, {0, 0, 6.2 + kR}));
  SpscRing<LeafMessage> ring(32);
  LeafPublisher publisher(ring, 1 << 14);
  BoneMirror mirror(before, ring);
  std::atomic<bool> done{false};
  // For the reader, too, bone never reappears: phi never decreases at a voxel. Volumes may grow for a moment, by 0.02
  // mm3, because those of cells also depend on the voxels around them, of which some are newer.
  std::vector<Vec3> voxels;
  for (int x = -60; x <= 60; ++x) {
    for (int y = -6; y <= 6; ++y) {
      for (int z = -10; z <= 35; ++z) voxels.push_back(0.2 * Vec3(x, y, z));
    }
  }
  double deepened_mm = 0;
  std::thread reader([&] {
    std::vector<double> last_mm(voxels.size(), -1);
    while (!done) {
      if (mirror.Update(8) == 0) continue;
      for (std::size_t i = 0; i < voxels.size(); ++i) {
        const double phi_mm = mirror.bone().SignedDistance(voxels[i]);
        deepened_mm = std::max(deepened_mm, last_mm[i] - phi_mm);
        last_mm[i] = phi_mm;
      }
    }
  });
  double removed = 0;
  for (int i = 0; i < 2500; ++i) {
    const double down = std::min(0.004 * i, 5.0);
    removed += simulation.Tick(Handle(DiscPose(Pose{}, {0.5 * std::sin(0.01 * i), 0, 6.2 + kR - down}))).removed_mm3;
    for (int k = 0; k < simulation.changed_count(); ++k) {
      const ChangedLeaf leaf = simulation.changed(k);
      ASSERT_TRUE(publisher.Mark(leaf.index, leaf.cut));
    }
    simulation.ClearChanged();
    publisher.Send(4);
    if (i % 16 == 0) std::this_thread::yield();
  }
  done = true;
  reader.join();
  while (publisher.waiting() > 0) {
    publisher.Send(32);
    mirror.Update();
  }
  mirror.Update();
  EXPECT_GT(removed, 1);
  verdict.Equal("bit-identical at rest", mirror.bone().CalcHash() == simulation.UpdateBone().CalcHash(), 1);
  EXPECT_NE(mirror.bone().CalcHash(), before.CalcHash());
  verdict.AtMost("bone that reappeared during the cut", deepened_mm, 1e-6, "mm");
}

}  // namespace
}  // namespace kerf
