// What the menu of saws says of a saw, in the window's language.
#pragma once

#include <string>

#include "session/scene/saws.h"

namespace kerf {

/// Returns its most important numbers, such as "22 x 0.25 mm, 24 teeth, 7,500 rpm".
std::string ShowSawNumbers(const Saw& saw);
/// Returns the source of its numbers.
std::string ShowSawSource(const Saw& saw);

}  // namespace kerf
