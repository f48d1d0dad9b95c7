// A recording: everything that a session was given, tick by tick, so that it can be gone through again to the same
// bits.
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

/// What stands at the head of a recording.
struct RecordingHead {
  RecordedKind kind = RecordedKind::kLoop;
  std::string scene_name;
  std::string scene_file;           // where it was; relative names in the scene are from there
  std::string scene_toml;           // resolved
  std::uint64_t bone_hash = 0;      // Bone::CalcHash()
  std::uint64_t material_hash = 0;  // Bone::CalcMaterialHash()
  double voxel_mm = 0;
  double rate_hz = 1000;
  Pose X_WT_start;
  int check_bits = 16;  // of RecordedStep's checks: 8 or 16
  int state_every_steps = 10;
  int hash_every_steps = 1000;
  // by whom and where, for people
  std::string version;
  std::string commit;
  std::string compiler;
  std::string machine;
  std::string created;        // UTC
  std::string taken_up_from;  // another recording, with the time; else empty
};

/// How it ended.
struct RecordingEnd {
  std::uint64_t steps = 0;
  double time_s = 0;
  std::uint64_t force_hash = 0;
  std::uint64_t voxel_hash = 0;            // as RecordedHash::bone
  std::optional<std::uint64_t> bone_hash;  // Bone::CalcHash()
  std::string why;                         // a few words: "asked", "the device failed"
};

/// Something that happened, for people and for a list: "checkpoint" "before the second cut".
struct RecordedEvent {
  std::uint64_t step = 0;  // before which
  double time_s = 0;
  std::string what;
  std::string name;
  std::uint32_t number = 0;  // RecordedStep::checkpoint
};

/// For asking before long work. Throws Error when a recording can't be made there, or would replace a file.
void CheckNewRecording(const std::string& path);

/// Writes a recording as it comes: a block for each quarter of a second.
class RecordingWriter {
 public:
  /// `files`: inputs of the scene by their full name, with their bytes. `key`: that signs it at its end. Throws Error.
  RecordingWriter(const std::string& path, const RecordingHead& head, const std::map<std::string, std::string>& files,
                  const std::optional<SealKey>& key = std::nullopt);

  /// `time_s`: at the end of the step. All throw Error when the file can't be written any further.
  void Add(const RecordedStep& step, double time_s);
  /// After the step that was added last.
  void AddState(RecordedState state);
  void AddHash(std::uint64_t force, std::uint64_t bone);
  void AddEvent(RecordedEvent event);
  void AddPiece(std::uint32_t number, const std::string& bytes);
  /// What has been added so far into the file.
  void Flush();
  void Finish(const RecordingEnd& end);

  std::uint64_t steps() const { return steps_; }
  std::uint64_t bytes() const { return file_.bytes(); }
  const std::string& path() const { return file_.path(); }
  // in the file
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

/// Memory: a block of steps and an index of the file.
class RecordingReader {
 public:
  /// Throws Error when it is none, or its head does not make sense. One that was cut short or damaged is read, but for
  /// what is missing: damage().
  explicit RecordingReader(const std::string& path);

  const std::string& path() const { return blocks_.path(); }
  std::uint64_t file_bytes() const { return blocks_.size(); }
  const RecordingHead& head() const { return head_; }
  std::map<std::string, std::string> ReadFiles();
  const std::optional<RecordingEnd>& end() const { return end_; }
  const std::vector<RecordedEvent>& events() const { return events_; }
  /// That were read; damage().whole_steps of them can be gone through again.
  std::uint64_t steps() const { return steps_; }
  /// At the end of the last step that was read.
  double duration_s() const { return duration_s_; }
  /// What is missing, if anything is.
  const RecordingDamage& damage() const { return damage_; }
  /// damage().sentence: empty when the recording is whole and has its end.
  const std::string& DescribeDamage() const { return damage_.sentence; }
  /// Whether the blocks are those that were written, and who signed them.
  const RecordingSeal& seal() const { return seal_; }

  /// The i-th block of steps that was read, in order; RecordedBlock::first_step tells where one is missing before it.
  /// False when there are not as many. Throws Error.
  bool ReadBlock(std::size_t i, RecordedBlock& block);
  /// Of a piece that was going to leave. Throws Error when there is none of that number.
  std::string ReadPiece(std::uint32_t number);

 private:
  void Read();
  void TakeSteps(const BlockPlace& place);
  void AddLostSteps(std::uint64_t until_step, double until_s);
  void TakeEnd(const BlockPlace& place);
  void KeepLost(bool with_steps);
  void CheckSeal();
  void FindDamage();
  void LimitToPieces();

  BlockReader blocks_;
  RecordingHead head_;
  std::optional<RecordingEnd> end_;
  std::vector<RecordedEvent> events_;
  std::vector<BlockPlace> steps_places_;
  std::uint64_t steps_ = 0;
  std::uint64_t next_step_ = 0;  // with those that are missing
  double duration_s_ = 0;
  RecordingDamage damage_;
  RecordingSeal seal_;
  std::vector<LostBlocks> lost_;     // since the last block of steps
  std::vector<std::string> faults_;  // besides the steps that are missing
  bool has_last_block_ = false;
  std::map<std::uint32_t, LostSteps> pieces_;  // where the steps name them: step and time before it
};

}  // namespace kerf
