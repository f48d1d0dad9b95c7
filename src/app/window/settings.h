// Settings of the window that are kept between sessions.
#pragma once

#include <string>
#include <vector>

#include "view/ui/ui.h"

namespace kerf {

struct WindowSettings {
  Theme theme = Theme::kLight;
  double text_size = 1;  // kTextSizeRange
  std::string language;  // code; empty: that of the environment
  double volume = 0.5;   // 0 to 1
  bool mute = false;
  bool tour_shown = false;          // the tour was finished or skipped
  std::string student;              // who practised last; empty: no name was entered
  std::string save_folder;          // of the project that was saved last; empty: none
  std::vector<std::string> recent;  // files and folders that were opened, latest first; at most kMaxRecent
};
inline constexpr std::size_t kMaxRecent = 8;

/// Returns $XDG_CONFIG_HOME/kerf/window.json, or ~/.config/kerf/window.json; empty if neither variable is set.
std::string FindSettingsFile();
/// Reads the settings. A missing file gives the defaults. Throws Error if the file cannot be read or is damaged.
WindowSettings ReadSettings(const std::string& path);
/// Replaces the file, and makes its folder if necessary. Does nothing for an empty path. Throws Error.
void WriteSettings(const WindowSettings& settings, const std::string& path);
/// Puts a file first in the list of recent ones.
void AddRecent(WindowSettings& settings, const std::string& path);
/// Returns the folder in which a new project is probably saved: the one used last, the user's documents, or the user's
/// home; "." if there is none. It is not that of a CT, where nothing may be written.
std::string FindSaveFolder(const WindowSettings& settings);
/// Returns the folder of the latest recent file, where the next one is probably looked for; "." if there is none.
std::string FindRecentFolder(const WindowSettings& settings);

}  // namespace kerf
