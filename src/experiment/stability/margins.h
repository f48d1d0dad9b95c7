// How far a loop is from swinging: gain margin, delay margin, and the map over stiffness and damping.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "experiment/stability/closed_loop.h"

namespace kerf {

/// What is examined: a tool, a place on a bone, a device and a hand.
struct StabilitySubject {
  Bone bone;
  ClosedLoopSetup setup;
  Pose X_WT_start;        // the tool, clear of the bone by less than 1 mm
  Vec3 into_W{0, 0, -1};  // the way of the feed from there into the bone, unit length
  double rpm = 7500;
  std::function<bool()> stop = {};  // true: a scenario under way throws Error; may be empty
};

enum class Behaviour : std::uint8_t {
  kStable,
  kLimitCycle,
  kUnstable,
  kNotHeld,  // cannot be told: the tool left its place, through the bone or off an edge, whatever the loop
};
const char* ToString(Behaviour behaviour);

/// What is said of a bound or a margin.
enum class Judgement : std::uint8_t {
  kHolds,
  kBroken,
  kNotJudged,  // it could not be told here, or not all of it; what could be told holds
  kNotAsked,
};
/// "yes", "no", "not judged", "not asked".
const char* ToString(Judgement judgement);

/// The states in which a loop is tried.
enum class HeldState : std::uint8_t {
  kStoppedOnBone,  // spindle off, pushed on the bone: a solid wall, the stiffest there is
  kCutting,        // spindle on, pushed with 5 N
  kInKerf,         // spindle on, some millimetres deep, pushed sideways against a wall of the kerf
};
const char* ToString(HeldState state);
inline constexpr std::array kHeldStates = {HeldState::kStoppedOnBone, HeldState::kCutting, HeldState::kInKerf};

/// Kicks the handle in that state and watches. Friction and encoder steps of the profile count unless `linear`;
/// the coupling's damper then still comes as late as the encoder makes it.
Behaviour TryState(const StabilitySubject& subject, HeldState state, bool linear);

struct Margins {
  double gain = 0;            // the loop gain at which it ceases to be stable
  bool gain_beyond = false;   // it was still stable at that gain, the largest that could be tried
  int delay_ticks = 0;        // whole ticks of further delay that it bears
  bool delay_beyond = false;  // it bore so many, the most that could be tried; at most 16
  /// Why nothing can be told of them here; empty when they can.
  std::string unjudged;
  /// Against the least that is asked.
  Judgement Judge(double least_gain, int least_delay_ticks) const;
};
/// By bisection, the gain to 2 %. `linear` as above.
Margins FindMargins(const StabilitySubject& subject, HeldState state, bool linear, double most_gain = 64);

/// The loop of another device and hand, its coupling lowered as `kerf loop` would for the hand `fitted_to`.
ClosedLoopSetup FitSetup(ClosedLoopSetup setup, const DeviceProfile& profile, const HandModel& hand,
                         const HandModel& fitted_to);

struct ProfileMargins {
  std::string profile;
  std::string hand;
  std::string fitted_to;    // the hand by which the coupling was fitted: the same, but for a device that is let go of
  CouplingParams coupling;  // as the simulation has it
  double force_scale = 1;   // device N per simulation N
  std::array<Margins, kHeldStates.size()> margins;  // in the order of kHeldStates, linear
};
/// Each profile with each hand, and let go of with the coupling fitted to H3. What `subject` has of device and hand is
/// not looked at; its coupling is what is asked for. About 2 s for each row on a block of 0.2 mm. Ends between two
/// margins when `stop` (may be null) says so, with the rows that are whole.
std::vector<ProfileMargins> CalcProfileMargins(const StabilitySubject& subject,
                                               const std::vector<DeviceProfile>& profiles,
                                               const std::function<void(double)>& progress = {},
                                               const std::atomic<bool>* stop = nullptr);

/// Each point of stiffness by damping (as the simulation has them), row by row from the least damping. With the
/// encoder's steps, but without the device's friction, which would hide much and is known of few devices. A limit
/// cycle: the handle goes on swaying by more than a step of the encoder, but not from the bone and back. About 0.1 s a
/// point.
struct StabilityMap {
  std::vector<double> stiffness_N_per_mm;
  std::vector<double> damping_Ns_per_mm;
  std::vector<Behaviour> behaviour;
};
StabilityMap DrawMap(const StabilitySubject& subject, HeldState state, const std::vector<double>& stiffness_N_per_mm,
                     const std::vector<double>& damping_Ns_per_mm, const std::function<void(double)>& progress = {});

}  // namespace kerf
