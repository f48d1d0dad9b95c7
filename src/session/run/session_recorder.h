// `--record`: what a run or a live session was given, into a file; of a loop by the thread that reads its samples.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/files/files.h"
#include "loop/haptics/haptic_loop.h"
#include "loop/record/recording.h"
#include "session/scene/scene.h"

namespace kerf {

/// The head of a recording of that scene by this program on this machine, but for what the run adds.
RecordingHead MakeRecordingHead(const Scene& scene, const std::string& scene_file, RecordedKind kind, const Bone& bone,
                                const Pose& X_WT_start);
/// The scene's inputs with their bytes, but for the bone's file, which may be large, and the scene itself, which stands
/// in the head.
std::map<std::string, std::string> ReadSceneFiles(const Scene& scene, const std::string& scene_file);

/// What was recorded, to go through again.
struct RecordedScene {
  Scene scene;
  std::unique_ptr<FileShelf> files;  // the inputs that came along, read in place of those on the disk while it lives
};
/// `bone_file`: a .vdb in place of the one that the recording names; empty: that one, or the model. Throws Error.
RecordedScene OpenRecordedScene(RecordingReader& recording, const std::string& bone_file);

/// Of a recording that is damaged or cut short: what is wrong, and where going through it again ends. Else nothing.
std::vector<std::string> FindDamageWarnings(const RecordingReader& recording);

/// What a recording keeps of a tick.
struct TickToRecord {
  RecordedStep step;
  std::uint64_t hash = 0;        // of all that came out: forces, poses, what was removed
  std::uint64_t voxel_hash = 0;  // bone/changed_hash.h
  // At its end, but for the time and what was removed before it.
  RecordedState state;  // removed_mm3: in the tick
};
TickToRecord MakeTickToRecord(const LoopTick& tick);
TickToRecord MakeTickToRecord(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash);

/// The 16 bits that a step keeps of a hash.
inline std::uint16_t CheckOf(std::uint64_t hash) {
  return static_cast<std::uint16_t>(hash ^ hash >> 16 ^ hash >> 32 ^ hash >> 48);
}

/// Of the bits of a check that are kept.
inline std::uint16_t MaskOf(int check_bits) {
  return static_cast<std::uint16_t>((1u << check_bits) - 1);
}

class SessionRecorder {
 public:
  /// It is signed at its end when there is a key of the installation. Throws Error when the file can't be made, or the
  /// key can't be used.
  SessionRecorder(const std::string& path, const RecordingHead& head, const std::map<std::string, std::string>& files);

  /// Every tick, in order. After the file could not be written any further it does nothing: failure().
  void Take(const TickToRecord& tick);
  /// The tool was lifted and set down.
  void TakeSetDown(const Pose& X);
  /// Ticks were lost before they came here: what follows could not be gone through again.
  void Lose(std::uint64_t ticks);
  void AddEvent(const std::string& what, const std::string& name, std::uint32_t number);
  /// Before the loop is told that it may leave.
  void AddPiece(std::uint32_t number, const std::string& bytes);
  /// Now and then, by the caller's clock: what is not in the file yet goes there when nothing went for 0.35 s.
  void FlushAt(double now_s);
  void Finish(const std::string& why, std::optional<std::uint64_t> bone_hash);

  /// A sentence; empty while all is well.
  const std::string& failure() const { return failure_; }
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t steps() const { return steps_; }

 private:
  template <typename Do>
  void Try(Do&& act);

  std::optional<RecordingWriter> writer_;
  std::string failure_;
  double rate_hz_;
  std::uint16_t check_mask_;
  int state_every_;
  int hash_every_;
  std::uint64_t steps_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t force_hash_ = 0;
  std::uint64_t voxel_hash_ = 0;
  double removed_mm3_ = 0;
  double time_s_ = 0;
  std::uint64_t flushed_bytes_ = 0;
  double flushed_at_s_ = 0;
};

}  // namespace kerf
