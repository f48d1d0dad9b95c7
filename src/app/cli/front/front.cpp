// Front program `kerf`: answers --version and --help itself; for everything else it is replaced by kerf_program, which
// is in the same folder or, if kerf is installed, in a folder for programs that only other programs start. kerf_program
// loads about a hundred shared libraries, which takes a tenth of a second or more.
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>

#include "front_texts.h"  // generated: the output of kerf_program

namespace {

// With less memory than this, kerf_program could neither load its libraries nor report that.
constexpr rlim_t kMinBytes = rlim_t{400} << 20;

bool Print(const char* text) {
  return std::fputs(text, stdout) >= 0 && std::fflush(stdout) == 0;
}

/// Returns the folder of this program with links resolved; "" if the system does not report it.
std::string FindFolder() {
  std::string path(4096, '\0');
  const ssize_t length = readlink("/proc/self/exe", path.data(), path.size());
  if (length <= 0 || static_cast<std::size_t>(length) == path.size()) return "";
  path.resize(static_cast<std::size_t>(length));
  return path.substr(0, path.rfind('/'));
}

}  // namespace

int main(int argc, char** argv) {
  // If the output cannot be written, kerf_program reports the error.
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0 && Print(kFrontVersion)) return 0;
  if (argc == 2 && (std::strcmp(argv[1], "--help") == 0 || std::strcmp(argv[1], "-h") == 0) && Print(kFrontHelp)) {
    return 0;
  }
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur < kMinBytes) {
    std::fprintf(stderr, "kerf: not enough memory to start: 'ulimit -v' allows %llu kB, and %llu are needed\n",
                 static_cast<unsigned long long>(limit.rlim_cur >> 10),
                 static_cast<unsigned long long>(kMinBytes >> 10));
    return 1;
  }
  try {
    const std::string folder = FindFolder();
    std::string program = folder + "/kerf_program";
    execv(program.c_str(), argv);
    if (errno == ENOENT) {
      program = folder + "/" KERF_PROGRAM_FOLDER "/kerf_program";
      execv(program.c_str(), argv);
    }
    std::fprintf(stderr, "kerf: %s, a part of kerf, can't be started: %s\n", program.c_str(), std::strerror(errno));
  } catch (const std::bad_alloc&) {
    std::fputs("kerf: not enough memory to start\n", stderr);
  }
  return 1;
}
