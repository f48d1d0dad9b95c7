// What haptic devices can do: the table that kerf ships, or one of the user's.
#pragma once

#include <string>
#include <vector>

#include "device/devices/device.h"

namespace kerf {

/// CSV as volumes/device_profiles.csv: a figure is followed by a letter that says how sure it is (S read in the source,
/// R recalled, A assumed), or is `none` or `unknown`, which both become 0. Which figures are not S is added to
/// `source`. `file` names the text in messages. Throws Error with file:line for the first fault.
std::vector<DeviceProfile> ParseDeviceProfiles(const std::string& text, const std::string& file);

/// volumes/device_profiles.csv, built in. Its first, `ideal`, is no device: it has no limits that matter.
const std::vector<DeviceProfile>& DeviceProfiles();

/// Throws Error that names the nearest when there is none of that name, or all when none is near.
const DeviceProfile& FindDeviceProfile(const std::vector<DeviceProfile>& profiles, const std::string& name);
const DeviceProfile& FindDeviceProfile(const std::string& name);  // of those built in

}  // namespace kerf
