#include "base/files/child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <string_view>

#include "base/core/errno_text.h"
#include "base/files/confine.h"
#include "kerf/error.h"

namespace kerf {
namespace {

ChildReport* report_of_this_child = nullptr;  // set in a child process

constexpr std::uint64_t kMaxOpenFiles = 256;
constexpr int kPoll_ms = 50;  // at least this often the parent calls `progress`

// Distinct from the exit codes that a library may use.
enum ExitCode { kDone = 100, kRefused = 101, kNoMemory = 102, kFailed = 103 };

class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor() { Close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  void Close() {
    if (fd_ >= 0) close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

bool WriteAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// Returns the address space of this process from /proc; 0 if unknown.
std::uint64_t FindAddressSpace() {
  std::ifstream in("/proc/self/statm");
  std::uint64_t pages = 0;
  in >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void SetLimit(int resource, std::uint64_t value) {
  rlimit limit{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, value);
  setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;  // the sanitizer's shadow memory uses terabytes of address space
#else
constexpr bool kSanitized = false;
#endif

/// Restricts this child process. A child that is killed by a signal prints nothing and leaves no core file, and a child
/// never outlives its parent.
void Confine(const ChildLimits& limits, std::uint64_t used_bytes, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(kFailed);
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) {
    std::signal(signal, SIG_DFL);
  }
  std::signal(SIGINT, SIG_IGN);  // the parent handles Ctrl-C and ends the child
  std::set_terminate(std::abort);
  SetLimit(RLIMIT_CORE, 0);
  SetLimit(RLIMIT_NOFILE, kMaxOpenFiles);
  if (!kSanitized) SetLimit(RLIMIT_AS, used_bytes + limits.memory_bytes);
  const int null_device = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (null_device < 0) _exit(kFailed);
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null_device, fd);
  ForbidSideEffects();
}

[[noreturn]] void Work(int result, ChildReport report, const std::function<std::string(ChildReport&)>& work) {
  const auto end = [result](ExitCode code, std::string_view bytes) { _exit(WriteAll(result, bytes) ? code : kFailed); };
  report_of_this_child = &report;
  try {
    end(kDone, work(report));
  } catch (const Error& e) {
    end(kRefused, e.what());
  } catch (const std::bad_alloc&) {
    end(kNoMemory, {});
  } catch (const std::exception& e) {
    end(kFailed, e.what());
  } catch (...) {
    end(kFailed, {});
  }
  _exit(kFailed);
}

/// Forwards progress until the child closes its end. Repeats the last progress while nothing arrives, so that it can be
/// cancelled. Returns false if nothing arrives for `silent_s`.
bool Follow(int pipe, double silent_s, const std::function<void(double)>& progress) {
  using Clock = std::chrono::steady_clock;
  const auto timeout = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(silent_s));
  auto heard = Clock::now();
  double last = 0;
  for (;;) {
    pollfd wait{pipe, POLLIN, 0};
    const int ready = poll(&wait, 1, kPoll_ms);
    if (ready < 0 && errno == EINTR) continue;
    if (ready < 0) return false;
    if (ready == 0) {
      if (Clock::now() - heard > timeout) return false;
      if (progress) progress(last);
      continue;
    }
    heard = Clock::now();
    double parts[64];
    const ssize_t n = read(pipe, parts, sizeof parts);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return true;
    const std::size_t count = static_cast<std::size_t>(n) / sizeof parts[0];
    if (count == 0) continue;
    last = std::clamp(parts[count - 1], 0.0, 1.0);
    if (progress) progress(last);
  }
}

std::string ReadAll(int fd) {
  struct stat about {};
  std::string bytes;
  if (fstat(fd, &about) != 0 || about.st_size == 0) return bytes;
  bytes.resize(static_cast<std::size_t>(about.st_size));
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t n = pread(fd, &bytes[got], bytes.size() - got, static_cast<off_t>(got));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    got += static_cast<std::size_t>(n);
  }
  bytes.resize(got);
  return bytes;
}

/// Returns the result, or throws the kerf::Error that describes the failure.
std::string TakeResult(int status, bool ended, std::string bytes, const std::string& name, const ChildLimits& limits) {
  const auto fail = [&name](const std::string& what) { throw Error(fmt::format("{}: {}", name, what)); };
  if (!ended) {
    fail(fmt::format("reading made no progress for {:g} s and was stopped; the file is damaged", limits.silent_s));
  }
  if (WIFSIGNALED(status)) {
    fail(fmt::format("the file is damaged: the library that reads it failed ({})", strsignal(WTERMSIG(status))));
  }
  const int code = WEXITSTATUS(status);
  if (code == kRefused) throw Error(bytes);
  if (code == kNoMemory) {
    fail(fmt::format("reading needs more than {} MiB of memory; the file is too large or damaged",
                     limits.memory_bytes >> 20));
  }
  if (code != kDone) {
    fail(fmt::format("the file is damaged: the library that reads it failed{}",
                     bytes.empty() ? "" : fmt::format(" ({})", bytes)));
  }
  return bytes;
}

}  // namespace

SharedMemory::SharedMemory(std::size_t bytes)
    : bytes_(bytes), start_(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
  if (start_ == MAP_FAILED) throw Error(fmt::format("not enough memory: {} MiB are needed", bytes >> 20));
}

SharedMemory::~SharedMemory() {
  munmap(start_, bytes_);
}

void ChildReport::SetProgress(double part) {
  WriteAll(pipe_, {reinterpret_cast<const char*>(&part), sizeof part});
}

void ChildReport::SetName(std::string_view name) {
  name = name.substr(0, kNameBytes - 1);
  std::memcpy(name_, name.data(), name.size());
  name_[name.size()] = '\0';
}

std::string RunInChild(const std::string& name, const ChildLimits& limits,
                       const std::function<std::string(ChildReport&)>& work,
                       const std::function<void(double)>& progress) {
  if (report_of_this_child != nullptr) return work(*report_of_this_child);
  const Descriptor result(memfd_create("kerf", MFD_CLOEXEC));
  const SharedMemory shared_name(ChildReport::kNameBytes);
  int ends[2];
  if (result.get() < 0 || pipe2(ends, O_CLOEXEC) != 0) {
    throw Error(fmt::format("{}: can't be read: {}", name, FormatErrno(errno)));
  }
  const Descriptor from(ends[0]);
  Descriptor to(ends[1]);
  ChildReport report(to.get(), shared_name.data());
  report.SetName(name);
  const std::uint64_t used_bytes = FindAddressSpace();
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child < 0) throw Error(fmt::format("{}: can't be read: no process can be started: {}", name, FormatErrno(errno)));
  if (child == 0) {
    Confine(limits, used_bytes, parent);
    Work(result.get(), report, work);
  }
  to.Close();
  bool ended = false;
  std::exception_ptr thrown;  // thrown by `progress`
  try {
    ended = Follow(from.get(), limits.silent_s, progress);
  } catch (...) {
    thrown = std::current_exception();
  }
  if (!ended) kill(child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (thrown) std::rethrow_exception(thrown);
  return TakeResult(status, ended, ReadAll(result.get()), std::string(shared_name.data()), limits);
}

}  // namespace kerf
