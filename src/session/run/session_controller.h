// Peer of a running loop, such as a window: it receives changes of the bone and requests actions.
#pragma once

#include <optional>
#include <string>

#include "loop/haptics/haptic_loop.h"
#include "session/run/loop_setup.h"
#include "session/run/loop_undo.h"

namespace kerf {

/// Initial state of a loop. The references are valid only during the call.
struct LoopInitialState {
  const Bone& bone;
  const CoupledParams& params;
  const LoopSetup& setup;
  const EffectPlan& effects;
  Pose X_WT;
};

/// Interface called by LoopSession in the thread that steps it, never in the loop's. Slow calls delay the writing of
/// the recording, not the ticks.
class SessionController {
 public:
  SessionController() = default;
  SessionController(const SessionController&) = delete;
  SessionController& operator=(const SessionController&) = delete;
  virtual ~SessionController() = default;

  /// If false, checkpoints, undo and redo are not prepared for it.
  virtual bool needs_undo() const { return true; }
  /// Called after the bone is made and before anything moves.
  virtual void Begin(const LoopInitialState& initial) = 0;
  /// Called with a leaf of the bone in its current state.
  virtual void TakeLeaf(const LeafMessage& leaf) = 0;
  /// Returns the next action to carry out now, one at a time; LoopAction::at_s is ignored. Returns none if there is no
  /// action.
  virtual std::optional<LoopAction> NextAction() = 0;
  /// Called when the requested action is done, or has failed for the reason in `failure`. `restored_mm3`: the volume
  /// that an undo has put back, or a redo has taken away again; none if it is not known.
  virtual void Done(const LoopAction& action, const std::string& failure, std::optional<double> restored_mm3) = 0;
};

}  // namespace kerf
