#include <cmath>

#include "device/devices/hid/wooden_kinematics.h"
#include "device/drivers/wooden_config.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(wooden_arm) {
  WoodenParams params;
  if (!Accepts([&] { params = ParseWoodenConfig(std::string(bytes), "fuzz.toml"); })) return;
  // Positions and currents must be finite for every accepted arm.
  const Vec3 angles = CalcWoodenAngles(params, {-12345, 32767, 1});
  const Vec3 p_D_mm = CalcWoodenPosition(params, angles);
  const Vec3 currents_mA = CalcWoodenCurrents(params, angles, {1, -2, 3});
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(p_D_mm[i]) < 1e5)) Finding(fmt::format("the handle at {} mm", p_D_mm[i]));
    if (!(std::abs(currents_mA[i]) < 3000.001)) Finding(fmt::format("a current of {} mA", currents_mA[i]));
  }
}

}  // namespace kerf::fuzz
