// For who times a tick: it is told when a part of it begins. The tick itself has no clock.
#pragma once

#include <cstddef>
#include <cstdint>

namespace kerf {

/// A tool on a path has no kNear and no kSolve.
enum class TickStage : std::uint8_t { kAccept, kNear, kEngage, kSolve, kRemove, kPublish, kEnd };

class TickObserver {
 public:
  virtual ~TickObserver() = default;
  /// The stage before is over. Called in the tick.
  virtual void Enter(TickStage stage) noexcept = 0;
  /// Work for an effect, within a stage; `effect`: its place in the plan. Called in the tick.
  virtual void EnterEffect(std::size_t /*effect*/) noexcept {}
  virtual void LeaveEffect() noexcept {}
};

}  // namespace kerf
