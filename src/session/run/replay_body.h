// Replays a recorded session in place of a device: the loop's ticks receive the recorded inputs.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "kerf/device.h"
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

/// Device in front of another one. During a replay it returns the recorded data; the device behind it receives the
/// recorded times and the forces, so that a simulated hand is in the right state when the recording ends.
class ReplayDevice final : public Device {
 public:
  explicit ReplayDevice(const DeviceProfile& profile) : profile_(profile) {}
  /// Sets the device behind this one, before the loop runs; until then it returns no pose and accepts any force.
  /// `device` must outlive this object.
  void set_device(Device& device) { device_ = &device; }

  /// Sets the step that is replayed.
  void Give(const RecordedStep& step) { step_ = step; }
  /// From now on, calls go to the device behind it.
  void HandOver() { step_.reset(); }

  const DeviceProfile& profile() const override { return profile_; }
  void Elapse(double dt_s) noexcept override {
    if (device_ != nullptr) device_->Elapse(dt_s);
  }
  bool Read(DeviceSample& sample) noexcept override;
  bool Write(const Vec3& f_H_W_N, const Vec3& tau_H_W_Nmm) noexcept override;
  void TakeToolPose(const Pose& X_WT) noexcept override {
    if (device_ != nullptr) device_->TakeToolPose(X_WT);
  }

 private:
  DeviceProfile profile_;
  Device* device_ = nullptr;
  std::optional<RecordedStep> step_;
};

/// Throws kerf::Error if the recording was made with a different bone, or by a version of kerf that computes other
/// bits.
void CheckReplays(const RecordingReader& recording, const Bone& bone);

/// Supplies the steps of a recording, with only one block of them in memory, and compares the results of their ticks
/// with it: the checks and hashes of forces and voxels, the rows of states, and the events.
class RecordedSteps {
 public:
  /// Supplies the steps that end by `until_s`, but not beyond the first missing one. `reader` must outlive this object.
  RecordedSteps(RecordingReader& reader, double until_s) : reader_(reader), until_s_(until_s), events_(reader) {}
  const RecordingReader& recording() const { return reader_; }

  /// Returns the next step, null if there is none. Not tick-safe. Throws kerf::Error.
  const RecordedStep* Next();
  /// Compares the result of the step that Next() has returned.
  void Compare(const TickToRecord& actual);

  std::uint64_t step() const { return step_; }  // number of steps that Next() has returned
  double time_s() const { return time_s_; }     // time at their end
  const std::optional<Divergence>& divergence() const { return divergence_; }  // the first
  /// `bone_hash`: after the last step. A complete replay must also end like the recording.
  Replayed MakeReport(std::uint64_t bone_hash) const;

 private:
  const RecordedStep* Find();
  void Expect();
  std::string FindDifference(const TickToRecord& actual) const;
  void Diverge(double time_s, const std::string& what);

  RecordingReader& reader_;
  double until_s_;
  RecordedBlock block_;
  std::size_t at_ = 0;
  std::size_t blocks_ = 0;
  std::uint64_t step_ = 0;
  double time_s_ = 0;

  // The step that is expected now, and what was recorded after it.
  RecordedStep expected_;
  std::optional<RecordedState> state_;
  std::optional<RecordedHash> hash_;
  EventCheck events_;
  std::optional<Divergence> divergence_;
  std::uint64_t force_hash_ = 0;
  std::uint64_t voxel_hash_ = 0;
  double removed_mm3_ = 0;
};

/// Wraps the loop's body: sets the recorded inputs before each tick and compares the results afterwards.
class ReplayBody final : public LoopBody {
 public:
  /// All references must outlive this object. `until_s`: as in RecordedSteps. `between_ticks`: called between ticks for
  /// each step with a piece, a checkpoint, an undo, a redo or a continuation, before it is replayed.
  ReplayBody(StepBody& body, CoupledSimulation& simulation, ReplayDevice& device, RecordingReader& recording,
             double until_s, std::function<void(const RecordedStep&)> between_ticks);

  /// Call before each tick: takes the next step. Returns false if there is none.
  bool Prepare();
  /// From now on, the loop's calls reach the wrapped body, and its calls reach the device behind the recorded one.
  void HandOver();
  const RecordedSteps& steps() const { return steps_; }

  bool Tick(double dt_s, TickObserver& observer, LoopTick& tick) override;
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
  void ClearChanged(int first) override { body_.ClearChanged(first); }

 private:
  StepBody& body_;
  CoupledSimulation& simulation_;
  ReplayDevice& device_;
  RecordedSteps steps_;
  std::function<void(const RecordedStep&)> between_ticks_;
  bool handed_over_ = false;
  bool first_ = true;  // first tick after HandOver()
  RecordedStep step_;
  std::optional<LoopTick> done_;  // not compared yet
};

}  // namespace kerf
