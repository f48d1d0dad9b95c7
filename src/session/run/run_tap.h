// Who listens to a run along a path, tick by tick: to record it, or to give it again what was recorded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kerf/simulation.h"
#include "session/run/replay_body.h"
#include "session/run/session_recorder.h"

namespace kerf {

class RunTap {
 public:
  virtual ~RunTap() = default;
  /// The tool is lifted and about to be set down at `X`, which may be put right. False: the run ends here.
  virtual bool SetDown(Pose& X) = 0;
  /// A tick is about to be, given `in`, which may be put right. False: the run ends here.
  virtual bool Begin(TickInput& in) = 0;
  virtual void End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) = 0;
};

class RunRecorder final : public RunTap {
 public:
  /// Throws Error when the file can't be made.
  RunRecorder(const std::string& path, const RecordingHead& head, const std::map<std::string, std::string>& files)
      : recorder_(path, head, files) {}
  bool SetDown(Pose& X) override;
  bool Begin(TickInput&) override { return true; }
  void End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) override;
  /// Why it could not be written to its end; empty when it was.
  std::string Finish(std::optional<std::uint64_t> bone_hash);

 private:
  SessionRecorder recorder_;
};

/// Gives what was recorded.
class RunReplay final : public RunTap {
 public:
  /// `recording` must outlive it. `verify`: ends where something else comes out.
  RunReplay(RecordingReader& recording, double until_s, bool verify)
      : recording_(recording), steps_(recording, until_s), verify_(verify), check_(recording) {}
  bool SetDown(Pose& X) override;
  bool Begin(TickInput& in) override;
  void End(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash) override;

  const RecordingHead& head() const { return recording_.head(); }
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

/// What `kerf run` is asked to do besides.
struct RunSession {
  std::string record;           // a file that is not there yet; empty: none
  std::string scene_file;       // of the scene, for a recording to name
  RunReplay* replay = nullptr;  // instead; may be null
  /// Gets a sentence when the recording could not be written to its end; the results are written all the same.
  std::string* lost = nullptr;
};

/// The tap of such a run, which goes on without it when it fails.
class SessionTap {
 public:
  /// Throws Error when there is no file to record into, or the bone is not the one that was recorded.
  SessionTap(const RunSession& session, const Scene& scene, RecordedKind kind, const Bone& bone);
  RunTap* tap();
  /// Before the results are written, so that they take no room from it.
  void Finish(std::optional<std::uint64_t> bone_hash);

 private:
  RunReplay* replay_;
  std::string* lost_;
  std::optional<RunRecorder> recorder_;
};

}  // namespace kerf
