#include <cmath>

#include "device/devices/haply/haply_message.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(haply_message) {
  HaplyState state;
  if (ReadHaplyMessage(bytes, "", state) != HaplyReading::kOk) return;
  for (int i = 0; i < 3; ++i) {
    if (!(std::abs(state.p_H_mm[i]) <= 10'000)) Finding(fmt::format("the cursor at {} mm", state.p_H_mm[i]));
  }
  // The device must be found by its own id, and a reply must be written for it.
  HaplyState again;
  if (ReadHaplyMessage(bytes, state.id, again) != HaplyReading::kOk)
    Finding("a device that is not found by its own id");
  if (WriteHaplyForce(state.id, {1, 2, 3}).empty()) Finding("no message");
}

}  // namespace kerf::fuzz
