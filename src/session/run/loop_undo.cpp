#include "session/run/loop_undo.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

#include "cut/hand_sim/internals.h"
#include "kerf/error.h"

namespace kerf {

LoopAction ParseLoopAction(const std::string& text, const Range& rates) {
  const auto fail = [&] {
    throw Error(
        fmt::format("\"{}\" is not an action; write TIME:checkpoint=NAME, TIME:undo, TIME:undo=NAME, TIME:redo or "
                    "TIME:rpm=SPEED, TIME in s",
                    text));
  };
  LoopAction action;
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) fail();
  const auto [end, error] = std::from_chars(text.data(), text.data() + colon, action.at_s);
  if (error != std::errc{} || end != text.data() + colon || !kSessionTimeRange_s.Contains(action.at_s)) fail();
  const std::size_t equals = text.find('=', colon);
  const std::string word = text.substr(colon + 1, equals == std::string::npos ? equals : equals - colon - 1);
  if (equals != std::string::npos) action.name = text.substr(equals + 1);
  const bool named = equals != std::string::npos;
  if (word == "checkpoint" && !action.name.empty()) {
    action.kind = LoopAction::Kind::kCheckpoint;
  } else if (word == "undo" && named == !action.name.empty()) {
    action.kind = LoopAction::Kind::kUndo;
  } else if (word == "redo" && !named) {
    action.kind = LoopAction::Kind::kRedo;
  } else if (word == "rpm" && named) {
    action.kind = LoopAction::Kind::kSpindle;
    const auto [stop, fault] = std::from_chars(action.name.data(), action.name.data() + action.name.size(), action.rpm);
    if (fault != std::errc{} || stop != action.name.data() + action.name.size()) fail();
    CheckRange("rpm", action.rpm, rates, fmt::format("\"{}\"", text));
  } else {
    fail();
  }
  return action;
}

LoopUndo::LoopUndo(CoupledSimulation& simulation, double max_MB, ToolMover* mover)
    : simulation_(simulation), mover_(mover), journal_(KeepHistory(simulation), UndoParams{.max_MB = max_MB}) {
  if (mover_ != nullptr) at_[0] = MakeState();
}

/// Prepares an undo or redo, and the motion of the tool that follows it.
UndoJob* LoopUndo::Prepare(const LoopAction& action) {
  const bool redo = action.kind == LoopAction::Kind::kRedo;
  journal_.Drain();
  if (!journal_.CanRedo()) undone_.clear();
  UndoJob* job = redo ? journal_.PrepareRedo()
                      : journal_.PrepareUndo(action.name.empty() ? journal_.FindOneBack() : journal_.Find(action.name));
  goal_.reset();
  if (mover_ == nullptr) return job;
  before_ = MakeState();
  if (redo && !undone_.empty()) goal_ = undone_.back();
  if (const auto at = at_.find(job->number); !redo && at != at_.end()) goal_ = at->second;
  retracting_.reset();
  if (can_move()) carry_ = std::make_unique<CarryJob>();
  return job;
}

void LoopUndo::FinishRestore(bool redo) {
  ++restores_;
  pending_.reset();
  if (mover_ == nullptr) return;
  restored_mm3_.reset();
  if (goal_) {
    const double put_back_mm3 = before_.removed_mm3 - goal_->removed_mm3;
    put_back_mm3_ += put_back_mm3;
    restored_mm3_ = std::abs(put_back_mm3);
  }
  if (!redo) {
    undone_.push_back(before_);
  } else if (!undone_.empty()) {
    undone_.pop_back();
  }
}

void LoopUndo::Send(UndoJob& job) {
  if (!exchange_.Send(job, carry_.get())) throw Error("more actions were requested than the loop can queue");
}

bool LoopUndo::Do(const LoopAction& action, const RecordRequest& record_request) {
  if (!is_idle()) return false;
  if (action.kind == LoopAction::Kind::kCheckpoint) {
    const std::uint32_t number = journal_.Name(action.name);
    record_request("checkpoint", action.name, number);
    if (!exchange_.RequestCheckpoint(number)) throw Error("more actions were requested than the loop can queue");
    pending_checkpoint_ = number;
    if (mover_ != nullptr) at_[number] = MakeState();
    return true;
  }
  if (action.kind == LoopAction::Kind::kRetract) {
    if (!can_move()) throw Error("the saw can't be retracted, because its path or the device determines where it is");
    record_request("retract", action.name, 0);
    retracting_ = action;
    carry_ = std::make_unique<CarryJob>();
    if (!exchange_.Send(*carry_)) throw Error("more actions were requested than the loop can queue");
    return true;
  }
  UndoJob* job = Prepare(action);
  record_request(action.kind == LoopAction::Kind::kRedo ? "redo" : "undo", action.name, job->number);
  pending_ = action;
  supplied_ = false;
  Send(*job);
  return true;
}

void LoopUndo::PollCarry() {
  if (carry_ == nullptr) return;
  const CarryJob::State state = carry_->state.load(std::memory_order_acquire);
  if (state == CarryJob::State::kDone) {
    carry_.reset();
  } else if (state == CarryJob::State::kHeld) {
    std::optional<std::vector<Pose>> poses =
        retracting_ ? mover_->FindRetraction(retracting_->X_to) : mover_->FindReturn(goal_.value_or(before_).X_WT);
    if (!poses) return;
    carry_->poses = std::move(*poses);
    carry_->state.store(CarryJob::State::kReady, std::memory_order_release);
  }
}

bool LoopUndo::Poll() {
  if (const UndoJob* job = journal_.job()) {
    const RestoreJob::State state = job->state.load(std::memory_order_acquire);
    if (state == RestoreJob::State::kWaiting || state == RestoreJob::State::kRunning) return false;
    const std::string why = WhyRefused(state);
    const bool redo = job->redo;
    const auto leaves = static_cast<int>(job->leaves.size());
    if (journal_.Finish()) {
      FinishRestore(redo);
      journal_.Drain();
      return true;
    }
    carry_.reset();
    if (state == RestoreJob::State::kNoLeaves && !std::exchange(supplied_, true)) {
      SupplyLeaves(simulation_, 2 * leaves);
    } else if (state != RestoreJob::State::kChanged) {
      throw Error(why);
    }
    Send(*Prepare(LoopAction(*pending_)));
    return false;
  }
  PollCarry();
  journal_.Drain();
  if (pending_checkpoint_ != 0) {
    const std::vector<UndoCheckpoint> made = journal_.checkpoints();
    // The requested checkpoint is the latest; if memory is short, it may already have been dropped.
    if (!made.empty() && made.back().number >= pending_checkpoint_) pending_checkpoint_ = 0;
  }
  return false;
}

void LoopUndo::Repeat(const RecordedStep& step, const std::vector<RecordedEvent>& names) {
  Poll();
  if ((step.flags & kRecordedCarried) != 0) exchange_.Repeat(step.X);
  if ((step.flags & kRecordedCheckpoint) != 0) {
    std::string name = "checkpoint";
    for (const RecordedEvent& event : names) {
      if (event.what == "checkpoint" && event.number == step.checkpoint) name = event.name;
    }
    const std::uint32_t number = journal_.Name(name);
    pending_checkpoint_ = number;
    if (mover_ != nullptr) at_[number] = MakeState();
    if (number != step.checkpoint || !exchange_.RequestCheckpoint(number)) {
      throw Error(fmt::format("the recording's checkpoint {} can't be repeated", step.checkpoint));
    }
  } else if ((step.flags & (kRecordedUndo | kRecordedRedo)) != 0) {
    journal_.Drain();
    const bool redo = (step.flags & kRecordedRedo) != 0;
    UndoJob* job = redo ? journal_.PrepareRedo() : journal_.PrepareUndo(step.checkpoint);
    SupplyLeaves(simulation_, 2 * static_cast<int>(job->leaves.size()));
    if (!exchange_.Send(*job)) throw Error("the recording's undo can't be repeated");
  }
}

}  // namespace kerf
