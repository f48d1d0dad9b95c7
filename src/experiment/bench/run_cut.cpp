#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "cut/hand_sim/internals.h"
#include "cut/tool/shape.h"
#include "experiment/bench/cut_case.h"
#include "experiment/bench/dense_bone.h"
#include "experiment/bench/machine_rates.h"
#include "experiment/bench/vdb_cut.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kTick_s = 0.001;

/// Returns a coupling so stiff that the tool follows the path to within a few hundredths of a millimetre, as tools do
/// in the other programs.
CouplingParams MakeStiffCoupling() {
  CouplingParams coupling;
  coupling.stiffness_N_per_mm = 1000;
  coupling.torsion_Nmm_per_rad = 1e7;
  coupling.max_force_N = 1e4;
  coupling.max_torque_Nmm = 1e6;
  return coupling;
}

/// Returns the area, mm^2, of that part of the tool's cross-section perpendicular to the feed that lies below a plane.
/// The tool's centre is `height_mm` above the plane.
double CalcSection(const Tool& tool, double height_mm) {
  if (IsBlade(tool)) {
    const double radius_mm = CalcRadius(tool);
    return CalcThickness(tool) * std::clamp(radius_mm - height_mm, 0.0, 2 * radius_mm);
  }
  if (const std::optional<RoundSolid> solid = CalcRoundSolid(tool)) {
    // Twice the area between the axis and the profile, from the tip up to the plane.
    const double to_mm = std::clamp(-height_mm, 0.0, solid->top_z_mm);
    const double end_mm = std::min(to_mm, solid->corner_z_mm);
    const double slope = (solid->top_radius_mm - solid->corner_radius_mm) / (solid->top_z_mm - solid->corner_z_mm);
    const double end_mm2 = end_mm > 0 ? end_mm * end_mm * solid->corner_radius_mm / solid->corner_z_mm : 0;
    const double side_mm = std::max(0.0, to_mm - solid->corner_z_mm);
    return end_mm2 + side_mm * (2 * solid->corner_radius_mm + slope * side_mm);
  }
  const double r = CalcReach(tool);
  const double h = std::clamp(height_mm, -r, r);
  return r * r * std::acos(h / r) - h * std::sqrt(r * r - h * h);
}

/// Returns a coupling as for a large desktop device.
CouplingParams MakeDeviceCoupling() {
  CouplingParams coupling;
  coupling.stiffness_N_per_mm = 4;
  coupling.torsion_Nmm_per_rad = 5000;
  coupling.max_force_N = 40;
  return coupling;
}

/// A tremor of 9 Hz: 0.1 mm along the spindle, where there is no feed, and 0.5 degrees of tilt about the feed.
constexpr double kTremor_Hz = 9;
constexpr double kTremor_mm = 0.1;
constexpr double kTremor_rad = 0.5 * std::numbers::pi / 180;

double Sum(const std::array<double, 256>& by_region) {
  return std::accumulate(by_region.begin(), by_region.end(), 0.0);
}

/// One pass along the cut, tick by tick.
class Pass {
 public:
  Pass(const CutCase& cut, Bone bone, bool without_effects)
      : cut_(cut), simulation_(std::move(bone), MakeParams(cut, without_effects), HandlePose(cut, 0)) {}

  static int CountTicks(const CutCase& cut, double length_mm) {
    return static_cast<int>(std::lround(length_mm / cut.feed_mm_per_s / kTick_s));
  }
  static Pose HandlePose(const CutCase& cut, int tick) {
    const Vec3 p_B = cut.X_BT_start.p_AB + cut.feed_mm_per_s * kTick_s * tick * cut.direction_B;
    Pose X_WH{cut.X_WB.R_AB * cut.X_BT_start.R_AB, cut.X_WB.Point(p_B)};
    if (cut.by_hand) {
      const double wave = std::sin(2 * std::numbers::pi * kTremor_Hz * kTick_s * tick);
      X_WH.p_AB += X_WH.Vector({0, 0, kTremor_mm * wave});
      X_WH.R_AB = glm::normalize(glm::angleAxis(kTremor_rad * wave, cut.X_WB.Vector(cut.direction_B)) * X_WH.R_AB);
    }
    return X_WH;
  }

  CoupledOutput Tick(TickObserver* observer) {
    CoupledInput in;
    in.X_WH = HandlePose(cut_, ++tick_);
    in.v_H_W_mm_per_s = cut_.X_WB.Vector(cut_.feed_mm_per_s * cut_.direction_B);
    in.dt_s = kTick_s;
    in.rpm = cut_.rpm;
    const CoupledOutput out = simulation_.Tick(in, observer);
    // In the loop, readers read the changed leaves and clear them between ticks; this does the same.
    simulation_.ClearChanged();
    return out;
  }

  CoupledSimulation& simulation() { return simulation_; }

 private:
  static CoupledParams MakeParams(const CutCase& cut, bool without_effects) {
    CoupledParams params;
    if (cut.effects) params.effects = *cut.effects;
    if (without_effects) params.effects.clear();
    params.tool = cut.tool;
    params.coupling = cut.by_hand ? MakeDeviceCoupling() : MakeStiffCoupling();
    params.spare_leaves = cut.spare_leaves;
    return params;
  }

  const CutCase& cut_;
  CoupledSimulation simulation_;
  int tick_ = 0;
};

/// Results of the first pass, for the comparisons.
struct Trace {
  std::vector<Pose> X_WT;  // at the start and after each tick
  double swept_mm3 = 0;    // in the measured ticks, by the closed form
  double removed_mm3 = 0;  // in the measured ticks, of the bone
  double occupancy_mm3 = 0;
  double force_N = 0;  // mean
  double substeps = 0;
  int max_iterations = 0;
  int limited_ticks = 0;  // ticks in which substeps, iterations or leaves were used up, or the force was limited
  std::uint32_t status = 0;
};

void Follow(const CutCase& cut, const CoupledOutput& out, Trace& trace) {
  const Pose& before = trace.X_WT.back();
  const double height = 0.5 * (cut.X_WB.InversePoint(before.p_AB).z + cut.X_WB.InversePoint(out.X_WT.p_AB).z);
  const double advance_mm = glm::dot(cut.X_WB.Vector(cut.direction_B), out.X_WT.p_AB - before.p_AB);
  trace.swept_mm3 += (cut.section_mm2 > 0 ? cut.section_mm2 : CalcSection(cut.tool, height)) * advance_mm;
  trace.occupancy_mm3 += out.removed_mm3;
  trace.force_N += glm::length(out.f_H_W_N);
  trace.substeps += out.substeps;
  trace.max_iterations = std::max(trace.max_iterations, out.iterations);
  constexpr std::uint32_t kLimits =
      kCoupledSubstepsUsedUp | kCoupledIterationsUsedUp | kCoupledForceLimited | kCoupledLeavesUsedUp;
  if (out.status & kLimits) ++trace.limited_ticks;
  trace.status |= out.status;
}

/// Cuts the tool's path into a dense copy of the bone and times the same ticks as for the fast path.
void CompareWithDense(const CutCase& cut, const Bone& fresh, const Bone& after, const Trace& trace, int warm_up_ticks,
                      BenchResult& result) {
  Box3 box_W = fresh.CalcBounds().Grown(fresh.band_mm());
  if (!cut.dense_all) {
    const std::size_t middle = (static_cast<std::size_t>(warm_up_ticks) + trace.X_WT.size()) / 2;
    const Vec3 middle_W = trace.X_WT[middle].p_AB + cut.X_WB.Vector(cut.dense_offset_B);
    box_W = {middle_W - 0.5 * cut.dense_edge_mm, middle_W + 0.5 * cut.dense_edge_mm};
  }
  DenseBone dense(fresh, box_W);
  const double before_mm3 = dense.CalcOccupancy_mm3();
  std::vector<double> times_us;
  for (std::size_t i = 1; i < trace.X_WT.size(); ++i) {
    const double us = TimeWork([&] { dense.Cut(cut.tool, trace.X_WT[i - 1], trace.X_WT[i]); }).us();
    if (static_cast<int>(i) > warm_up_ticks) times_us.push_back(us);
  }
  if (cut.baseline == BenchBaseline::kDense) {
    result.baseline = {"dense array, brute force", CalcPercentiles(times_us)};
  }
  const DenseDifference difference = dense.Compare(after, 0.5 * fresh.voxel_mm());
  const double gone_mm3 = before_mm3 - dense.CalcOccupancy_mm3();
  result.figures.push_back(
      {"phi against dense at the surface, at most", "voxels", difference.max_phi_mm / fresh.voxel_mm()});
  result.figures.push_back({"removed against dense", "%", gone_mm3 > 0 ? -100 * difference.volume_mm3 / gone_mm3 : 0});
}

/// Times OpenVDB's own ways to remove the tool, in blocks between those of the ticks: both with the same clock, under
/// the same load and frequency of the core.
class OpenVdbBaselines {
 public:
  static constexpr int kBlocks = 5;

  /// `bone`: as before the first block.
  OpenVdbBaselines(const CutCase& cut, const Bone& bone, const BenchOptions& options)
      : cut_(cut),
        removals_((options.baseline_ticks + kBlocks - 1) / kBlocks),
        ways_{Way(bone), Way(bone), Way(bone)} {}

  /// Removes the tool at poses from X_WT on, as far apart as those of ticks. `ticks_us`: median of the ticks since the
  /// last block.
  void RunBlock(const Pose& X_WT, double ticks_us) {
    const Vec3 step_W = cut_.feed_mm_per_s * kTick_s * cut_.X_WB.Vector(cut_.direction_B);
    for (std::size_t k = 0; k < kWays; ++k) {
      Way& way = ways_[k];
      const std::size_t begin = way.timer.size();
      for (int i = 0; i <= removals_; ++i) {
        const Pose X{X_WT.R_AB, X_WT.p_AB + static_cast<double>(i) * step_W};
        if (k == kAlone) way.vdb.MakeTool(cut_.tool, X);
        const auto remove = [&] {
          if (k == kWhole) way.vdb.MakeTool(cut_.tool, X);
          if (k == kContact) return way.vdb.CutLeaves(cut_.tool, X);
          way.vdb.RemoveTool();
        };
        // The first removal is not counted, because the caches are cold; the first tick after the block is.
        if (i == 0) {
          remove();
        } else {
          way.timer.Time(remove);
        }
      }
      way.ratios.push_back(way.timer.CalcTimes(begin).p50_us / ticks_us);
    }
  }
  void Report(BenchResult& result) const {
    const Way& whole = ways_[kWhole];
    result.baseline = {"OpenVDB: a new level set of the tool, csgDifference", whole.timer.CalcTimes()};
    constexpr const char* kNames[kWays] = {"the baseline", "csgDifference alone",
                                           "OpenVDB, limited to the leaves in contact"};
    for (std::size_t k = 0; k < kWays; ++k) {
      const Way& way = ways_[k];
      const std::string name = kNames[k];
      const double p50_us = way.timer.CalcTimes().p50_us;
      if (k != kWhole) result.figures.push_back({name + ", p50", "us", p50_us});
      result.figures.push_back({"speedup over " + name, "", p50_us / result.times.p50_us});
      const auto [least, most] = std::minmax_element(way.ratios.begin(), way.ratios.end());
      result.figures.push_back({"speedup over " + name + ", least of the blocks", "", *least});
      result.figures.push_back({"speedup over " + name + ", most of the blocks", "", *most});
    }
  }

 private:
  enum : std::size_t { kWhole, kAlone, kContact, kWays };
  struct Way {
    explicit Way(const Bone& bone) : vdb(bone) {}
    VdbCut vdb;
    TickTimer timer;
    std::vector<double> ratios;  // of each block's median to that of the ticks before it
  };
  const CutCase& cut_;
  int removals_;
  std::array<Way, kWays> ways_;
};

/// The ticks that took long, by what happened in them; a new list of leaves is one in the last step of a tick.
class LongTicks {
 public:
  void Reserve(std::size_t ticks) { ticks_.reserve(ticks); }
  void Add(const WorkTime& time, const StepWork& before, const StepWork& after) {
    ticks_.push_back(
        {time.us(),
         {!time.undisturbed, time.page_fault, after.removal.is_new_list, after.spare_leaves < before.spare_leaves}});
  }
  /// Adds the number of ticks that took more than 3 times the median, and of those in which each thing happened.
  void Report(double p50_us, BenchResult& result) const {
    constexpr double kLong = 3;
    const char* const kNames[kThings] = {"with another program on the core", "with a page fault",
                                         "with a new list of leaves", "with a new leaf"};
    int ticks = 0;
    int unexplained = 0;
    int counts[kThings] = {};
    for (const Tick& tick : ticks_) {
      if (!(tick.us > kLong * p50_us)) continue;
      ++ticks;
      bool explained = false;
      for (std::size_t i = 0; i < kThings; ++i) {
        if (!tick.happened[i]) continue;
        explained = true;
        ++counts[i];
      }
      if (!explained) ++unexplained;
    }
    result.figures.push_back({"ticks over 3 times p50", "", static_cast<double>(ticks)});
    for (std::size_t i = 0; i < kThings; ++i) {
      result.figures.push_back({std::string("of these, ") + kNames[i], "", static_cast<double>(counts[i])});
    }
    result.figures.push_back({"of these, with none of this", "", static_cast<double>(unexplained)});
  }

 private:
  static constexpr std::size_t kThings = 4;
  struct Tick {
    double us;
    std::array<bool, kThings> happened;
  };
  std::vector<Tick> ticks_;
};

/// Sums over the ticks of one step each, nearly all.
struct WorkSums {
  std::uint64_t ticks = 0;
  double leaves = 0;
  double computed_voxels = 0;
  double changed_voxels = 0;
  double samples = 0;

  void Add(const CoupledOutput& out, const StepWork& before, const StepWork& after) {
    if (out.substeps != 1) return;
    constexpr int kBrickVoxels = 8;
    ++ticks;
    leaves += after.removal.leaves;
    computed_voxels += kBrickVoxels * after.removal.bricks;
    changed_voxels += after.removal.changed_voxels;
    samples += static_cast<double>(after.samples - before.samples);
  }
};

constexpr double kVoxelBytes = 2 * sizeof(float);   // read and written
constexpr double kSampleBytes = 8 * sizeof(float);  // of the corners

/// Adds the work of a tick, and how near it comes to the machine's limits.
void AddWork(const CutCase& cut, const WorkSums& sums, BenchResult& result) {
  if (sums.ticks == 0) return;
  const double ticks = static_cast<double>(sums.ticks);
  const double computed = sums.computed_voxels / ticks;
  const double samples = sums.samples / ticks;
  const double bytes = kVoxelBytes * computed + kSampleBytes * samples;
  const std::vector<double>& us = result.stages_us;
  const double all_us = std::accumulate(us.begin(), us.end(), 0.0);
  const MachineRates rates = MeasureMachineRates();
  const auto share = [](double amount, double time_us, double giga_per_s) {
    return 100 * amount / (1e3 * time_us * giga_per_s);
  };
  result.figures.push_back({"leaves visited by removal", "", sums.leaves / ticks});
  result.figures.push_back({"voxels computed by removal", "", computed});
  result.figures.push_back({"voxels changed", "", sums.changed_voxels / ticks});
  result.figures.push_back({"samples of the bone by contact", "", samples});
  result.figures.push_back({"bytes of these voxels and corners", "kB", 1e-3 * bytes});
  result.figures.push_back(
      {"these bytes against this core's memory", "%", share(bytes, all_us, rates.memory_GB_per_s)});
  const ToolForm form = GetForm(cut.tool);
  if (form == ToolForm::kBall || std::holds_alternative<DiscSaw>(cut.tool)) {
    const double operations = computed * (form == ToolForm::kBall ? kBallOperations : kDiscOperations);
    const double remove_us = us[static_cast<std::size_t>(TickStage::kRemove)];
    result.figures.push_back(
        {"removal against this core's vector rate", "%", share(operations, remove_us, rates.float_Gop_per_s)});
  }
  const double engage_us = us[static_cast<std::size_t>(TickStage::kEngage)];
  result.figures.push_back({"samples against this core's vector rate", "%",
                            share(kSampleOperations * samples, engage_us, rates.double_Gop_per_s)});
  result.figures.push_back({"memory rate of this core", "GB/s", rates.memory_GB_per_s});
  result.figures.push_back({"vector rate of this core, floats", "Gop/s", rates.float_Gop_per_s});
  result.figures.push_back({"vector rate of this core, doubles", "Gop/s", rates.double_Gop_per_s});
}

}  // namespace

const BenchFigure* BenchResult::Find(const std::string& figure) const {
  for (const BenchFigure& f : figures) {
    if (f.what == figure) return &f;
  }
  return nullptr;
}

BenchResult RunCut(const CutCase& cut, const BenchOptions& options) {
  const int warm_up = Pass::CountTicks(cut, cut.warm_up_mm);
  const int in_pass = std::min(options.ticks, std::max(1, Pass::CountTicks(cut, cut.measured_mm)));
  const int passes = (options.ticks + in_pass - 1) / in_pass;
  const auto show = [&](const char* what, double fraction) {
    if (options.progress) options.progress(fmt::format("{}: {}", cut.name, what), fraction);
  };

  BenchResult result;
  result.name = cut.name;
  result.title = cut.title;
  show("bone", 0);
  const Bone fresh = cut.make_bone();
  result.figures.push_back({"memory of the bone", "MB", 1e-6 * static_cast<double>(fresh.CalcMemoryBytes())});
  const PinnedToCore pinned(options.core, options.realtime);

  TickTimer timer;
  timer.Reserve(static_cast<std::size_t>(passes) * static_cast<std::size_t>(in_pass));
  LongTicks long_ticks;
  long_ticks.Reserve(static_cast<std::size_t>(passes) * static_cast<std::size_t>(in_pass));
  std::optional<OpenVdbBaselines> baselines;
  Trace trace;
  trace.X_WT.push_back(Pass::HandlePose(cut, 0));
  Bone after;
  bool same_hash = true;
  for (int n = 0; n < passes; ++n) {
    show("ticks", static_cast<double>(n) / (passes + 2));
    Pass pass(cut, fresh, options.without_effects);
    for (int i = 0; i < warm_up; ++i) {
      const CoupledOutput out = pass.Tick(nullptr);
      if (n == 0) trace.X_WT.push_back(out.X_WT);
    }
    const double removed_before = n == 0 ? Sum(pass.simulation().CalcRemovedByRegion()) : 0;
    if (n == 0 && cut.baseline == BenchBaseline::kOpenVdb)
      baselines.emplace(cut, pass.simulation().UpdateBone(), options);
    std::size_t block_begin = timer.size();
    for (int i = 0; i < in_pass; ++i) {
      CoupledOutput out;
      const StepWork before = CoupledInternals::Work(pass.simulation());
      const WorkTime time = timer.Time([&] { out = pass.Tick(nullptr); });
      long_ticks.Add(time, before, CoupledInternals::Work(pass.simulation()));
      if (n > 0) continue;
      Follow(cut, out, trace);
      trace.X_WT.push_back(out.X_WT);
      if (!baselines || (i + 1) * OpenVdbBaselines::kBlocks / in_pass == i * OpenVdbBaselines::kBlocks / in_pass)
        continue;
      show("baseline", static_cast<double>(i) / in_pass / (passes + 2));
      baselines->RunBlock(out.X_WT, timer.CalcTimes(std::exchange(block_begin, timer.size())).p50_us);
    }
    if (n == 0) trace.removed_mm3 = Sum(pass.simulation().CalcRemovedByRegion()) - removed_before;
    const std::uint64_t hash = pass.simulation().UpdateBone().CalcHash();
    if (n == 0) {
      result.hash = hash;
      result.figures.push_back(
          {"memory of the simulation", "MB", 1e-6 * static_cast<double>(pass.simulation().CalcMemoryBytes())});
      after = std::move(pass.simulation()).TakeBone();
    }
    same_hash = same_hash && hash == result.hash;
  }
  result.times = timer.CalcTimes();
  result.undisturbed = timer.CalcUndisturbed();
  if (baselines) baselines->Report(result);
  if (!same_hash) throw Error(fmt::format("the passes of {} gave different bones; this is a bug in kerf", cut.name));

  // Timing the stages itself takes time, so it is done in a separate pass.
  WorkSums work;
  {
    show("stages", static_cast<double>(passes) / (passes + 2));
    Pass pass(cut, fresh, options.without_effects);
    for (int i = 0; i < warm_up; ++i) pass.Tick(nullptr);
    UndisturbedStages stages;
    for (int i = 0; i < std::min(in_pass, 2000); ++i) {
      const StepWork before = CoupledInternals::Work(pass.simulation());
      CoupledOutput out;
      stages.Time([&](TickObserver* observer) { out = pass.Tick(observer); });
      work.Add(out, before, CoupledInternals::Work(pass.simulation()));
    }
    result.stages_us = stages.CalcMeans_us();
  }

  const double ticks = in_pass;
  const Vec3 motion_W = trace.X_WT.back().p_AB - trace.X_WT[static_cast<std::size_t>(warm_up)].p_AB;
  const double feed = glm::dot(cut.X_WB.Vector(cut.direction_B), motion_W) / (ticks * kTick_s);
  result.figures.push_back({"feed of the tool", "mm/s", feed});
  result.figures.push_back({"force on the hand, mean", "N", trace.force_N / ticks});
  result.figures.push_back({"removed", "mm3", trace.removed_mm3});
  if (cut.flat_top) {
    result.figures.push_back({"removed minus swept", "%", 100 * (trace.removed_mm3 / trace.swept_mm3 - 1)});
    result.figures.push_back(
        {"removed by occupancy minus swept", "%", 100 * (trace.occupancy_mm3 / trace.swept_mm3 - 1)});
  }
  result.figures.push_back({"substeps, mean", "", trace.substeps / ticks});
  result.figures.push_back({"iterations, maximum", "", static_cast<double>(trace.max_iterations)});
  result.figures.push_back({"ticks at a limit", "", static_cast<double>(trace.limited_ticks)});
  long_ticks.Report(result.times.p50_us, result);
  AddWork(cut, work, result);
  if (std::abs(feed / cut.feed_mm_per_s - 1) > 0.02) {
    result.note = fmt::format("the tool fed at {:.3g} mm/s, not at {:.3g}", feed, cut.feed_mm_per_s);
  }

  show("dense array", static_cast<double>(passes + 1) / (passes + 2));
  if (cut.dense_all || cut.dense_edge_mm > 0) CompareWithDense(cut, fresh, after, trace, warm_up, result);
  return result;
}

}  // namespace kerf
