// Preload library (LD_PRELOAD) that makes one of a program's system calls fail and logs the program's writes. It is not
// part of kerf; tests/reliability/io_faults.py and power_loss.py use it.
//
//   KERF_FAULT_ROOT    folder; only files below it are affected, in calls that name a file or have one open
//   KERF_FAULT_CALL    kind of call: open, open_elsewhere, read, write, fwrite, sync, rename, mmap, new, alloc,
//                      sigaction
//   KERF_FAULT_AT      number of the call that fails, starting at 1; 0: none, calls are only counted
//   KERF_FAULT_ERROR   errno of the failure
//   KERF_FAULT_SIGNAL  a signal's number: the signal is raised instead of the failure, before the call; for "open" and
//                      "sigaction", after the call
//   KERF_FAULT_LASTS   1: all later calls of this kind fail too
//   KERF_FAULT_REPORT  output file of two 64-bit numbers: how many such calls there were, and how many of them failed
//   KERF_FAULT_SITES   output file with a 64-bit number for each place that calls operator new: a hash of the call
//                      stack, equal in each run without address randomisation (setarch -R)
//   KERF_FAULT_SITE    such a number, decimal: the first call from that place fails, regardless of KERF_FAULT_AT
//   KERF_IO_LOG        output file of the operations on files below the root, one line "WHAT INODE A B NAME|NAME" each:
//                      O created or emptied (A = 1), W written (B bytes at A, which follow), T truncated to A,
//                      S synced (its B bytes follow), D folder synced, R renamed, U unlinked
//
// "alloc": calls of malloc() and similar functions for at least 64 kB; "new": each operator new. Both are counted only
// while main() runs. "sigaction": calls that set a handler for KERF_FAULT_SIGNAL; they never fail.
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>

// These names are those of the C library.
// NOLINTBEGIN(bugprone-reserved-identifier)
extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

constexpr std::size_t kLargeBytes = 65536;  // threshold of "alloc"
constexpr int kMaxFiles = 65536;

struct Settings {
  char root[PATH_MAX] = "";
  const char* call = "";
  std::uint64_t at = 0;
  int error = EIO;
  int signal = 0;
  bool lasts = false;
  int log = -1;
  int sites = -1;
  std::uint64_t site = 0;
};
Settings settings;
std::atomic<bool> active{false};
std::atomic<bool> is_tracked[kMaxFiles];  // true for descriptors of files below the root
std::mutex log_mutex;

struct Report {
  std::atomic<std::uint64_t> calls;
  std::atomic<std::uint64_t> failed;
};
Report unreported;
Report* report = &unreported;

template <typename F>
F* Next(const char* name) {
  return reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
}
#define NEXT(name) static auto* const next = Next<decltype(name)>(#name)

/// Counts a call. Returns true and sets errno if the call must fail.
bool Fails(const char* call) {
  if (!active.load(std::memory_order_relaxed) || std::strcmp(settings.call, call) != 0) return false;
  const std::uint64_t number = ++report->calls;
  if (settings.at == 0 || number < settings.at || (number > settings.at && !settings.lasts)) return false;
  ++report->failed;
  if (settings.signal != 0) {
    std::raise(settings.signal);
    return false;
  }
  errno = settings.error;
  return true;
}

constexpr int kMaxFrames = 7;  // of the call stack that identifies a place
constexpr std::uint32_t kMaxSites = 1 << 16;
std::atomic<std::uint64_t> sites[kMaxSites];  // a hash table
thread_local bool is_tracing = false;         // set because backtrace() may allocate

/// Returns a hash of the call stack; never 0.
std::uint64_t HashCallStack() {
  void* frames[kMaxFrames];
  const int count = backtrace(frames, kMaxFrames);
  std::uint64_t sum = 0xcbf29ce484222325U;
  for (int i = 0; i < count; ++i) sum = (sum ^ reinterpret_cast<std::uint64_t>(frames[i])) * 0x100000001b3U;
  return sum == 0 ? 1 : sum;
}

/// Adds a place to the table. Returns true if it was not there before.
bool IsNewSite(std::uint64_t sum) {
  for (std::uint32_t i = 0; i < kMaxSites; ++i) {
    std::atomic<std::uint64_t>& place = sites[(sum + i) % kMaxSites];
    std::uint64_t there = 0;
    if (place.compare_exchange_strong(there, sum)) return true;
    if (there == sum) return false;
  }
  return false;
}

/// Records the calling place of an operator new. Returns true if the call must fail.
bool FailsAtSite() {
  const bool is_wanted = settings.sites >= 0 || settings.site != 0;
  if (!is_wanted || is_tracing || !active.load(std::memory_order_relaxed)) return false;
  is_tracing = true;
  const std::uint64_t sum = HashCallStack();
  if (settings.sites >= 0 && IsNewSite(sum) && write(settings.sites, &sum, sizeof(sum)) != sizeof(sum)) std::abort();
  is_tracing = false;
  if (sum != settings.site || report->failed.fetch_add(1) != 0) return false;
  errno = settings.error;
  return true;
}

bool IsTracked(int file) {
  return file >= 0 && file < kMaxFiles && is_tracked[file].load(std::memory_order_relaxed);
}

bool IsBelowRoot(const char* path) {
  constexpr char kOwn[] = "/proc/self/fd/";
  if (settings.root[0] == '\0' || path == nullptr) return false;
  if (std::strncmp(path, kOwn, sizeof(kOwn) - 1) == 0) return IsTracked(std::atoi(path + sizeof(kOwn) - 1));
  char absolute[2 * PATH_MAX];
  if (path[0] == '/') {
    std::snprintf(absolute, sizeof(absolute), "%s", path);
  } else {
    char folder[PATH_MAX];
    if (getcwd(folder, sizeof(folder)) == nullptr) return false;
    std::snprintf(absolute, sizeof(absolute), "%s/%s", folder, path);
  }
  const std::size_t size = std::strlen(settings.root);
  return std::strncmp(absolute, settings.root, size) == 0 && (absolute[size] == '/' || absolute[size] == '\0');
}

void Log(char what, std::uint64_t inode, std::uint64_t a, std::uint64_t b, const char* name, const char* name2,
         const void* bytes, std::size_t size) {
  if (settings.log < 0) return;
  char line[2 * PATH_MAX + 128];
  const int length =
      std::snprintf(line, sizeof(line), "%c %llu %llu %llu %s|%s\n", what, static_cast<unsigned long long>(inode),
                    static_cast<unsigned long long>(a), static_cast<unsigned long long>(b), name, name2);
  NEXT(write);
  bool good = next(settings.log, line, static_cast<std::size_t>(length)) == length;
  if (size > 0) good = good && next(settings.log, bytes, size) == static_cast<ssize_t>(size);
  if (!good) std::abort();
}

std::uint64_t InodeOf(int file) {
  struct stat status {};
  return fstat(file, &status) == 0 ? status.st_ino : 0;
}

void LogWrite(int file, const void* bytes, std::size_t size, std::int64_t offset) {
  Log('W', InodeOf(file), static_cast<std::uint64_t>(offset), size, "", "", bytes, size);
}

/// Logs a sync with the file's content, which is on the disk from that moment on.
void LogSync(int file) {
  if (settings.log < 0) return;
  char name[64];
  char path[PATH_MAX] = "";
  std::snprintf(name, sizeof(name), "/proc/self/fd/%d", file);
  if (readlink(name, path, sizeof(path) - 1) < 0) path[0] = '\0';
  struct stat status {};
  if (fstat(file, &status) != 0 || S_ISDIR(status.st_mode)) return Log('D', status.st_ino, 0, 0, path, "", nullptr, 0);
  const auto size = static_cast<std::size_t>(status.st_size);
  void* content = size == 0 ? nullptr : __libc_malloc(size);
  const int copy = Next<decltype(open)>("open")(name, O_RDONLY | O_CLOEXEC);
  if (size > 0 && Next<decltype(pread)>("pread")(copy, content, size, 0) != static_cast<ssize_t>(size)) std::abort();
  Next<decltype(close)>("close")(copy);
  Log('S', status.st_ino, 0, size, path, "", content, size);
  std::free(content);
}

void NoteOpened(int file, const char* path, int flags) {
  if (file < 0 || file >= kMaxFiles) return;
  is_tracked[file] = true;
  if ((flags & (O_CREAT | O_TRUNC)) == 0) return;
  Log('O', InodeOf(file), (flags & O_TRUNC) != 0 ? 1 : 0, 0, path, "", nullptr, 0);
}

template <typename Open>
int OpenBy(const char* path, int flags, Open&& open) {
  const bool below = IsBelowRoot(path);
  const char* const call = below ? "open" : "open_elsewhere";
  if (settings.signal == 0 && Fails(call)) return -1;
  if (!below || settings.log < 0) {
    const int file = open();
    if (file >= 0 && file < kMaxFiles) is_tracked[file] = below;
    if (settings.signal != 0) Fails(call);
    return file;
  }
  const std::lock_guard lock(log_mutex);
  const int file = open();
  NoteOpened(file, path, flags);
  return file;
}

mode_t ModeOf(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

template <typename Call>
auto WithLog(Call&& call) {
  const std::lock_guard lock(log_mutex);
  return call();
}

[[gnu::constructor]] void Begin() {
  const auto get = [](const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
  };
  std::snprintf(settings.root, sizeof(settings.root), "%s", get("KERF_FAULT_ROOT"));
  settings.call = get("KERF_FAULT_CALL");
  settings.at = std::strtoull(get("KERF_FAULT_AT"), nullptr, 10);
  settings.error = std::atoi(get("KERF_FAULT_ERROR"));
  settings.signal = std::atoi(get("KERF_FAULT_SIGNAL"));
  settings.lasts = std::atoi(get("KERF_FAULT_LASTS")) != 0;
  const char* log = get("KERF_IO_LOG");
  if (log[0] != '\0') {
    const int file = Next<decltype(open)>("open")(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    settings.log = fcntl(file, F_DUPFD_CLOEXEC, 900);
    close(file);
  }
  settings.site = std::strtoull(get("KERF_FAULT_SITE"), nullptr, 10);
  if (const char* sites_file = get("KERF_FAULT_SITES"); sites_file[0] != '\0') {
    const int file = Next<decltype(open)>("open")(sites_file, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    settings.sites = fcntl(file, F_DUPFD_CLOEXEC, 901);
    close(file);
  }
  const char* name = get("KERF_FAULT_REPORT");
  if (name[0] == '\0') return;
  const int file = Next<decltype(open)>("open")(name, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0 || Next<decltype(ftruncate)>("ftruncate")(file, sizeof(Report)) != 0) std::abort();
  void* memory = Next<decltype(mmap)>("mmap")(nullptr, sizeof(Report), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (memory == MAP_FAILED) std::abort();
  report = static_cast<Report*>(memory);
  Next<decltype(close)>("close")(file);
}

int (*real_main)(int, char**, char**) = nullptr;
int CountedMain(int argc, char** argv, char** environment) {
  active = true;
  const int code = real_main(argc, argv, environment);
  active = false;
  return code;
}

/// Returns true if a large allocation must fail. Allocations by the software renderer (Mesa's drivers), which does not
/// check the result, and by libpng, which ends the program, are not made to fail.
bool FailsLarge(std::size_t size, const void* caller) {
  if (size < kLargeBytes || !active.load(std::memory_order_relaxed)) return false;
  Dl_info object{};
  const bool renderer =
      dladdr(caller, &object) != 0 && object.dli_fname != nullptr &&
      (std::strstr(object.dli_fname, "/dri/") != nullptr || std::strstr(object.dli_fname, "mesa") != nullptr ||
       std::strstr(object.dli_fname, "LLVM") != nullptr || std::strstr(object.dli_fname, "libpng") != nullptr);
  return !renderer && Fails("alloc");
}
#define FAILS_LARGE(size) FailsLarge(size, __builtin_return_address(0))

void* Allocate(std::size_t size, std::size_t alignment) {
  if (FailsAtSite() || Fails("new")) {
    if (const std::new_handler handler = std::get_new_handler()) handler();
    return nullptr;
  }
  return alignment > alignof(std::max_align_t) ? __libc_memalign(alignment, size) : __libc_malloc(size == 0 ? 1 : size);
}
void* AllocateOrThrow(std::size_t size, std::size_t alignment) {
  void* memory = Allocate(size, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  return AllocateOrThrow(size, 0);
}
void* operator new[](std::size_t size) {
  return AllocateOrThrow(size, 0);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return AllocateOrThrow(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return AllocateOrThrow(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return Allocate(size, 0);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return Allocate(size, 0);
}

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(), void (*fini)(),
                      void (*rtld_fini)(), void* stack_end) {
  using Start = int(int (*)(int, char**, char**), int, char**, void (*)(), void (*)(), void (*)(), void*);
  real_main = main;
  return Next<Start>("__libc_start_main")(CountedMain, argc, argv, init, fini, rtld_fini, stack_end);
}

void* malloc(std::size_t size) {
  if (FAILS_LARGE(size)) return nullptr;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  if (FAILS_LARGE(count * size)) return nullptr;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  if (FAILS_LARGE(size)) return nullptr;
  return __libc_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  if (FAILS_LARGE(size)) return nullptr;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  if (FAILS_LARGE(size)) return ENOMEM;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}

#define KERF_OPEN(name)                                                  \
  int name(const char* path, int flags, ...) {                           \
    va_list arguments;                                                   \
    va_start(arguments, flags);                                          \
    const mode_t mode = ModeOf(flags, arguments);                        \
    va_end(arguments);                                                   \
    NEXT(name);                                                          \
    return OpenBy(path, flags, [&] { return next(path, flags, mode); }); \
  }
KERF_OPEN(open)
KERF_OPEN(open64)
#define KERF_OPENAT(name)                                                        \
  int name(int folder, const char* path, int flags, ...) {                       \
    va_list arguments;                                                           \
    va_start(arguments, flags);                                                  \
    const mode_t mode = ModeOf(flags, arguments);                                \
    va_end(arguments);                                                           \
    NEXT(name);                                                                  \
    return OpenBy(path, flags, [&] { return next(folder, path, flags, mode); }); \
  }
KERF_OPENAT(openat)
KERF_OPENAT(openat64)
int __open_2(const char* path, int flags) {
  return open(path, flags);
}
int __open64_2(const char* path, int flags) {
  return open64(path, flags);
}

#define KERF_FOPEN(name)                                                                 \
  FILE* name(const char* path, const char* mode) {                                       \
    NEXT(name);                                                                          \
    FILE* stream = nullptr;                                                              \
    const int flags = mode[0] == 'w' ? O_CREAT | O_TRUNC : mode[0] == 'a' ? O_CREAT : 0; \
    OpenBy(path, flags, [&] {                                                            \
      stream = next(path, mode);                                                         \
      return stream == nullptr ? -1 : fileno(stream);                                    \
    });                                                                                  \
    return stream;                                                                       \
  }
KERF_FOPEN(fopen)
KERF_FOPEN(fopen64)

int mkdir(const char* path, mode_t mode) {
  NEXT(mkdir);
  return IsBelowRoot(path) && Fails("open") ? -1 : next(path, mode);
}

int close(int file) {
  NEXT(close);
  if (file >= 0 && file < kMaxFiles) is_tracked[file] = false;
  return next(file);
}

ssize_t read(int file, void* bytes, std::size_t size) {
  NEXT(read);
  return IsTracked(file) && Fails("read") ? -1 : next(file, bytes, size);
}
ssize_t pread(int file, void* bytes, std::size_t size, off_t offset) {
  NEXT(pread);
  return IsTracked(file) && Fails("read") ? -1 : next(file, bytes, size, offset);
}
ssize_t pread64(int file, void* bytes, std::size_t size, off64_t offset) {
  NEXT(pread64);
  return IsTracked(file) && Fails("read") ? -1 : next(file, bytes, size, offset);
}

ssize_t write(int file, const void* bytes, std::size_t size) {
  NEXT(write);
  if (!IsTracked(file)) return next(file, bytes, size);
  if (Fails("write")) return -1;
  if (settings.log < 0) return next(file, bytes, size);
  return WithLog([&] {
    const ssize_t written = next(file, bytes, size);
    if (written > 0) LogWrite(file, bytes, static_cast<std::size_t>(written), lseek(file, 0, SEEK_CUR) - written);
    return written;
  });
}
ssize_t writev(int file, const iovec* parts, int count) {
  NEXT(writev);
  if (!IsTracked(file)) return next(file, parts, count);
  ssize_t sum = 0;
  for (int i = 0; i < count; ++i) {
    const ssize_t written = write(file, parts[i].iov_base, parts[i].iov_len);
    if (written < 0) return sum > 0 ? sum : -1;
    sum += written;
    if (written < static_cast<ssize_t>(parts[i].iov_len)) break;
  }
  return sum;
}
#define KERF_PWRITE(name, Offset)                                                        \
  ssize_t name(int file, const void* bytes, std::size_t size, Offset offset) {           \
    NEXT(name);                                                                          \
    if (!IsTracked(file)) return next(file, bytes, size, offset);                        \
    if (Fails("write")) return -1;                                                       \
    if (settings.log < 0) return next(file, bytes, size, offset);                        \
    return WithLog([&] {                                                                 \
      const ssize_t written = next(file, bytes, size, offset);                           \
      if (written > 0) LogWrite(file, bytes, static_cast<std::size_t>(written), offset); \
      return written;                                                                    \
    });                                                                                  \
  }
KERF_PWRITE(pwrite, off_t)
KERF_PWRITE(pwrite64, off64_t)

// Output through the C library's streams does not use write() above. It can fail here but is not logged.
std::size_t fwrite(const void* bytes, std::size_t size, std::size_t count, FILE* stream) {
  NEXT(fwrite);
  return IsTracked(fileno(stream)) && Fails("fwrite") ? 0 : next(bytes, size, count, stream);
}
int fflush(FILE* stream) {
  NEXT(fflush);
  return stream != nullptr && IsTracked(fileno(stream)) && Fails("fwrite") ? EOF : next(stream);
}
int fclose(FILE* stream) {
  NEXT(fclose);
  const int file = fileno(stream);
  const bool fails = IsTracked(file) && Fails("fwrite");
  if (file >= 0 && file < kMaxFiles) is_tracked[file] = false;
  const int result = next(stream);
  return fails ? EOF : result;
}

#define KERF_TRUNCATE(name, Offset)                                                                      \
  int name(int file, Offset size) {                                                                      \
    NEXT(name);                                                                                          \
    if (!IsTracked(file)) return next(file, size);                                                       \
    if (Fails("write")) return -1;                                                                       \
    return WithLog([&] {                                                                                 \
      const int result = next(file, size);                                                               \
      if (result == 0) Log('T', InodeOf(file), static_cast<std::uint64_t>(size), 0, "", "", nullptr, 0); \
      return result;                                                                                     \
    });                                                                                                  \
  }
KERF_TRUNCATE(ftruncate, off_t)
KERF_TRUNCATE(ftruncate64, off64_t)

#define KERF_SYNC(name)                      \
  int name(int file) {                       \
    NEXT(name);                              \
    if (!IsTracked(file)) return next(file); \
    if (Fails("sync")) return -1;            \
    return WithLog([&] {                     \
      const int result = next(file);         \
      if (result == 0) LogSync(file);        \
      return result;                         \
    });                                      \
  }
KERF_SYNC(fsync)
KERF_SYNC(fdatasync)

int rename(const char* from, const char* to) {
  NEXT(rename);
  if (!IsBelowRoot(to)) return next(from, to);
  if (Fails("rename")) return -1;
  return WithLog([&] {
    const int result = next(from, to);
    if (result == 0) Log('R', 0, 0, 0, from, to, nullptr, 0);
    return result;
  });
}
int sigaction(int number, const struct sigaction* action, struct sigaction* before) {
  using Call = int(int, const struct sigaction*, struct sigaction*);
  static auto* const next = Next<Call>("sigaction");
  const int result = next(number, action, before);
  const bool sets = action != nullptr && action->sa_handler != SIG_DFL && action->sa_handler != SIG_IGN;
  if (sets && number == settings.signal) Fails("sigaction");
  return result;
}
int unlink(const char* path) {
  NEXT(unlink);
  if (!IsBelowRoot(path)) return next(path);
  return WithLog([&] {
    const int result = next(path);
    if (result == 0) Log('U', 0, 0, 0, path, "", nullptr, 0);
    return result;
  });
}

#define KERF_MMAP(name, Offset)                                                               \
  void* name(void* place, std::size_t size, int access, int flags, int file, Offset offset) { \
    NEXT(name);                                                                               \
    if (Fails("mmap")) return MAP_FAILED;                                                     \
    return next(place, size, access, flags, file, offset);                                    \
  }
KERF_MMAP(mmap, off_t)
KERF_MMAP(mmap64, off64_t)

}  // extern "C"
// NOLINTEND(bugprone-reserved-identifier)
