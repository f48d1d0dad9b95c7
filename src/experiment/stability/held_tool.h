// A tool brought to where a loop is tried, and whether a kick of the handle dies out there.
#pragma once

#include <optional>

#include "experiment/stability/margins.h"

namespace kerf {

struct HeldTool {
  Bone bone;           // cut on the way, where the state asks for it
  Pose X_WT;           // the tool
  Vec3 push_W{0};      // the way in which the hand pushes, unit length
  double rpm = 0;      // of the spindle
  double push_N = 0;   // in the simulation's newtons; less where the device can't bear it
  bool feeds = false;  // the tool goes ahead while it is pushed
  bool slips = false;  // it rubs across the push
};

/// Brings the tool there with a slow, soft pull and takes it out of that hand. On an edge a stopped tool is pushed
/// squarely, not along the feed, by which it would slide off. Throws Error when it meets no bone.
HeldTool HoldTool(const StabilitySubject& subject, HeldState state);

/// How a small kick of the handle along the push goes on while friction and encoder steps of the profile don't count:
/// two loops run side by side, one kicked, and only their difference is looked at, which is linear whatever the rest
/// does.
///
/// The logarithm's growth per second of the difference's swing: below 0 it dies out. None when the tool left its place
/// before that could be told, through the bone or off an edge, as it does in a hand in which nothing swings too.
std::optional<double> FindGrowth(const HeldTool& held, const ClosedLoopSetup& setup);

/// As TryState().
Behaviour TryHeld(const HeldTool& held, const ClosedLoopSetup& setup, bool linear);

/// As FindMargins().
Margins FindHeldMargins(const HeldTool& held, const ClosedLoopSetup& setup, bool linear, double most_gain = 64);

}  // namespace kerf
