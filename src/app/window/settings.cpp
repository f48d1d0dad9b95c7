#include "app/window/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {

namespace fs = std::filesystem;

std::string FindSettingsFile() {
  const auto get = [](const char* name) {
    const char* value = std::getenv(name);
    return std::string(value == nullptr ? "" : value);
  };
  if (const std::string folder = get("XDG_CONFIG_HOME"); !folder.empty()) return folder + "/kerf/window.json";
  if (const std::string home = get("HOME"); !home.empty()) return home + "/.config/kerf/window.json";
  return {};
}

WindowSettings ReadSettings(const std::string& path) {
  WindowSettings settings;
  if (path.empty() || !fs::exists(path)) return settings;
  try {
    const nlohmann::json json = nlohmann::json::parse(ReadTextFile(path));
    settings.theme = json.value("theme", "light") == "dark" ? Theme::kDark : Theme::kLight;
    settings.text_size = kTextSizeRange.Clamp(json.value("text_size", settings.text_size));
    settings.language = json.value("language", settings.language);
    settings.volume = std::clamp(json.value("volume", settings.volume), 0.0, 1.0);
    settings.mute = json.value("mute", settings.mute);
    settings.tour_shown = json.value("tour_shown", settings.tour_shown);
    settings.student = json.value("student", settings.student);
    settings.recent = json.value("recent", settings.recent);
    if (settings.recent.size() > kMaxRecent) settings.recent.resize(kMaxRecent);
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: this is not a file of window settings; the default settings are used", path));
  }
  return settings;
}

void WriteSettings(const WindowSettings& settings, const std::string& path) {
  if (path.empty()) return;
  const nlohmann::json json{{"theme", settings.theme == Theme::kDark ? "dark" : "light"},
                            {"text_size", settings.text_size},
                            {"language", settings.language},
                            {"volume", settings.volume},
                            {"mute", settings.mute},
                            {"tour_shown", settings.tour_shown},
                            {"student", settings.student},
                            {"recent", settings.recent}};
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  if (error) throw Error(fmt::format("{}: can't be made: {}", fs::path(path).parent_path().string(), error.message()));
  WriteTextFile(path, json.dump(2) + "\n");
}

void AddRecent(WindowSettings& settings, const std::string& path) {
  const std::string absolute = fs::absolute(path).lexically_normal().string();
  std::erase(settings.recent, absolute);
  settings.recent.insert(settings.recent.begin(), absolute);
  if (settings.recent.size() > kMaxRecent) settings.recent.resize(kMaxRecent);
}

std::string FindRecentFolder(const WindowSettings& settings) {
  if (settings.recent.empty()) return ".";
  const std::string folder = fs::path(settings.recent.front()).parent_path().string();
  std::error_code error;
  return fs::is_directory(folder, error) ? folder : ".";
}

}  // namespace kerf
