// A coupled session, stepped: a scene's bone and tool, a driver (recording, simulated hand or real device), and what
// watches it. `kerf loop`, replays of its recordings, the window, scores and studies step it.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "session/run/run_loop.h"

namespace kerf {

/// What the options do not ask for is not made: recording, undo, pieces, costs, logs.
class LoopSession {
 public:
  using Progress = std::function<void(const std::string& stage, double fraction)>;

  /// Makes the bone. `scene` and `options` must outlive this object. Throws as RunLoop() does.
  LoopSession(const Scene& scene, const LoopOptions& options, const Progress& progress);
  ~LoopSession();

  /// Advances the session: by a tick in a replay and in virtual time; live, until the next reading of the loop, 10 ms
  /// later. Returns false at the end of the session.
  bool Step();
  /// Call once, after the last step. Takes the remaining pieces out and sums the session up.
  LoopSummary Finish();
  /// Call once, after Step() has thrown: ends the session and returns a summary with the failure and the bone as it is
  /// now. Of the results, it has only these and the recording, which is complete until then.
  LoopSummary Abandon(const std::string& failure);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
