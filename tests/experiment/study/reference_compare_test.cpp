// Compares the simulation with the reference for one case. Both agree, coupled to a handle and on a path.
#include <gtest/gtest.h>

#include <cstdio>

#include "experiment/study/case.h"
#include "experiment/study/case_run.h"

namespace kerf {
namespace {

ReferenceRun RunReference(const StudyPath& path, Holding holding, double rate_hz) {
  ReferenceParams params;
  params.saw = path.saw;
  params.law = ForceLaw(StudySettings().law);
  params.rpm = path.rpm;
  const CouplingParams& c = path.coupling;
  params.coupling = {
      c.p_TC_mm,     c.stiffness_N_per_mm, c.damping_Ns_per_mm, c.torsion_Nmm_per_rad, c.torsion_damping_Nmms,
      c.max_force_N, c.max_torque_Nmm};
  std::vector<Pose> poses{path.pose(holding, 0)};
  for (const CaseInput& in : MakeCaseInputs(path, holding, rate_hz)) poses.push_back(in.X_W);
  return holding == Holding::kHand ? RunReferenceInHand(path.solid, params, poses)
                                   : RunReferenceOnPath(path.solid, params, poses);
}

TEST(SimulationAndReference, AgreeOnAnEntryInAHandAndOnAPath) {
  const StudySettings settings;
  for (const char* name : {"entry"}) {
    const StudyPathList list = MakeStudyPaths({name}, "");
    ASSERT_EQ(list.paths.size(), 1u);
    const StudyPath& path = list.paths.front();
    for (const Holding holding : {Holding::kHand, Holding::kPath}) {
      const ReferenceRun reference = RunReference(path, holding, settings.rate_hz);
      const CasePass pass = RunCasePass(path, holding, settings);
      ASSERT_EQ(pass.f_W_N.size(), reference.ticks.size());
      double off2 = 0;
      double whole2 = 0;
      for (std::size_t k = 0; k < pass.f_W_N.size(); ++k) {
        const Vec3 off = pass.f_W_N[k] - reference.ticks[k].f_W_N;
        off2 += glm::dot(off, off);
        whole2 += glm::dot(reference.ticks[k].f_W_N, reference.ticks[k].f_W_N);
      }
      const double removed = reference.ticks.back().removed_mm3;
      std::printf("%s, %s: force %.2e of %.2f N rms, volume %.2e of %.3f mm3\n", name,
                  std::string(ToString(holding)).c_str(), std::sqrt(off2 / whole2),
                  std::sqrt(whole2 / static_cast<double>(pass.f_W_N.size())), pass.removed_mm3 / removed - 1, removed);
      // The tolerances are the errors of a grid of 0.1 mm (docs/physics.md). The ends of the engaged arc are off by a
      // quarter of a voxel, about 1 % of the force on a path and less with a compliant hand; a kerf's volume is off by
      // half a percent.
      EXPECT_LT(std::sqrt(off2 / whole2), holding == Holding::kHand ? 0.01 : 0.03) << name;
      EXPECT_NEAR(pass.removed_mm3 / removed, 1, 0.01) << name;
    }
  }
}

}  // namespace
}  // namespace kerf
