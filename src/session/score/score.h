// A recording, scored.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "loop/record/recording.h"
#include "session/scene/scene.h"
#include "session/score/measures.h"

namespace kerf {

struct ScoreOptions {
  std::string bone_file;                    // as OpenRecordedScene's
  const std::atomic<bool>* stop = nullptr;  // ends it by an Error; may be null
};

/// Of what its ticks were given, as far as it was read, and of nothing else: the same for a copy with another name,
/// another head or another seal.
struct StepsDigests {
  std::string all;
  /// Up to the tick in which the pose has changed kBeginningMoves times: the same for a copy that ends earlier or goes
  /// on otherwise. That of all ticks where it has changed less often.
  std::string beginning;
};
/// 2 s of motion at 1 kHz. Ticks in which nothing moves are not counted, as two sessions may begin with the same wait.
inline constexpr std::size_t kBeginningMoves = 2000;
StepsDigests CalcStepsDigests(RecordingReader& recording);

/// Goes through the recording again without the clock, as `kerf replay` does, and measures what it did: the same
/// recording gives the same sheet, wherever. `progress` gets a stage's name and 0..1; may be empty. Throws Error for a
/// recording that can't be gone through, or of slab mode, in which nothing is cut.
ScoreSheet ScoreRecording(RecordingReader& recording, const ScoreOptions& options,
                          const std::function<void(const std::string&, double)>& progress);

}  // namespace kerf
