#include "base/files/temporary.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <regex>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/core/errno_text.h"
#include "base/core/hash.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {

/// Entry of a path for a signal handler: the name is stored in place and never freed.
struct LivePath {
  std::atomic<bool> taken{false};
  std::atomic<bool> live{false};  // the name is complete
  std::atomic<int> folders{0};    // 0: a file
  std::array<char, 4096> path{};
};

namespace {

namespace fs = std::filesystem;

std::array<LivePath, FileBatch::kMost + 16> live_paths;  // of one batch and of other files
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

/// Removes an empty folder and then its parents, as long as they are empty. Async-signal-safe.
void RemoveFolders(std::array<char, 4096> path, int folders) {
  for (; folders > 0 && rmdir(path.data()) == 0; --folders) {
    char* const slash = std::strrchr(path.data(), '/');
    if (slash == nullptr) return;
    *slash = 0;
  }
}

/// Removes a folder with its content. Async-signal-safe: directories are read without readdir(), which allocates.
void RemoveTree(int parent, const char* name, int depth = 0) {
  constexpr int kMaxDepth = 32;
  const int folder = openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return;
  struct Entry {  // as the kernel writes it (getdents64)
    std::uint64_t inode;
    std::int64_t offset;
    std::uint16_t bytes;
    std::uint8_t type;
    char name[1];
  };
  alignas(Entry) std::array<char, 2048> block{};
  while (true) {
    const long bytes = syscall(SYS_getdents64, folder, block.data(), block.size());
    if (bytes <= 0) break;
    for (long at = 0; at < bytes;) {
      const auto* entry = reinterpret_cast<const Entry*>(block.data() + at);
      at += entry->bytes;
      const char* const inside = entry->name;
      if (std::strcmp(inside, ".") == 0 || std::strcmp(inside, "..") == 0) continue;
      if (unlinkat(folder, inside, 0) != 0 && depth < kMaxDepth) RemoveTree(folder, inside, depth + 1);
    }
  }
  close(folder);
  unlinkat(parent, name, AT_REMOVEDIR);
}

/// Returns an id of this machine: a hash of its machine id, which is the same on a copied disk, and its host name.
std::string HostId() {
  static const std::string id = [] {
    std::string text;
    std::ifstream machine("/etc/machine-id");
    std::getline(machine, text);
    std::array<char, 256> name{};
    gethostname(name.data(), name.size() - 1);
    text += name.data();
    std::uint64_t hash = 0;
    for (const char c : text) hash = MixHash(hash ^ static_cast<unsigned char>(c));
    return fmt::format("{:08x}", static_cast<std::uint32_t>(hash));
  }();
  return id;
}

std::string RandomName(const fs::path& target) {
  std::uint64_t random = 0;
  if (getrandom(&random, sizeof(random), 0) != static_cast<ssize_t>(sizeof(random))) {
    throw Error(fmt::format("no random numbers from the system: {}", FormatErrno(errno)));
  }
  const std::string tail = fmt::format(".kerf-{}-{:016x}{}", HostId(), random, target.extension().string());
  // Shorten a long stem, so that the temporary name is valid whenever the target's name is.
  std::string stem = target.stem().string();
  if (target.filename().string().size() <= NAME_MAX && tail.size() < NAME_MAX) {
    stem.resize(std::min(stem.size(), NAME_MAX - 1 - tail.size()));
  }
  return (target.parent_path() / ("." + stem + tail)).string();
}

/// Returns true if only this machine can have files open there, so that their locks are sufficient.
bool IsLocal(int file) {
  struct statfs system {};
  if (fstatfs(file, &system) != 0) return false;
  // ext2 to ext4, XFS, Btrfs, F2FS, tmpfs, overlayfs, ZFS.
  constexpr std::array<std::uint32_t, 7> kLocal = {0xef53,     0x58465342, 0x9123683e, 0xf2f52010,
                                                   0x01021994, 0x794c7630, 0x2fc12fc1};
  const auto type = static_cast<std::uint32_t>(system.f_type);
  for (const std::uint32_t local : kLocal) {
    if (type == local) return true;
  }
  return false;
}

/// Returns true if nothing but `file` has the file open, in this program or any other. Valid only on local file
/// systems.
bool IsOpenHereOnly(int file) {
  if (fcntl(file, F_SETLEASE, F_WRLCK) != 0) return false;
  fcntl(file, F_SETLEASE, F_UNLCK);
  return true;
}

bool IsRunning(const std::string& process) {
  errno = 0;
  const long id = std::strtol(process.c_str(), nullptr, 10);
  return errno != 0 || id <= 0 || id > INT_MAX || kill(static_cast<pid_t>(id), 0) == 0 || errno != ESRCH;
}

/// Removes the file if the program that created it is dead. `host`: as given in the file's name; empty if the file was
/// created by an earlier version of kerf, in `process`.
void RemoveIfLeft(const std::string& path, const std::string& host, const std::string& process) {
  const int file = open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return;
  struct stat opened {};
  struct stat named {};
  bool left = fstat(file, &opened) == 0 && S_ISREG(opened.st_mode) && opened.st_nlink == 1 &&
              opened.st_uid == geteuid() && flock(file, LOCK_EX | LOCK_NB) == 0;
  if (left && host.empty()) left = IsLocal(file) && !IsRunning(process) && IsOpenHereOnly(file);
  if (left && !host.empty()) left = IsLocal(file) || host == HostId();
  left = left && lstat(path.c_str(), &named) == 0 && named.st_ino == opened.st_ino && named.st_dev == opened.st_dev;
  if (left) unlink(path.c_str());
  close(file);
}

/// File name as in earlier versions: .STEM.PID-N.EXT.
struct OldName {
  std::string path;
  std::string target;  // target name: STEM.EXT
  std::string process;
};

std::vector<OldName> SweepFolder(const fs::path& folder) {
  static const std::regex now(R"(\.[\s\S]*\.kerf-([0-9a-f]{8})-[0-9a-f]{16}(\.[^.]*)?)");
  static const std::regex old(R"(\.([\s\S]+)\.([0-9]{1,10})-[0-9]{1,10}(\.[^.]*)?)");
  std::vector<OldName> old_names;
  std::vector<std::pair<std::string, std::string>> names;
  std::error_code ignored;
  for (fs::directory_iterator at(folder, ignored), end; !ignored && at != end; at.increment(ignored)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with('.')) continue;
    std::smatch parts;
    if (std::regex_match(name, parts, now)) {
      names.emplace_back(at->path().string(), parts[1]);
    } else if (std::regex_match(name, parts, old)) {
      old_names.push_back({at->path().string(), parts[1].str() + parts[3].str(), parts[2]});
    }
  }
  for (const auto& [path, host] : names) RemoveIfLeft(path, host, "");
  return old_names;
}

}  // namespace

LivePath* AddLive(const std::string& path, int folders) {
  if (path.size() >= LivePath{}.path.size()) return nullptr;
  for (LivePath& entry : live_paths) {
    if (entry.taken.exchange(true)) continue;
    std::memcpy(entry.path.data(), path.c_str(), path.size() + 1);
    entry.folders = folders;
    entry.live = true;
    return &entry;
  }
  return nullptr;
}

void RemoveLive(LivePath* entry) {
  if (entry == nullptr) return;
  entry->live = false;
  entry->taken = false;
}

void SweepLeftovers(const std::string& target) {
  static std::mutex mutex;
  static std::map<std::string, std::vector<OldName>> searched;
  const fs::path path(target);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const std::lock_guard lock(mutex);
  auto found = searched.find(folder.string());
  if (found == searched.end()) found = searched.emplace(folder.string(), SweepFolder(folder)).first;
  for (const OldName& name : found->second) {
    if (name.target == path.filename()) RemoveIfLeft(name.path, "", name.process);
  }
}

bool Temporary::Create(mode_t mode) {
  live_ = AddLive(path_);  // before the file exists, so that a signal never leaves it behind
  file_ = open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
  if (file_ < 0) {
    const int code = errno;
    RemoveLive(live_);
    if (code == EEXIST) return false;
    throw Error(FormatErrno(code));
  }
  // Another program's sweep may have come first; it then holds the lock or has removed the file.
  const bool locked = flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
  struct stat made {};
  if (locked && fstat(file_, &made) == 0 && made.st_nlink > 0) return true;
  unlink(path_.c_str());
  RemoveLive(live_);
  close(file_);
  file_ = -1;
  return false;
}

Temporary::Temporary(const std::string& target) {
  SweepLeftovers(target);
  struct stat earlier {};
  const bool replaces = stat(target.c_str(), &earlier) == 0 && S_ISREG(earlier.st_mode);
  constexpr std::string_view kOwnFiles = "/proc/self/fd/";
  path_to_write_.reserve(kOwnFiles.size() + 12);  // so that std::bad_alloc cannot occur after the file has been created
  // Create it in the target's folder, so that the rename stays within one file system.
  constexpr int kTries = 100;
  for (int i = 0; i < kTries && file_ < 0; ++i) {
    path_ = RandomName(target);
    Create(replaces ? earlier.st_mode & 0666 : 0666);
  }
  if (file_ < 0) throw Error("no free name for a temporary file");
  fmt::format_to(std::back_inserter(path_to_write_), "{}{}", kOwnFiles, file_);
  if (access(path_to_write_.c_str(), F_OK) != 0) path_to_write_.clear();
}

Temporary::~Temporary() {
  if (!renamed_) unlink(path_.c_str());
  RemoveLive(live_);
  close(file_);
}

void Temporary::Flush() const {
  if (fsync(file_) != 0) throw Error(FormatErrno(errno));
}

void Temporary::CheckName() const {
  struct stat written {};
  struct stat named {};
  if (fstat(file_, &written) != 0 || lstat(path_.c_str(), &named) != 0) throw Error(FormatErrno(errno));
  if (written.st_ino != named.st_ino || written.st_dev != named.st_dev) {
    throw Error("another program has replaced its temporary file");
  }
}

void Temporary::RenameTo(const std::string& target) {
  CheckName();
  // Keep an existing file's permissions: it may contain patient data.
  struct stat earlier {};
  if (stat(target.c_str(), &earlier) == 0 && S_ISREG(earlier.st_mode)) {
    static_cast<void>(fchmod(file_, earlier.st_mode & 07777) == 0);
  }
  if (rename(path_.c_str(), target.c_str()) != 0) throw Error(FormatErrno(errno));
  renamed_ = true;
}

namespace {

std::atomic<int> renaming{0};  // objects of RenamesTogether
std::atomic<bool> removing{false};

/// Waits for a millisecond. Async-signal-safe.
void Pause() {
  constexpr timespec kPause{0, 1'000'000};
  nanosleep(&kPause, nullptr);
}

}  // namespace

RenamesTogether::RenamesTogether() {
  sigset_t ending;
  sigemptyset(&ending);
  for (const int number : {SIGHUP, SIGINT, SIGTERM}) sigaddset(&ending, number);
  pthread_sigmask(SIG_BLOCK, &ending, &before_);
  for (++renaming; removing; ++renaming) {
    --renaming;
    Pause();
  }
}

RenamesTogether::~RenamesTogether() {
  --renaming;
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void RemoveLiveTemporaries() {
  removing = true;
  constexpr int kLongest = 5000;
  for (int i = 0; renaming > 0 && i < kLongest; ++i) Pause();
  for (const LivePath& entry : live_paths) {
    if (entry.live && entry.folders == 0) unlink(entry.path.data());
  }
  for (const LivePath& entry : live_paths) {
    if (entry.live && entry.folders > 0) RemoveFolders(entry.path, entry.folders);
    if (entry.live && entry.folders == kWithContent) RemoveTree(AT_FDCWD, entry.path.data());
  }
  removing = false;
}

TemporaryFolder::TemporaryFolder(const std::string& name) {
  std::error_code ignored;
  path_ = (fs::temp_directory_path(ignored) / (name + "_XXXXXX")).string();
  if (mkdtemp(path_.data()) == nullptr)
    throw Error(fmt::format("{}: the folder can't be created: {}", path_, FormatErrno(errno)));
  live_ = AddLive(path_, kWithContent);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  RemoveLive(live_);
}

}  // namespace kerf
