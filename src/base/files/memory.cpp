#include "base/files/memory.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <mutex>
#include <new>
#include <optional>

#include "kerf/error.h"

namespace kerf {
namespace {

/// Allowance for thread stacks and other memory that is reserved but hardly used.
constexpr std::uint64_t kSlackBytes = std::uint64_t{256} << 20;

void (*bad_alloc_handler)() = nullptr;
std::mutex exit_mutex;
int exit_count = 0;  // number of ExitOnBadAlloc objects

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

std::uint64_t PageBytes() {
  return static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

struct Pages {
  std::uint64_t all = 0;
  std::uint64_t resident = 0;
  std::uint64_t data = 0;  // private writable memory, including the stack
};

Pages ReadOwnPages() {
  std::ifstream file("/proc/self/statm");
  Pages pages;
  std::uint64_t skipped = 0;
  if (!(file >> pages.all >> pages.resident >> skipped >> skipped >> skipped >> pages.data)) return {};
  return pages;
}

/// Returns the sum of the named rows of a file with rows "name: number kB" or "name number".
std::optional<std::uint64_t> ReadRows(const char* path, std::initializer_list<const char*> names) {
  std::ifstream file(path);
  std::uint64_t sum = 0;
  bool any = false;
  for (std::string name, line; file >> name; std::getline(file, line)) {
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    std::uint64_t number = 0;
    if (!(file >> number)) break;
    sum += number;
    any = true;
  }
  return any ? std::optional(sum) : std::nullopt;
}

std::optional<std::uint64_t> ReadNumber(const char* path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (!(file >> number)) return std::nullopt;  // "max", or no such file
  return number;
}

std::uint64_t SaturatingSubtract(std::uint64_t limit, std::uint64_t used) {
  return limit > used ? limit - used : 0;
}

std::uint64_t ReadMachineBytes() {
  const auto kB = ReadRows("/proc/meminfo", {"MemAvailable:", "SwapFree:"});
  return kB ? *kB * 1024 : kNoLimit;
}

/// Returns what remains of the control group's limit. The group is found only within a container, where it is mounted
/// as the root.
std::uint64_t ReadGroupBytes() {
  const auto limit = ReadNumber("/sys/fs/cgroup/memory.max");
  const auto used = ReadNumber("/sys/fs/cgroup/memory.current");
  if (!limit || !used) return kNoLimit;
  // The kernel reclaims inactive file pages first.
  const std::uint64_t files = ReadRows("/sys/fs/cgroup/memory.stat", {"inactive_file"}).value_or(0);
  return SaturatingSubtract(*limit, SaturatingSubtract(*used, files));
}

/// Returns what remains of one of this program's limits after `pages`, the pages that count towards it.
template <typename Resource>
std::uint64_t ReadLimit(Resource resource, std::uint64_t pages) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  return SaturatingSubtract(limit.rlim_cur, pages * PageBytes());
}

std::uint64_t ReadUserBytes() {
  const Pages own = ReadOwnPages();
  return std::min(ReadLimit(RLIMIT_AS, own.all), ReadLimit(RLIMIT_DATA, own.data));
}

}  // namespace

std::size_t ReadResidentBytes() {
  malloc_trim(0);  // freed memory that malloc keeps is not in use
  return ReadOwnPages().resident * PageBytes();
}

std::size_t ReadHeapBytes() {
  const struct mallinfo2 heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

std::uint64_t ReadAvailableBytes() {
  return std::min({ReadMachineBytes(), ReadGroupBytes(), ReadUserBytes()});
}

std::uint64_t LimitMemory() {
  const std::uint64_t free = ReadAvailableBytes();
  rlimit limit{};
  if (free == kNoLimit || getrlimit(RLIMIT_DATA, &limit) != 0) return free;
  const rlim_t max_bytes = ReadOwnPages().data * PageBytes() + free + kSlackBytes;
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur <= max_bytes) return free;
  limit.rlim_cur = limit.rlim_max == RLIM_INFINITY ? max_bytes : std::min(max_bytes, limit.rlim_max);
  setrlimit(RLIMIT_DATA, &limit);
  return free;
}

void CheckMemory(double bytes, const std::string& what, const std::string& remedy) {
  const auto free = static_cast<double>(ReadAvailableBytes());
  if (!(bytes > free)) return;
  throw Error(fmt::format("{} needs about {:.1f} GB of memory and {:.1f} GB are free; {}", what, bytes / 1e9,
                          free / 1e9, remedy));
}

void CheckLimits(double address_bytes, double data_bytes, const std::string& what, const std::string& remedy) {
  const Pages own = ReadOwnPages();
  const auto address_left = static_cast<double>(ReadLimit(RLIMIT_AS, own.all));
  const auto data_left = static_cast<double>(ReadLimit(RLIMIT_DATA, own.data));
  if (address_left < address_bytes) {
    throw Error(fmt::format("{} needs about {:.1f} GB of address space and 'ulimit -v' leaves {:.2f} GB; {}", what,
                            address_bytes / 1e9, address_left / 1e9, remedy));
  }
  if (data_left < data_bytes) {
    throw Error(fmt::format("{} needs about {:.1f} GB of memory and {:.2f} GB are free; {}", what, data_bytes / 1e9,
                            data_left / 1e9, remedy));
  }
}

void SetBadAllocHandler(void (*handler)()) {
  bad_alloc_handler = handler;
}

ExitOnBadAlloc::ExitOnBadAlloc() {
  const std::lock_guard lock(exit_mutex);
  if (exit_count++ == 0 && bad_alloc_handler != nullptr) std::set_new_handler(bad_alloc_handler);
}

ExitOnBadAlloc::~ExitOnBadAlloc() {
  const std::lock_guard lock(exit_mutex);
  if (--exit_count == 0 && bad_alloc_handler != nullptr) std::set_new_handler(nullptr);
}

}  // namespace kerf
