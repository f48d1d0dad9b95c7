#include "base/files/installed.h"

#include <filesystem>
#include <system_error>

namespace kerf {

namespace fs = std::filesystem;

std::string FindProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? std::string() : program.string();
}

std::string FindProgramFolder() {
  return fs::path(FindProgram()).parent_path().string();
}

std::string FindShareFolder() {
  const std::string program = FindProgramFolder();
  return program.empty() ? program : (fs::path(program) / KERF_SHARE_FROM_PROGRAM).lexically_normal().string();
}

std::string FindInput(const std::string& path) {
  std::error_code error;
  if (path.empty() || fs::path(path).is_absolute() || fs::exists(path, error)) return path;
  const std::string share = FindShareFolder();
  if (share.empty()) return path;
  const fs::path folder = fs::path(share) / "kerf";
  const fs::path installed = (folder / path).lexically_normal();
  // "../x" does not name a file of kerf.
  const bool inside = !fs::path(path).lexically_normal().string().starts_with("..");
  return inside && fs::is_regular_file(installed, error) ? installed.string() : path;
}

}  // namespace kerf
