// The file with the measures of a WoodenHaptics-type device (docs/wooden.md).
#pragma once

#include <string>

#include "device/devices/hid/wooden_params.h"

namespace kerf {

/// TOML, its keys those of WoodenParams; a key that is absent has the value of the wooden build of 2016. Throws Error
/// with `file`:line:column for each fault: unknown key (with the nearest), wrong type, out of range, a gear or number
/// of counts that is 0, an arm that can't reach its workspace.
WoodenParams ParseWoodenConfig(const std::string& text, const std::string& file);
/// The same of a file.
WoodenParams ReadWoodenConfig(const std::string& path);

}  // namespace kerf
