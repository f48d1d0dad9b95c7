#include "cut/hand_sim/take_out.h"

#include "cut/hand_sim/state.h"

namespace kerf {
bool CoupledSimulation::IsClearOf(const Box3& bounds_W) const {
  const State& s = *state_;
  return !s.slab.active() && IsToolClearOf(bounds_W, s.World(s.X_WT).p_AB, s.shape.reach_mm, s.h);
}

bool CoupledSimulation::Replace(const std::array<int, 3>& index, const float* from, const float* to) {
  return state_->cutter.Replace(state_->field.FromWorld(index), from, to);
}

void CoupledSimulation::AddTakenOut(const std::array<double, 256>& mm3, double sign) {
  for (std::size_t id = 0; id < mm3.size(); ++id) state_->taken_out_mm3[id] += sign * mm3[id];
}

void TakeOut::Leave() {
  if (place_ != PiecePlace::kOut) place_ = PiecePlace::kLeaving;
}
void TakeOut::Return() {
  if (place_ != PiecePlace::kHeld) place_ = PiecePlace::kReturning;
}

bool TakeOut::Step(CoupledSimulation& simulation, std::size_t leaves) {
  waits_for_tool_ = false;
  if (place_ == PiecePlace::kHeld || place_ == PiecePlace::kOut) return true;
  if (!simulation.IsClearOf(removal_.bounds_W)) {
    waits_for_tool_ = true;
    return false;
  }
  const bool leaving = place_ == PiecePlace::kLeaving;
  const std::size_t end = leaving ? removal_.leaves.size() : 0;
  for (std::size_t n = 0; n < leaves && out_ != end; ++n) {
    const LeafChange& change = removal_.leaves[leaving ? out_ : out_ - 1];
    const float* with = change.with.data();
    const float* without = change.without.data();
    // SupplyLeaves() or CoupledSimulation::Refill() provides the leaves that are missing.
    if (!simulation.Replace(change.index, leaving ? with : without, leaving ? without : with)) return false;
    out_ = leaving ? out_ + 1 : out_ - 1;
  }
  if (out_ != end) return false;
  if (counted_ != leaving) simulation.AddTakenOut(removal_.mm3, leaving ? 1 : -1);
  counted_ = leaving;
  place_ = leaving ? PiecePlace::kOut : PiecePlace::kHeld;
  return true;
}

}  // namespace kerf
