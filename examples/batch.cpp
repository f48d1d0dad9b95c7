// Cuts the same slot into several bones and prints a table: patients' bones from files, or generic ones by default.
//
//   batch SCENE [BONE.vdb ...]
#include <algorithm>
#include <cstdio>
#include <glm/geometric.hpp>
#include <kerf/bone_file.h>
#include <kerf/error.h>
#include <kerf/models.h>
#include <kerf/run.h>
#include <string>
#include <utility>
#include <vector>

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: batch SCENE [BONE.vdb ...]\n");
    return 2;
  }
  const kerf::SceneFile scene = kerf::SceneFile::Read(argv[1]);
  std::vector<std::pair<std::string, kerf::Bone>> bones;
  for (int i = 2; i < argc; ++i) bones.emplace_back(argv[i], kerf::ReadBone(argv[i]));
  if (bones.empty()) {
    for (const double cortex_mm : {1.0, 2.5, 4.0}) {
      kerf::BlockParams block;
      block.size_mm = {20, 8, 10};
      block.layers = {{.thickness_mm = cortex_mm, .region = 24}, {.thickness_mm = 10 - cortex_mm, .region = 32}};
      block.voxel_mm = 0.2;
      bones.emplace_back("cortex of " + std::to_string(cortex_mm).substr(0, 3) + " mm", kerf::MakeBlock(block));
    }
  }
  std::printf("%-24s %10s %12s %12s\n", "bone", "peak, N", "impulse, Ns", "removed, mm3");
  for (auto& [name, bone] : bones) {
    const kerf::PathRun run = kerf::RunAlongPath(scene, std::move(bone));
    double peak_N = 0, impulse_Ns = 0;
    for (const kerf::TickRecord& tick : run.ticks) {
      const double force_N = glm::length(tick.out.f_T_W_N);
      peak_N = std::max(peak_N, force_N);
      impulse_Ns += force_N / scene.rate_hz();
    }
    std::printf("%-24s %10.4g %12.4g %12.4f\n", name.c_str(), peak_N, impulse_Ns, run.removed_mm3);
  }
} catch (const kerf::Error& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
