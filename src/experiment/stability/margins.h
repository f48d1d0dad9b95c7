// Distance of a loop from oscillation: gain margin, delay margin, and the map over stiffness and damping.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "experiment/stability/closed_loop.h"

namespace kerf {

/// The combination that is examined: a tool, a place on a bone, a device and a hand.
struct StabilitySubject {
  Bone bone;
  ClosedLoopSetup setup;
  Pose X_WT_start;        // the tool, clear of the bone by less than 1 mm
  Vec3 into_W{0, 0, -1};  // direction of the feed from there into the bone, unit length
  double rpm = 7500;
  std::function<bool()> stop = {};  // optional; once it returns true, a running scenario throws Error
};

enum class Behaviour : std::uint8_t {
  kStable,
  kLimitCycle,
  kUnstable,
  kNotHeld,  // unknown, because the tool left its place (through the bone or off an edge), for which the loop is not
             // the cause
};
const char* ToString(Behaviour behaviour);

/// The result of comparing a figure with its bound, or a margin with its required minimum.
enum class Judgement : std::uint8_t {
  kHolds,
  kBroken,
  kNotJudged,  // could not be judged here, at least in part; the part that could be judged holds
  kNotAsked,
};
/// Returns "yes", "no", "not judged" or "not asked".
const char* ToString(Judgement judgement);

/// The states in which a loop is tested.
enum class HeldState : std::uint8_t {
  kStoppedOnBone,  // spindle off, pushed against the bone: a solid wall, the stiffest case
  kCutting,        // spindle on, pushed with 5 N
  kInKerf,         // spindle on, a few millimetres deep, pushed sideways against a wall of the kerf
};
const char* ToString(HeldState state);
inline constexpr std::array kHeldStates = {HeldState::kStoppedOnBone, HeldState::kCutting, HeldState::kInKerf};

struct Margins {
  double gain = 0;            // loop gain at which the loop ceases to be stable
  bool gain_beyond = false;   // the loop was still stable at that gain, the largest that could be tested
  int delay_ticks = 0;        // additional delay that the loop tolerates, whole ticks
  bool delay_beyond = false;  // that delay, which the loop tolerated, is the largest that could be tested; at most 16
  /// Reason why the margins are unknown here; empty if they are known.
  std::string unjudged;
  /// Compares with the required minimums.
  Judgement Judge(double min_gain, int min_delay_ticks) const;
};

/// Returns the loop of another device and hand, with the coupling reduced as `kerf loop` would reduce it for the hand
/// `fitted_to`.
ClosedLoopSetup FitSetup(ClosedLoopSetup setup, const DeviceProfile& profile, const HandModel& hand,
                         const HandModel& fitted_to);

struct ProfileMargins {
  std::string profile;
  std::string hand;
  std::string fitted_to;    // hand that the coupling was fitted to: the same hand, except for a released device
  CouplingParams coupling;  // as in the simulation
  double force_scale = 1;   // device N per simulation N
  std::array<Margins, kHeldStates.size()> margins;  // in the order of kHeldStates, linear
};
/// Computes the margins of each profile with each hand, and of each profile released with the coupling fitted to H3.
/// The device and the hand of `subject` are ignored; its coupling is the requested one. Takes about 2 s per row on a
/// block with 0.2 mm voxels. If `stop` (may be null) becomes true, stops after the current margin and returns the
/// complete rows.
std::vector<ProfileMargins> CalcProfileMargins(const StabilitySubject& subject,
                                               const std::vector<DeviceProfile>& profiles,
                                               const std::function<void(double)>& progress = {},
                                               const std::atomic<bool>* stop = nullptr);

/// The behaviour at each pair of stiffness and damping (in simulation units), row by row from the lowest damping.
/// Includes the encoder steps but not the device's friction, which would mask many effects and is known for few
/// devices. In a limit cycle the handle keeps oscillating by more than an encoder step, but the tool does not bounce
/// off the bone. Takes about 0.1 s per point.
struct StabilityMap {
  std::vector<double> stiffness_N_per_mm;
  std::vector<double> damping_Ns_per_mm;
  std::vector<Behaviour> behaviour;
};

}  // namespace kerf
