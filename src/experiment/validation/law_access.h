// The only calls of force laws in this folder.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kerf/force.h"
#include "kerf/tool.h"

namespace kerf {

/// Forces on one tooth, N.
struct ToothForces {
  double thrust_N = 0;
  double cutting_N = 0;  // from the law, or thrust / kThrustPerCuttingForce
};

/// State of a tooth in the bone of the measurements (cut/force/measured.h).
struct ToothState {
  double bite_mm = 0;
  double speed_mm_per_s = 0;
  double density = 1;  // relative; E ~ density^b, with the b of the law, or 1.93 if the law has none
};

/// A law prepared for a tool that cuts the bone of the measurements.
class LawOnTooth {
 public:
  /// Throws Error if a parameter is out of range.
  LawOnTooth(const ForceLaw& law, const Tool& tool);
  ToothForces operator()(const ToothState& state) const;

 private:
  ToothForce force_;
  Tool tool_;
  double modulus_exponent_;
};

/// Returns true if the law has a cutting force of its own.
bool HasCuttingForce(const ForceLaw& law);
/// Returns the names of the laws that a set may name as calibrated with it.
std::vector<std::string> LawNames();

/// Returns a disc with teeth of this width for which the laws have the values that docs/physics.md gives: the disc of
/// the paper, of 22 mm with 24 teeth. Hertz's laws ignore the width and depend on the disc instead.
DiscSaw MakeReferenceDisc(double width_mm);
/// Returns `law` with the parameters that make its force on a tooth of `to` that on a tooth of `from`, which must have
/// equal widths: Hertz's laws depend on radius and pitch of the tool.
ForceLaw TransferLaw(const ForceLaw& law, const DiscSaw& from, const Tool& to);

}  // namespace kerf
