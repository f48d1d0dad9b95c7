// Work behind a result, in a thread of low priority: the expert's attempt, then the replay of the recording.
#pragma once

#include <atomic>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "session/practise/replay_pair.h"
#include "session/scene/scene.h"
#include "session/score/measures.h"

namespace kerf {

class ResultChecks {
 public:
  ResultChecks() = default;
  ~ResultChecks() { End(); }
  ResultChecks(const ResultChecks&) = delete;
  ResultChecks& operator=(const ResultChecks&) = delete;

  /// Begins with a recording of the scene and the sheet that was computed from the session.
  void Begin(const Scene& scene, const std::string& recording, const ScoreSheet& sheet);
  /// Ends the work soon; its results are dropped.
  void End();

  /// What has become known since the last call.
  struct News {
    bool expert = false;
    bool verified = false;
    std::string failure;  // a sentence; empty: none
  };
  News Take();

  /// Null: not computed yet.
  const std::shared_ptr<const ToolTrack>& expert() const { return expert_; }
  /// Whether a replay of the recording gives the same sheet; unset while that is not known.
  std::optional<bool> verified() const { return verified_; }
  bool failed() const { return failed_; }  // it will not become known

 private:
  struct Work {
    std::atomic<bool> stop{false};
    std::mutex mutex;  // protects what follows
    std::shared_ptr<const ToolTrack> expert;
    std::optional<bool> verified;
    std::string failure;
  };
  std::shared_ptr<ExpertTracks> experts_ = std::make_shared<ExpertTracks>();
  std::shared_ptr<Work> work_;
  std::vector<std::future<void>> running_;  // also work that is ending
  std::shared_ptr<const ToolTrack> expert_;
  std::optional<bool> verified_;
  bool failed_ = false;
};

}  // namespace kerf
