#include "app/window/viewer_help.h"

namespace kerf {

std::vector<HudKeyGroup> ViewerHelp() {
  return {{"Saw",
           {{"Space", "spindle on/off"},
            {"left drag", "move across the picture"},
            {"Shift + left drag", "move into the picture"},
            {"Ctrl + left drag", "turn"},
            {"arrows, PgUp PgDn", "the same with keys; Shift: fast"},
            {"W S  A D  Q E", "turn: tilt, swing, roll"},
            {"[  ]", "keys move slower, faster"},
            {"L", "stay in the blade's plane"},
            {"R", "return to the start"}}},
          {"View",
           {{"right drag", "turn the view"},
            {"middle drag", "pan the view (or Shift + right drag)"},
            {"wheel", "zoom"},
            {"V", "next view: front, left, ..."},
            {"Home", "show all"},
            {"T", "translucent: nerve and roots"},
            {"M", "colours: plain, tissue, region"},
            {"X", "CT slices"},
            {"F12", "save a picture"},
            {"F1  ?", "this help"},
            {"Ctrl+Q", "quit"}}}};
}

}  // namespace kerf
