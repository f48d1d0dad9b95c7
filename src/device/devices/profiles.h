// Table of the capabilities of haptic devices, either kerf's own or one that the user supplies.
#pragma once

#include <string>
#include <vector>

#include "kerf/device.h"

namespace kerf {

/// Parses CSV in the format of volumes/device_profiles.csv. Each value is followed by a letter for its reliability (S:
/// read in the source, R: recalled, A: assumed), or is `none` or `unknown`, which both become 0. The names of values
/// that are not S are appended to `source`. `file` is the name used in messages. Throws kerf::Error with file:line at
/// the first fault.
std::vector<DeviceProfile> ParseDeviceProfiles(const std::string& text, const std::string& file);

/// Returns the built-in volumes/device_profiles.csv. Its first entry, `ideal`, is not a real device and has no
/// relevant limits.
const std::vector<DeviceProfile>& DeviceProfiles();

/// Returns the profile of that name. If there is none, throws a kerf::Error that suggests the most similar name, or
/// lists all names if none is similar.
const DeviceProfile& FindDeviceProfile(const std::vector<DeviceProfile>& profiles, const std::string& name);
const DeviceProfile& FindDeviceProfile(const std::string& name);  // of the built-in profiles

}  // namespace kerf
