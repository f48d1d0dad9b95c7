#include "session/run/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "base/files/files.h"
#include "base/files/memory.h"
#include "bone/grid/changed_hash.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kTicksBetweenRefills = 1024;
constexpr std::size_t kLogBlockBytes = std::size_t{1} << 18;
/// Memory per tick: its record, its duration, and the effects' channels, sound and spectral lines.
constexpr double kBytesPerTick = sizeof(TickRecord) + sizeof(double) + 200;
constexpr std::chrono::milliseconds kBetweenLines(250);

/// Sets components that are only rounding errors of a rotation to zero.
Vec3 RoundTinyToZero(Vec3 v) {
  for (int axis = 0; axis < 3; ++axis) v[axis] = std::abs(v[axis]) < 1e-12 ? 0 : v[axis];
  return v;
}

}  // namespace

void CheckRunTicks(const Path& path, double rate_hz) {
  const auto ticks = static_cast<double>(path.CountTicks(rate_hz));
  const double bytes = kBytesPerTick * ticks;
  if (ticks > kMaxRunTicks) {
    throw Error(fmt::format(
        "{:.0f} ticks ({:.0f} s at {:g} Hz) would need {:.1f} GB of memory; a run has at most {:.0f} ticks: "
        "lower [simulation] rate_hz or make several runs of it",
        ticks, path.duration_s(), rate_hz, bytes / 1e9, kMaxRunTicks));
  }
  CheckMemory(bytes, fmt::format("a run of {:.0f} ticks", ticks),
              "lower [simulation] rate_hz or make several runs of it");
}

namespace {

/// Voxels that are cut along a path, with the effects' records, the pieces and the costs.
class VoxelPathBody final : public PathBody {
 public:
  VoxelPathBody(Bone bone, const SimulationParams& params, const Pose& X_WT_start, double rate_hz, std::size_t ticks,
                const CostOptions& costs)
      : simulation_(std::move(bone), params, X_WT_start),
        effects_(EffectsOf(std::as_const(simulation_))),
        record_(effects_),
        files_(effects_, ticks, true),
        channels_(effects_.channel_count()),
        fragments_(EffectsOf(simulation_)),
        live_(costs.live) {
    record_.rows.reserve(ticks * channels_.size());
    if (costs.costs) meter_.emplace(1e6 / rate_hz).Watch(EffectsOf(simulation_));
    if (fragments_.is_on()) {
      const double interval = std::round(fragments_.every_s() * rate_hz);
      ticks_between_searches_ = std::max<std::size_t>(1, static_cast<std::size_t>(interval));
    }
  }

  void SetDown(const Pose& X_WT, double time_s) override {
    if (ticks_ > 0 && fragments_.takes_out()) {
      Search(time_s);
      TakeOut(time_s, true);
    }
    simulation_.SetDown(X_WT);
  }
  TickOutput Tick(const TickInput& in) override { return simulation_.Tick(in, meter_ ? &meter_->observer() : nullptr); }
  std::uint64_t TakeHash() override {
    if (!hash_) hash_.emplace();
    for (int i = 0; i < simulation_.changed_count(); ++i) hash_->Take(simulation_.changed(i));
    if (!fragments_.is_on()) simulation_.ClearChanged();
    return hash_->value();
  }
  void End(TickRecord& record, double dt_s, double tick_us) override {
    ++ticks_;
    if (meter_) meter_->Finish(tick_us);
    if (ticks_between_searches_ > 0 && ticks_ % ticks_between_searches_ == 0) {
      Search(record.time_s);
      TakeOut(record.time_s, false);
    }
    if (!channels_.empty()) {
      effects_.Report(channels_);
      record_.TakeRow(channels_);
      files_.Take(record.time_s, dt_s, record.X_WT, channels_);
    }
    if (ticks_ % kTicksBetweenRefills == 0) simulation_.Refill();
    if (meter_ && live_ && ticks_ % 64 == 0 && Clock::now() - line_at_ > kBetweenLines) {
      live_(FormatCostLine(meter_->Make(effects_)));
      line_at_ = Clock::now();
    }
  }

  /// Call after the last tick, `last`, null if there was none. The body is empty afterwards.
  void Finish(const TickRecord* last, RunResult& result) {
    if (meter_) result.costs = meter_->Make(effects_);
    result.removed_mm3_by_region = simulation_.CalcRemovedByRegion();
    for (const double mm3 : result.removed_mm3_by_region) result.removed_mm3 += mm3;
    if (fragments_.is_on()) {
      const double end_s = last != nullptr ? last->time_s : 0;
      Search(end_s);
      TakeOut(end_s, true);
    }
    result.heat = MakeHeatReport(EffectsOf(simulation_), last != nullptr ? last->X_WT : Pose{});
    result.fragments = fragments_.MakeReport(simulation_.UpdateBone().materials());
    files_.Finish();
    result.files = std::move(files_);
    result.effects = std::move(record_);
    result.bone = std::move(simulation_).TakeBone();
  }

 private:
  using Clock = std::chrono::steady_clock;

  void Search(double time_s) {
    for (int i = 0; i < simulation_.changed_count(); ++i) {
      const ChangedLeaf leaf = simulation_.changed(i);
      fragments_.Change(leaf.index, std::span<const float, 512>(leaf.values, 512));
    }
    simulation_.ClearChanged();
    fragments_.Search(time_s);
  }
  /// Takes pieces out at fixed ticks, and each as a whole, so that runs are reproducible. `lifted`: the tool has not
  /// been placed yet, so every piece is clear of it.
  void TakeOut(double time_s, bool lifted) {
    const auto is_clear = [&](const Box3& box_W) { return lifted || simulation_.IsClearOf(box_W); };
    while (std::optional<PieceJob> job = fragments_.Prepare(simulation_.UpdateBone(), is_clear)) {
      Install(job->removal, simulation_);
      fragments_.Finish(*std::move(job), time_s);
      Search(time_s);
    }
  }

  Simulation simulation_;
  const EffectPlan& effects_;
  EffectRecord record_;
  EffectFiles files_;
  std::vector<double> channels_;
  FragmentsDriver fragments_;
  std::size_t ticks_between_searches_ = 0;  // 0: no searches
  std::optional<StageCostMeter> meter_;
  std::function<void(const std::string&)> live_;
  Clock::time_point line_at_ = Clock::now();
  std::optional<ChangedHash> hash_;
  std::size_t ticks_ = 0;
};

}  // namespace

RunResult RunPath(Bone bone, const SimulationParams& params, const Path& path, double rate_hz, double rpm,
                  const std::function<void(double)>& progress, const CostOptions& costs, const PathTape& tape) {
  CheckRunTicks(path, rate_hz);
  const std::size_t ticks = path.CountTicks(rate_hz);
  VoxelPathBody body(std::move(bone), params, path.CalcPose(0, 0), rate_hz, ticks, costs);
  PathSession session(PathDriver(path, rate_hz), body, rpm, ticks, tape);
  session.Run(progress);
  RunResult result;
  result.wall_s = session.CalcElapsed_s();
  result.times = session.CalcTimes();
  result.ticks = session.TakeTicks();
  body.Finish(result.ticks.empty() ? nullptr : &result.ticks.back(), result);
  return result;
}

const Columns<ForceRow>& ForceColumns() {
  const char* const kPose = "pose of the tool at the end of the tick";
  const char* const kTeeth = "mean over the engaged teeth; 0 if none is engaged";
  const char* const kRemoved =
      "volume removed since the previous row; since the start. It is computed from the occupancy of voxels, clamp(1/2 "
      "- "
      "phi/h, 0, 1), and is within a few per cent of the exact volume in the summary, but 13 % too small in a plate "
      "two voxels thick (1.7 % in one of eight), and up to 50 % too large if the kerf is at most a voxel wide";
  using Row = ForceRow;
  static const Columns<Row> kColumns = JoinColumns<Row>(
      {{{"time_s", "{:.6f}", "path time at the end of the tick", [](const Row& r) { return r.tick.time_s; }},
        {"segment", "{}", "number of the stroke, counted from 1", [](const Row& r) { return r.tick.segment + 1; }}},
       PartsOf<Row>("{}_mm", "xyz", "{:.6f}", kPose, [](const Row& r) { return r.tick.X_WT.p_AB; }),
       PartsOf<Row>("q{}", "wxyz", "{:.9f}", kPose, [](const Row& r) { return PartsOfQuat(r.tick.X_WT.R_AB); }),
       PartsOf<Row>("force_{}_N", "xyz", "{:.6g}", "force on the tool, world frame, mean over the tick",
                    [](const Row& r) { return RoundTinyToZero(r.tick.out.f_T_W_N); }),
       PartsOf<Row>("torque_{}_Nmm", "xyz", "{:.6g}", "torque on the tool about the grip, world frame",
                    [](const Row& r) { return RoundTinyToZero(r.tick.out.tau_TG_W_Nmm); }),
       {{"thrust_sum_N", "{:.6g}", "sum of the magnitudes of the tooth forces",
         [](const Row& r) { return r.tick.out.thrust_sum_N; }},
        {"engaged_teeth", "{:.6g}", "engaged arc / tooth pitch", [](const Row& r) { return r.tick.out.engaged_teeth; }},
        {"mean_bite_um", "{:.6g}", kTeeth, [](const Row& r) { return 1000 * r.tick.out.mean_bite_mm; }},
        {"mean_E_GPa", "{:.6g}", kTeeth, [](const Row& r) { return r.tick.out.mean_E_MPa / 1000; }},
        {"main_region", "{}", "the region with the largest part of the thrust; 0 if no tooth is engaged",
         [](const Row& r) { return r.tick.out.main_region; }},
        {"travel_mm", "{:.6f}", "travel of the tool's origin since the first contact of the stroke",
         [](const Row& r) { return r.tick.travel_mm; }},
        {"removed_mm3", "{:.6g}", kRemoved, &Row::removed_mm3},
        {"removed_total_mm3", "{:.9g}", kRemoved, &Row::total_mm3},
        {"status", "{}",
         "sum of these bits: 1 invalid pose (nothing done), 2 spindle stopped, 4 number of substeps limited, 8 time "
         "step too short (nothing done), 16 the path leads through metal (left, and without force)",
         [](const Row& r) { return r.tick.out.status; }}}});
  return kColumns;
}

namespace {

/// Calls write() after each row; write() may clear `csv`.
template <typename Write>
void FormatRows(const std::vector<TickRecord>& ticks, int every, const EffectRecord* effects, std::string& csv,
                const Write& write) {
  csv = CsvHeader(ForceColumns()) + (effects ? effects->Header() : "") + "\n";
  double total_mm3 = 0;
  double since_last_row_mm3 = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    total_mm3 += ticks[i].out.removed_mm3;
    since_last_row_mm3 += ticks[i].out.removed_mm3;
    if ((i + 1) % static_cast<std::size_t>(std::max(every, 1)) != 0 && i + 1 != ticks.size()) continue;
    AppendCsv(ForceColumns(), {ticks[i], since_last_row_mm3, total_mm3}, csv);
    csv += (effects ? effects->Row(i) : "") + "\n";
    since_last_row_mm3 = 0;
    write();
  }
}

}  // namespace

std::string FormatForceLog(const std::vector<TickRecord>& ticks, int every, const EffectRecord* effects) {
  std::string csv;
  FormatRows(ticks, every, effects, csv, [] {});
  return csv;
}

void WriteForceLog(const std::string& path, const std::vector<TickRecord>& ticks, int every,
                   const EffectRecord* effects) {
  GrowingFile file(path);
  std::string csv;
  FormatRows(ticks, every, effects, csv, [&] {
    if (csv.size() < kLogBlockBytes) return;
    file.Append(csv);
    csv.clear();
  });
  file.Append(csv);
  file.Commit();
}

}  // namespace kerf
