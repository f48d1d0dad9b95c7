// Configuration file with the dimensions of a WoodenHaptics-type device (docs/wooden.md).
#pragma once

#include <string>

#include "device/devices/hid/wooden_params.h"

namespace kerf {

/// Parses TOML whose keys are those of WoodenParams; absent keys have the values of the 2016 wooden build. Throws
/// kerf::Error with `file`:line:column for each fault: unknown key (with the nearest), wrong type, out of range, a gear
/// or count of 0, an arm that cannot reach its workspace.
WoodenParams ParseWoodenConfig(const std::string& text, const std::string& file);
/// The same from a file.
WoodenParams ReadWoodenConfig(const std::string& path);

}  // namespace kerf
