// Recording and replay of a run along a path.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/simulation.h"
#include "session/run/replay_body.h"
#include "session/run/session_recorder.h"

namespace kerf {

/// Supplies the recorded inputs and compares the results with the recording.
class RunReplay {
 public:
  /// `recording` must outlive this object. `verify`: the run ends at the first divergence.
  RunReplay(RecordingReader& recording, double until_s, bool verify) : steps_(recording, until_s), verify_(verify) {}
  /// Replaces the pose at which the tool is placed, or the input of a tick, by the recorded one. Returns false at the
  /// end of the run.
  bool SetDown(Pose& X);
  bool Begin(TickInput& in);
  void End(const TickToRecord& tick) { steps_.Compare(tick); }

  const RecordingReader& recording() const { return steps_.recording(); }
  std::vector<std::string> FindWarnings() const { return FindDamageWarnings(steps_.recording()); }
  /// `bone_hash`: after the last step.
  Replayed MakeReport(std::uint64_t bone_hash) const { return steps_.MakeReport(bone_hash); }

 private:
  const RecordedStep* Next(bool set_down);

  RecordedSteps steps_;
  bool verify_;
};

/// What a run along a path is recorded to and replayed from; each is optional and must outlive the run.
struct PathTape {
  SessionRecorder* recorder = nullptr;
  RunReplay* replay = nullptr;
};

/// Recording and replay options of `kerf run`.
struct RunSession {
  std::string record;           // a new file; empty: none
  std::string scene_file;       // path of the scene, stored in a recording
  RunReplay* replay = nullptr;  // if set, the run replays this recording
  /// Receives a sentence if the recording could not be completed; the results are written anyway.
  std::string* recording_failure = nullptr;
};

/// Tape of a run with these options. If recording fails, the run continues without it.
class RunTape {
 public:
  /// Throws kerf::Error if the recording cannot be created, or if the bone is not the recorded one.
  RunTape(const RunSession& session, const Scene& scene, RecordedKind kind, const Bone& bone);
  /// Without Finish(), the run has ended early: the recording keeps all its ticks, but has no hash of the bone.
  ~RunTape();
  RunTape(const RunTape&) = delete;
  RunTape& operator=(const RunTape&) = delete;
  PathTape tape() { return {recorder_ ? &*recorder_ : nullptr, replay_}; }
  /// Completes the recording. Call before the results are written, so that they do not use its disk space.
  void Finish(std::optional<std::uint64_t> bone_hash);

 private:
  RunReplay* replay_;
  std::string* recording_failure_;
  std::optional<SessionRecorder> recorder_;
};

}  // namespace kerf
