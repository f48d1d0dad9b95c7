// hertz_chip: a^2 = R delta with the bite delta, so F = 4/3 E* sqrt(R) delta^(3/2).
#include <cmath>

#include "cut/force/hertz.h"
#include "cut/force/laws.h"
#include "cut/force/measured.h"

namespace kerf {
namespace {

// coefficients: R, mm.
double CalcChipThrust(const ToothForce& law, double bite_mm, const ToothCut& cut) {
  return CalcHertzForce(std::sqrt(law.c[0] * bite_mm), law.c[0], cut.E_star_MPa);
}

}  // namespace

const ForceLawInfo& HertzChip() {
  static const ForceLawInfo kLaw{
      "hertz_chip",
      "grows with the bite: Hertz's sphere pressed in as deep as the tooth bites",
      "Hertz; a sphere of the tool's radius, as the paper takes its disc (docs/physics.md)",
      {kMinMeasuredBite_mm, 0.003, "",
       "beyond it gives more than twice the measured thrust; feed more slowly or turn "
       "faster"},
      {kContactRadius},
      [](const LawValues& values, const Tooth& tooth, const std::shared_ptr<const ForceTable>&) {
        return ToothForce{.thrust = CalcChipThrust, .c = {ContactRadius(values[0], tooth)}};
      }};
  return kLaw;
}

}  // namespace kerf
