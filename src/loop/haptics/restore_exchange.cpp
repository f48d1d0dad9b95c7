#include "loop/haptics/restore_exchange.h"
#include "cut/hand_sim/internals.h"

#include <utility>

namespace kerf {

const Pose* RestoreExchange::Begin(CoupledSimulation& simulation, const Pose* X_WT, bool wait, TickInputs& in) {
  if (!wait && !restore_.running() && carry_ == nullptr) BeginNext(simulation, in);
  const Pose* next = nullptr;
  if (repeated_) {
    next = &*repeated_;
  } else if (carry_ != nullptr && !restore_.running() && X_WT != nullptr) {
    next = FindNextPose(*X_WT);
  }
  moves_ = next != nullptr;
  // The force of the old place must not move the hand away from the new one.
  if (moves_) in.flags |= kRecordedCarried | kRecordedForceOff;
  return next;
}

const Pose* RestoreExchange::FindNextPose(const Pose& X_WT) {
  if (carry_->state.load(std::memory_order_acquire) != CarryJob::State::kReady) {
    X_held_ = X_WT;
    carry_->state.store(CarryJob::State::kHeld, std::memory_order_release);
    return &X_held_;
  }
  if (next_pose_ < carry_->poses.size()) {
    X_held_ = carry_->poses[next_pose_++];
    return &X_held_;
  }
  std::exchange(carry_, nullptr)->state.store(CarryJob::State::kDone, std::memory_order_release);
  return nullptr;
}

void RestoreExchange::BeginNext(CoupledSimulation& simulation, TickInputs& in) {
  const Request* next = ring_.Peek();
  if (next == nullptr) return;
  const Request request = *next;
  if (request.job == nullptr && request.carry == nullptr) {
    if (!MakeCheckpoint(simulation, request.checkpoint)) return;
    ring_.Pop();
    in.flags |= kRecordedCheckpoint;
    in.checkpoint = request.checkpoint;
    return;
  }
  ring_.Pop();
  if (request.job != nullptr) {
    // These are copied first, since the job may be destroyed as soon as its refusal is reported.
    const std::uint32_t flag = request.job->redo ? kRecordedRedo : kRecordedUndo;
    const std::uint32_t number = request.job->number;
    if (!restore_.Begin(simulation, *request.job)) return;
    in.flags |= flag;
    in.checkpoint = number;
  }
  carry_ = request.carry;
  next_pose_ = 0;
}

void RestoreExchange::Step(CoupledSimulation& simulation, const Pose* X_WT) {
  if (restore_.running()) {
    if (restore_.Step(simulation, leaves_per_tick_)) restore_.End(simulation, X_WT);
  } else if (moves_ && X_WT != nullptr) {
    Restore::SetDown(simulation, *X_WT);
  }
  moves_ = false;
  repeated_.reset();
}

}  // namespace kerf
