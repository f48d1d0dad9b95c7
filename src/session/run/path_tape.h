// Interface to observe or control a run along a path, tick by tick: to record it or to replay a recording.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/simulation.h"
#include "session/run/replay_body.h"
#include "session/run/session_recorder.h"

namespace kerf {

class TickInterceptor {
 public:
  virtual ~TickInterceptor() = default;
  /// Called when the tool is lifted and about to be placed at `X`, which may be changed. The run ends if it returns
  /// false.
  virtual bool SetDown(Pose& X) = 0;
  /// Called before a tick with the input `in`, which may be changed. The run ends if it returns false.
  virtual bool Begin(TickInput& in) = 0;
  virtual void End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) = 0;
};

class RunRecorder final : public TickInterceptor {
 public:
  /// Throws kerf::Error if the file cannot be created.
  RunRecorder(const std::string& path, const RecordingHeader& header, const std::map<std::string, std::string>& files)
      : recorder_(path, header, files) {}
  bool SetDown(Pose& X) override;
  bool Begin(TickInput&) override { return true; }
  void End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) override;
  /// Returns the reason if the recording could not be completed, otherwise "".
  std::string Finish(std::optional<std::uint64_t> bone_hash);

 private:
  SessionRecorder recorder_;
};

/// Supplies the recorded inputs and compares the results with the recording.
class RunReplay final : public TickInterceptor {
 public:
  /// `recording` must outlive this object. `verify`: the run ends at the first divergence.
  RunReplay(RecordingReader& recording, double until_s, bool verify)
      : recording_(recording), steps_(recording, until_s), verify_(verify), check_(recording) {}
  bool SetDown(Pose& X) override;
  bool Begin(TickInput& in) override;
  void End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) override;

  const RecordingHeader& header() const { return recording_.header(); }
  std::vector<std::string> FindWarnings() const { return FindDamageWarnings(recording_); }
  /// `bone_hash`: after the last step.
  Replayed MakeReport(std::uint64_t bone_hash) const;

 private:
  bool Next(bool set_down);

  RecordingReader& recording_;
  RecordedSteps steps_;
  bool verify_;
  RecordedStep step_;
  ReplayCheck check_;
};

/// Recording and replay options of `kerf run`.
struct RunSession {
  std::string record;           // a new file; empty: none
  std::string scene_file;       // path of the scene, stored in a recording
  RunReplay* replay = nullptr;  // if set, the run replays this recording
  /// Receives a sentence if the recording could not be completed; the results are written anyway.
  std::string* recording_failure = nullptr;
};

/// Interceptor of a run with these options. If recording fails, the run continues without it.
class SessionInterceptor {
 public:
  /// Throws kerf::Error if the recording cannot be created, or if the bone is not the recorded one.
  SessionInterceptor(const RunSession& session, const Scene& scene, RecordedKind kind, const Bone& bone);
  TickInterceptor* tap();
  /// Completes the recording. Call before the results are written, so that they do not use its disk space.
  void Finish(std::optional<std::uint64_t> bone_hash);

 private:
  RunReplay* replay_;
  std::string* recording_failure_;
  std::optional<RunRecorder> recorder_;
};

}  // namespace kerf
