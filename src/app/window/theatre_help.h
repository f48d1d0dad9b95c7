// The keys that work in every activity of the theatre.
#pragma once

#include <vector>

#include "view/live/hud.h"

namespace kerf {

std::vector<HudKeyGroup> TheatreHelp();

}  // namespace kerf
