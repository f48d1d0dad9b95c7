// Back to any checkpoint and forward again, bit for bit, in bounded memory.
#include "cut/undo/journal.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <map>
#include <numeric>
#include <optional>

#include "bone/grid/piece_finder.h"
#include "bone/grid/piece_removal.h"
#include "cut/hand_sim/internals.h"
#include "cut/hand_sim/take_out.h"
#include "cut/undo/same_bone.h"
#include "kerf/error.h"
#include "support/message_of.h"
#include "support/seeded_check.h"

namespace kerf {
namespace {

using test::BarParams;
using test::CountDifferingVoxels;
using test::MakeBar;
using test::OverBar;
using test::Plunge;

const Pose kAway = OverBar(0, 0, 60);

struct Session {
  explicit Session(const UndoParams& params = {}, const CoupledParams& coupled = BarParams(), int ring = 8192)
      : simulation(MakeBar(), coupled, kAway), journal(KeepHistory(simulation, ring), params) {}

  double Removed() {
    const auto mm3 = simulation.CalcRemovedByRegion();
    return std::accumulate(mm3.begin(), mm3.end(), 0.0);
  }
  std::uint32_t Checkpoint(const std::string& name) {
    MakeCheckpoint(simulation, journal, name);
    return journal.Find(name);
  }

  CoupledSimulation simulation;
  UndoJournal journal;
};

/// Returns the message with which a call is refused, or "" if it is not.
template <typename Call>
std::string Refusal(Call&& call) {
  return test::MessageOf([&] { call(); });
}

/// Exchanges pure bone and air in the leaves whose x is at least `first` and below `end`, one leaf after another.
void Empty(Session& s, int first, int end) {
  std::array<float, 512> bone, air;
  bone.fill(static_cast<float>(-3 * test::kBarVoxel_mm));
  air.fill(static_cast<float>(3 * test::kBarVoxel_mm));
  for (int x = first; x < end; ++x) {
    for (int i = 0; i < 9; ++i) {
      SupplyLeaves(s.simulation);
      ASSERT_TRUE(s.simulation.Replace({x, i / 3 - 1, i % 3 - 1}, bone.data(), air.data()));
      s.journal.Drain();
      s.simulation.ClearChanged();
    }
  }
}

TEST(UndoJournal, UndoThatWasRefusedForLackOfLeavesSucceedsOnceTheyAreSupplied) {
  CoupledParams params = BarParams();
  params.spare_leaves = 2;
  Session s({}, params);
  const Bone before = s.simulation.UpdateBone();
  const double volume_mm3 = before.CalcVolume();
  Empty(s, -3, 0);
  s.simulation.UpdateBone();  // gives the emptied leaves back
  Empty(s, 0, 3);
  EXPECT_NEAR(s.Removed(), volume_mm3 - s.simulation.UpdateBone().CalcVolume(), 1e-9 * volume_mm3);
  for (int used = 0; CoupledInternals::Work(s.simulation).spare_leaves > 2; ++used) {
    ASSERT_LT(used, 3 * 9);
    Empty(s, 3, 4);
  }
  UndoJob* job = s.journal.PrepareUndo(0);
  ASSERT_FALSE(Restore().Begin(s.simulation, *job));
  EXPECT_EQ(job->state.load(), RestoreJob::State::kNoLeaves);
  const auto leaves = static_cast<int>(job->leaves.size());
  EXPECT_FALSE(s.journal.Finish());
  SupplyLeaves(s.simulation, 2 * leaves);
  UndoTo(s.simulation, s.journal, 0, &kAway);
  EXPECT_EQ(CountDifferingVoxels(before, s.simulation.UpdateBone()), 0u);
  EXPECT_NEAR(s.Removed(), 0, 1e-9 * volume_mm3);
}

TEST(UndoJournal, RoomForOldValuesIsThatOfTheLeavesThatWereCut) {
  Session s;
  Empty(s, -3, 3);
  s.simulation.UpdateBone();
  s.Removed();
  UndoTo(s.simulation, s.journal, 0, &kAway);
  s.simulation.UpdateBone();
  s.Removed();
  const std::size_t bytes = s.simulation.CalcMemoryBytes();
  for (int n = 0; n < 10; ++n) {
    Redo(s.simulation, s.journal, &kAway);
    s.simulation.UpdateBone();
    s.Removed();
    UndoTo(s.simulation, s.journal, 0, &kAway);
    s.simulation.UpdateBone();
    s.Removed();
  }
  // Emptied leaves come back as spare ones; those beyond the initial ones are counted here.
  EXPECT_LE(s.simulation.CalcMemoryBytes(), bytes + 54 * 2200);
}

TEST(UndoJournal, CheckpointCutRestoreIsBitIdentical) {
  Session s;
  Plunge(1).Run(s.simulation);
  const std::uint32_t saved = s.Checkpoint("saved");
  const Bone before = s.simulation.UpdateBone();
  const double removed_mm3 = s.Removed();
  Plunge(2).Run(s.simulation);
  Plunge(3).Run(s.simulation);
  const Bone after = s.simulation.UpdateBone();
  const double after_mm3 = s.Removed();
  ASSERT_GT(CountDifferingVoxels(before, after), 1000u);
  UndoTo(s.simulation, s.journal, saved, &kAway);
  EXPECT_EQ(CountDifferingVoxels(before, s.simulation.UpdateBone()), 0u);
  EXPECT_EQ(s.simulation.UpdateBone().CalcHash(), before.CalcHash());
  // Equal except for rounding, 1e-9 of the bone.
  EXPECT_NEAR(s.Removed(), removed_mm3, 1e-9 * before.CalcVolume());
  Redo(s.simulation, s.journal, &kAway);
  EXPECT_EQ(CountDifferingVoxels(after, s.simulation.UpdateBone()), 0u);
  EXPECT_NEAR(s.Removed(), after_mm3, 1e-9 * before.CalcVolume());
  UndoTo(s.simulation, s.journal, s.journal.Find("start"), &kAway);
  EXPECT_EQ(CountDifferingVoxels(MakeBar(), s.simulation.UpdateBone()), 0u);
  EXPECT_NEAR(s.Removed(), 0, 1e-9 * before.CalcVolume());
}

TEST(UndoJournal, AnySequenceOfCutsCheckpointsUndoAndRedoMatchesDeepCopies) {
  EXPECT_TRUE(test::CheckSeeded(20261121, 30, [](std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Session s;
    struct Copy {
      std::uint32_t number;
      Bone bone;
      std::optional<double> removed_mm3;  // reading it settles the account, which must not affect the restored bone
    };
    std::vector<Copy> kept{{0, s.simulation.UpdateBone(), 0}};
    struct Redone {
      std::vector<Copy> kept;
      Bone bone;
      std::optional<double> removed_mm3;
    };
    std::vector<Redone> redo;
    const auto removed = [&] { return random() % 3 == 0 ? std::optional(s.Removed()) : std::nullopt; };
    const auto same = [&](const Bone& bone, const std::optional<double>& removed_mm3) {
      RC_ASSERT(CountDifferingVoxels(bone, s.simulation.UpdateBone()) == 0u);
      if (removed_mm3 && random() % 2 == 0) RC_ASSERT(std::abs(s.Removed() - *removed_mm3) < 1e-9 * 600);
    };
    for (int step = 0; step < 14; ++step) {
      const std::uint64_t pick = random() >> 8;
      switch (random() % 8) {
        case 0:
        case 1:
        case 2: {
          const std::size_t pushed = HistoryOf(s.simulation)->pushed();
          Plunge(pick).Run(s.simulation);
          if (HistoryOf(s.simulation)->pushed() != pushed) redo.clear();
          if (pick % 2 == 0) s.journal.Drain();
          break;
        }
        case 3:
        case 4: {
          const std::uint32_t number = s.Checkpoint(std::to_string(pick));
          kept.push_back({number, s.simulation.UpdateBone(), removed()});
          redo.clear();
          break;
        }
        case 5:
        case 6: {
          const std::size_t to = pick % kept.size();
          Redone back{kept, s.simulation.UpdateBone(), removed()};
          UndoTo(s.simulation, s.journal, kept[to].number, &kAway);
          kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(to) + 1, kept.end());
          redo.push_back(std::move(back));
          same(kept[to].bone, kept[to].removed_mm3);
          break;
        }
        case 7:
          s.journal.Drain();
          RC_ASSERT(s.journal.CanRedo() == !redo.empty());
          if (redo.empty()) {
            RC_ASSERT(Refusal([&] { Redo(s.simulation, s.journal); }) ==
                      "there is nothing to redo: nothing was undone, or bone was cut since");
            break;
          }
          Redo(s.simulation, s.journal, &kAway);
          same(redo.back().bone, redo.back().removed_mm3);
          kept = redo.back().kept;
          redo.pop_back();
          break;
      }
    }
    // Finally, back to the start.
    UndoTo(s.simulation, s.journal, 0, &kAway);
    RC_ASSERT(CountDifferingVoxels(kept[0].bone, s.simulation.UpdateBone()) == 0u);
  }));
}

TEST(UndoJournal, CutAfterUndoMatchesAFreshSimulationOfTheBone) {
  for (const int interval : {1, 8}) {
    CoupledParams params = BarParams();
    params.carve_interval_ticks = interval;
    Session s({}, params);
    Plunge(1).Run(s.simulation);
    const std::uint32_t saved = s.Checkpoint("saved");
    const Bone bone = s.simulation.UpdateBone();
    Plunge(1).Run(s.simulation);
    for (const std::uint64_t seed : {4, 5, 6}) Plunge(seed).Run(s.simulation);
    UndoTo(s.simulation, s.journal, saved);
    CoupledSimulation fresh(bone, params, kAway);
    for (const std::uint64_t seed : {7, 1, 8}) {
      std::vector<CoupledOutput> outs;
      Plunge(seed).Run(s.simulation, [&](const CoupledOutput& out) { outs.push_back(out); });
      std::size_t i = 0;
      Plunge(seed).Run(fresh, [&](const CoupledOutput& out) {
        ASSERT_EQ(out.f_H_W_N, outs[i].f_H_W_N) << seed << " " << i;
        ASSERT_EQ(out.X_WT.p_AB, outs[i].X_WT.p_AB) << seed << " " << i;
        ASSERT_EQ(out.removed_mm3, outs[i].removed_mm3) << seed << " " << i;
        ++i;
      });
    }
    EXPECT_EQ(CountDifferingVoxels(fresh.UpdateBone(), s.simulation.UpdateBone()), 0u);
  }
}

TEST(UndoJournal, CompletelyRemovedBoneIsRestored) {
  CoupledParams params = BarParams();
  params.tool = BallBurr{.diameter_mm = 6};
  params.coupling.max_force_N = 1000;
  Session s({}, params);
  // The saw moves back and forth until leaves are empty; settling turns those into air.
  s.simulation.SetDown(OverBar(-6, 0, 7));
  for (int i = 1; i <= 3000; ++i) {
    s.simulation.Tick({.X_WH = OverBar(-6 + 12 * std::abs(std::sin(0.004 * i)), 0, 7 - 0.0018 * i), .rpm = 30000});
    s.journal.Drain();
  }
  const Bone cut = s.simulation.UpdateBone();
  const Bone whole = MakeBar();
  std::size_t gone = 0;
  for (auto leaf = GridsOf(whole).phi->tree().cbeginLeaf(); leaf; ++leaf) {
    gone += GridsOf(cut).phi->tree().probeConstLeaf(leaf->origin()) == nullptr ? 1 : 0;
  }
  ASSERT_GT(gone, 0u);
  UndoTo(s.simulation, s.journal, 0);
  EXPECT_EQ(CountDifferingVoxels(MakeBar(), s.simulation.UpdateBone()), 0u);
  EXPECT_NEAR(s.Removed(), 0, 1e-9 * MakeBar().CalcVolume());
  // Restored bone is felt again.
  double max_N = 0;
  Plunge(3).Run(s.simulation, [&](const CoupledOutput& out) { max_N = std::max(max_N, glm::length(out.f_cut_W_N)); });
  EXPECT_GT(max_N, 0.05);
  UndoTo(s.simulation, s.journal, 0);
  Plunge(3).Run(s.simulation);
  CoupledSimulation fresh(MakeBar(), params, kAway);
  Plunge(3).Run(fresh);
  EXPECT_EQ(CountDifferingVoxels(fresh.UpdateBone(), s.simulation.UpdateBone()), 0u);
}

TEST(UndoJournal, StaysWithinItsMemoryOverThousandsOfCheckpoints) {
  Session s({.max_MB = 0.2, .max_changed_leaves = 16});
  std::size_t largest = 0;
  for (int round = 0; round < 3000; ++round) {
    s.Checkpoint("checkpoint " + std::to_string(round));
    if (round % 3 == 0) Plunge(static_cast<std::uint64_t>(round)).Run(s.simulation);
    s.journal.Drain();
    ASSERT_LE(s.journal.CalcMemoryBytes(), 200'000u);
    largest = std::max(largest, s.journal.CalcMemoryBytes());
    // From time to time everything is undone, so that there is bone to cut.
    if (round % 250 == 249) UndoTo(s.simulation, s.journal, s.journal.checkpoints().front().number);
    ASSERT_LE(s.journal.CalcMemoryBytes(), 200'000u);
  }
  EXPECT_GT(largest, 190'000u);
  EXPECT_GT(s.journal.checkpoints().front().number, 1000u);
}

TEST(UndoJournal, DroppedCheckpointsAreRefusedWithAReason) {
  Session s({.max_MB = 0.2, .max_changed_leaves = 16});
  std::map<std::uint32_t, Bone> bones;
  for (std::uint64_t k = 1; k <= 60; ++k) {
    Plunge(100 + k).Run(s.simulation);
    const std::uint32_t number = s.Checkpoint("cut " + std::to_string(k));
    if (k > 30) bones.emplace(number, s.simulation.UpdateBone());
  }
  const std::vector<UndoCheckpoint> kept = s.journal.checkpoints();
  ASSERT_GT(kept.front().number, 0u);
  EXPECT_EQ(Refusal([&] { s.journal.PrepareUndo(0); }),
            "that checkpoint is no longer kept: undo can go back to '" + kept.front().name + "' at the earliest");
  EXPECT_EQ(Refusal([&] { s.journal.Find("nowhere"); }),
            "there is no checkpoint 'nowhere' to go back to; the earliest is '" + kept.front().name + "'");
  for (auto c = kept.rbegin(); c != kept.rend(); ++c) {
    UndoTo(s.simulation, s.journal, c->number);
    if (!bones.contains(c->number)) continue;
    EXPECT_EQ(CountDifferingVoxels(bones.at(c->number), s.simulation.UpdateBone()), 0u);
  }
}

TEST(UndoJournal, NeverGivesWrongBitsWhenTheHistoryOverflows) {
  Session s({}, BarParams(), 16);
  Plunge(5).Run(s.simulation);
  Plunge(1).Run(s.simulation);  // changes more leaves than the ring holds
  EXPECT_NE(HistoryOf(s.simulation)->last_lost(), 0u);
  EXPECT_EQ(Refusal([&] { s.journal.PrepareUndo(0); }),
            "more has been cut since the last checkpoint than undo can keep; undo is possible again from the next "
            "checkpoint on");
  EXPECT_EQ(s.journal.job(), nullptr);
  const std::uint32_t later = s.Checkpoint("later");
  const Bone bone = s.simulation.UpdateBone();
  // The ring is drained in small amounts.
  Plunge(2).Run(s.simulation, [&](const CoupledOutput&) { s.journal.Drain(); });
  UndoTo(s.simulation, s.journal, later);
  EXPECT_EQ(CountDifferingVoxels(bone, s.simulation.UpdateBone()), 0u);
  EXPECT_EQ(Refusal([&] { s.journal.PrepareUndo(0); }),
            "that checkpoint is no longer kept: undo can go back to 'later' at the earliest");
  // A job that was prepared before data were lost is refused.
  Plunge(3).Run(s.simulation, [&](const CoupledOutput&) { s.journal.Drain(); });
  UndoJob* job = s.journal.PrepareUndo(later);
  const std::uint64_t hash = s.simulation.UpdateBone().CalcHash();
  for (std::uint64_t k = 4; k < 14; ++k) Plunge(k).Run(s.simulation);
  const std::uint64_t cut_hash = s.simulation.UpdateBone().CalcHash();
  ASSERT_NE(cut_hash, hash);
  EXPECT_FALSE(RunRestore(s.simulation, *job));
  EXPECT_TRUE(job->state == RestoreJob::State::kLost || job->state == RestoreJob::State::kChanged);
  EXPECT_FALSE(s.journal.Finish());
  EXPECT_EQ(s.simulation.UpdateBone().CalcHash(), cut_hash);
}

TEST(UndoJournal, TakenOutPieceIsRestoredAndCountedAsBefore) {
  Session s;
  // The saw cuts through the bar: the disc is 8 mm wide, and the bar is 6 mm thick.
  s.simulation.SetDown(OverBar(2, 0, 9));
  for (int i = 1; i <= 1500; ++i) {
    s.simulation.Tick({.X_WH = OverBar(2, 0, 9 - 0.0065 * i)});
    s.journal.Drain();
  }
  for (double y_mm : {-2.0, 2.0}) {
    Pose X = OverBar(2, 0, 9);
    X.p_AB.y = y_mm;
    s.simulation.SetDown(X);
    for (int i = 1; i <= 1500; ++i) {
      X.p_AB.z = 9 - 0.0065 * i;
      s.simulation.Tick({.X_WH = X});
      s.journal.Drain();
    }
  }
  s.simulation.SetDown(kAway);
  s.simulation.Tick({.X_WH = kAway});
  const std::uint32_t whole = s.Checkpoint("both pieces");
  const Bone before = s.simulation.UpdateBone();
  const double removed_mm3 = s.Removed();
  const PieceFinder finder(before, 0.5);
  ASSERT_EQ(finder.found().pieces.size(), 2u);
  const PieceRemoval removal = MakePieceRemoval(before, finder, finder.found().pieces[1].id);
  TakeOut out(removal);
  out.Leave();
  while (!out.Step(s.simulation)) s.journal.Drain();
  EXPECT_NEAR(s.Removed(), removed_mm3, 1e-9 * before.CalcVolume());
  const double rest_mm3 = s.simulation.UpdateBone().CalcVolume();
  ASSERT_LT(rest_mm3, 0.8 * before.CalcVolume());
  UndoTo(s.simulation, s.journal, whole);
  EXPECT_EQ(CountDifferingVoxels(before, s.simulation.UpdateBone()), 0u);
  EXPECT_NEAR(s.Removed(), removed_mm3, 1e-9 * before.CalcVolume());
  Redo(s.simulation, s.journal);
  EXPECT_NEAR(s.simulation.UpdateBone().CalcVolume(), rest_mm3, 1e-9 * rest_mm3);
  EXPECT_NEAR(s.Removed(), removed_mm3, 1e-9 * before.CalcVolume());
}

TEST(UndoJournal, RefusesInvalidRequests) {
  Session s;
  EXPECT_EQ(Refusal([&] { s.journal.FindOneBack(); }), "there is nothing to undo");
  EXPECT_EQ(Refusal([&] { s.journal.PrepareUndo(7); }), "there is no checkpoint 7 to go back to");
  EXPECT_EQ(Refusal([&] { s.journal.PrepareRedo(); }),
            "there is nothing to redo: nothing was undone, or bone was cut since");
  s.journal.PrepareUndo(0);
  EXPECT_EQ(Refusal([&] { s.journal.PrepareUndo(0); }), "an undo or redo is already in progress");
  EXPECT_FALSE(s.journal.Finish());  // the job was never sent
  EXPECT_NE(Refusal([&] { UndoJournal(*HistoryOf(s.simulation), {.max_MB = 0.1}); }).find("valid range 0.2 to"),
            std::string::npos);
  CoupledSimulation forgetful(MakeBar(), BarParams(), kAway);
  EXPECT_EQ(HistoryOf(forgetful), nullptr);
  EXPECT_FALSE(MakeCheckpoint(forgetful, 1));
}

TEST(UndoJournal, OneBackIsTheLastCutAndThenThePreviousOne) {
  Session s;
  Plunge(1).Run(s.simulation);
  const std::uint32_t a = s.Checkpoint("a");
  Plunge(2).Run(s.simulation);
  const std::uint32_t b = s.Checkpoint("b");
  EXPECT_EQ(s.journal.FindOneBack(), a);
  Plunge(9).Run(s.simulation);
  s.journal.Drain();
  EXPECT_EQ(s.journal.FindOneBack(), b);
  UndoTo(s.simulation, s.journal, b);
  EXPECT_EQ(s.journal.FindOneBack(), a);
  UndoTo(s.simulation, s.journal, a);
  EXPECT_EQ(s.journal.FindOneBack(), 0u);
  Redo(s.simulation, s.journal);
  Redo(s.simulation, s.journal);
  EXPECT_EQ(s.journal.FindOneBack(), b);
  EXPECT_EQ(s.journal.checkpoints().size(), 3u);
  EXPECT_EQ(s.journal.Find("b"), b);
}

TEST(UndoJournal, PieceFinderFollowsRestoredBone) {
  Session s;
  PieceFinder finder(MakeBar(), 0.5);
  const auto find_pieces = [&] {
    for (int i = 0; i < s.simulation.changed_count(); ++i) {
      const ChangedLeaf leaf = s.simulation.changed(i);
      finder.Change(leaf.index, std::span<const float, 512>(leaf.values, 512));
    }
    s.simulation.ClearChanged();
    return finder.Find();
  };
  for (double y_mm : {-2.0, 2.0}) {
    Pose X = OverBar(2, 0, 9);
    X.p_AB.y = y_mm;
    s.simulation.SetDown(X);
    for (int i = 1; i <= 1500; ++i) {
      X.p_AB.z = 9 - 0.0065 * i;
      s.simulation.Tick({.X_WH = X});
      s.journal.Drain();
    }
  }
  ASSERT_EQ(find_pieces().pieces.size(), 2u);
  EXPECT_EQ(finder.found().came_off.size(), 1u);
  UndoTo(s.simulation, s.journal, 0);
  EXPECT_EQ(find_pieces().pieces.size(), 1u);
  EXPECT_EQ(finder.found().pieces[0].id, 1);
  EXPECT_TRUE(finder.found().came_off.empty());
  EXPECT_EQ(finder.found().pieces[0].voxels, PieceFinder(MakeBar(), 0.5).found().pieces[0].voxels);
  Redo(s.simulation, s.journal);
  ASSERT_EQ(find_pieces().pieces.size(), 2u);
  EXPECT_EQ(finder.found().pieces[0].id, 1);
  EXPECT_EQ(finder.found().pieces[1].id, 3);  // numbers are permanent
  EXPECT_EQ(finder.found().came_off.size(), 1u);
}

}  // namespace
}  // namespace kerf
