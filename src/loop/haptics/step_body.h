// Body of the loop that runs the haptic step.
#pragma once

#include <atomic>
#include <optional>

#include "bone/grid/changed_hash.h"
#include "loop/haptics/guarded_device.h"
#include "loop/haptics/loop_body.h"
#include "loop/haptics/piece_exchange.h"
#include "loop/haptics/restore_exchange.h"

namespace kerf {

/// Called before each tick, in the loop thread, for something that moves with the loop but is not part of it, such as a
/// simulated hand.
class HandDriver {
 public:
  virtual ~HandDriver() = default;
  /// Tick-safe.
  virtual void Advance(double dt_s) noexcept = 0;
  /// Called before Advance() with the tool's pose after the last tick, whether bone or an effect exerted a force on it,
  /// and whether the spindle turned. Tick-safe.
  virtual void Follow(const Pose& /*X_WT*/, bool /*touches*/, bool /*turns*/) noexcept {}
  /// Returns true if Place() is possible. It is not if something else determines the handle's pose, such as a path.
  virtual bool can_place() const { return false; }
  /// Moves the hand and the handle to X_WH, where they rest. Tick-safe.
  virtual void Place(const Pose& /*X_WH*/) noexcept {}
  /// False if the user has let go of the tool, as of the last Advance() or Place(). Tick-safe.
  virtual bool holds() const noexcept { return true; }
};

/// Returns true if something exerts a force on the tool, so that the hand feels a load. Tick-safe.
bool Touches(const CoupledOutput& out);

struct StepBodyParams {
  ForceMapParams force_map;
  double rpm = 7500;
  double period_s = 0.001;  // period of the loop: the time used for the slew limit, even after missed ticks
  double give_up_s = 1;     // if the device fails for longer than this, the loop ends
};

class StepBody final : public LoopBody {
 public:
  /// All references must outlive this object; `before` is optional. Throws kerf::Error if a parameter of the force map
  /// is out of range.
  StepBody(CoupledSimulation& simulation, GuardedDevice& device, const StepBodyParams& params,
           HandDriver* before = nullptr);
  /// Sets the exchange for pieces, which leave the bone between ticks; null: none. Call before the loop starts.
  void set_pieces(PieceExchange* pieces) { pieces_ = pieces; }

  /// Sets the exchange for checkpoints, undo and redo, which happen between ticks; null: none. Call before the loop
  /// starts. The simulation must keep a history.
  void set_restores(RestoreExchange* restores) { restores_ = restores; }
  /// Sets a hash that is updated with the changed voxels of each tick; null: none. Call before the loop starts.
  void set_hash(ChangedHash* hash) { hash_ = hash; }
  /// Takes effect from the next tick on. Tick-safe. May be called by any thread.
  void set_rpm(double rpm) { rpm_.store(rpm, std::memory_order_relaxed); }

  bool Tick(double dt_s, TickObserver& observer, LoopTick& tick) override;
  std::size_t channel_count() const override;
  void ReportChannels(std::span<double> channels) const override;
  void RampIn() override { force_off_ = true; }
  void SetFidelity(Fidelity fidelity) override { simulation_.SetFidelity(fidelity); }
  int changed_count() const override { return simulation_.changed_count(); }
  ChangedLeaf changed(int i) const override { return simulation_.changed(i); }
  void ClearChanged(int first) override;

  /// Returns true if the exchange's motions of the tool are possible.
  bool can_place() const { return before_ != nullptr && before_->can_place(); }
  /// Call in the loop thread, or after the loop has ended.
  const HapticStep& step() const { return step_; }

 private:
  CoupledSimulation& simulation_;
  GuardedDevice& device_;
  StepBodyParams params_;
  std::atomic<double> rpm_;
  HandDriver* before_;
  PieceExchange* pieces_ = nullptr;
  RestoreExchange* restores_ = nullptr;
  ChangedHash* hash_ = nullptr;
  HapticStep step_;
  bool force_off_ = false;
  double failed_s_ = 0;
  std::optional<Pose> X_WT_;  // tool pose after the last tick
  bool touches_ = false;      // a force acted on the tool in the last tick
  bool turns_ = false;        // the spindle turned in the last tick
};

}  // namespace kerf
