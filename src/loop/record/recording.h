// Recording: all inputs of a session, tick by tick, so that it can be replayed bit for bit.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loop/record/block_reader.h"
#include "loop/record/blocks.h"
#include "loop/record/damage.h"
#include "loop/record/seal.h"
#include "loop/record/step.h"

namespace kerf {

enum class RecordedKind : std::uint8_t { kLoop, kRun, kSlab };
const char* ToString(RecordedKind kind);

/// Rises with each version of kerf that computes voxel mode with other bits. 2: the whole bone and the cut are kept
/// apart (docs/physics.md). 3: the bite of a blade with a stroke; with any other tool, the bits are those of 2.
inline constexpr int kComputation = 3;

/// Header of a recording.
struct RecordingHeader {
  RecordedKind kind = RecordedKind::kLoop;
  int computation = kComputation;
  std::string scene_name;
  std::string scene_file;           // path of the scene file, which relative names in the scene refer to
  std::string scene_toml;           // the scene with all its settings, as TOML
  std::uint64_t bone_hash = 0;      // Bone::CalcHash()
  std::uint64_t material_hash = 0;  // Bone::CalcMaterialHash()
  double voxel_mm = 0;
  double rate_hz = 1000;
  Pose X_WT_start;
  int check_bits = 16;  // size of the checks in RecordedStep: 8 or 16
  int state_every_steps = 10;
  int hash_every_steps = 1000;
  // Origin of the recording, for display.
  std::string version;
  std::string commit;
  std::string compiler;
  std::string machine;
  std::string created;        // UTC
  std::string taken_up_from;  // path of the recording that this one continues; empty: none

  /// Returns whether this build computes the same bits; slab mode has not changed.
  bool IsReplayable() const;
};

/// End of a recording.
struct RecordingEnd {
  std::uint64_t steps = 0;
  double time_s = 0;
  std::uint64_t force_hash = 0;
  std::uint64_t voxel_hash = 0;            // the same hash as RecordedHash::bone
  std::optional<std::uint64_t> bone_hash;  // Bone::CalcHash()
  std::string why;                         // reason in a few words: "asked", "the device failed"
};

/// An event, for display and lists, such as a "checkpoint" named "before the second cut".
struct RecordedEvent {
  std::uint64_t step = 0;  // step that follows the event
  double time_s = 0;
  std::string what;
  std::string name;
  std::uint32_t number = 0;  // RecordedStep::checkpoint
};

/// Checks, before lengthy work begins, that a recording can be created at `path`. Throws kerf::Error if it cannot, or
/// if it would replace a file.
void CheckNewRecording(const std::string& path);

/// Writes a recording during the session, in blocks of a quarter of a second.
class RecordingWriter {
 public:
  /// `files`: inputs of the scene by full name, with their bytes. `key`: signs the recording when it ends. Throws
  /// kerf::Error if the file cannot be created.
  RecordingWriter(const std::string& path, const RecordingHeader& header,
                  const std::map<std::string, std::string>& files, const std::optional<SealKey>& key = std::nullopt);

  /// Adds a step. `time_s`: time at the end of the step. All functions throw kerf::Error if the file can no longer be
  /// written.
  void Add(const RecordedStep& step, double time_s);
  /// States and hashes belong to the last step added; an event happens after that step.
  void AddState(RecordedState state);
  void AddHash(std::uint64_t force, std::uint64_t bone);
  void AddEvent(RecordedEvent event);
  void AddPiece(std::uint32_t number, const std::string& bytes);
  /// Writes all steps added so far to the file.
  void Flush();
  void Finish(const RecordingEnd& end);

  std::uint64_t steps() const { return steps_; }
  std::uint64_t bytes() const { return file_.bytes(); }
  const std::string& path() const { return file_.path(); }
  // Number of steps written to the file, and their end time.
  std::uint64_t written_steps() const { return written_steps_; }
  double written_s() const { return written_s_; }

 private:
  BlockFile file_;
  std::optional<SealKey> key_;
  std::uint64_t written_steps_ = 0;
  double written_s_ = 0;
  std::size_t steps_in_block_;
  RecordedBlock block_;
  std::uint64_t steps_ = 0;
  double time_s_ = 0;
};

/// Reads a recording. Needs memory for one block of steps and an index of the file.
class RecordingReader {
 public:
  /// Throws kerf::Error if the file is not a recording or its header is invalid. Of a truncated or damaged recording,
  /// all parts that are present are read; see damage().
  explicit RecordingReader(const std::string& path);

  const std::string& path() const { return blocks_.path(); }
  std::uint64_t file_bytes() const { return blocks_.size(); }
  const RecordingHeader& header() const { return header_; }
  std::map<std::string, std::string> ReadFiles();
  const std::optional<RecordingEnd>& end() const { return end_; }
  const std::vector<RecordedEvent>& events() const { return events_; }
  /// Number of steps read. The first damage().whole_steps of them can be replayed.
  std::uint64_t steps() const { return steps_; }
  /// Time at the end of the last step read.
  double duration_s() const { return duration_s_; }
  /// The missing parts.
  const RecordingDamage& damage() const { return damage_; }
  /// damage().sentence: empty if the recording is whole, including its end.
  const std::string& DescribeDamage() const { return damage_.sentence; }
  /// Result of the checks of the chain and the signature.
  const RecordingSeal& seal() const { return seal_; }

  /// Reads the i-th readable block of steps, in order; a jump in RecordedBlock::first_step shows that a block before it
  /// is missing. Returns false if there are fewer blocks. Throws kerf::Error if the block is invalid.
  bool ReadBlock(std::size_t i, RecordedBlock& block);
  /// Reads a piece that was about to leave. Throws kerf::Error if no piece has this number.
  std::string ReadPiece(std::uint32_t number);

 private:
  void Read();
  void TakeSteps(const BlockPlace& place);
  void AddLostSteps(std::uint64_t until_step, double until_s);
  void TakeEnd(const BlockPlace& place);
  void ReportLostBlocks(bool with_steps);
  void CheckSeal();
  void FindDamage();
  void LimitToPieces();

  BlockReader blocks_;
  RecordingHeader header_;
  std::optional<RecordingEnd> end_;
  std::vector<RecordedEvent> events_;
  std::vector<BlockPlace> steps_places_;
  std::uint64_t steps_ = 0;
  std::uint64_t next_step_ = 0;  // includes missing steps
  double duration_s_ = 0;
  RecordingDamage damage_;
  RecordingSeal seal_;
  std::vector<LostBlocks> lost_;     // since the last block of steps
  std::vector<std::string> faults_;  // faults in addition to the missing steps
  bool has_last_block_ = false;
  std::map<std::uint32_t, LostSteps> pieces_;  // pieces that steps refer to, with that step and the time before it
};

}  // namespace kerf
