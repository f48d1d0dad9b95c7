// What of a recording could not be read.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loop/record/blocks.h"

namespace kerf {

enum class RecordingState : std::uint8_t {
  kWhole,     // every block was read, and it has its end
  kCutShort,  // it has no end or no seal, as after a kill or a power loss; every block before that was read
  kDamaged,   // something in the middle is missing or is not as it was written; it may have no end besides
};
/// "whole", "cut short", "damaged".
const char* ToString(RecordingState state);

/// Steps that are missing between two that were read, or before the end.
struct LostSteps {
  std::uint64_t first_step = 0;  // counted from 0
  std::uint64_t count = 0;
  double from_s = 0;
  double to_s = 0;
};

struct RecordingDamage {
  RecordingState state = RecordingState::kWhole;
  bool has_end = true;            // the block that tells why it ended was read; the seal may still be missing
  std::vector<LostSteps> gaps;    // in their order
  std::uint64_t lost_steps = 0;   // in all gaps
  std::uint64_t known_steps = 0;  // read and lost: all up to the end, or to the last one that was read
  std::uint64_t lost_blocks = 0;  // of all kinds, as far as their numbers tell
  std::uint64_t bad_bytes = 0;    // of the file that belong to no block that could be read
  std::uint64_t whole_steps = 0;  // from the start on without a gap: what a replay can go through
  double whole_s = 0;             // at their end
  std::string sentence;           // empty when it is whole
};

/// Blocks that are missing.
struct LostBlocks {
  std::uint32_t count = 0;
  std::optional<BlockKind> last_kind;  // where it is known
};
/// "an event is damaged".
std::string Describe(const LostBlocks& lost);
/// The sentence. `faults`: besides the steps that are missing.
std::string Describe(const RecordingDamage& damage, const std::vector<std::string>& faults, double duration_s);

}  // namespace kerf
