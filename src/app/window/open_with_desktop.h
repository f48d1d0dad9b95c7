// Opening of files with the programs of the user's desktop.
#pragma once

#include <string>

namespace kerf {

/// Opens a file or folder with xdg-open, without waiting for it. Returns false if xdg-open is not installed.
bool OpenWithDesktop(const std::string& path);

}  // namespace kerf
