#include "session/run/replay_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/core/hash.h"
#include "kerf/error.h"
#include "session/run/session_recorder.h"

namespace kerf {
namespace {

// Tolerance for a time that is a sum of many steps.
constexpr double kSameTime_s = 1e-9;

constexpr std::uint32_t kBetweenTicks = kRecordedPieceLeaves | kRecordedCheckpoint | kRecordedUndo | kRecordedRedo;
constexpr std::uint32_t kReported = kBetweenTicks | kRecordedTakenUp;
// Flags that are results of a tick.
constexpr std::uint32_t kCompared =
    kRecordedReadFailed | kRecordedWriteFailed | kRecordedForceOff | kRecordedPieceLeaves;

}  // namespace

bool ReplayDevice::Read(DeviceSample& sample) noexcept {
  if (handed_over_) return behind_.Read(sample);
  sample.X_WH = step_.X;
  sample.buttons = step_.buttons;
  return (step_.flags & kRecordedReadFailed) == 0;
}

bool ReplayDevice::Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept {
  const bool wrote = behind_.Write(f_H_W_N, tau_H_W_Nmm);
  return handed_over_ ? wrote : (step_.flags & kRecordedWriteFailed) == 0;
}

RecordedSteps::RecordedSteps(RecordingReader& reader, double until_s) : reader_(reader), until_s_(until_s) {}

const RecordedStep* RecordedSteps::Peek() {
  if (step_ >= reader_.damage().whole_steps) return nullptr;
  while (at_ == block_.steps.size()) {
    if (!reader_.ReadBlock(blocks_, block_)) return nullptr;
    ++blocks_;
    at_ = 0;
  }
  const RecordedStep& next = block_.steps[at_];
  const bool set_down = (next.flags & kRecordedSetDown) != 0;
  if (!set_down && time_s_ + CalcElapsed(next, reader_.header().rate_hz) > until_s_ + kSameTime_s) return nullptr;
  return &next;
}

void RecordedSteps::Pop() {
  const RecordedStep& step = block_.steps[at_++];
  ++step_;
  time_s_ += CalcElapsed(step, reader_.header().rate_hz);
}

namespace {

/// Returns the item for `step`; null if there is none. `items`: in the order of the steps.
template <typename T>
const T* FindAt(const std::vector<T>& items, std::uint64_t step) {
  const auto it =
      std::lower_bound(items.begin(), items.end(), step, [](const T& a, std::uint64_t b) { return a.step < b; });
  return it == items.end() || it->step != step ? nullptr : &*it;
}

}  // namespace

const RecordedState* RecordedSteps::FindState() const {
  return FindAt(block_.states, step_);
}
const RecordedHash* RecordedSteps::FindHash() const {
  return FindAt(block_.hashes, step_);
}

void CheckBone(const RecordingHeader& header, const Bone& bone) {
  if (const std::uint64_t hash = bone.CalcHash(); hash != header.bone_hash) {
    throw Error(fmt::format("the bone is not the one that was recorded: its hash is {:016x}, the recording's {:016x}",
                            hash, header.bone_hash));
  }
  if (bone.CalcMaterialHash() != header.material_hash) {
    throw Error("the bone is not the one that was recorded: it has the same voxels, but different materials");
  }
}

void CheckEnd(const RecordingReader& recording, Replayed& replayed) {
  const std::optional<RecordingEnd>& end = recording.end();
  if (replayed.divergence || !end || replayed.steps != end->steps) return;
  const char* what = end->bone_hash && *end->bone_hash != replayed.bone_hash ? "the bone at the end"
                     : end->voxel_hash != replayed.voxel_hash                ? "the voxels at the end"
                     : end->force_hash != replayed.force_hash                ? "the hash of all forces"
                     : end->time_s != replayed.time_s                        ? "the time at the end"
                                                                             : nullptr;
  if (what != nullptr) replayed.divergence = {replayed.steps, replayed.time_s, what};
}

void ReplayCheck::Expect(const RecordedSteps& steps, const RecordedStep& step) {
  number_ = steps.step();
  step_ = step;
  const RecordedState* state = steps.FindState();
  const RecordedHash* hash = steps.FindHash();
  state_ = state != nullptr ? std::optional(*state) : std::nullopt;
  hash_ = hash != nullptr ? std::optional(*hash) : std::nullopt;
  const std::string wrong = events_.Take(step, number_, steps.time_s());
  if (!wrong.empty()) Diverge(steps.time_s(), wrong);
  // A set-down has no state or hash.
  const bool set_down = (step.flags & kRecordedSetDown) != 0;
  const auto is_due = [&](int every) { return !set_down && (number_ + 1) % static_cast<std::uint64_t>(every) == 0; };
  const RecordingHeader& header = recording_.header();
  if (state_.has_value() != is_due(header.state_every_steps)) {
    Diverge(steps.time_s(), state_ ? "an extra row of states" : "a row of states is missing");
  }
  if (hash_.has_value() != is_due(header.hash_every_steps)) {
    Diverge(steps.time_s(), hash_ ? "extra hashes" : "hashes are missing");
  }
}

void ReplayCheck::Diverge(double time_s, const std::string& what) {
  if (!divergence_) divergence_ = {number_, time_s, what};
}

void ReplayCheck::Compare(const TickToRecord& actual, double time_s) {
  force_hash_ = MixHash(force_hash_ ^ actual.hash);
  voxel_hash_ = actual.voxel_hash;
  removed_mm3_ += actual.state.removed_mm3;
  if (divergence_) return;
  if (const std::string what = FindDifference(actual, time_s); !what.empty()) Diverge(time_s, what);
}

std::string ReplayCheck::FindDifference(const TickToRecord& actual, double time_s) const {
  const RecordedStep& step = actual.step;
  const std::uint16_t mask = MaskOf(recording_.header().check_bits);
  const bool forces = (step.force_check & mask) != step_.force_check || (hash_ && hash_->force != force_hash_);
  const bool voxels = (step.bone_check & mask) != step_.bone_check || (hash_ && hash_->bone != voxel_hash_);
  if (forces || voxels) {
    std::string what = forces && voxels ? "the forces (or the tool's pose) and the voxels"
                       : forces         ? "the forces or the tool's pose"
                                        : "the voxels";
    if (!forces || !state_) return what;
    const Vec3& now = actual.state.f_N;
    return what + fmt::format("; force recorded {:.3f} {:.3f} {:.3f} N, now {:.3f} {:.3f} {:.3f} N", state_->f_N.x,
                              state_->f_N.y, state_->f_N.z, now.x, now.y, now.z);
  }
  if (((step.flags ^ step_.flags) & kCompared) != 0) return "an event outside the tick";
  if (!state_) return "";
  RecordedState now = actual.state;
  now.time_s = time_s;
  now.removed_mm3 = removed_mm3_;
  const std::string difference = DescribeDifference(*state_, now);
  return difference.empty() ? "" : fmt::format("the row of states of {:.3f} s: {}", time_s, difference);
}

ReplayBody::ReplayBody(StepBody& body, CoupledSimulation& simulation, ReplayDevice& device, RecordedSteps& steps,
                       std::function<void(const RecordedStep&)> between_ticks)
    : body_(body),
      simulation_(simulation),
      device_(device),
      steps_(steps),
      between_ticks_(std::move(between_ticks)),
      check_(steps.recording()) {}

bool ReplayBody::Prepare() {
  if (done_) check_.Compare(MakeTickToRecord(*done_), steps_.time_s());
  done_.reset();
  while (const RecordedStep* next = steps_.Peek()) {
    step_ = *next;
    check_.Expect(steps_, step_);
    steps_.Pop();
    if ((step_.flags & kRecordedSetDown) != 0) {
      simulation_.SetDown(step_.X);
      continue;
    }
    device_.Give(step_);
    if ((step_.flags & kReported) != 0) between_ticks_(step_);
    return true;
  }
  return false;
}

bool ReplayBody::Tick(double dt_s, TickObserver& observer, LoopTick& report) {
  if (handed_over_) {
    const bool good = body_.Tick(dt_s, observer, report);
    report.inputs.taken_up = std::exchange(first_, false);
    return good;
  }
  if ((step_.flags & kRecordedForceOff) != 0) body_.RampIn();
  const auto fidelity = static_cast<Fidelity>(step_.fidelity);
  if (simulation_.fidelity() != fidelity) body_.SetFidelity(fidelity);
  body_.set_rpm(step_.rpm);
  body_.Tick(step_.dt_s, observer, report);
  report.inputs.skipped = step_.skipped;
  report.inputs.taken_up = (step_.flags & kRecordedTakenUp) != 0;
  done_ = report;
  return true;
}

}  // namespace kerf
