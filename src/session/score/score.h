// Scores a recording.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "loop/haptics/loop_body.h"
#include "loop/record/recording.h"
#include "session/scene/scene.h"
#include "session/score/measures.h"
#include "session/score/motion.h"

namespace kerf {

struct ScoreOptions {
  std::string bone_file;                    // as in OpenRecordedScene()
  const std::atomic<bool>* stop = nullptr;  // ends the scoring with an Error; optional
};

/// Digests of the inputs of the readable ticks only. They are the same for a copy with another name, header or seal.
struct StepsDigests {
  std::string all;
  /// Digest up to the tick in which the pose has changed kBeginningMoves times: the same for a copy that ends earlier
  /// or continues differently. If the pose has changed less often, the digest of all ticks.
  std::string beginning;
};
/// Number of moves in a recording's beginning: 2 s of motion at 1 kHz. Ticks without motion are not counted, because
/// two sessions may begin with the same wait.
inline constexpr std::size_t kBeginningMoves = 2000;
StepsDigests CalcStepsDigests(RecordingReader& recording);

/// Replays the recording in virtual time, as `kerf replay` does, and measures the motion and the cut. The same
/// recording gives the same sheet on every machine. `progress` (optional) is called with the name of a stage and its
/// completed fraction, 0 to 1. Throws kerf::Error for a recording that cannot be replayed, and for one in slab mode,
/// which removes no bone.
ScoreSheet ScoreRecording(RecordingReader& recording, const ScoreOptions& options,
                          const std::function<void(const std::string&, double)>& progress);

/// Returns the time that an unhurried attempt takes; twice this time costs half of its points.
double CalcUnhurriedTime_s(const std::vector<WantedCut>& cuts, const SceneExercise& exercise);

/// Measures a coupled session while it runs, so that it can be scored at its end without a replay.
class SessionMeter {
 public:
  /// `scene`: of the session.
  explicit SessionMeter(const Scene& scene);
  /// Takes the session's ticks in order, for example as LoopWatchers::take_tick.
  void Take(const LoopTick& tick);
  /// Returns true if no tick is missing; otherwise only a replay shows what happened.
  bool is_complete() const { return is_complete_; }
  /// Time of the session at which the attempt began: the tool moved, or the spindle started to turn. Negative: not yet.
  /// May be called by any thread.
  double begun_s() const { return begun_s_.load(std::memory_order_relaxed); }
  /// Scores the session from its recording's header and seal, the ticks, and the bones before and after. The sheet
  /// equals that of ScoreRecording(), which also verifies that the recording reproduces the session. `nerve`: distance
  /// to the nerve canal of `before`; null: it is computed. Throws kerf::Error if ticks are missing, or if the recording
  /// has another number of steps.
  ScoreSheet Score(RecordingReader& recording, const Bone& before, const Bone& after,
                   const RegionDistance* nerve = nullptr) const;

 private:
  Scene scene_;
  MotionMeter meter_;
  double time_s_ = 0;
  std::uint64_t ticks_ = 0;
  bool is_complete_ = true;
  std::atomic<double> begun_s_{-1};
};

}  // namespace kerf
