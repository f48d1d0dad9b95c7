// Free disk space.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// Returns how many bytes this user may still write at `path`, or the largest double if the system does not report it.
double ReadFreeDiskBytes(const std::string& path);

/// File that will be written, and the minimum size that it will have.
struct ExpectedFile {
  std::string path;
  double bytes = 0;
};
/// Returns a sentence if a file system has too little space for the files; otherwise an empty string.
std::string DescribeLackOfSpace(const std::vector<ExpectedFile>& files);

}  // namespace kerf
