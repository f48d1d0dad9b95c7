#include "experiment/reference/check.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf::reference {
namespace {

void CheckRange(const char* name, double value, double lower, double upper) {
  if (!(value >= lower && value <= upper)) {
    throw Error(fmt::format("{} = {} is out of range; valid range {} to {}", name, value, lower, upper));
  }
}

}  // namespace

void Check(const ReferenceParams& params, const std::vector<Pose>& poses) {
  params.saw.Validate();
  CheckRange("rpm", params.rpm, -1e6, 1e6);
  CheckRange("tick_s", params.tick_s, 1e-6, 1);
  const ReferenceFineness& f = params.fineness;
  CheckRange("rim_points", f.rim_points, 16, 1 << 20);
  CheckRange("steps_per_tick", f.steps_per_tick, 1, 1 << 16);
  CheckRange("flat_spacing_mm", f.flat_spacing_mm, 0.01, 10);
  CheckRange("look_ahead_mm", f.look_ahead_mm, 1e-8, 0.1);
  CheckRange("edge_mm", f.edge_mm, 1e-3, 0.5 * params.saw.radius_mm());
  const ReferenceCoupling& c = params.coupling;
  CheckRange("coupling stiffness_N_per_mm", c.stiffness_N_per_mm, 1e-3, 1e3);
  CheckRange("coupling damping_Ns_per_mm", c.damping_Ns_per_mm, 0, 1);
  CheckRange("coupling torsion_Nmm_per_rad", c.torsion_Nmm_per_rad, 1, 1e7);
  CheckRange("coupling torsion_damping_Nmms", c.torsion_damping_Nmms, 0, 1e4);
  CheckRange("coupling max_force_N", c.max_force_N, 0.1, 1e4);
  CheckRange("coupling max_torque_Nmm", c.max_torque_Nmm, 1, 1e6);
  if (poses.empty()) throw Error("a reference needs at least a start pose");
  for (const Pose& X : poses) {
    if (!IsValid(X) || !IsInWorld(X.p_AB))
      throw Error("a pose of the reference's path is not finite or outside the world");
  }
}

bool IsSetDown(const ReferenceParams& params, std::size_t k) {
  return std::binary_search(params.set_downs.begin(), params.set_downs.end(), k);
}

void StopIf(const std::atomic<bool>* stop) {
  if (stop != nullptr && *stop) throw Error("stopped while a reference was being computed");
}

void SettleRemoved(ReferenceRun& run) {
  constexpr double kFinest_mm = 1.0 / 64;
  if (run.ticks.empty() || !(run.ticks.back().removed_mm3 > 0)) return;
  const double factor = run.bone.CalcRemoved(kFinest_mm) / run.ticks.back().removed_mm3;
  for (ReferenceTick& tick : run.ticks) tick.removed_mm3 *= factor;
}

}  // namespace kerf::reference
