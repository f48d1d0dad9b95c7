#include "experiment/bench/undo_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "bone/material/region_table.h"
#include "bone/models/mandible.h"
#include "cut/hand_sim/internals.h"
#include "cut/undo/journal.h"
#include "experiment/bench/cut_cases.h"
#include "experiment/bench/measure.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kCuts = 20;
constexpr double kApart_mm = 1.4;
constexpr double kUndoTick_s = 0.001;
constexpr int kTicksPerRead = 16;  // ticks between two reads of the journal

/// Returns the k-th cut through the mandible; the cuts lie side by side in its body.
CutCase MakeCut(int k) {
  CutCase cut = MakeMandibleCut(true);
  cut.X_BT_start.p_AB.y += kApart_mm * (k - 0.5 * (kCuts - 1));
  return cut;
}
int CountTicks(const CutCase& cut) {
  return static_cast<int>(std::lround((cut.warm_up_mm + cut.measured_mm) / cut.feed_mm_per_s / kUndoTick_s));
}
CoupledInput Handle(const CutCase& cut, int tick) {
  CoupledInput in;
  const Vec3 p_B = cut.X_BT_start.p_AB + cut.feed_mm_per_s * kUndoTick_s * tick * cut.direction_B;
  in.X_WH = {cut.X_WB.R_AB * cut.X_BT_start.R_AB, cut.X_WB.Point(p_B)};
  in.v_H_W_mm_per_s = cut.X_WB.Vector(cut.feed_mm_per_s * cut.direction_B);
  in.dt_s = kUndoTick_s;
  in.rpm = cut.rpm;
  return in;
}

CoupledParams MakeParams(const CutCase& cut) {
  CoupledParams params;
  params.tool = cut.tool;
  params.coupling.stiffness_N_per_mm = 1000;
  params.coupling.torsion_Nmm_per_rad = 1e7;
  params.coupling.max_force_N = 1e4;
  params.coupling.max_torque_Nmm = 1e6;
  params.spare_leaves = 60'000;
  return params;
}

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[(values.size() - 1) / 2];
}
double Largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

/// Times of undo or of redo: one entry per repetition, and in `tick_us` one per tick.
struct UndoSamples {
  std::vector<double> prepare_ms, tick_us, all_ms;
  int ticks = 0;

  UndoTimes Summarize() const {
    return {Median(prepare_ms), Largest(prepare_ms), Median(tick_us), Largest(tick_us), ticks,
            Median(all_ms),     Largest(all_ms)};
  }
};

/// Runs an undo or a redo as the loop does, but without waiting for the next tick.
void Go(CoupledSimulation& simulation, UndoJournal& journal, bool redo, std::size_t leaves_per_tick,
        UndoSamples& samples) {
  const double start_ms = ReadClock_ms();
  UndoJob* job = redo ? journal.PrepareRedo() : journal.PrepareUndo(0);
  samples.prepare_ms.push_back(ReadClock_ms() - start_ms);
  double all_ms = samples.prepare_ms.back();
  Restore restore;
  samples.ticks = 0;
  for (bool done = false; !done;) {
    const double tick_ms = ReadClock_ms();
    if (samples.ticks == 0 && !restore.Begin(simulation, *job)) {
      throw Error(fmt::format("the benchmark could not undo: {}", WhyRefused(job->state)));
    }
    done = restore.Step(simulation, leaves_per_tick);
    if (done) restore.End(simulation, nullptr);
    const double took_ms = ReadClock_ms() - tick_ms;
    samples.tick_us.push_back(1e3 * took_ms);
    all_ms += std::max(1e3 * kUndoTick_s, took_ms);
    ++samples.ticks;
  }
  samples.all_ms.push_back(all_ms);
  journal.Finish();
  simulation.ClearChanged();
}

UndoResult Measure(CoupledSimulation& simulation, UndoJournal& journal, int cuts, const UndoBenchOptions& options) {
  UndoResult result;
  result.cuts = cuts;
  journal.Drain();
  for (const UndoCheckpoint& c : journal.checkpoints()) result.leaves += c.leaves;
  result.kept_MB = 1e-6 * static_cast<double>(journal.CalcMemoryBytes());
  result.raw_MB = 1e-6 * static_cast<double>(journal.CountLeaves() * LeafPack::kLeafBytes);
  result.cut = simulation.UpdateBone().CalcHash();
  UndoSamples undo, redo;
  for (int round = 0; round < options.rounds; ++round) {
    if (options.progress) options.progress(fmt::format("undo of {} cuts", cuts), 1.0 * round / options.rounds);
    Go(simulation, journal, false, options.leaves_per_tick, undo);
    if (round == 0) result.undone = simulation.UpdateBone().CalcHash();
    Go(simulation, journal, true, options.leaves_per_tick, redo);
    if (round == 0) result.redone = simulation.UpdateBone().CalcHash();
  }
  result.undo = undo.Summarize();
  result.redo = redo.Summarize();
  return result;
}

}  // namespace

UndoReport RunUndoBench(const UndoBenchOptions& options) {
  CheckParameters(options);
  UndoReport report;
  report.options = options;
  report.run = ReadRunInfo(options.core, options.realtime);
  if (options.progress) options.progress("bone", 0);
  MandibleParams mandible;
  mandible.voxel_mm = options.voxel_mm;
  const Bone bone = MakeMandible(mandible, DefaultMandibleTable());
  const std::uint64_t hash = bone.CalcHash();
  const CutCase first = MakeCut(0);
  CoupledSimulation simulation(bone, MakeParams(first), Handle(first, 0).X_WH);
  CoupledSimulation without(bone, MakeParams(first), Handle(first, 0).X_WH);
  UndoJournal journal(KeepHistory(simulation));
  report.history_MB = 1e-6 * static_cast<double>(HistoryOf(simulation)->CalcMemoryBytes());
  const PinnedToCore pinned(options.core, options.realtime);
  std::vector<double> with_us, without_us;
  for (int k = 0; k < kCuts; ++k) {
    const CutCase cut = MakeCut(k * 7 % kCuts);  // successive cuts are not neighbours
    if (options.progress) options.progress(fmt::format("cut {}", k + 1), 1.0 * k / kCuts);
    if (k > 0) MakeCheckpoint(simulation, journal, fmt::format("cut {}", k));
    for (CoupledSimulation* s : {&simulation, &without}) {
      s->SetDown(Handle(cut, 0).X_WH);
      s->Refill();
    }
    for (int tick = 1; tick <= CountTicks(cut); ++tick) {
      const CoupledInput in = Handle(cut, tick);
      // The order alternates, so that each simulation goes first equally often.
      for (const bool one : {tick % 2 == 0, tick % 2 != 0}) {
        const std::int64_t start_ns = ReadClock_ns();
        const CoupledOutput out = (one ? simulation : without).Tick(in);
        const double us = 1e-3 * static_cast<double>(ReadClock_ns() - start_ns);
        (one ? simulation : without).ClearChanged();
        if (out.engaged_teeth > 0) (one ? with_us : without_us).push_back(us);
      }
      if (tick % kTicksPerRead == 0) journal.Drain();
    }
    if (k + 1 == 1 || k + 1 == 5 || k + 1 == kCuts) {
      UndoResult result = Measure(simulation, journal, k + 1, options);
      result.before = hash;
      if (result.undone != hash || result.redone != result.cut || result.cut != without.UpdateBone().CalcHash()) {
        throw Error(fmt::format("undo of {} cuts did not restore the same bone", k + 1));
      }
      report.results.push_back(result);
    }
  }
  report.with_history = CalcPercentiles(with_us);
  report.without = CalcPercentiles(without_us);
  return report;
}

}  // namespace kerf
