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
constexpr std::uint32_t kReported = kBetweenTicks | kRecordedTakenUp | kRecordedCarried;
// Flags that are results of a tick.
constexpr std::uint32_t kCompared =
    kRecordedReadFailed | kRecordedWriteFailed | kRecordedForceOff | kRecordedPieceLeaves;

/// Returns the item for `step`, if there is one. `items`: in the order of the steps.
template <typename T>
std::optional<T> FindAt(const std::vector<T>& items, std::uint64_t step) {
  const auto it =
      std::lower_bound(items.begin(), items.end(), step, [](const T& a, std::uint64_t b) { return a.step < b; });
  return it == items.end() || it->step != step ? std::nullopt : std::optional(*it);
}

}  // namespace

bool ReplayDevice::Read(DeviceSample& sample) noexcept {
  if (!step_) return device_ != nullptr && device_->Read(sample);
  sample.X_WH = step_->X;
  sample.buttons = step_->buttons;
  return (step_->flags & kRecordedReadFailed) == 0;
}

bool ReplayDevice::Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept {
  const bool wrote = device_ == nullptr || device_->Write(f_H_W_N, tau_H_W_Nmm);
  return step_ ? (step_->flags & kRecordedWriteFailed) == 0 : wrote;
}

void CheckReplays(const RecordingReader& recording, const Bone& bone) {
  const RecordingHeader& header = recording.header();
  if (!header.IsReplayable()) {
    const bool was_changed = !header.commit.empty() && header.commit.back() == '+';
    throw Error(fmt::format(
        "{}: the recording was made by kerf {} of commit {}{}, whose forces differ from those of this build; "
        "replay it with a build of that commit",
        recording.path(), header.version, header.commit.substr(0, 12), was_changed ? "+" : ""));
  }
  if (const std::uint64_t hash = bone.CalcHash(); hash != header.bone_hash) {
    throw Error(
        fmt::format("{}: the bone is not the one that was recorded: its hash is {:016x}, the recording's {:016x}",
                    recording.path(), hash, header.bone_hash));
  }
  if (bone.CalcMaterialHash() != header.material_hash) {
    throw Error(
        fmt::format("{}: the bone is not the one that was recorded: it has the same voxels, but different materials",
                    recording.path()));
  }
}

/// Returns the next step, null if there is none.
const RecordedStep* RecordedSteps::Find() {
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

const RecordedStep* RecordedSteps::Next() {
  const RecordedStep* next = Find();
  if (next == nullptr) return nullptr;
  expected_ = *next;
  Expect();
  ++at_;
  ++step_;
  time_s_ += CalcElapsed(expected_, reader_.header().rate_hz);
  return &expected_;
}

/// Finds what was recorded after the step, and checks that it is there where it is due.
void RecordedSteps::Expect() {
  state_ = FindAt(block_.states, step_);
  hash_ = FindAt(block_.hashes, step_);
  const std::string wrong = events_.Take(expected_, step_, time_s_);
  if (!wrong.empty()) Diverge(time_s_, wrong);
  // A set-down has no state or hash.
  const bool set_down = (expected_.flags & kRecordedSetDown) != 0;
  const auto is_due = [&](int every) { return !set_down && (step_ + 1) % static_cast<std::uint64_t>(every) == 0; };
  const RecordingHeader& header = reader_.header();
  if (state_.has_value() != is_due(header.state_every_steps)) {
    Diverge(time_s_, state_ ? "an extra row of states" : "a row of states is missing");
  }
  if (hash_.has_value() != is_due(header.hash_every_steps)) {
    Diverge(time_s_, hash_ ? "extra hashes" : "hashes are missing");
  }
}

void RecordedSteps::Diverge(double time_s, const std::string& what) {
  if (!divergence_) divergence_ = {step_, time_s, what};
}

void RecordedSteps::Compare(const TickToRecord& actual) {
  force_hash_ = MixHash(force_hash_ ^ actual.hash);
  voxel_hash_ = actual.voxel_hash;
  removed_mm3_ += actual.state.removed_mm3;
  if (divergence_) return;
  if (const std::string what = FindDifference(actual); !what.empty()) divergence_ = {step_ - 1, time_s_, what};
}

std::string RecordedSteps::FindDifference(const TickToRecord& actual) const {
  const RecordedStep& step = actual.step;
  const std::uint16_t mask = MaskOf(reader_.header().check_bits);
  const bool forces = (step.force_check & mask) != expected_.force_check || (hash_ && hash_->force != force_hash_);
  const bool voxels = (step.bone_check & mask) != expected_.bone_check || (hash_ && hash_->bone != voxel_hash_);
  if (forces || voxels) {
    std::string what = forces && voxels ? "the forces (or the tool's pose) and the voxels"
                       : forces         ? "the forces or the tool's pose"
                                        : "the voxels";
    if (!forces || !state_) return what;
    const Vec3& now = actual.state.f_N;
    return what + fmt::format("; force recorded {:.3f} {:.3f} {:.3f} N, now {:.3f} {:.3f} {:.3f} N", state_->f_N.x,
                              state_->f_N.y, state_->f_N.z, now.x, now.y, now.z);
  }
  if (((step.flags ^ expected_.flags) & kCompared) != 0) return "an event outside the tick";
  if (!state_) return "";
  RecordedState now = actual.state;
  now.time_s = time_s_;
  now.removed_mm3 = removed_mm3_;
  const std::string difference = DescribeDifference(*state_, now);
  return difference.empty() ? "" : fmt::format("the row of states of {:.3f} s: {}", time_s_, difference);
}

Replayed RecordedSteps::MakeReport(std::uint64_t bone_hash) const {
  Replayed replayed{step_, time_s_, divergence_, force_hash_, voxel_hash_, bone_hash};
  const std::optional<RecordingEnd>& end = reader_.end();
  if (divergence_ || !end || step_ != end->steps) return replayed;
  const char* what = end->bone_hash && *end->bone_hash != bone_hash ? "the bone at the end"
                     : end->voxel_hash != voxel_hash_               ? "the voxels at the end"
                     : end->force_hash != force_hash_               ? "the hash of all forces"
                     : end->time_s != time_s_                       ? "the time at the end"
                                                                    : nullptr;
  if (what != nullptr) replayed.divergence = {step_, time_s_, what};
  return replayed;
}

ReplayBody::ReplayBody(StepBody& body, CoupledSimulation& simulation, ReplayDevice& device, RecordingReader& recording,
                       double until_s, std::function<void(const RecordedStep&)> between_ticks)
    : body_(body),
      simulation_(simulation),
      device_(device),
      steps_(recording, until_s),
      between_ticks_(std::move(between_ticks)) {}

bool ReplayBody::Prepare() {
  if (done_) steps_.Compare(MakeTickToRecord(*done_));
  done_.reset();
  while (const RecordedStep* next = steps_.Next()) {
    step_ = *next;
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

void ReplayBody::HandOver() {
  device_.HandOver();
  handed_over_ = true;
}

bool ReplayBody::Tick(double dt_s, TickObserver& observer, LoopTick& tick) {
  if (handed_over_) {
    const bool good = body_.Tick(dt_s, observer, tick);
    if (std::exchange(first_, false)) tick.in.flags |= kRecordedTakenUp;
    return good;
  }
  if ((step_.flags & kRecordedForceOff) != 0) body_.RampIn();
  const auto fidelity = static_cast<Fidelity>(step_.fidelity);
  if (simulation_.fidelity() != fidelity) body_.SetFidelity(fidelity);
  body_.set_rpm(step_.rpm);
  body_.Tick(step_.dt_s, observer, tick);
  tick.in.skipped = step_.skipped;
  tick.in.flags |= step_.flags & kRecordedTakenUp;
  done_ = tick;
  return true;
}

}  // namespace kerf
