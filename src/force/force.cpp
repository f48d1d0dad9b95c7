#include "kerf/force.h"

#include <cmath>

#include "kerf/error.h"

namespace kerf {

double ToothForce::operator()(double bite_mm, double E_star_MPa) const {
  if (bite_mm <= 0) return 0;
  const double a = kind == ForceLawKind::kHertzChip ? std::sqrt(R_mm * bite_mm) : a_mm;
  return 4.0 / 3.0 * E_star_MPa * a * a * a / R_mm;
}

ToothForce MakeToothForce(const ForceLaw& law, const DiscSaw& saw) {
  if (!(law.contact_radius_mm >= 0 && law.contact_radius_mm <= 1000)) {
    throw Error("contact_radius_mm is out of range; valid range 0 to 1000 mm");
  }
  if (!(law.contact_share_of_pitch > 0 && law.contact_share_of_pitch <= 1)) {
    throw Error("contact_share_of_pitch is out of range; valid range above 0 to 1");
  }
  return {law.kind, law.contact_radius_mm > 0 ? law.contact_radius_mm : saw.radius_mm(),
          law.contact_share_of_pitch * saw.pitch_mm()};
}

const char* ToString(ForceLawKind kind) {
  return kind == ForceLawKind::kHertzChip ? "hertz_chip" : "hertz_constant_bite";
}

}  // namespace kerf
