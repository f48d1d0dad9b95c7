// hertz_constant_bite: a is a fixed fraction of the pitch, so F = 4/3 E* a^3 / R for any bite: a yield force, the
// paper's (a / K)^3.
#include "cut/force/hertz.h"
#include "cut/force/laws.h"

namespace kerf {
namespace {

// coefficients: R, mm; a, mm.
double CalcYieldThrust(const ToothForce& law, double, const ToothCut& cut) {
  return CalcHertzForce(law.c[1], law.c[0], cut.E_star_MPa);
}

}  // namespace

const ForceLawInfo& HertzConstantBite() {
  static const ForceLawInfo kLaw{
      "hertz_constant_bite",
      "the paper's yield force, independent of the feed: a fixed contact radius",
      "the paper, eq. (1), (3) and (4), with Hertz's own 1 - nu^2 (docs/physics.md)",
      // Not valid at any bite.
      {0, 0, "", "gives the same force regardless of the bite"},
      {kContactRadius,
       {"contact_share_of_pitch", 0.01, 1e-6, 0.5, "a tooth's contact radius as a fraction of the tooth pitch"}},
      [](const LawValues& values, const Tooth& tooth, const std::shared_ptr<const ForceTable>&) {
        return ToothForce{.thrust = CalcYieldThrust,
                          .c = {ContactRadius(values[0], tooth), values[1] * tooth.pitch_mm}};
      }};
  return kLaw;
}

}  // namespace kerf
