// Inputs of a tick, and what a recording stores of a tick.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Bits of TickInputs::flags.
enum RecordedFlag : std::uint32_t {
  kRecordedReadFailed = 1u << 0,   // the device returned no pose
  kRecordedWriteFailed = 1u << 1,  // the device did not accept the force
  kRecordedForceOff = 1u << 2,     // no force in this tick, and a ramp after it
  kRecordedSetDown = 1u << 3,      // no tick: the tool was retracted and set down at X
  kRecordedPieceLeaves = 1u << 4,  // after this tick, `piece` began to leave the bone
  kRecordedCheckpoint = 1u << 5,   // before this tick, `checkpoint` was made
  kRecordedUndo = 1u << 6,         // before this tick, an undo to `checkpoint` began
  kRecordedRedo = 1u << 7,         // before this tick, a redo to `checkpoint` began
  kRecordedTakenUp = 1u << 8,      // from this tick on, the session was continued by another user or at another time
  kRecordedCarried = 1u << 9,      // the hand was moved to X, and the tool was set down there without touching bone
};
inline constexpr std::uint32_t kRecordedFlags = (1u << 10) - 1;

/// All inputs of a tick, with what the session does just before or after it: the same inputs reproduce the tick bit for
/// bit. They travel from the loop's body, which fills them in, to the recording.
struct TickInputs {
  Pose X = {};  // coupled: handle pose as reported by the device; on a path: tool pose at the end of the tick
  std::uint32_t buttons = 0;
  double dt_s = 0.001;        // time step of the simulation
  std::uint32_t skipped = 0;  // number of deadlines that the loop missed before this step
  double rpm = 0;
  std::uint32_t flags = 0;
  std::uint8_t fidelity = 0;  // requested fidelity
  std::uint32_t piece = 0;    // valid only if a flag refers to it; the same applies to `checkpoint`
  std::uint32_t checkpoint = 0;
};

struct RecordedStep : TickInputs {
  // Hashes truncated to 16 bits, or to 8 (RecordingHeader::check_bits): one of the forces and the tool's pose, and one
  // of all changed voxels.
  std::uint16_t force_check = 0;
  std::uint16_t bone_check = 0;
};

/// Returns the time since the previous step, s, by the clock of the loop or the path. A set-down takes no time.
inline double CalcElapsed(const TickInputs& step, double rate_hz) {
  if ((step.flags & kRecordedSetDown) != 0) return 0;
  return step.skipped == 0 ? step.dt_s : (1.0 + step.skipped) / rate_hz;
}

/// Rounded state after a tick, for display only; a replay does not use it.
struct RecordedState {
  std::uint64_t step = 0;    // zero-based index
  double time_s = 0;         // to 1 us
  Vec3 p_WT_mm{0};           // position of the tool, to 1 um
  Vec3 f_N{0};               // on the hand, or on the tool for a path, before scaling for a device; to 1 mN
  double removed_mm3 = 0;    // total so far, by occupancy, to 1e-3 mm3
  double engaged_teeth = 0;  // to 1e-3
};

/// Describes the first column in which the rounded values differ, with both values. Returns "" if none differs.
std::string DescribeDifference(const RecordedState& recorded, const RecordedState& now);

/// Hashes after a tick: one of all forces and poses so far, and one of all voxels that have changed so far.
struct RecordedHash {
  std::uint64_t step = 0;
  std::uint64_t force = 0;
  std::uint64_t bone = 0;
};

/// Consecutive steps, with the states and hashes that were recorded among them.
struct RecordedBlock {
  std::uint64_t first_step = 0;
  double first_time_s = 0;  // time before the first step
  std::vector<RecordedStep> steps;
  std::vector<RecordedState> states;
  std::vector<RecordedHash> hashes;
};

inline constexpr std::size_t kMaxStepsInBlock = 8192;

/// Encodes at most kMaxStepsInBlock steps without loss, whatever their values, including NaN.
std::string EncodeBlock(const RecordedBlock& block);
/// Throws kerf::Error if `bytes` are not a block.
RecordedBlock DecodeBlock(std::string_view bytes);

}  // namespace kerf
