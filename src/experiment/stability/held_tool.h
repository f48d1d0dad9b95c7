// A tool in the place where a loop is tested, and a test of whether a kick of the handle decays there.
#pragma once

#include <optional>

#include "experiment/stability/margins.h"

namespace kerf {

struct HeldTool {
  Bone bone;           // cut on the way, if the state requires it
  Pose X_WT;           // the tool
  Vec3 push_W{0};      // direction in which the hand pushes, unit length
  double rpm = 0;      // of the spindle
  double push_N = 0;   // simulated newtons; reduced for a device or coupling that cannot bear it
  bool feeds = false;  // the tool advances while it is pushed
  bool slips = false;  // the tool's surface slips across the push
};

/// Brings the tool into place with a slow, soft pull and then releases it. On an edge a stopped tool is pushed along
/// the contact normal, because along the feed it would slide off. Throws Error if the tool touches no bone.
HeldTool HoldTool(const StabilitySubject& subject, HeldState state);

inline constexpr double kHardPush_N = 5;  // simulated newtons
/// Fastest feed at which a loop is examined while the tool must remain in the cut; ordinary cuts have 0.5 to 2 mm/s.
inline constexpr double kFastFeed_mm_per_s = 10;

/// Returns the force that a feed of kFastFeed_mm_per_s into the bone requires, simulated newtons; nullopt if it is more
/// than kHardPush_N, or if the tool is through the bone before its feed is steady.
std::optional<double> FindFeedForce_N(const StabilitySubject& subject);

/// Computes how a small kick of the handle along the push evolves, without the friction and the encoder steps of the
/// profile. Two loops run side by side, one of them kicked. Only their difference is examined, which is linear
/// even if the loops are not.
///
/// Returns the growth rate of the logarithm of the difference's amplitude, 1/s; negative if it decays. Returns nullopt
/// if the tool left its place, through the bone or off an edge, before the result was clear, provided that it does so
/// with an overdamped hand too.
std::optional<double> FindGrowth(const HeldTool& held, const ClosedLoopSetup& setup);

/// Kicks the handle and observes the result. Friction and encoder steps of the profile are included unless `linear` is
/// true; even then the coupling's damper has the delay that the encoder causes.
Behaviour TryHeld(const HeldTool& held, const ClosedLoopSetup& setup, bool linear);

/// Finds the margins by bisection, the gain to within 2 %. `linear` as for TryHeld().
Margins FindHeldMargins(const HeldTool& held, const ClosedLoopSetup& setup, bool linear, double max_gain = 64);

}  // namespace kerf
