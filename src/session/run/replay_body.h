// A recorded session in place of a device: the loop's ticks are given again what they were given.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/devices/device.h"
#include "loop/haptics/step_body.h"
#include "loop/record/recording.h"
#include "session/run/event_check.h"
#include "session/run/session_recorder.h"

namespace kerf {

/// What came of a recording that was gone through again.
struct Replayed {
  std::uint64_t steps = 0;
  double time_s = 0;
  std::optional<Divergence> divergence;
  std::uint64_t force_hash = 0;  // as RecordingEnd's
  std::uint64_t voxel_hash = 0;
  std::uint64_t bone_hash = 0;  // after its last step
};

/// Gives what was recorded; whatever device stands behind it is told of time and force as it was then, so that a
/// simulated hand is where it was when the recording ends.
class ReplayDevice final : public Device {
 public:
  /// `behind` must outlive it; it has the profile.
  explicit ReplayDevice(Device& behind) : behind_(behind) {}

  void Give(const RecordedStep& step) { step_ = step; }
  /// From here on it is the device behind.
  void HandOver() { handed_over_ = true; }

  const DeviceProfile& profile() const override { return behind_.profile(); }
  void Elapse(double dt_s) noexcept override { behind_.Elapse(dt_s); }
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;

 private:
  Device& behind_;
  RecordedStep step_;
  bool handed_over_ = false;
};

/// A device that comes later: until then it tells no pose and takes any force.
class LateDevice final : public Device {
 public:
  explicit LateDevice(const DeviceProfile& profile) : profile_(profile) {}
  /// Before the loop runs. It must outlive this.
  void Become(Device& device) { device_ = &device; }

  const DeviceProfile& profile() const override { return profile_; }
  void Elapse(double dt_s) noexcept override {
    if (device_ != nullptr) device_->Elapse(dt_s);
  }
  bool Read(DeviceSample& sample) noexcept override { return device_ != nullptr && device_->Read(sample); }
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override {
    return device_ == nullptr || device_->Write(f_H_W_N, tau_H_W_Nmm);
  }

 private:
  DeviceProfile profile_;
  Device* device_ = nullptr;
};

/// The recording's steps one by one, a block of them in memory.
class RecordedSteps {
 public:
  const RecordingReader& recording() const { return reader_; }
  /// Those that end by `until_s`, or before the first that is missing. The reader must outlive it.
  RecordedSteps(RecordingReader& reader, double until_s);
  /// The next one, null when there is none. Not tick-safe. Throws Error.
  const RecordedStep* Peek();
  void Pop();
  std::uint64_t step() const { return step_; }  // the number of the next
  double time_s() const { return time_s_; }     // before it
  /// Noted after the next one, if anything is.
  const RecordedState* FindState() const;
  const RecordedHash* FindHash() const;

 private:
  RecordingReader& reader_;
  double until_s_;
  RecordedBlock block_;
  std::size_t at_ = 0;
  std::size_t blocks_ = 0;
  std::uint64_t step_ = 0;
  double time_s_ = 0;
};

/// Throws Error when the recording was made of another bone.
void CheckBone(const RecordingHead& head, const Bone& bone);
/// What was gone through to its end ends as it did; else that is a divergence too.
void CheckEnd(const RecordingReader& recording, Replayed& replayed);

/// Holds what comes out of one tick after another against what was recorded: the checks and hashes of forces and
/// voxels, the rows of states, and the events.
class ReplayCheck {
 public:
  explicit ReplayCheck(const RecordingReader& recording) : recording_(recording), events_(recording) {}
  /// The next step that is gone through, with what is noted after it.
  void Expect(const RecordedSteps& steps, const RecordedStep& step);
  /// `time_s`: at its end.
  void Compare(const TickToRecord& came, double time_s);
  const std::optional<Divergence>& divergence() const { return divergence_; }  // the first
  std::uint64_t force_hash() const { return force_hash_; }
  std::uint64_t voxel_hash() const { return voxel_hash_; }

 private:
  std::string FindDifference(const TickToRecord& came, double time_s) const;
  void Diverge(double time_s, const std::string& what);

  const RecordingReader& recording_;
  EventCheck events_;
  std::uint64_t number_ = 0;
  RecordedStep step_;
  std::optional<RecordedState> state_;
  std::optional<RecordedHash> hash_;
  std::optional<Divergence> divergence_;
  std::uint64_t force_hash_ = 0;
  std::uint64_t voxel_hash_ = 0;
  double removed_mm3_ = 0;
};

/// Between the loop and its body: before each tick it puts things as they were, after it looks whether the same came
/// out.
class ReplayBody final : public LoopBody {
 public:
  /// All must outlive it. `beside`: told, between ticks, of each step with a piece, a checkpoint, an undo, a redo or a
  /// taking up before it is gone through.
  ReplayBody(StepBody& body, CoupledSimulation& simulation, ReplayDevice& device, RecordedSteps& steps,
             std::function<void(const RecordedStep&)> beside);

  /// Between ticks, before each: takes what is next. False: there is no more.
  bool Prepare();
  /// From here on it passes on what the loop says.
  void HandOver() { handed_over_ = true; }
  const ReplayCheck& check() const { return check_; }
  double time_s() const { return steps_.time_s(); }
  std::uint64_t step() const { return steps_.step(); }

  bool Tick(double dt_s, TickObserver& observer, LoopTick& report) override;
  std::size_t channel_count() const override { return body_.channel_count(); }
  void ReportChannels(std::span<double> channels) const override { body_.ReportChannels(channels); }
  void RampIn() override {
    if (handed_over_) body_.RampIn();
  }
  void SetFidelity(Fidelity fidelity) override {
    if (handed_over_) body_.SetFidelity(fidelity);
  }
  int changed_count() const override { return body_.changed_count(); }
  ChangedLeaf changed(int i) const override { return body_.changed(i); }
  void ClearChanged() override { body_.ClearChanged(); }

 private:
  StepBody& body_;
  CoupledSimulation& simulation_;
  ReplayDevice& device_;
  RecordedSteps& steps_;
  std::function<void(const RecordedStep&)> beside_;
  bool handed_over_ = false;
  bool first_ = true;  // after that
  RecordedStep step_;
  ReplayCheck check_;
  std::optional<LoopTick> done_;  // not looked at yet
};

}  // namespace kerf
