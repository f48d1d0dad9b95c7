#include "session/run/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "base/files/files.h"
#include "base/files/memory.h"
#include "bone/grid/changed_hash.h"
#include "cut/effects/plan.h"
#include "kerf/error.h"
#include "session/run/tick_interceptor.h"

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

RunResult RunPath(Bone bone, const SimulationParams& params, const Path& path, double rate_hz, double rpm,
                  const std::function<void(double)>& progress, const CostOptions& costs, TickInterceptor* tap) {
  using Clock = std::chrono::steady_clock;
  RunResult result;
  CheckRunTicks(path, rate_hz);
  const std::size_t total = path.CountTicks(rate_hz);
  result.ticks.reserve(total);
  std::vector<double> times_us;
  times_us.reserve(total);

  Simulation simulation(std::move(bone), params, path.CalcPose(0, 0));
  const EffectPlan& effects = std::as_const(simulation).effects();
  std::unique_ptr<StageCostMeter> meter;
  if (costs.costs) {
    meter = std::make_unique<StageCostMeter>(1e6 / rate_hz);
    meter->Watch(simulation.effects());
  }
  TickObserver* const observer = meter ? &meter->observer() : nullptr;
  Clock::time_point line_at = Clock::now();
  result.effects = EffectRecord(effects);
  result.files = EffectFiles(effects, total, true);
  std::vector<double> channels(effects.channel_count());
  result.effects.rows.reserve(total * channels.size());
  FragmentsDriver fragments(simulation.effects());
  const std::size_t ticks_between_searches =
      fragments.is_on()
          ? std::max<std::size_t>(1, static_cast<std::size_t>(std::llround(fragments.every_s() * rate_hz)))
          : 0;
  const auto search = [&](double time_s) {
    for (int i = 0; i < simulation.changed_count(); ++i) {
      const ChangedLeaf leaf = simulation.changed(i);
      fragments.Change(leaf.index, std::span<const float, 512>(leaf.values, 512));
    }
    simulation.ClearChanged();
    fragments.Search(time_s);
  };
  // Pieces are taken out at fixed ticks, and each as a whole, so that runs are reproducible. `lifted`: the tool has not
  // been placed yet, so every piece is clear of it.
  const auto take_out = [&](double time_s, bool lifted) {
    while (std::optional<PieceJob> job = fragments.Prepare(
               simulation.bone(), [&](const Box3& box_W) { return lifted || simulation.IsClearOf(box_W); })) {
      Install(job->removal, simulation);
      fragments.Finish(*std::move(job), time_s);
      search(time_s);
    }
  };
  std::optional<ChangedHash> voxel_hash;
  if (tap != nullptr) voxel_hash.emplace();
  const auto take_hash = [&] {
    for (int i = 0; i < simulation.changed_count(); ++i) voxel_hash->Take(simulation.changed(i));
    if (!fragments.is_on()) simulation.ClearChanged();
    return voxel_hash->value();
  };
  bool keep_going = true;
  const Clock::time_point start = Clock::now();
  for (std::size_t segment = 0; segment < path.segments().size() && keep_going; ++segment) {
    const PathSegment& path_segment = path.segments()[segment];
    if (path_segment.retract_before && segment > 0 && fragments.takes_out()) {
      search(result.ticks.back().time_s);
      take_out(result.ticks.back().time_s, true);
    }
    if (path_segment.retract_before) {
      Pose X_WT_down = path.CalcPose(segment, path_segment.start_s);
      keep_going = tap == nullptr || tap->SetDown(X_WT_down);
      if (!keep_going) break;
      simulation.SetDown(X_WT_down);
    }
    double time_s = path_segment.start_s;
    Pose X_WT = path.CalcPose(segment, time_s);
    double travel_mm = 0;
    bool touched = false;
    const std::size_t count = path.CountTicks(segment, rate_hz);
    for (std::size_t k = 1; k <= count; ++k) {
      const double end_s = std::min(path_segment.start_s + static_cast<double>(k) / rate_hz, path_segment.end_s);
      const double dt_s = end_s - time_s;
      TickInput in{path.CalcPose(segment, end_s), dt_s, rpm};
      keep_going = tap == nullptr || tap->Begin(in);
      if (!keep_going) break;
      TickRecord record;
      record.X_WT = in.X_WT;
      const Clock::time_point before = Clock::now();
      record.out = simulation.Tick(in, observer);
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - before).count());
      if (meter) meter->Finish(times_us.back());
      if (tap != nullptr) tap->End(in, record.out, take_hash());
      touched = touched || record.out.engaged_teeth > 0;
      if (touched) travel_mm += glm::length(record.X_WT.p_AB - X_WT.p_AB);
      record.time_s = time_s = end_s;
      record.segment = segment;
      record.travel_mm = travel_mm;
      record.touched = touched;
      X_WT = record.X_WT;
      result.ticks.push_back(record);
      if (fragments.is_on() && result.ticks.size() % ticks_between_searches == 0) {
        search(time_s);
        take_out(time_s, false);
      }
      if (!channels.empty()) {
        effects.Report(channels);
        result.effects.TakeRow(channels);
        result.files.Take(time_s, dt_s, record.X_WT, channels);
      }
      if (k % kTicksBetweenRefills == 0) simulation.Refill();
      if (meter && costs.live && k % 64 == 0 && Clock::now() - line_at > kBetweenLines) {
        costs.live(FormatCostLine(meter->Make(effects)));
        line_at = Clock::now();
      }
      if (progress && k % 64 == 0) progress(static_cast<double>(result.ticks.size()) / static_cast<double>(total));
    }
  }
  result.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  if (meter) result.costs = meter->Make(effects);
  result.times = CalcPercentiles(times_us);
  result.removed_mm3_by_region = simulation.CalcRemovedByRegion();
  for (const double mm3 : result.removed_mm3_by_region) result.removed_mm3 += mm3;
  if (fragments.is_on()) {
    const double end_s = result.ticks.empty() ? 0 : result.ticks.back().time_s;
    search(end_s);
    take_out(end_s, true);
  }
  result.heat = MakeHeatReport(simulation.effects(), result.ticks.empty() ? Pose{} : result.ticks.back().X_WT);
  result.fragments = fragments.MakeReport(simulation.bone().materials());
  result.files.Finish();
  result.bone = std::move(simulation).TakeBone();
  return result;
}

namespace {

/// Calls write() after each row; write() may clear `csv`.
template <typename Write>
void FormatRows(const std::vector<TickRecord>& ticks, int every, const EffectRecord* effects, std::string& csv,
                const Write& write) {
  csv =
      "time_s,segment,x_mm,y_mm,z_mm,qw,qx,qy,qz,force_x_N,force_y_N,force_z_N,torque_x_Nmm,torque_y_Nmm,torque_z_Nmm,"
      "thrust_sum_N,engaged_teeth,mean_bite_um,mean_E_GPa,main_region,travel_mm,removed_mm3,removed_total_mm3,status";
  csv += (effects ? effects->Header() : "") + "\n";
  double total_mm3 = 0;
  double since_last_row_mm3 = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const TickRecord& t = ticks[i];
    total_mm3 += t.out.removed_mm3;
    since_last_row_mm3 += t.out.removed_mm3;
    if ((i + 1) % static_cast<std::size_t>(std::max(every, 1)) != 0 && i + 1 != ticks.size()) continue;
    const Vec3& p = t.X_WT.p_AB;
    const Quat& q = t.X_WT.R_AB;
    const Vec3 f = RoundTinyToZero(t.out.f_T_W_N);
    const Vec3 m = RoundTinyToZero(t.out.tau_TG_W_Nmm);
    fmt::format_to(
        std::back_inserter(csv),
        "{:.6f},{},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},"
        "{:.6g},{:.6g},{:.6g},{:.6g},{},{:.6f},{:.6g},{:.9g},{}",
        t.time_s, t.segment + 1, p.x, p.y, p.z, q.w, q.x, q.y, q.z, f.x, f.y, f.z, m.x, m.y, m.z, t.out.thrust_sum_N,
        t.out.engaged_teeth, 1000 * t.out.mean_bite_mm, t.out.mean_E_MPa / 1000, t.out.main_region, t.travel_mm,
        since_last_row_mm3, total_mm3, t.out.status);
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
