// Checkpoints of a bone that a tool in a hand cuts, with undo and redo.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "kerf/coupled.h"
#include "kerf/geometry.h"

namespace kerf {

/// Checkpoint that can be restored.
struct UndoCheckpoint {
  std::uint32_t number = 0;
  std::string name;
  std::size_t leaves = 0;  // leaves changed between it and the next checkpoint
  std::size_t bytes = 0;   // memory of these leaves
};

/// Compressed earlier states of a simulation's bone. To be used between ticks, in the thread that ticks; not tick-safe.
class Checkpoints {
 public:
  /// Begins with a checkpoint "start". `simulation` must outlive this object, must not be moved meanwhile, and must not
  /// have another one. `max_MB`: memory, 0.2 to 1e6; the oldest checkpoints are dropped first. Throws kerf::Error if it
  /// is out of range.
  explicit Checkpoints(CoupledSimulation& simulation, double max_MB = 256);
  ~Checkpoints();
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  /// Takes over what has changed since the last call. Call it at least every 500 ticks, or changes are lost and the
  /// checkpoints before them can no longer be restored.
  void Update();
  /// Makes a checkpoint of the current bone.
  void Make(const std::string& name);
  /// Returns the checkpoints, oldest first.
  std::vector<UndoCheckpoint> List() const;

  /// Restores the newest checkpoint of that name; without a name, the last one, or the one before it if nothing was cut
  /// since. The tool is set down at its current pose, or at `X_WT`. Throws kerf::Error if there is none.
  void Undo(const std::string& name = "", const Pose* X_WT = nullptr);
  /// Returns to the state before the last undo. Throws kerf::Error if bone was cut since, or there was none.
  void Redo(const Pose* X_WT = nullptr);
  bool CanRedo() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
