// What a tick was given, and what came of it, as a recording keeps it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Bits of RecordedStep::flags.
enum RecordedFlag : std::uint32_t {
  kRecordedReadFailed = 1u << 0,   // the device told no pose
  kRecordedWriteFailed = 1u << 1,  // it did not take the force
  kRecordedForceOff = 1u << 2,     // no force in this tick, and a ramp after it
  kRecordedSetDown = 1u << 3,      // no tick: the tool was lifted and set down at X
  kRecordedPieceLeaves = 1u << 4,  // after this tick `piece` began to leave the bone
  kRecordedCheckpoint = 1u << 5,   // before this tick `checkpoint` was made
  kRecordedUndo = 1u << 6,         // before this tick the bone began to go back to `checkpoint`
  kRecordedRedo = 1u << 7,         // and forth again to where it was before that
  kRecordedTakenUp = 1u << 8,      // from this tick on somebody else, or at another time, went on
};
inline constexpr std::uint32_t kRecordedFlags = (1u << 9) - 1;

struct RecordedStep {
  Pose X;  // in a hand: the handle as the device told it; on a path: the tool at the end of the tick
  std::uint32_t buttons = 0;
  double dt_s = 0.001;        // that the simulation went on by
  std::uint32_t skipped = 0;  // deadlines of a loop that were missed before it
  double rpm = 0;
  std::uint32_t flags = 0;
  std::uint8_t fidelity = 0;  // asked for
  std::uint32_t piece = 0;    // their numbers, where a flag names them
  std::uint32_t checkpoint = 0;
  // 16 bits of a hash each, or 8 (RecordingHead::check_bits): of the forces and the tool's pose, and of all voxels that
  // have changed.
  std::uint16_t force_check = 0;
  std::uint16_t bone_check = 0;
};

/// How long after the step before it, s, by the clock of the loop or the path. A set-down takes no time.
inline double CalcElapsed(const RecordedStep& step, double rate_hz) {
  if ((step.flags & kRecordedSetDown) != 0) return 0;
  return step.skipped == 0 ? step.dt_s : (1.0 + step.skipped) / rate_hz;
}

/// How things stood after a tick, rounded: to look at, not to go by.
struct RecordedState {
  std::uint64_t step = 0;    // the how-manieth, from 0
  double time_s = 0;         // to 1 us
  Vec3 p_WT_mm{0};           // tool, to 1 um
  Vec3 f_N{0};               // on the hand, or on the path on the tool, before a device's scale, to 1 mN
  double removed_mm3 = 0;    // so far, by occupancy, to 1e-3
  double engaged_teeth = 0;  // to 1e-3
};

/// The first column in which they differ, rounded as they are kept, with both values; empty when none does.
std::string DescribeDifference(const RecordedState& recorded, const RecordedState& now);

/// Hashes after a tick: of all forces and poses so far, and of all voxels that have changed so far.
struct RecordedHash {
  std::uint64_t step = 0;
  std::uint64_t force = 0;
  std::uint64_t bone = 0;
};

/// Steps one after another, with what was noted among them.
struct RecordedBlock {
  std::uint64_t first_step = 0;
  double first_time_s = 0;  // before them
  std::vector<RecordedStep> steps;
  std::vector<RecordedState> states;
  std::vector<RecordedHash> hashes;
};

inline constexpr std::size_t kMostStepsInBlock = 8192;

/// Exact for steps, whatever is in them, NaN too. At most kMostStepsInBlock of them.
std::string EncodeBlock(const RecordedBlock& block);
/// Throws Error for bytes that are no block.
RecordedBlock DecodeBlock(std::string_view bytes);

}  // namespace kerf
