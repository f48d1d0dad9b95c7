#include "base/files/disk_space.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/statvfs.h>

#include <filesystem>
#include <limits>
#include <map>
#include <system_error>

#include "base/core/byte_text.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Returns the file's folder, or its nearest parent that exists.
std::string FindFolder(const std::string& path) {
  std::error_code failed;
  fs::path folder = fs::absolute(path, failed).parent_path();
  while (!fs::is_directory(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
  return folder.string();
}

}  // namespace

double ReadFreeDiskBytes(const std::string& path) {
  struct statvfs system {};
  if (statvfs(FindFolder(path).c_str(), &system) != 0) return std::numeric_limits<double>::max();
  return static_cast<double>(system.f_bavail) * static_cast<double>(system.f_frsize);
}

std::string DescribeLackOfSpace(const std::vector<ExpectedFile>& files) {
  std::map<dev_t, ExpectedFile> sums;  // per file system
  for (const ExpectedFile& file : files) {
    struct stat status {};
    if (stat(FindFolder(file.path).c_str(), &status) != 0) continue;
    ExpectedFile& sum = sums[status.st_dev];
    sum.path += (sum.path.empty() ? "" : " and ") + file.path;
    sum.bytes += file.bytes;
  }
  for (const auto& [device, sum] : sums) {
    const double free_bytes = ReadFreeDiskBytes(sum.path);
    if (sum.bytes <= free_bytes) continue;
    const auto [needed, available] = FormatBytePair(sum.bytes, free_bytes);
    return fmt::format("{}: can't be written: at least {} are needed and {} are free on the disk", sum.path, needed,
                       available);
  }
  return "";
}

}  // namespace kerf
