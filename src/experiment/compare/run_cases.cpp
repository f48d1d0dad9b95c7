#include "experiment/compare/run_cases.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "base/core/hash.h"
#include "session/run/run.h"
#include "session/run/run_scene.h"
#include "session/run/run_slab.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

constexpr double kNoForce_N = 1e-12;

/// The hash depends on the order of the ticks: the same forces in another order have another hash.
std::uint64_t HashForces(const std::vector<TickRecord>& ticks) {
  std::uint64_t hash = 0;
  for (const TickRecord& t : ticks) {
    for (const double value : {t.out.f_T_W_N.x, t.out.f_T_W_N.y, t.out.f_T_W_N.z, t.out.thrust_sum_N}) {
      hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(value + 0.0));  // + 0.0 turns -0 into 0
    }
  }
  return hash;
}

DepthSample MakeSample(double depth_mm, const TickOutput& out, const Vec3& direction_W) {
  const double against_N = -glm::dot(out.f_T_W_N, direction_W);
  // Rounding left over from springs at rest counts as zero.
  return {depth_mm, std::abs(against_N) < kNoForce_N ? 0 : against_N, glm::length(out.f_T_W_N), out.thrust_sum_N,
          out.engaged_teeth};
}

/// Returns the distance along the direction from the origin to the leading point of the disc's rim.
double CalcReach(const Pose& X_WT, double radius_mm, const Vec3& direction_W) {
  const double along_normal = glm::dot(X_WT.Vector({0, 0, 1}), direction_W);
  return glm::dot(X_WT.p_AB, direction_W) + radius_mm * std::sqrt(std::max(0.0, 1 - along_normal * along_normal));
}

CaseRun RunVoxelCase(const CompareCase& what, const Scene& scene, const Bone& bone, const SlabProfile& profile,
                     const std::function<void(double)>& progress) {
  const Path path = MakePath(scene);
  SimulationParams params = MakeSimulationParams(scene);
  params.law = what.law;
  const double radius_mm = CalcRadius(scene.tool.shape);
  const double rate_hz = scene.simulation.rate_hz;
  const RunResult run = RunPath(bone, params, path, rate_hz, scene.tool.CalcTickRpm(), progress);
  const Vec3 d = glm::normalize(scene.slab.direction);
  CaseRun result;
  result.samples.reserve(run.ticks.size());
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    const TickRecord& t = run.ticks[i];
    const bool goes_on = i > 0 && run.ticks[i - 1].segment == t.segment;
    const PathSegment& stretch = path.segments()[t.segment];
    const Pose before = goes_on ? run.ticks[i - 1].X_WT : path.CalcPose(t.segment, stretch.start_s);
    // A tick's force is the mean over the tick, so it belongs to the middle of the motion.
    const double depth = 0.5 * (CalcReach(before, radius_mm, d) + CalcReach(t.X_WT, radius_mm, d)) - profile.entry_mm;
    result.samples.push_back(MakeSample(depth, t.out, d));
  }
  result.times = run.times;
  result.work_mJ = SummarizeForces(run.ticks, rate_hz).work_Nmm;
  result.removed_mm3 = run.removed_mm3;
  result.force_hash = HashForces(run.ticks);
  result.bone_hash = run.bone.CalcHash();
  result.memory_bytes = std::max(bone.CalcMemoryBytes(), run.bone.CalcMemoryBytes());
  return result;
}

CaseRun RunSlabCase(const CompareCase& what, Scene scene, const SlabProfile& profile,
                    const std::function<void(double)>& progress) {
  scene.slab.params.reading = what.reading;
  const SlabRun run = RunSlab(scene, profile, progress);
  const Vec3 d = glm::normalize(scene.slab.direction);
  CaseRun result;
  result.samples.reserve(run.ticks.size());
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    const bool goes_on = i > 0 && run.ticks[i - 1].segment == run.ticks[i].segment;
    const double before = run.states[goes_on ? i - 1 : i].depth_mm;
    result.samples.push_back(MakeSample(0.5 * (before + run.states[i].depth_mm), run.ticks[i].out, d));
  }
  result.times = run.times;
  result.work_mJ = run.states.empty() ? 0 : run.states.back().hand_work_mJ;
  result.force_hash = HashForces(run.ticks);
  result.memory_bytes = run.memory_bytes;
  return result;
}

}  // namespace

CaseRun RunCase(const CompareCase& what, const Scene& scene, const Bone& bone, const SlabProfile& profile,
                const std::function<void(double)>& progress) {
  return what.slab ? RunSlabCase(what, scene, profile, progress) : RunVoxelCase(what, scene, bone, profile, progress);
}

}  // namespace kerf
