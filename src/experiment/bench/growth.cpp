#include "experiment/bench/growth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "bone/grid/set_leaf.h"
#include "experiment/bench/cut_cases.h"
#include "experiment/bench/slope.h"

namespace kerf {
namespace {

constexpr double kDepth_mm = 8;
constexpr double kBlockLength_mm = 46;
constexpr double kMeasured_mm = 5;

/// Returns "disc-0.1" with another voxel, disc, block and feed. The disc enters the block at its side; it is measured
/// as soon as its lowest point is 2 mm inside.
CutCase MakeCut(const std::string& name, double voxel_mm, double disc_scale, const Vec3& block_mm,
                double feed_mm_per_s) {
  CutCase cut = MakeDiscCut(voxel_mm);
  const DiscSaw usual;
  DiscSaw disc = usual;
  disc.diameter_mm = disc_scale * usual.diameter_mm;
  cut.name = name;
  cut.tool = disc;
  cut.feed_mm_per_s = feed_mm_per_s;
  UseBlock(block_mm, voxel_mm, cut);
  constexpr double kGap_mm = 0.5;
  const double radius_mm = 0.5 * disc.diameter_mm;
  cut.X_BT_start.p_AB = {-0.5 * block_mm.x - radius_mm - kGap_mm, 0, radius_mm - disc_scale * kDepth_mm};
  cut.warm_up_mm = kGap_mm + radius_mm + 2;
  cut.measured_mm = kMeasured_mm;
  cut.baseline = BenchBaseline::kNone;
  cut.dense_edge_mm = 0;
  cut.spare_leaves = 4096;
  cut.flat_top = false;  // the removed volume is checked by `kerf bench tick`
  return cut;
}

struct Limits {
  double tick = 0;
  double bone = 0;
  double simulation = 0;
};

GrowthPlan MakePlan(const char* quantity, const Limits& limits, const char* why) {
  GrowthPlan plan;
  plan.series.quantity = quantity;
  plan.series.why = why;
  plan.series.tick.limit = limits.tick;
  plan.series.bone.limit = limits.bone;
  plan.series.simulation.limit = limits.simulation;
  return plan;
}

GrowthPlan PlanVoxels() {
  GrowthPlan plan = MakePlan("voxel edge (mm)", {.tick = -2, .bone = -2, .simulation = -2},
                             "a surface of A mm2 passes through A / h^2 voxels");
  for (const double h : {0.4, 0.3, 0.2, 0.15, 0.1, 0.07, 0.05}) {
    plan.cuts.emplace_back(h, MakeCut("voxel", h, 1, {kBlockLength_mm, 4, 12}, 5));
  }
  return plan;
}

GrowthPlan PlanDiscs() {
  GrowthPlan plan = MakePlan("diameter and depth of the disc, relative to 22 and 8 mm", {.tick = 1, .simulation = 1},
                             "only the rim meets bone that changes");
  for (const double scale : {0.5, 0.7, 1.0, 1.4, 2.0}) {
    plan.cuts.emplace_back(scale, MakeCut("disc", 0.1, scale, {kBlockLength_mm, 4, 20}, 5));
  }
  return plan;
}

GrowthPlan PlanBones() {
  GrowthPlan plan = MakePlan("edges of the bone, relative to 46 x 4 x 12 mm", {.bone = 2, .simulation = 2},
                             "a tick visits only bone near the tool; memory is that of the surface's leaves");
  for (const double scale : {1.0, 1.4, 2.0, 2.8, 4.0}) {
    plan.cuts.emplace_back(scale, MakeCut("bone", 0.2, 1, scale * Vec3(kBlockLength_mm, 4, 12), 5));
  }
  return plan;
}

GrowthPlan PlanFeeds() {
  GrowthPlan plan = MakePlan("feed (mm/s)", {.tick = 1}, "as the volume that is removed in a tick");
  for (const double feed : {1, 2, 5, 10, 20, 40}) {
    plan.cuts.emplace_back(feed, MakeCut("feed", 0.1, 1, {kBlockLength_mm, 4, 12}, feed));
  }
  return plan;
}

GrowthPlan PlanEffects() {
  GrowthPlan plan = MakePlan("number of effects", {}, "each adds its own work");
  plan.series.is_power = false;
  CutCase cut = MakeCut("effects", 0.1, 1, {kBlockLength_mm, 4, 12}, 5);
  const EffectChoices all = ListEffectsOf(cut);
  for (std::size_t n = 0; n <= all.size(); ++n) {
    cut.effects = EffectChoices(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(n));
    plan.cuts.emplace_back(static_cast<double>(n), cut);
  }
  return plan;
}

/// Cuts the block into a plate that is 4 mm wide, in whose middle the disc cuts, and `pieces` - 1 pieces beside it.
void Separate(const Pose& X_WB, const Vec3& block_mm, int pieces, Bone& bone) {
  if (pieces < 2) return;
  constexpr double kSlot_mm = 0.5;
  const int beside = pieces - 1;
  const auto depth_mm = [&](const Vec3& p_W) {
    const Vec3 p_B = X_WB.InversePoint(p_W);
    double depth = 0.5 * kSlot_mm - std::abs(p_B.y - 2 - 0.5 * kSlot_mm);
    if (p_B.y > 2) {
      for (int i = 1; i < beside; ++i) {
        const double at_mm = block_mm.x * (static_cast<double>(i) / beside - 0.5);
        depth = std::max(depth, 0.5 * kSlot_mm - std::abs(p_B.x - at_mm));
      }
    }
    return depth;
  };
  CutAway(bone, bone.CalcBounds(), depth_mm);
}

GrowthPlan PlanPieces() {
  GrowthPlan plan = MakePlan("pieces of the bone", {.bone = 1, .simulation = 1},
                             "pieces are looked for outside the tick; each has a surface");
  const Vec3 block_mm(kBlockLength_mm, 20, 12);
  for (const int pieces : {1, 2, 4, 8, 16, 32}) {
    CutCase cut = MakeCut("pieces", 0.2, 1, block_mm, 5);
    cut.effects = EffectChoices{EffectChoice("fragments")};
    cut.make_bone = [whole = cut.make_bone, X_WB = cut.X_WB, block_mm, pieces] {
      Bone bone = whole();
      Separate(X_WB, block_mm, pieces, bone);
      return bone;
    };
    plan.cuts.emplace_back(pieces, cut);
  }
  return plan;
}

double FitExponent(const GrowthSeries& series, double GrowthPoint::*figure) {
  SlopePath path;
  for (const GrowthPoint& point : series.points) {
    path.numbers.push_back(point.value);
    path.errors.push_back(point.*figure);
  }
  const std::optional<Slope> slope = FitSlope({path});
  return slope ? slope->slope : 0;
}

double FindFigure(const BenchResult& result, const char* what) {
  const BenchFigure* figure = result.Find(what);
  return figure != nullptr ? figure->value : 0;
}

}  // namespace

std::vector<GrowthPlan> PlanGrowth() {
  return {PlanVoxels(), PlanDiscs(), PlanBones(), PlanFeeds(), PlanEffects(), PlanPieces()};
}

GrowthReport MeasureGrowth(const std::vector<GrowthPlan>& plan, const GrowthOptions& options) {
  GrowthReport report;
  report.options = options;
  report.run = ReadRunInfo(options.core, options.realtime);
  std::size_t all = 0;
  for (const GrowthPlan& one : plan) all += one.cuts.size();
  std::size_t done = 0;
  for (const GrowthPlan& one : plan) {
    GrowthSeries series = one.series;
    for (const auto& [value, cut] : one.cuts) {
      if (options.progress) {
        options.progress(fmt::format("{}: {:g}", series.quantity, value),
                         static_cast<double>(done++) / static_cast<double>(all));
      }
      BenchOptions bench;
      bench.ticks = options.ticks;
      bench.core = options.core;
      bench.realtime = options.realtime;
      const BenchResult result = RunCut(cut, bench);
      GrowthPoint point;
      point.value = value;
      point.tick_p50_us = result.times.p50_us;
      point.tick_p99_us = result.times.p99_us;
      point.bone_MB = FindFigure(result, "memory of the bone");
      point.simulation_MB = FindFigure(result, "memory of the simulation");
      point.computed_voxels = FindFigure(result, "voxels computed by removal");
      point.samples = FindFigure(result, "samples of the bone by contact");
      point.hash = result.hash;
      series.points.push_back(point);
    }
    if (series.is_power) {
      series.tick.measured = FitExponent(series, &GrowthPoint::tick_p50_us);
      series.bone.measured = FitExponent(series, &GrowthPoint::bone_MB);
      series.simulation.measured = FitExponent(series, &GrowthPoint::simulation_MB);
    }
    report.series.push_back(std::move(series));
  }
  return report;
}

}  // namespace kerf
