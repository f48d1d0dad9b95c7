// Undo in a running loop, while the saw cuts: it is exact bit for bit, causes no jump in the force, and can be repeated
// from its events.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <optional>
#include <thread>
#include <vector>

#include "cut/hand_sim/internals.h"
#include "cut/undo/journal.h"
#include "cut/undo/same_bone.h"
#include "kerf/error.h"
#include "loop/haptics/bone_mirror.h"
#include "loop/haptics/haptic_loop.h"
#include "loop/haptics/held_saw.h"
#include "loop/haptics/step_body.h"

namespace kerf {
namespace {

using test::CountDifferingVoxels;
using test::HeldSawOptions;
using test::Upright;

Bone MakeBone() {
  return MakeBlock({.size_mm = {26, 6, 26}, .X_WB = {}, .layers = {}, .voxel_mm = 0.2}, test::OneRegionTable());
}

/// A hand that pushes a saw down into a block and back and forth in it, continuously.
struct Stage {
  struct Hand : HandDriver {
    explicit Hand(SimulatedDevice& the_device) : device(the_device) {}
    void Advance(double dt_s) noexcept override {
      t_s += dt_s;
      const double down_mm = 12 * std::min(1.0, t_s / 1.2);
      device.SetIntention({.X_WH = Upright(Vec3(4 * std::sin(3 * t_s), 0, 11.2 - down_mm))});
    }
    SimulatedDevice& device;
    double t_s = 0;
  };

  explicit Stage(std::size_t leaves_per_tick = 1000)
      : options(MakeOptions()),
        simulation(MakeBone(), test::MakeComparedParams(options), Upright(Vec3(0, 0, 11.2))),
        journal(KeepHistory(simulation)),
        simulated(options.profile, FindHandModel("H2"), Upright(Vec3(0, 0, 11.2))),
        device(simulated),
        hand(simulated),
        body(simulation, device, MakeBodyParams(), &hand),
        restores(leaves_per_tick) {
    body.set_restores(&restores);
  }
  static HeldSawOptions MakeOptions() {
    HeldSawOptions made;
    made.damping_Ns_per_mm = 0.005;
    return made;
  }
  static StepBodyParams MakeBodyParams() {
    StepBodyParams params;
    params.force_map.slew_N_per_s = 500;
    params.force_map.ramp_in_s = 0.1;
    return params;
  }

  HeldSawOptions options;
  CoupledSimulation simulation;
  UndoJournal journal;
  SimulatedDevice simulated;
  GuardedDevice device;
  Hand hand;
  StepBody body;
  RestoreExchange restores;
};

struct TickOf {
  LoopTick tick;
  bool operator==(const TickOf& other) const {
    return tick.force.f_H_W_N == other.tick.force.f_H_W_N && tick.X_WH.p_AB == other.tick.X_WH.p_AB &&
           tick.coupled.f_H_W_N == other.tick.coupled.f_H_W_N &&
           tick.coupled.X_WT.p_AB == other.tick.coupled.X_WT.p_AB && tick.stands == other.tick.stands;
  }
};

LoopTick TakeTick(HapticLoop& loop) {
  const LoopTick* sample = loop.samples().Peek();
  if (sample == nullptr) return {};
  const LoopTick tick = *sample;
  loop.samples().Pop();
  return tick;
}

LoopParams QuietParams() {
  LoopParams params;
  params.lock_memory = false;
  params.priority = 0;
  return params;
}

/// Returns the bone after `ticks` ticks of the stage without undo.
Bone BoneAfter(std::int64_t ticks) {
  Stage s;
  VirtualClock clock;
  HapticLoop loop(s.body, s.device, clock, QuietParams());
  loop.RunHere(ticks);
  return s.simulation.UpdateBone();
}

TEST(UndoInTheLoop, RestoresTheCheckpointWhileCuttingAndContinues) {
  const Bone at_checkpoint = BoneAfter(500);
  Stage s(200);
  VirtualClock clock;
  HapticLoop loop(s.body, s.device, clock, QuietParams());
  BoneMirror mirror(MakeBone(), loop.leaves());
  std::vector<TickOf> ticks;
  std::size_t more = 0;
  std::size_t leaves = 0;
  std::int64_t stood = 0;
  std::optional<Bone> restored;
  const HeapUseCounter heap;
  loop.RunHere(2000, [&] {
    ticks.push_back({TakeTick(loop)});
    const bool stands = ticks.back().tick.stands;
    stood += stands ? 1 : 0;
    const bool ended = stood > 0 && !stands && s.journal.job() != nullptr;
    mirror.Update();
    const auto tick = static_cast<std::int64_t>(ticks.size());
    bool taken = true;
    if (tick == 500) taken = s.restores.RequestCheckpoint(s.journal.Name("here"));
    if (tick == 800) {
      s.journal.PrepareUndo((s.journal.Drain(), s.journal.Find("here")));
      leaves = s.journal.job()->leaves.size();
    }
    // Cutting continues for a while before the loop receives the job.
    if (tick == 950) taken = s.restores.Send(*s.journal.job());
    EXPECT_TRUE(taken);
    if (tick > 950 && ended) {
      EXPECT_EQ(s.journal.job()->state, RestoreJob::State::kDone);
      more = s.journal.job()->leaves.size() - leaves;
      EXPECT_TRUE(s.journal.Finish());
      EXPECT_FALSE(s.journal.CanRedo());  // the next tick has already cut
    }
    return true;
  });
  EXPECT_EQ(heap.count(), 0);
  EXPECT_EQ(loop.counts().not_finite, 0u);
  EXPECT_GT(more, 0u) << leaves;
  EXPECT_EQ(ticks[500].tick.in.flags, kRecordedCheckpoint);
  EXPECT_EQ(ticks[950].tick.in.flags, kRecordedUndo);
  EXPECT_EQ(ticks[950].tick.in.checkpoint, 1u);
  // The restore took exactly the ticks that its leaves need: 200 leaves per tick.
  EXPECT_EQ(stood, static_cast<std::int64_t>((leaves + more + 199) / 200));
  while (loop.SendRemaining()) mirror.Update();
  mirror.Update();
  EXPECT_EQ(CountDifferingVoxels(mirror.bone(), s.simulation.UpdateBone()), 0u);
  // Undoing the later cuts as well gives the checkpoint's bone.
  EXPECT_GT(CountDifferingVoxels(at_checkpoint, s.simulation.UpdateBone()), 100u);
  UndoTo(s.simulation, s.journal, s.journal.Find("here"));
  EXPECT_EQ(CountDifferingVoxels(at_checkpoint, s.simulation.UpdateBone()), 0u);
  UndoTo(s.simulation, s.journal, 0);
  EXPECT_EQ(CountDifferingVoxels(MakeBone(), s.simulation.UpdateBone()), 0u);
}

TEST(UndoInTheLoop, ReplayOfItsEventsGivesTheSameTicks) {
  struct Event {
    std::size_t tick;
    TickInputs in;
  };
  std::vector<Event> events;
  std::vector<TickOf> first;
  std::uint64_t hash = 0;
  const auto run = [&](auto&& between, std::vector<TickOf>& ticks) {
    Stage s(300);
    VirtualClock clock;
    HapticLoop loop(s.body, s.device, clock, QuietParams());
    loop.RunHere(2400, [&] {
      ticks.push_back({TakeTick(loop)});
      while (loop.leaves().Peek() != nullptr) loop.leaves().Pop();
      if (s.journal.job() != nullptr && s.journal.job()->state == RestoreJob::State::kDone) s.journal.Finish();
      between(s, ticks.size());
      return true;
    });
    hash = s.simulation.UpdateBone().CalcHash();
  };
  // The reader is slow: it requests several checkpoints and undos, and prepares jobs some ticks before they begin.
  run(
      [&](Stage& s, std::size_t tick) {
        if (tick % 37 == 0) s.journal.Drain();
        if (tick == 300 || tick == 700) s.restores.RequestCheckpoint(s.journal.Name(std::to_string(tick)));
        if (tick == 900) s.journal.PrepareUndo((s.journal.Drain(), s.journal.Find("700")));
        if (tick == 913) s.restores.Send(*s.journal.job());
        if (tick == 1400) s.restores.RequestCheckpoint(s.journal.Name("1400"));
        if (tick == 1800) s.journal.PrepareUndo((s.journal.Drain(), s.journal.Find("300")));
        if (tick == 1804) s.restores.Send(*s.journal.job());
      },
      first);
  const std::uint64_t first_hash = hash;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (first[i].tick.in.flags != 0) events.push_back({i, first[i].tick.in});
  }
  ASSERT_EQ(events.size(), 5u);
  std::vector<TickOf> second;
  run(
      [&](Stage& s, std::size_t tick) {
        for (const Event& e : events) {
          if (e.tick != tick) continue;
          if (e.in.flags == kRecordedCheckpoint) {
            EXPECT_EQ(s.journal.Name(""), e.in.checkpoint);
            s.restores.RequestCheckpoint(e.in.checkpoint);
          } else {
            s.restores.Send(*s.journal.PrepareUndo(e.in.checkpoint));
          }
        }
      },
      second);
  EXPECT_EQ(first_hash, hash);
  EXPECT_TRUE(first == second);
}

TEST(UndoInTheLoop, RedoIsRefusedAfterACut) {
  Stage s;
  VirtualClock clock;
  HapticLoop loop(s.body, s.device, clock, QuietParams());
  std::int64_t tick = 0;
  bool tried = false;
  loop.RunHere(1500, [&] {
    ++tick;
    while (loop.samples().Peek() != nullptr) loop.samples().Pop();
    while (loop.leaves().Peek() != nullptr) loop.leaves().Pop();
    UndoJob* job = s.journal.job();
    if (tick == 800) s.restores.Send(*s.journal.PrepareUndo(0));
    if (job != nullptr && job->state == RestoreJob::State::kDone && s.journal.Finish() && !tried) {
      tried = true;
      // The job is prepared at once, but sent when the saw is in the bone again.
      s.journal.PrepareRedo();
    }
    if (tick == 1200) s.restores.Send(*s.journal.job());
    if (tick == 1210) {
      EXPECT_EQ(s.journal.job()->state, RestoreJob::State::kChanged);
      EXPECT_STREQ(WhyRefused(s.journal.job()->state), "the bone was cut in the meantime");
      EXPECT_FALSE(s.journal.Finish());
      EXPECT_FALSE(s.journal.CanRedo());
    }
    return true;
  });
  EXPECT_TRUE(tried);
}

TEST(UndoInTheLoop, MirrorReadOnAnotherThreadMatchesTheLoopsBone) {
  Stage s;
  MonotonicClock clock;
  HapticLoop loop(s.body, s.device, clock, QuietParams());
  BoneMirror mirror(MakeBone(), loop.leaves());
  int undone = 0;
  loop.Start();
  const auto read = [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
    mirror.Update();
    while (loop.samples().Peek() != nullptr) loop.samples().Pop();
    s.journal.Drain();
  };
  const auto finish = [&] {
    while (s.journal.job()->state == RestoreJob::State::kWaiting ||
           s.journal.job()->state == RestoreJob::State::kRunning) {
      read();
    }
    return s.journal.Finish();
  };
  for (int round = 0; round < 6; ++round) {
    s.restores.RequestCheckpoint(s.journal.Name(std::to_string(round)));
    for (int i = 0; i < 40; ++i) read();
    // The saw keeps cutting while an undo is prepared, so the undo may be refused, more often on a busy machine; it is
    // then repeated.
    bool done = false;
    for (int tries = 0; !done && tries < 100; ++tries) {
      const auto kept = s.journal.checkpoints();
      s.journal.PrepareUndo(kept[static_cast<std::size_t>(round) % kept.size()].number);
      s.restores.Send(*s.journal.job());
      done = finish();
    }
    if (done) ++undone;
    try {
      s.restores.Send(*s.journal.PrepareRedo());
      finish();
    } catch (const Error&) {  // the bone was cut in the meantime
    }
  }
  loop.Stop();
  EXPECT_EQ(loop.end(), LoopEnd::kRequested);
  EXPECT_EQ(undone, 6);
  EXPECT_EQ(loop.counts().not_finite, 0u);
  while (loop.SendRemaining()) mirror.Update();
  mirror.Update();
  EXPECT_EQ(CountDifferingVoxels(mirror.bone(), s.simulation.UpdateBone()), 0u);
  UndoTo(s.simulation, s.journal, 0);
  EXPECT_EQ(CountDifferingVoxels(MakeBone(), s.simulation.UpdateBone()), 0u);
}

}  // namespace
}  // namespace kerf
