// How exactly a tick is worked out, and the way from one fidelity to another.
#include "cut/hand_sim/state.h"

namespace kerf {
namespace {

constexpr double kBlend_s = 0.2;      // from one law to the other
constexpr int kCutsOfPath = 4;        // in a tick, of what the slab has passed
constexpr double kLeastTeeth = 0.05;  // in a cut, to go on as a slab
constexpr double kLeastThrust_N = 0.05;

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

/// Takes the fidelity that is asked for, and passes from one law to the other.
void CoupledSimulation::State::StepFidelity(const CoupledInput& in, CoupledOutput& out) {
  const int stride = fidelity == Fidelity::kFull ? 1 : 2;
  if (stride != edge.stride()) {
    contact_mJ = guide_mJ + effects_mJ;
    effects.Release();
  }
  edge.set_stride(stride);
  faces.set_stride(stride);
  const bool may = fidelity == Fidelity::kSlab && is_disc && in.rpm != 0;
  if (may && !slab.active() && teeth > kLeastTeeth && glm::length(f_cut_T) > kLeastThrust_N) {
    slab.Begin(X_WT, f_cut_T, teeth, u);
  }
  if (slab.active()) {
    if (may && slab.CalcDepth(X_WT) > 0) {
      blend = std::max(0.0, blend - in.dt_s / kBlend_s);
    } else if (path.empty()) {
      blend = std::min(1.0, blend + in.dt_s / kBlend_s);
    }
    looked_share = blend * blend * (3 - 2 * blend);  // without a corner at either end
    if (blend == 1) EndSlab();
  }
  const bool is_slab = slab.active() && may && looked_share == 0;
  if (!is_slab && !path.forgotten()) {
    // Up to here, and no further once the spindle stands still: the saw is held then.
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

/// Removes what waits for its turn (CoupledParams::carve_interval_ticks).
void CoupledSimulation::State::CutWaiting(CoupledOutput& out) {
  const Cutter::Result cut = paced.Flush(X_WT);
  out.removed_mm3 += cut.removed_mm3;
  if (cut.out_of_leaves) out.status |= kCoupledLeavesUsedUp;
}

/// Removes some of what the slab has passed.
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

/// Removes all that waits or that the slab has passed. Not for the tick.
void CoupledSimulation::State::FinishPath() {
  while (paced.Flush(X_WT).out_of_leaves) {
    field.Refill(std::max(params.spare_leaves, 1024));
    cutter.Refill();
  }
  if (path.forgotten()) return;
  path.Record(X_WT, 0);
  CoupledOutput unused;
  while (!path.forgotten()) {
    unused.status = 0;
    CutPath(unused);
    if ((unused.status & kCoupledLeavesUsedUp) == 0) continue;
    field.Refill(std::max(params.spare_leaves, 1024));
    cutter.Refill();
  }
}

void CoupledSimulation::SetFidelity(Fidelity fidelity) {
  state_->fidelity = fidelity;
}
Fidelity CoupledSimulation::fidelity() const {
  return state_->fidelity;
}

}  // namespace kerf
