#include "device/devices/profiles.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(device_profiles) {
  Accepts([&] { FindDeviceProfile(ParseDeviceProfiles(std::string(bytes), "fuzz.csv"), "ideal"); });
}

}  // namespace kerf::fuzz
