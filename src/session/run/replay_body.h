// Replays a recorded session in place of a device: the loop's ticks receive the recorded inputs.
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

/// Result of a replay.
struct Replayed {
  std::uint64_t steps = 0;
  double time_s = 0;
  std::optional<Divergence> divergence;
  std::uint64_t force_hash = 0;  // as in RecordingEnd
  std::uint64_t voxel_hash = 0;
  std::uint64_t bone_hash = 0;  // after the last step
};

/// Returns the recorded device data. The device behind it receives the recorded times and forces, so that a simulated
/// hand is in the right state when the recording ends.
class ReplayDevice final : public Device {
 public:
  /// `behind` must outlive this object; it supplies the profile.
  explicit ReplayDevice(Device& behind) : behind_(behind) {}

  void Give(const RecordedStep& step) { step_ = step; }
  /// From now on, calls go to the device behind it.
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

/// Device whose implementation is set later. Until then it returns no pose and accepts any force.
class DeviceSlot final : public Device {
 public:
  explicit DeviceSlot(const DeviceProfile& profile) : profile_(profile) {}
  /// Sets the device, before the loop runs. `device` must outlive this object.
  void set_device(Device& device) { device_ = &device; }

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

/// Iterates over the steps of a recording, with only one block of them in memory.
class RecordedSteps {
 public:
  const RecordingReader& recording() const { return reader_; }
  /// Iterates over the steps that end by `until_s`, but not beyond the first missing step. `reader` must outlive this
  /// object.
  RecordedSteps(RecordingReader& reader, double until_s);
  /// Returns the next step, null if there is none. Not tick-safe. Throws kerf::Error.
  const RecordedStep* Peek();
  void Pop();
  std::uint64_t step() const { return step_; }  // number of the next step
  double time_s() const { return time_s_; }     // time before it
  /// These return the state and the hash that were recorded after the next step; null if there is none.
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

/// Throws kerf::Error if the recording was made with a different bone.
void CheckBone(const RecordingHeader& header, const Bone& bone);
/// Checks that a complete replay ends like the recording. If not, sets the divergence.
void CheckEnd(const RecordingReader& recording, Replayed& replayed);

/// Compares the results of consecutive ticks with the recording: the checks and hashes of forces and voxels, the rows
/// of states, and the events.
class ReplayCheck {
 public:
  explicit ReplayCheck(const RecordingReader& recording) : recording_(recording), events_(recording) {}
  /// Sets the next step to be replayed, with the state and hash recorded after it.
  void Expect(const RecordedSteps& steps, const RecordedStep& step);
  /// `time_s`: time at the end of the step.
  void Compare(const TickToRecord& actual, double time_s);
  const std::optional<Divergence>& divergence() const { return divergence_; }  // the first
  std::uint64_t force_hash() const { return force_hash_; }
  std::uint64_t voxel_hash() const { return voxel_hash_; }

 private:
  std::string FindDifference(const TickToRecord& actual, double time_s) const;
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

/// Wraps the loop's body: sets the recorded inputs before each tick and compares the results afterwards.
class ReplayBody final : public LoopBody {
 public:
  /// All references must outlive this object. `between_ticks`: called between ticks for each step with a piece, a
  /// checkpoint, an undo, a redo or a continuation, before it is replayed.
  ReplayBody(StepBody& body, CoupledSimulation& simulation, ReplayDevice& device, RecordedSteps& steps,
             std::function<void(const RecordedStep&)> between_ticks);

  /// Call before each tick: takes the next step. Returns false if there is none.
  bool Prepare();
  /// From now on, the loop's calls are forwarded to the wrapped body.
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
  std::function<void(const RecordedStep&)> between_ticks_;
  bool handed_over_ = false;
  bool first_ = true;  // first tick after HandOver()
  RecordedStep step_;
  ReplayCheck check_;
  std::optional<LoopTick> done_;  // not compared yet
};

}  // namespace kerf
