#include "kerf/tool.h"

#include <fmt/format.h>

#include "kerf/error.h"

namespace kerf {
namespace {

void CheckRange(const char* name, double value, double lower, double upper) {
  if (!(value >= lower && value <= upper)) {
    throw Error(fmt::format("{} = {} is out of range; valid range {} to {}", name, value, lower, upper));
  }
}

}  // namespace

void DiscSaw::Validate() const {
  CheckRange("diameter_mm", diameter_mm, 1, 200);
  CheckRange("thickness_mm", thickness_mm, 0.02, 10);
  CheckRange("teeth", teeth, 1, 1000);
  CheckRange("E_MPa", E_MPa, 1, 1e9);
  CheckRange("nu", nu, 0, 0.5);
  for (int axis = 0; axis < 3; ++axis) CheckRange("grip_mm", p_TG_mm[axis], -1000, 1000);
}

}  // namespace kerf
