// Force laws: the force on one tooth from its bite and the material it cuts.
#pragma once

#include <string>

#include "kerf/tool.h"

namespace kerf {

enum class ForceLawKind {
  kHertzChip,          // "hertz_chip": a^2 = R delta, grows with the bite
  kHertzConstantBite,  // "hertz_constant_bite": a is a fixed share of the pitch, a yield force
};

struct ForceLaw {
  ForceLawKind kind = ForceLawKind::kHertzChip;
  /// R in a^2 = R delta, mm; 0 means half the disc's diameter, the paper's choice (the disc as Hertz's sphere).
  double contact_radius_mm = 0;
  /// Constant bite only: a as a share of the tooth pitch.
  double contact_share_of_pitch = 0.01;
};

/// A force law made ready for one tool: no lookups left in the tick.
struct ToothForce {
  ForceLawKind kind;
  double R_mm;
  double a_mm;  // constant bite only

  /// Radial (thrust) force on a tooth that bites `bite_mm` deep into material of reduced modulus `E_star_MPa`, N, >= 0.
  /// hertz_chip:          F = 4/3 E* sqrt(R) delta^(3/2)          [Hertz, sphere on half space]
  /// hertz_constant_bite: F = 4/3 E* a^3 / R for delta > 0, else 0 [the same with a given; the paper's (a/K)^3]
  /// Valid for bites up to about 5 um; beyond, measured thrust grows much more slowly (docs/physics.md). Tick-safe.
  double operator()(double bite_mm, double E_star_MPa) const;
};

ToothForce MakeToothForce(const ForceLaw& law, const DiscSaw& saw);
const char* ToString(ForceLawKind kind);

}  // namespace kerf
