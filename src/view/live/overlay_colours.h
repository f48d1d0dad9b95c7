// Colours of the picture that depend on the theme or on an alarm's level. Pure.
#pragma once

#include "view/live/overlays.h"

namespace kerf {

struct SceneColours {
  Rgb8 top;     // background, at the top of the window
  Rgb8 bottom;  // at its bottom
  Rgb8 text;    // on the picture
  Rgb8 ground;  // behind this text
};
SceneColours SceneColoursOf(Theme theme);

/// Colour of a level; distinguishable with any colour vision.
Rgb8 AlarmColour(AlarmLevel level);

}  // namespace kerf
