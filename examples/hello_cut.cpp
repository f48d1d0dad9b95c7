// Cuts a slot into a block of bone and prints the force: the scene hello_cut.toml, tick by tick.
#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>
#include <kerf/error.h>
#include <kerf/models.h>
#include <kerf/simulation.h>

int main() try {
  kerf::BlockParams block;  // 2.5 mm of cortical bone (region 24) on cancellous bone (region 32); its top is z = 0
  block.size_mm = {20, 8, 10};
  block.layers = {{.thickness_mm = 2.5, .region = 24}, {.thickness_mm = 7.5, .region = 32}};
  block.voxel_mm = 0.2;

  const kerf::Quat upright = glm::angleAxis(glm::radians(-90.0), kerf::Vec3(1, 0, 0));  // the spindle points along y
  const auto pose = [&](double x_mm) { return kerf::Pose{upright, {x_mm, 0, 8}}; };    // 3 mm below the top
  kerf::SimulationParams params;
  params.tool = kerf::DiscSaw{.diameter_mm = 22, .thickness_mm = 0.5, .teeth = 24};
  kerf::Simulation simulation(kerf::MakeBlock(block), params, pose(-20));

  const int ticks = 4000;  // of 1 ms: 10 mm/s
  double peak_N = 0, removed_mm3 = 0;
  for (int i = 1; i <= ticks; ++i) {
    const kerf::TickOutput out = simulation.Tick({.X_WT = pose(-20 + i * 40.0 / ticks), .dt_s = 0.001, .rpm = 7500});
    peak_N = std::max(peak_N, glm::length(out.f_T_W_N));
    removed_mm3 += out.removed_mm3;
  }
  const unsigned long long hash = simulation.UpdateBone().CalcHash();
  std::printf("peak force %.6g N, removed %.4f mm3, bone %016llx\n", peak_N, removed_mm3, hash);
} catch (const kerf::Error& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
