#include "base/files/user_folders.h"

#include <cstdlib>
#include <filesystem>

namespace kerf {
namespace {

struct Place {
  const char* variable;
  const char* in_home;
};

Place FindPlace(UserFolder folder) {
  switch (folder) {
    case UserFolder::kConfig:
      return {"XDG_CONFIG_HOME", "/.config"};
    case UserFolder::kData:
      return {"XDG_DATA_HOME", "/.local/share"};
    case UserFolder::kCache:
      break;
  }
  return {"XDG_CACHE_HOME", "/.cache"};
}

}  // namespace

std::string GetVariable(const char* name) {
  const char* const value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value == nullptr ? "" : value;
}

std::string FindUserFolder(UserFolder folder) {
  const auto is_absolute = [](const std::string& path) { return std::filesystem::path(path).is_absolute(); };
  const Place place = FindPlace(folder);
  if (std::string named = GetVariable(place.variable); is_absolute(named)) return named;
  const std::string home = GetVariable("HOME");
  return is_absolute(home) ? home + place.in_home : "";
}

}  // namespace kerf
