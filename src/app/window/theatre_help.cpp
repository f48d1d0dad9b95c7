#include "app/window/theatre_help.h"

namespace kerf {

std::vector<HudKeyGroup> TheatreHelp() {
  return {{"Saw",
           {{"Space", "spindle on, off"},
            {"left drag", "move across the picture"},
            {"Shift + left drag", "move into the picture"},
            {"Ctrl + left drag", "turn"},
            {"arrows, PgUp PgDn", "the same by keys; Shift: fast"},
            {"W S  A D  Q E", "turn: tilt, swing, roll"},
            {"[  ]", "keys move slower, faster"},
            {"L", "stay in the blade's plane"},
            {"R", "back to where it began"}}},
          {"View",
           {{"right drag", "turn the view"},
            {"middle drag", "shift the view (or Shift + right drag)"},
            {"wheel", "nearer, further"},
            {"V", "next of front, left, top, ..."},
            {"Home", "show all"},
            {"T", "translucent: nerve and roots"},
            {"M", "colours: plain, tissue, region"},
            {"X", "CT slices"},
            {"F12", "picture into a file"},
            {"F1  ?", "this help"},
            {"Ctrl+Q", "end"}}}};
}

}  // namespace kerf
