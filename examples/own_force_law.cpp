// Adds a force law to kerf and cuts with it: a constant specific energy, so that the thrust is proportional to the bite.
//
//   own_force_law SCENE [specific_energy_J_per_mm3]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <glm/geometric.hpp>
#include <kerf/error.h>
#include <kerf/force.h>
#include <kerf/run.h>

namespace {

// Coefficients, prepared once for a tool: c[0] specific energy, N/mm2 = mJ/mm3; c[1] width of a tooth, mm.
double CalcThrust(const kerf::ToothForce& law, double bite_mm, const kerf::ToothCut& cut) {
  if (cut.E_MPa <= 0) return 0;  // no bone
  return law.c[0] * law.c[1] * bite_mm * cut.E_MPa / 19300;
}

kerf::ToothForce MakeLaw(const kerf::LawValues& values, const kerf::Tooth& tooth,
                         const std::shared_ptr<const kerf::ForceTable>&) {
  kerf::ToothForce law;
  law.thrust = CalcThrust;
  law.c = {1000 * values[0], tooth.width_mm};
  return law;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: own_force_law SCENE [specific_energy_J_per_mm3]\n");
    return 2;
  }
  kerf::RegisterForceLaw({
      .name = "specific_energy",
      .summary = "thrust = specific energy x width x bite, scaled with E",
      .source = "an example; the value is an assumption",
      .validity = {},
      .parameters = {{"specific_energy_J_per_mm3", 0.05, 0, 10, "energy to remove a volume of bone of 19.3 GPa"}},
      .make = MakeLaw,
  });
  // From here on scenes may name it too: [force] law = "specific_energy".
  kerf::SceneFile scene = kerf::SceneFile::Read(argv[1]).With("force", "law", "\"specific_energy\"");
  if (argc > 2) scene = scene.With("force", "specific_energy_J_per_mm3", argv[2]);
  const kerf::PathRun run = kerf::RunAlongPath(scene);
  double peak_N = 0;
  for (const kerf::TickRecord& tick : run.ticks) peak_N = std::max(peak_N, glm::length(tick.out.f_T_W_N));
  std::printf("peak force %.6g N with %s\n", peak_N, scene.MakeSimulationParams().law.name());
} catch (const kerf::Error& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
