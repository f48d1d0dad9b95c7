// Small picture of a tool for menus, drawn without a graphics processor. Pure.
#pragma once

#include "kerf/tool.h"
#include "view/picture/image.h"

namespace kerf {

/// Draws a tool as large as the picture allows, its longest side from left to right: a blade from its flat, any other
/// tool from the side. Sizes in pixels, at least 1. Throws kerf::Error for an invalid tool.
Image DrawToolIcon(const Tool& tool, int width, int height);

}  // namespace kerf
