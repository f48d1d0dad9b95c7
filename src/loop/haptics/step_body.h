// The haptic step as the loop's body.
#pragma once

#include <atomic>
#include <optional>

#include "bone/grid/changed_hash.h"
#include "loop/haptics/guarded_device.h"
#include "loop/haptics/haptic_step.h"
#include "loop/haptics/loop_body.h"
#include "loop/haptics/piece_exchange.h"
#include "loop/haptics/restore_exchange.h"

namespace kerf {

/// Told before each tick, in the loop's thread: what moves with the loop but is no part of it, as a simulated hand.
class BeforeTick {
 public:
  virtual ~BeforeTick() = default;
  /// Tick-safe.
  virtual void Advance(double dt_s) noexcept = 0;
};

struct StepBodyParams {
  ForceMapParams force_map;
  double rpm = 7500;
  double period_s = 0.001;  // of the loop: the force's slew in a tick, however many were missed before it
  double give_up_s = 1;     // a device that fails for so long ends the loop
};

class StepBody final : public LoopBody {
 public:
  /// All must outlive it; `before` may be null. Throws Error for a parameter of the force map out of range.
  StepBody(CoupledSimulation& simulation, GuardedDevice& device, const StepBodyParams& params,
           BeforeTick* before = nullptr);
  /// Pieces that leave the bone between ticks; null: none do. Before the loop begins.
  void set_pieces(PieceExchange* pieces) { pieces_ = pieces; }

  /// Checkpoints, undo and redo between ticks; null: none. Before the loop begins. The simulation keeps a history.
  void set_restores(RestoreExchange* restores) { restores_ = restores; }
  /// Kept up to date with the voxels that change, tick by tick; null: nobody needs it. Before the loop begins.
  void set_hash(ChangedHash* hash) { hash_ = hash; }
  /// From the next tick on. Tick-safe; any thread.
  void set_rpm(double rpm) { rpm_.store(rpm, std::memory_order_relaxed); }

  bool Tick(double dt_s, TickObserver& observer, LoopTick& report) override;
  std::size_t channel_count() const override;
  void ReportChannels(std::span<double> channels) const override;
  void RampIn() override { force_off_ = true; }
  void SetFidelity(Fidelity fidelity) override { simulation_.SetFidelity(fidelity); }
  int changed_count() const override { return simulation_.changed_count(); }
  ChangedLeaf changed(int i) const override { return simulation_.changed(i); }
  void ClearChanged() override { simulation_.ClearChanged(); }

  /// The loop's, or after its end.
  const HapticStep& step() const { return step_; }

 private:
  CoupledSimulation& simulation_;
  GuardedDevice& device_;
  StepBodyParams params_;
  std::atomic<double> rpm_;
  BeforeTick* before_;
  PieceExchange* pieces_ = nullptr;
  RestoreExchange* restores_ = nullptr;
  ChangedHash* hash_ = nullptr;
  HapticStep step_;
  bool force_off_ = false;
  double failed_s_ = 0;
  std::optional<Pose> X_WT_;  // the tool after the last tick
};

}  // namespace kerf
