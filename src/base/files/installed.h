// Files that are installed with kerf: scenes, tables and catalogues of languages.
#pragma once

#include <string>

namespace kerf {

/// Returns the file of the running program with links resolved; empty if the system does not report it.
std::string FindProgram();
/// Returns the folder of the running program with links resolved; empty if the system does not report it.
std::string FindProgramFolder();
/// Returns the folder for data that does not depend on the machine, such as /usr/share, of the installation to which
/// the running program belongs. It need not exist: a program in a build folder is not installed. Empty if the system
/// does not report the program's folder.
std::string FindShareFolder();
/// Returns `path` if such a file exists, if it is absolute, or if kerf has no file of this name; otherwise the
/// installed file: "scenes/x.toml" may give "/usr/share/kerf/scenes/x.toml". For inputs only; a result must not be
/// written there.
std::string FindInput(const std::string& path);

}  // namespace kerf
