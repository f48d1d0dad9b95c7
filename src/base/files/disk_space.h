// What room there is on the disk.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// What this user may still write where `path` is or would be, bytes. The largest number where the system does not say.
double ReadFreeDiskBytes(const std::string& path);

/// A file that is going to be written, and the least that it will take.
struct ExpectedFile {
  std::string path;
  double bytes = 0;
};
/// A sentence when a file system has no room for those that are to go there; empty when each has.
std::string DescribeLackOfSpace(const std::vector<ExpectedFile>& files);

}  // namespace kerf
