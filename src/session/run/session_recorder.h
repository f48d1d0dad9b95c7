// `--record`: records the inputs of a run or a live session in a file. In a loop, this is done in the thread that reads
// the samples.
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

/// Returns the header of a recording of the scene by this program on this machine, without the data that the run adds.
RecordingHeader MakeRecordingHeader(const Scene& scene, const std::string& scene_file, RecordedKind kind,
                                    const Bone& bone, const Pose& X_WT_start);
/// Returns the scene's input files with their contents, except the bone's file, which may be large, and the scene
/// itself, which is in the header. `known`: contents that need not be read, by path.
std::map<std::string, std::string> ReadSceneFiles(const Scene& scene, const std::string& scene_file,
                                                  const std::map<std::string, std::string>& known = {});

/// Scene of a recording, for a replay.
struct RecordedScene {
  Scene scene;
  std::unique_ptr<FileShelf> files;  // recorded inputs, read in place of those on disk while it exists
};
/// `bone_file`: a .vdb that replaces the file named in the recording; empty: the named file, or the model, is used.
/// Throws kerf::Error.
RecordedScene OpenRecordedScene(RecordingReader& recording, const std::string& bone_file);

/// For a damaged or truncated recording, returns sentences that describe the damage and state where a replay ends;
/// otherwise nothing.
std::vector<std::string> FindDamageWarnings(const RecordingReader& recording);

/// A tick as a recording keeps it: all its inputs, but only hashes and a few of its results, since a replay computes
/// the rest again.
struct TickToRecord {
  RecordedStep step;
  std::uint64_t hash = 0;        // of all results: forces, poses, removed volume
  std::uint64_t voxel_hash = 0;  // bone/grid/changed_hash.h
  // State at the end of the tick, without the time.
  RecordedState state;  // removed_mm3: in this tick only
};
TickToRecord MakeTickToRecord(const LoopTick& tick);
TickToRecord MakeTickToRecord(const TickInput& in, const TickOutput& out, std::uint64_t voxel_hash);

/// Returns the 16 bits of a hash that a step stores.
inline std::uint16_t CheckOf(std::uint64_t hash) {
  return static_cast<std::uint16_t>(hash ^ hash >> 16 ^ hash >> 32 ^ hash >> 48);
}

/// Returns the mask for the stored bits of a check.
inline std::uint16_t MaskOf(int check_bits) {
  return static_cast<std::uint16_t>((1u << check_bits) - 1);
}

class SessionRecorder {
 public:
  /// Signs the recording at its end if the installation has a key. Throws kerf::Error if the file cannot be created or
  /// the key cannot be used.
  SessionRecorder(const std::string& path, const RecordingHeader& header,
                  const std::map<std::string, std::string>& files);

  /// Call for every tick, in order. Does nothing after a write failure; see failure().
  void Take(const TickToRecord& tick);
  /// Call when the tool has been lifted and placed at `X`.
  void TakeSetDown(const Pose& X);
  /// Call when ticks were lost before they were recorded. The recording ends, because later ticks could not be
  /// replayed.
  void Lose(std::uint64_t ticks);
  void AddEvent(const std::string& what, const std::string& name, std::uint32_t number);
  /// Call before the loop is allowed to remove the piece.
  void AddPiece(std::uint32_t number, const std::string& bytes);
  /// Call periodically with the caller's clock: flushes pending data if nothing was written for 0.35 s.
  void FlushAt(double now_s);
  void Finish(const std::string& why, std::optional<std::uint64_t> bone_hash);

  /// One sentence; empty while no error has occurred.
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
