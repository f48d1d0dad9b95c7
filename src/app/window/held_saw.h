// Why a saw does not follow the hand.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "kerf/coupled.h"
#include "kerf/tool.h"

namespace kerf {

/// Cause that holds the saw.
enum class HeldReason : std::uint8_t {
  kGuidePlane,  // the guide keeps it in the planned plane
  kGuideDepth,  // the guide's depth stop, or an end of its slot
  kBinds,       // the walls of the kerf hold the blade sideways, or against turning
  kSpindleOff,  // bone is in the way of a blade that does not turn
  kForceLimit,  // it presses with the largest force of the coupling
  kFedTooFast,  // the teeth cut, but not as fast as the hand moves
  kMetal,       // the edge rests on metal, which it does not cut
  kNoMemory,    // the simulation prepares memory for more cut bone
  kNotCut,      // bone is in the way of a part of the tool that does not cut, such as the middle of the blade
};

/// State of the saw and its hand at one moment. Vectors are in the world frame.
struct HeldSawInput {
  Tool tool;
  Pose X_WT;           // of the saw
  Pose X_wanted;       // where the user wants it, in terms of the tool frame
  bool holds = false;  // the user moves the saw
  bool spindle_on = false;
  CoupledOutput coupled;                // the last tick
  std::optional<double> guide_force_N;  // force of the guide effect on the tool; none: no guide
  Vec3 guide_normal_W{0, 0, 1};         // normal of the guide's plane, unit length
};

/// Leads and forces from which on the user is taken to want a motion that something prevents.
inline constexpr double kHeldLead_mm = 3;
inline constexpr double kHeldLead_rad = 0.1;
inline constexpr double kHeldForce_N = 1.5;

/// Returns true if the user wants to move the saw farther than it is, or presses it.
bool WantsMotion(const HeldSawInput& in);
/// Returns what prevents the motion that the user wants; nullopt if nothing touches the saw or no motion is wanted.
/// Does not consider whether the saw moves: see HeldSawWatch.
std::optional<HeldReason> DiagnoseHeldSaw(const HeldSawInput& in);
/// Returns the cause and what to do about it, one or two sentences.
const char* DescribeHeldReason(HeldReason reason);

/// Detects that a saw has not followed the hand for a second.
class HeldSawWatch {
 public:
  static constexpr double kHeldFor_s = 1;
  static constexpr double kMoved_mm = 0.4;
  static constexpr double kMoved_rad = 0.02;

  /// Must be called once per frame; `dt_s`: time since the last frame.
  void Update(double dt_s, const HeldSawInput& in);
  /// Returns the cause while the saw is held; nullopt otherwise.
  const std::optional<HeldReason>& reason() const { return reason_; }

 private:
  std::optional<HeldReason> reason_;
  Pose X_from_;          // where the saw was when it last moved
  double stands_s_ = 0;  // time since then
};

}  // namespace kerf
