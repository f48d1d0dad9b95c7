#include "experiment/bench/other_cases.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "base/files/memory.h"
#include "bone/grid/grids.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "experiment/bench/cut_cases.h"

namespace kerf {
namespace {

constexpr double kAbove_mm = 5;

/// Returns the pose of the saw on a circle of 10 mm radius, along which it moves at 40 mm/s and with which it rotates.
/// Its lowest point is `kAbove_mm` above the plane z = 0.
Pose Hover(const DiscSaw& saw, double tilt, double t_s) {
  const double angle = 4 * t_s;
  const double lowest = saw.radius_mm() * std::sin(tilt) + 0.5 * saw.thickness_mm * std::cos(tilt);
  return {glm::angleAxis(angle, Vec3(0, 0, 1)) * glm::angleAxis(tilt, Vec3(1, 0, 0)),
          {10 * std::cos(angle), 10 * std::sin(angle), kAbove_mm + lowest}};
}

struct Footprint {
  double level_set_MB = 0;
  double bone_MB = 0;  // including the regions
  double simulation_MB = 0;
  double resident_MB = 0;  // growth of the program's memory
};

Footprint Weigh(const std::function<Bone()>& make_bone) {
  const std::size_t before = ReadResidentBytes();
  Bone bone = make_bone();
  Footprint footprint;
  footprint.level_set_MB = 1e-6 * static_cast<double>(GridsOf(bone).phi->memUsage());
  footprint.bone_MB = 1e-6 * static_cast<double>(bone.CalcMemoryBytes());
  Pose above;
  above.p_AB = bone.CalcBounds().upper + Vec3(50);
  const CoupledSimulation simulation(std::move(bone), CoupledParams{}, above);
  footprint.simulation_MB = 1e-6 * static_cast<double>(simulation.CalcMemoryBytes());
  footprint.resident_MB = 1e-6 * (static_cast<double>(ReadResidentBytes()) - static_cast<double>(before));
  return footprint;
}

}  // namespace

BenchResult RunIdle(const BenchOptions& options) {
  BenchResult result;
  result.name = "idle";
  result.title = "disc 22 x 0.25 mm, 5 mm from a block: flat, on edge, in between; 40 mm/s, 0.1 mm voxels";
  if (options.progress) options.progress("idle: bone", 0);
  BlockParams block;
  block.size_mm = {46, 46, 4};
  block.voxel_mm = 0.1;
  CoupledParams params;
  const auto saw = std::get<DiscSaw>(params.tool);
  TickTimer timer;
  double asleep = 0;
  UndisturbedStages stages;
  CoupledSimulation simulation(MakeBlock(block, DefaultMandibleTable()), params, Hover(saw, 0, 0));
  const PinnedToCore pinned(options.core, options.realtime);
  const int in_turn = (options.ticks + 2) / 3;
  for (const bool with_stages : {false, true}) {
    for (const double tilt : {0.0, 0.5 * std::numbers::pi, 0.25 * std::numbers::pi}) {
      simulation.SetDown(Hover(saw, tilt, 0));
      for (int i = -100; i < in_turn; ++i) {  // the first hundred are the warm-up
        CoupledInput in;
        in.X_WH = Hover(saw, tilt, 0.001 * i);
        if (with_stages) {
          stages.Time([&](TickObserver* observer) { simulation.Tick(in, observer); });
          continue;
        }
        if (i < 0) {
          simulation.Tick(in);
          continue;
        }
        CoupledOutput out;
        timer.Time([&] { out = simulation.Tick(in); });
        asleep += out.status & kCoupledAsleep ? 1 : 0;
      }
    }
  }
  result.times = timer.CalcTimes();
  result.undisturbed = timer.CalcUndisturbed();
  result.figures.push_back({"ticks asleep", "%", 100 * asleep / static_cast<double>(result.times.count)});
  result.stages_us = stages.CalcMeans_us();
  return result;
}

BenchResult RunMemory(const BenchOptions& options) {
  BenchResult result;
  result.name = "memory";
  result.title = "bone and simulation in memory: whole mandible at 0.1 mm; block of 256^3 voxels";
  if (options.progress) options.progress("memory: block", 0);
  const Footprint block = Weigh(MakeBallCut(0.2, 10, true).make_bone);
  if (options.progress) options.progress("memory: mandible", 0.2);
  MandibleParams params;
  params.voxel_mm = 0.1;
  const Footprint mandible = Weigh([&params] { return MakeMandible(params, DefaultMandibleTable()); });
  const double dense_MB = 1e-6 * sizeof(float) * 256 * 256 * 256;
  for (const auto& [name, footprint] : {std::pair{"mandible", mandible}, std::pair{"block", block}}) {
    const auto add = [&, bone = std::string(name)](const char* what, double MB) {
      result.figures.push_back({bone + ": " + what, "MB", MB});
    };
    add("level set", footprint.level_set_MB);
    add("level set and regions", footprint.bone_MB);
    add("simulation", footprint.simulation_MB);
    add("growth of resident memory", footprint.resident_MB);
  }
  result.figures.push_back({"block: dense float array", "MB", dense_MB});
  result.targets = {{"mandible, total", "MB", 600, mandible.bone_MB + mandible.simulation_MB},
                    {"mandible, resident", "MB", 600, mandible.resident_MB},
                    {"block, level set and regions / dense array", "", 0.25, block.bone_MB / dense_MB}};
  return result;
}

}  // namespace kerf
