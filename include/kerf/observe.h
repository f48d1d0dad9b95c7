// Observer that times the stages of a tick. The tick itself uses no clock.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kerf {

/// Stages of a tick. The ticks of a tool that follows a prescribed path have no kNear and no kSolve, those of a scene
/// without effects no kEffects.
enum class TickStage : std::uint8_t { kAccept, kNear, kEngage, kSolve, kRemove, kEffects, kPublish, kEnd };

class TickObserver {
 public:
  virtual ~TickObserver() = default;
  /// Called when a stage begins and the previous one ends. Called in the tick.
  virtual void Enter(TickStage stage) noexcept = 0;
  /// Called around the work of an effect within a stage; `effect` is its index in the plan. Called in the tick.
  virtual void EnterEffect(std::size_t /*effect*/) noexcept {}
  virtual void LeaveEffect() noexcept {}
};

}  // namespace kerf
