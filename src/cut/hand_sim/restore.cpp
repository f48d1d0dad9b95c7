#include "cut/hand_sim/restore.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "cut/hand_sim/internals.h"
#include "cut/hand_sim/state.h"

namespace kerf {

LeafHistory& CoupledInternals::KeepHistory(CoupledSimulation& simulation, int ring_leaves) {
  CoupledSimulation::State& s = *simulation.state_;
  if (s.history) return *s.history;
  s.history = std::make_unique<LeafHistory>(s.field, static_cast<std::size_t>(std::max(ring_leaves, 2)));
  s.field.set_history(s.history.get());
  s.history->Checkpoint(0, s.taken_out_mm3);
  return *s.history;
}

LeafHistory* CoupledInternals::History(CoupledSimulation& simulation) {
  return simulation.state_->history.get();
}

bool CoupledInternals::Checkpoint(CoupledSimulation& simulation, std::uint32_t number) {
  CoupledSimulation::State& s = *simulation.state_;
  if (!s.history) return false;
  CoupledOutput unused;
  s.CutWaiting(unused);
  return s.history->Checkpoint(number, s.taken_out_mm3);
}

const char* WhyRefused(RestoreJob::State state) {
  switch (state) {
    case RestoreJob::State::kChanged:
      return "the bone was cut in the meantime";
    case RestoreJob::State::kLost:
      return "not all of the cut could be recorded";
    case RestoreJob::State::kNoLeaves:
      return "too few leaves are reserved for the restored bone";
    case RestoreJob::State::kWaiting:
    case RestoreJob::State::kRunning:
    case RestoreJob::State::kDone:
      break;
  }
  return "";
}

/// Returns true if there is room for every leaf of the job. Leaves that changed since the job was made need no room:
/// they already have values of their own, and their old values are recorded.
bool Restore::HasRoom(const CoupledSimulation& simulation) const {
  const CoupledSimulation::State& s = *simulation.state_;
  Cutter::Need need;
  for (const RestoreJob::Leaf& leaf : job_->leaves) s.cutter.AddNeed(s.field.FromWorld(leaf.index), need);
  if (may_refill_) return !need.outside;
  return s.cutter.HasRoomFor(need);
}

bool Restore::Begin(CoupledSimulation& simulation, RestoreJob& job, bool may_refill) {
  job_ = &job;
  may_refill_ = may_refill;
  const auto refuse = [&](RestoreJob::State why) {
    job_ = nullptr;
    job.state.store(why, std::memory_order_release);
    return false;
  };
  LeafHistory* history = HistoryOf(simulation);
  if (history == nullptr || history->last_lost() != job.lost) return refuse(RestoreJob::State::kLost);
  const std::size_t more = history->pushed() - job.seen;
  if (job.redo ? more > 0 : more > job.spare.size()) return refuse(RestoreJob::State::kChanged);
  if (more > 0 && history->At(job.seen) == nullptr) return refuse(RestoreJob::State::kChanged);
  if (!HasRoom(simulation)) return refuse(RestoreJob::State::kNoLeaves);
  job.state.store(RestoreJob::State::kRunning, std::memory_order_relaxed);
  job.pushed = history->pushed();
  next_ = 0;
  at_begin_ = job.leaves.size();
  next_seen_ = job.seen;
  history->BeginRestore();
  return true;
}

void Restore::Swap(CoupledSimulation& simulation, const RestoreJob::Leaf& leaf) {
  CoupledSimulation::State& s = *simulation.state_;
  const LeafIndex index = s.field.FromWorld(leaf.index);
  if (s.cutter.Swap(index, leaf.values) || !may_refill_) return;
  s.field.Refill(std::max(s.params.spare_leaves, 1024));
  s.cutter.Swap(index, leaf.values);
}

bool Restore::Touch(CoupledSimulation& simulation, const std::array<int, 3>& index) {
  CoupledSimulation::State& s = *simulation.state_;
  return s.history->Touch(s.field.PlaceOf(s.field.FromWorld(index)));
}

bool Restore::Step(CoupledSimulation& simulation, std::size_t leaves) {
  RestoreJob& job = *job_;
  for (; next_ < at_begin_ && leaves > 0; ++next_, --leaves) {
    Touch(simulation, job.leaves[next_].index);
    Swap(simulation, job.leaves[next_]);
  }
  if (next_ < at_begin_) return false;
  // Then restore the leaves that changed since the job was made. For each leaf only the oldest values apply, and the
  // job's values are older than the history's.
  CoupledSimulation::State& s = *simulation.state_;
  for (; next_seen_ < job.pushed && leaves > 0; ++next_seen_) {
    const LeafBefore* found = s.history->At(next_seen_);
    if (found == nullptr || found->kind == LeafBefore::Kind::kCheckpoint || !Touch(simulation, found->index)) continue;
    const LeafBefore& before = *found;
    float* values = job.spare.back();
    job.spare.pop_back();
    if (before.kind == LeafBefore::Kind::kInside) {
      std::fill_n(values, BoneField::kLeafVoxels, s.history->inside_mm());
    } else {
      std::copy(before.values.begin(), before.values.end(), values);
    }
    job.leaves.push_back({before.index, values});
    Swap(simulation, job.leaves.back());
    --leaves;
  }
  return next_seen_ == job.pushed;
}

void Restore::End(CoupledSimulation& simulation, const Pose* X_WT) {
  CoupledSimulation::State& s = *simulation.state_;
  std::swap(s.taken_out_mm3, job_->taken_out_mm3);
  s.paced.Forget();  // pending removal belongs to the bone before the restore
  s.cutter.BoneRestored();
  s.effects.BoneRestored();
  SetDown(simulation, X_WT != nullptr && IsValid(*X_WT) && IsInWorld(X_WT->p_AB) ? *X_WT : s.World(s.X_WT));
  job_->epoch = s.history->EndRestore();
  job_->state.store(RestoreJob::State::kDone, std::memory_order_release);
  job_ = nullptr;
}

void Restore::SetDown(CoupledSimulation& simulation, const Pose& X_WT) {
  if (!IsValid(X_WT) || !IsInWorld(X_WT.p_AB)) return;
  CoupledSimulation::State& s = *simulation.state_;
  s.X_WH = s.Local(X_WT);
  simulation.SetDown(X_WT);
}

bool RunRestore(CoupledSimulation& simulation, RestoreJob& job, const Pose* X_WT) {
  Restore restore;
  if (!restore.Begin(simulation, job, true)) return false;
  restore.Step(simulation, std::numeric_limits<std::size_t>::max());
  restore.End(simulation, X_WT);
  return true;
}

}  // namespace kerf
