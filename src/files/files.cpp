#include "files/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

std::string Reason(int code) {
  return std::generic_category().message(code);
}

// The temporaries there are, where a signal's handler can read them: names in place, never freed.
struct LiveTemporary {
  std::atomic<bool> taken{false};
  std::atomic<bool> live{false};  // the name is whole
  std::array<char, 4096> path{};
};
std::array<LiveTemporary, 16> live_temporaries;
static_assert(std::atomic<bool>::is_always_lock_free);

/// nullptr when there is no room: it then stays when a signal ends the program.
LiveTemporary* AddLive(const std::string& path) {
  if (path.size() >= LiveTemporary{}.path.size()) return nullptr;
  for (LiveTemporary& entry : live_temporaries) {
    if (entry.taken.exchange(true)) continue;
    std::memcpy(entry.path.data(), path.c_str(), path.size() + 1);
    entry.live = true;
    return &entry;
  }
  return nullptr;
}

void RemoveLive(LiveTemporary* entry) {
  if (entry == nullptr) return;
  entry->live = false;
  entry->taken = false;
}

// Removes the temporary unless it was renamed.
class Temporary {
 public:
  explicit Temporary(const std::string& path) {
    const fs::path target(path);
    // Beside the target, so that the rename stays within one file system; with its extension, which some writers go by.
    static std::atomic<int> count{0};
    path_ = (target.parent_path() /
             fmt::format(".{}.{}-{}{}", target.stem().string(), getpid(), count++, target.extension().string()))
                .string();
    live_ = AddLive(path_);
  }
  ~Temporary() {
    std::error_code ignored;
    if (!renamed_) fs::remove(path_, ignored);
    RemoveLive(live_);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  const std::string& path() const { return path_; }
  void RenameTo(const std::string& path) {
    std::error_code error;
    fs::rename(path_, path, error);
    if (error) throw Error(fmt::format("{}: can't be written: {}", path, error.message()));
    renamed_ = true;
  }

 private:
  std::string path_;
  LiveTemporary* live_ = nullptr;
  bool renamed_ = false;
};

// Onto the disk, so that the rename can't overtake the content.
void Flush(const std::string& temporary, const std::string& path) {
  const int file = open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) throw Error(fmt::format("{}: can't be written: {}", path, Reason(errno)));
  const int result = fsync(file);
  const int code = errno;
  close(file);
  if (result != 0) throw Error(fmt::format("{}: can't be written: {}", path, Reason(code)));
}

/// Where a link leads, so that the file is replaced and not the link.
std::string FollowLinks(const std::string& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target.string();
}

}  // namespace

void CheckWritable(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored)) {
    throw Error(fmt::format("{}: can't be written: there is no folder {}", path, folder.string()));
  }
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) throw Error(fmt::format("{}: can't be written: it is a folder", path));
  // A device or a pipe would be replaced by a file.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(fmt::format("{}: can't be written: it is not a regular file", path));
  }
}

std::string ReadTextFile(const std::string& path, std::size_t max_bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw Error(fmt::format("{}: there is no such file", path));
  if (fs::is_directory(status)) throw Error(fmt::format("{}: is a folder, not a file", path));
  // A pipe may never end, or never begin.
  if (!fs::is_regular_file(status)) throw Error(fmt::format("{}: is not a regular file", path));
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(fmt::format("{}: can't be read: {}", path, Reason(errno)));
  std::string content;
  // In blocks and not by the file's stated size: that is 0 for pipes.
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  if (fs::is_regular_file(status)) {
    const std::uintmax_t size = fs::file_size(path, error);
    if (!error && size <= max_bytes) content.reserve(static_cast<std::size_t>(size) + 1);
  }
  while (in) {
    const std::size_t old = content.size();
    content.resize(old + kBlock);
    in.read(content.data() + old, static_cast<std::streamsize>(kBlock));
    content.resize(old + static_cast<std::size_t>(in.gcount()));
    if (content.size() > max_bytes) {
      throw Error(fmt::format("{}: is larger than {} MiB, which is more than a file of its kind can need", path,
                              max_bytes >> 20));
    }
  }
  if (in.bad()) throw Error(fmt::format("{}: can't be read to its end", path));
  return content;
}

void WriteAtomically(const std::string& path, const std::function<void(const std::string&)>& write) {
  CheckWritable(path);
  const std::string target = FollowLinks(path);
  Temporary temporary(target);
  write(temporary.path());
  Flush(temporary.path(), path);
  // An earlier file's permissions stay: it may hold a patient's data.
  std::error_code ignored;
  if (fs::is_regular_file(target, ignored)) {
    fs::permissions(temporary.path(), fs::status(target, ignored).permissions(), ignored);
  }
  temporary.RenameTo(target);
}

void WriteTextFile(const std::string& path, const std::string& content) {
  WriteAtomically(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) throw Error(fmt::format("{}: can't be written: {}", path, Reason(errno)));
  });
}

bool IsSameFile(const std::string& a, const std::string& b) {
  std::error_code failed;
  if (fs::equivalent(a, b, failed)) return true;
  const fs::path one = fs::weakly_canonical(fs::absolute(a, failed), failed);
  const fs::path other = fs::weakly_canonical(fs::absolute(b, failed), failed);
  return !failed && one == other;
}

void CheckInputsStay(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  for (const std::string& input : inputs) {
    for (const std::string& output : outputs) {
      if (input.empty() || output.empty() || !IsSameFile(input, output)) continue;
      throw Error(fmt::format("{}: is an input and would be written over by {}; choose another output", input, output));
    }
  }
}

void RemoveTemporaries() {
  for (const LiveTemporary& entry : live_temporaries) {
    if (entry.live) unlink(entry.path.data());
  }
}

void MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path)) {
    throw Error(fmt::format("{}: the folder can't be made: {}", path, error ? error.message() : "a file has its name"));
  }
}

}  // namespace kerf
