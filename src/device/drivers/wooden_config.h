// Configuration file with the dimensions of a WoodenHaptics-type device (docs/wooden.md).
#pragma once

#include <string>

#include "device/devices/hid/wooden_params.h"

namespace kerf {

/// Parses TOML whose keys are those of WoodenParams; absent keys have the values of the 2016 wooden build. Throws a
/// kerf::Error that lists each fault with its `file`:line:column: an unknown key (with the nearest one), a wrong type,
/// a value out of range, a gear or count of 0, too many counts per turn of a joint, or an arm that cannot reach its
/// workspace.
WoodenParams ParseWoodenConfig(const std::string& text, const std::string& file);
/// Reads and parses such a file.
WoodenParams ReadWoodenConfig(const std::string& path);

}  // namespace kerf
