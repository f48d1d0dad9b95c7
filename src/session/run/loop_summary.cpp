#include "session/run/loop_summary.h"

#include <string>
#include <utility>
#include <vector>

#include "kerf/surface.h"
#include "session/run/run_warnings.h"

namespace kerf {
namespace {

PartTimes Summarize(const std::string& name, const LogHistogram& times) {
  return {CalcPercentiles(times), name, times.CalcMean_us()};
}

/// Returns a histogram with eight bars per octave, from the first bar to the last one that is not empty.
std::vector<LoopBar> MakeBars(const LogHistogram& times) {
  constexpr std::size_t kBuckets = 4;
  std::vector<LoopBar> bars;
  for (std::size_t i = 0; i + kBuckets <= LogHistogram::kBuckets; i += kBuckets) {
    LoopBar bar;
    bar.lower_us = LogHistogram::LowerEdge_us(i);
    bar.upper_us = LogHistogram::UpperEdge_us(i + kBuckets - 1) + 0.001;
    for (std::size_t k = i; k < i + kBuckets; ++k) bar.count += times.count(k);
    if (bar.count > 0 || !bars.empty()) bars.push_back(bar);
  }
  while (!bars.empty() && bars.back().count == 0) bars.pop_back();
  return bars;
}

}  // namespace

void SummarizeLoop(const HapticLoop& loop, LoopSummary& s) {
  s.end = loop.end();
  s.failure = loop.failure();
  s.grants = loop.grants();
  s.counts = loop.counts();
  s.watchdog_trips = loop.watchdog_trips();
  s.tick = Summarize("tick", loop.tick_times());
  s.lateness = Summarize("lateness", loop.lateness());
  for (std::size_t i = 0; i < kTickStages; ++i) {
    const auto stage = static_cast<TickStage>(i);
    if (loop.stage_times(stage).total() > 0) s.stages.push_back(Summarize(ToString(stage), loop.stage_times(stage)));
  }
  s.stages.push_back(Summarize("exchange", loop.exchange_times()));
  s.tick_bars = MakeBars(loop.tick_times());
  s.lateness_bars = MakeBars(loop.lateness());
  s.fidelity_steps.assign(loop.governor().steps().begin(), loop.governor().steps().end());
  s.fidelity_step_count = loop.governor().step_count();
}

void SummarizeBone(Bone bone, const Scene& scene, bool keep, LoopSummary& s) {
  Pieces split = SplitPieces(bone, scene.output.smallest_piece_mm3, s.before.empty() ? nullptr : &s.before);
  s.piece_counts = split;
  for (const std::string& warning : FindPieceWarnings(scene, split, bone.voxel_mm())) s.warnings.push_back(warning);
  const std::span<const PieceOut> out = s.fragments ? s.fragments->out : std::span<const PieceOut>{};
  s.piece_volumes_mm3 = CalcVolumes(split.pieces);
  for (const ResultPiece& piece : ListPieces(split.pieces, s.piece_volumes_mm3, out)) {
    s.pieces.push_back(Summarize(piece));
  }
  s.volume_after_mm3 = bone.CalcVolume();
  if (!keep) return;
  s.after = std::move(bone);
  s.after.set_note("cut_by_scene", scene.name);
  s.piece_bones = std::move(split.pieces);
  s.dust = std::move(split.dust);
}

}  // namespace kerf
