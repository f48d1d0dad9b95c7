// Description of the parts of a recording that could not be read.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loop/record/blocks.h"

namespace kerf {

enum class RecordingState : std::uint8_t {
  kWhole,     // every block was read, including the last one
  kCutShort,  // no end or no seal, as after a kill or a power loss; every block before that was read
  kDamaged,   // a block in the middle is missing or changed; the end may be missing too
};
/// "whole", "cut short", "damaged".
const char* ToString(RecordingState state);

/// Steps that are missing between two steps that were read, or at the end.
struct LostSteps {
  std::uint64_t first_step = 0;  // zero-based index
  std::uint64_t count = 0;
  double from_s = 0;
  double to_s = 0;
};

struct RecordingDamage {
  RecordingState state = RecordingState::kWhole;
  bool has_end = true;            // the block with the reason for the end was read; the seal may still be missing
  std::vector<LostSteps> gaps;    // in the order of their steps
  std::uint64_t lost_steps = 0;   // number of missing steps in all gaps
  std::uint64_t known_steps = 0;  // number of steps, read or lost, up to the end or the last step read
  std::uint64_t lost_blocks = 0;  // number of lost blocks of all kinds, as far as block numbers show
  std::uint64_t bad_bytes = 0;    // bytes of the file that are not part of a readable block
  std::uint64_t whole_steps = 0;  // number of steps before the first gap, which a replay can run
  double whole_s = 0;             // time at the end of these steps
  std::string sentence;           // description of the damage; empty if the recording is whole
};

/// A sequence of missing blocks.
struct LostBlocks {
  std::uint32_t count = 0;
  std::optional<BlockKind> last_kind;  // if known
};
/// Returns a phrase such as "an event is damaged".
std::string Describe(const LostBlocks& lost);
/// Returns RecordingDamage::sentence. `faults`: faults in addition to the missing steps.
std::string Describe(const RecordingDamage& damage, const std::vector<std::string>& faults, double duration_s);

}  // namespace kerf
