// Help on the keys that work in every activity of the viewer.
#pragma once

#include <vector>

#include "view/live/hud.h"

namespace kerf {

std::vector<HudKeyGroup> ViewerHelp();

}  // namespace kerf
