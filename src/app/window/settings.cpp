#include "app/window/settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "base/files/user_folders.h"
#include "kerf/error.h"

namespace kerf {

namespace fs = std::filesystem;

namespace {

/// Returns the folder of the user's documents as the desktop has set it; empty if it has not.
std::string FindDocuments() {
  std::ifstream in(FindUserFolder(UserFolder::kConfig) + "/user-dirs.dirs");
  constexpr std::string_view kKey = "XDG_DOCUMENTS_DIR=\"";
  constexpr std::string_view kHome = "$HOME";
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(kKey) || line.back() != '"') continue;
    std::string folder = line.substr(kKey.size(), line.size() - kKey.size() - 1);
    if (folder.starts_with(kHome)) folder.replace(0, kHome.size(), GetVariable("HOME"));
    return folder;
  }
  return {};
}

}  // namespace

std::string FindSettingsFile() {
  const std::string folder = FindUserFolder(UserFolder::kConfig);
  return folder.empty() ? "" : folder + "/kerf/window.json";
}

std::string FindSaveFolder(const WindowSettings& settings) {
  const std::string home = GetVariable("HOME");
  std::error_code error;
  for (const std::string& folder : {settings.save_folder, FindDocuments(), home + "/Documents", home}) {
    if (!folder.empty() && fs::is_directory(folder, error)) return folder;
  }
  return ".";
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
    settings.save_folder = json.value("save_folder", settings.save_folder);
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
                            {"save_folder", settings.save_folder},
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
