#include "app/window/open_with_desktop.h"

#include <spawn.h>
#include <sys/wait.h>

#include <filesystem>
#include <thread>

extern char** environ;

namespace kerf {

bool OpenWithDesktop(const std::string& path) {
  std::string program = "xdg-open";
  std::string absolute = std::filesystem::absolute(path).string();
  char* arguments[] = {program.data(), absolute.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments, environ) != 0) return false;
  std::thread([child] { waitpid(child, nullptr, 0); }).detach();
  return true;
}

}  // namespace kerf
