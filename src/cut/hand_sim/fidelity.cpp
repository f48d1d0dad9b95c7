// Fidelity of a tick, and the transition from one fidelity to another.
#include "cut/hand_sim/state.h"

namespace kerf {
namespace {

constexpr double kBlend_s = 0.2;    // duration of the transition between the two laws
constexpr int kCutsOfPath = 4;      // cuts per tick along the path that the slab law has passed
constexpr double kMinTeeth = 0.05;  // minimum engaged teeth for the slab law to begin
constexpr double kMinThrust_N = 0.05;

}  // namespace

const char* ToString(Fidelity fidelity) {
  switch (fidelity) {
    case Fidelity::kFull:
      return "full";
    case Fidelity::kCoarse:
      return "coarse";
    case Fidelity::kSlab:
      return "slab";
  }
  return "";
}

/// Applies the requested fidelity, and advances the transition between the two laws.
void CoupledSimulation::State::StepFidelity(const CoupledInput& in, CoupledOutput& out) {
  const int stride = fidelity == Fidelity::kFull ? 1 : 2;
  if (stride != edge.stride()) {
    contact_mJ = guide_mJ + effects_mJ;
    effects.Release();
  }
  edge.set_stride(stride);
  faces.set_stride(stride);
  const bool may = fidelity == Fidelity::kSlab && slab.applies() && in.rpm != 0;
  if (may && !slab.active() && teeth > kMinTeeth && glm::length(f_cut_T) > kMinThrust_N) {
    slab.Begin(X_WT, f_cut_T, teeth, u);
  }
  if (slab.active()) {
    if (may && slab.CalcDepth(X_WT) > 0) {
      blend = std::max(0.0, blend - in.dt_s / kBlend_s);
    } else if (path.empty()) {
      blend = std::min(1.0, blend + in.dt_s / kBlend_s);
    }
    bone_fraction = blend * blend * (3 - 2 * blend);  // smooth at both ends
    if (blend == 1) EndSlab();
  }
  const bool is_slab = slab.active() && may && bone_fraction == 0;
  if (!is_slab && !path.forgotten()) {
    // Complete the path up to this pose. Nothing is added once the spindle is stopped, because the saw is then held.
    if (in.rpm != 0 || (slab.active() && !slab.stopped())) path.Record(X_WT, 0);
    CutPath(out);
  }
  if (in.rpm == 0) {
    slab.Stop(X_WT);
  } else {
    slab.Turn();
  }
  if (slab.active() && !is_slab) out.status |= kCoupledBlending;
  out.fidelity = is_slab ? Fidelity::kSlab : stride == 2 ? Fidelity::kCoarse : Fidelity::kFull;
}

/// Performs the pending removal (CoupledParams::carve_interval_ticks).
void CoupledSimulation::State::CutWaiting(CoupledOutput& out) {
  const Cutter::Result cut = paced.Flush(X_WT);
  out.removed_mm3 += cut.removed_mm3;
  if (cut.out_of_leaves) out.status |= kCoupledLeavesUsedUp;
}

/// Removes a part of the bone that the slab law has passed.
void CoupledSimulation::State::CutPath(CoupledOutput& out) {
  Pose from, to;
  cutter.Lift();
  for (int n = 0; n < kCutsOfPath && path.Next(params.tool, h, from, to); ++n) {
    const Cutter::Result cut = cutter.Cut(from, to);
    out.removed_mm3 += cut.removed_mm3;
    if (cut.out_of_leaves) {
      out.status |= kCoupledLeavesUsedUp;
      path.PutBack();
      break;
    }
  }
  cutter.Lift();
}

/// Removes all bone that is pending or that the slab law has passed. Not tick-safe.
void CoupledSimulation::State::FinishPath() {
  while (paced.Flush(X_WT).out_of_leaves) field.Refill(std::max(params.spare_leaves, 1024));
  if (path.forgotten()) return;
  path.Record(X_WT, 0);
  CoupledOutput unused;
  while (!path.forgotten()) {
    unused.status = 0;
    CutPath(unused);
    if ((unused.status & kCoupledLeavesUsedUp) == 0) continue;
    field.Refill(std::max(params.spare_leaves, 1024));
  }
}

void CoupledSimulation::SetFidelity(Fidelity fidelity) {
  state_->fidelity = fidelity;
}
Fidelity CoupledSimulation::fidelity() const {
  return state_->fidelity;
}

}  // namespace kerf
