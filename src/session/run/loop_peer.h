// Somebody who sits at a loop while it runs, as a window does: sees the bone change and asks for what is to be done.
#pragma once

#include <optional>
#include <string>

#include "loop/haptics/haptic_loop.h"
#include "session/run/loop_setup.h"
#include "session/run/loop_undo.h"

namespace kerf {

/// What a loop begins with. All of it only during the call.
struct LoopBeginning {
  const Bone& bone;
  const CoupledParams& params;
  const LoopSetup& setup;
  const EffectPlan& effects;
  Pose X_WT;
};

/// Called by RunLoop in the thread that it runs in, never in the loop's: what takes long here keeps the recording from
/// being written, not the ticks from running.
class LoopPeer {
 public:
  LoopPeer() = default;
  LoopPeer(const LoopPeer&) = delete;
  LoopPeer& operator=(const LoopPeer&) = delete;
  virtual ~LoopPeer() = default;

  /// The bone is made and nothing has moved yet.
  virtual void Begin(const LoopBeginning& beginning) = 0;
  /// A leaf of the bone as it is now.
  virtual void TakeLeaf(const LeafMessage& leaf) = 0;
  /// Done from now on, one after the other; its moment (LoopAction::at_s) is not looked at. None: nothing to be done.
  virtual std::optional<LoopAction> NextAction() = 0;
  /// The undo, redo or checkpoint that was asked for is done, or `failure` says why not.
  virtual void Done(const LoopAction& action, const std::string& failure) = 0;
};

}  // namespace kerf
