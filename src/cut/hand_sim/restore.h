// The bone is put back to what it was, between ticks, so many leaves at a time.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kerf/coupled.h"

namespace kerf {

/// What is to be put back. Made and kept by the reader of a history (src/cut/undo/journal.h) until the simulation has
/// done with it: then it holds what was there instead, from which it can be taken back in turn.
///
/// The reader is a little behind. What changed since is in the history's ring, where the simulation's own thread finds
/// it: so the bone comes out as it was at the checkpoint, whenever the restore begins.
struct RestoreJob {
  struct Leaf {
    std::array<int, 3> index{};
    float* values = nullptr;  // 512, swapped with the bone's
  };
  /// What became of it.
  enum class State : std::uint8_t {
    kWaiting,
    kRunning,
    kDone,
    kChanged,   // bone was cut since it was made: too much of it, or what was undone can't be redone; make another
    kLost,      // the history's ring was full meanwhile
    kNoLeaves,  // too few leaves are set aside: CoupledSimulation::Refill()
  };

  std::uint32_t number = 0;   // of the checkpoint that it leads to; of redo the one that was left by undo
  bool redo = false;          // only good while nothing changes
  std::size_t seen = 0;       // of the history's messages, when it was made
  std::uint32_t lost = 0;     // LeafHistory::last_lost(), then
  std::vector<Leaf> leaves;   // each once
  std::vector<float*> spare;  // blocks of 512 for leaves that changed since; from the last one on they are taken
  std::array<double, 256> taken_out_mm3{};

  // the simulation's, before `state` is kDone
  std::size_t pushed = 0;   // the history's messages up to here are from before the restore,
  std::uint32_t epoch = 0;  // and this is the one that it ended with
  std::atomic<State> state{State::kWaiting};
};

/// Why it was refused, as a sentence; empty when it was not.
const char* WhyRefused(RestoreJob::State state);

/// The simulation's side. All of it is tick-safe, and depends on nothing but the tick in which it begins: a bone of so
/// many changed leaves takes so many steps.
class Restore {
 public:
  /// Whether it can be done; if not job.state says why and nothing is changed. `may_refill`: leaves are set aside where
  /// they are wanted, which is not for the tick.
  bool Begin(CoupledSimulation& simulation, RestoreJob& job, bool may_refill = false);
  bool running() const { return job_ != nullptr; }
  /// At most `leaves` more, 1 or more. True when all are there; End() is to follow before the next tick.
  bool Step(CoupledSimulation& simulation, std::size_t leaves);
  /// Sets the tool down at X_WT, null: where it is. The job is its maker's again.
  void End(CoupledSimulation& simulation, const Pose* X_WT);

 private:
  bool HasRoom(const CoupledSimulation& simulation) const;
  void Swap(CoupledSimulation& simulation, const RestoreJob::Leaf& leaf);
  static bool Touch(CoupledSimulation& simulation, const std::array<int, 3>& index);

  RestoreJob* job_ = nullptr;
  bool may_refill_ = false;
  std::size_t next_ = 0;       // of the job's leaves
  std::size_t at_begin_ = 0;   // the job had so many
  std::size_t next_seen_ = 0;  // of the history's messages
};

/// For a thread that owns everything, not for the tick: all at once, with leaves set aside where they are wanted.
/// `X_WT`: where the tool is then set down, null: where it is. False when it was refused: job.state.
bool RunRestore(CoupledSimulation& simulation, RestoreJob& job, const Pose* X_WT = nullptr);

}  // namespace kerf
