// Folders of the user's settings, data and caches, as the XDG Base Directory Specification defines them.
#pragma once

#include <string>

namespace kerf {

enum class UserFolder {
  kConfig,  // $XDG_CONFIG_HOME or $HOME/.config
  kData,    // $XDG_DATA_HOME or $HOME/.local/share
  kCache,   // $XDG_CACHE_HOME or $HOME/.cache
};

/// Returns the value of an environment variable; empty if it is not set.
std::string GetVariable(const char* name);
/// Returns a folder, which need not exist. A variable whose value is not an absolute path is ignored. Empty if neither
/// variable has such a value.
std::string FindUserFolder(UserFolder folder);

}  // namespace kerf
