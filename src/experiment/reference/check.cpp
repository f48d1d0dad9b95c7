#include "experiment/reference/check.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf::reference {
void Check(const ReferenceParams& params, const std::vector<Pose>& poses) {
  params.saw.Validate();
  CheckParameters(params);
  CheckParameters(params.fineness);
  CheckParameters(params.coupling, "coupling");
  if (params.fineness.edge_mm > 0.5 * params.saw.radius_mm()) {
    throw Error(fmt::format("edge_mm = {} is above half the radius of the saw", params.fineness.edge_mm));
  }
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
