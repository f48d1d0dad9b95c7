// Common parts of the fuzz targets. A target takes any bytes as the content of a file and either reads them or throws
// Error with one clear sentence. Everything else is a finding: another exception, a sanitizer's report, or more time or
// memory than tools/fuzz allows.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

#include "kerf/error.h"

namespace kerf::fuzz {

/// Declares and begins the definition of a target: FuzzTarget_NAME(bytes).
#define KERF_FUZZ_TARGET(name)                         \
  void FuzzTarget_##name(std::string_view bytes); /**/ \
  void FuzzTarget_##name(std::string_view bytes)

/// Ends the program with a message, because a guarantee of the target is violated.
[[noreturn]] inline void Finding(const std::string& what) {
  fmt::print(stderr, "finding: {}\n", what);
  std::abort();
}

/// Runs `read`. Returns true if it accepted the input. If it refuses the input, the message must have a limited length.
template <typename Read>
bool Accepts(Read&& read) {
  constexpr std::size_t kMaxMessage = 65536;  // a scene reports up to 50 faults
  try {
    read();
    return true;
  } catch (const Error& e) {
    const std::string_view what = e.what();
    if (what.empty() || what.size() > kMaxMessage) Finding(fmt::format("a message of {} bytes", what.size()));
    // Prints why an input was refused.
    if (std::getenv("KERF_FUZZ_TELL") != nullptr) fmt::print(stderr, "refused: {}\n", what);
    return false;
  }
}

/// A folder of this process, in memory if there is such a file system.
class MemoryFolder {
 public:
  MemoryFolder() {
    const std::filesystem::path shm = "/dev/shm";
    std::error_code none;
    const std::filesystem::path root =
        std::filesystem::is_directory(shm, none) ? shm : std::filesystem::temp_directory_path();
    path_ = (root / fmt::format("kerf_fuzz_{}", getpid())).string();
    std::filesystem::create_directories(path_);
  }
  ~MemoryFolder() {
    std::error_code none;
    std::filesystem::remove_all(path_, none);
  }
  MemoryFolder(const MemoryFolder&) = delete;
  MemoryFolder& operator=(const MemoryFolder&) = delete;

  const std::string& path() const { return path_; }
  /// Writes a file with these bytes and returns its path, which is valid until the next call with that name.
  std::string Write(const std::string& name, std::string_view bytes) const {
    std::string path = path_ + "/" + name;
    const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (file < 0 || write(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) {
      Finding("the memory file can't be written");
    }
    close(file);
    return path;
  }

 private:
  std::string path_;
};

}  // namespace kerf::fuzz
