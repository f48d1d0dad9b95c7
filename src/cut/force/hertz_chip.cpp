// hertz_chip: a^2 = R delta with the bite delta, so F = 4/3 E* sqrt(R) delta^(3/2).
#include <cmath>

#include "cut/force/hertz.h"
#include "cut/force/laws.h"

namespace kerf {
namespace {

// coefficients: R, mm.
double CalcChipForce(const LawValues& c, double bite_mm, double E_star_MPa) {
  return CalcHertzForce(std::sqrt(c[0] * bite_mm), c[0], E_star_MPa);
}

}  // namespace

const ForceLawInfo& HertzChip() {
  static const ForceLawInfo kLaw{"hertz_chip",
                                 "grows with the bite: Hertz's sphere pressed in as deep as the tooth bites",
                                 "Hertz; the disc taken as the sphere, as in the paper (docs/physics.md)",
                                 {0, 0.003, "",
                                  "beyond it gives more than twice the measured thrust; feed more slowly or turn "
                                  "faster"},
                                 {kContactRadius},
                                 [](const LawValues& values, const Tooth& tooth) {
                                   return ToothForce{CalcChipForce, {ContactRadius(values[0], tooth)}};
                                 }};
  return kLaw;
}

}  // namespace kerf
