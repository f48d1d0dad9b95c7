#include "view/live/overlay_colours.h"

namespace kerf {

SceneColours SceneColoursOf(Theme theme) {
  if (theme == Theme::kDark) return {{52, 58, 67}, {30, 34, 40}, {236, 239, 243}, {38, 43, 50}};
  return {{153, 168, 186}, {204, 212, 222}, {26, 29, 36}, {255, 255, 255}};
}

Rgb8 AlarmColour(AlarmLevel level) {
  switch (level) {
    case AlarmLevel::kDanger:
      return {190, 40, 20};
    case AlarmLevel::kWarning:
      return {230, 159, 0};
    case AlarmLevel::kNotice:
    case AlarmLevel::kNone:
      break;
  }
  return {0, 92, 150};
}

}  // namespace kerf
