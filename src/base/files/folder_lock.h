// One program at a time writes results into a folder.
#pragma once

#include <string>

namespace kerf {

/// Holds the folder for this program's results; made when missing. The lock is flock(2) on the folder itself: it leaves
/// no file, goes when the program ends, also when it is killed, and readers don't notice it. Where a folder can't be
/// locked (NFS), the file ".lock" in it is; file systems without locks exist on clusters, and there nothing is held.
class FolderLock {
 public:
  /// Throws Error, at once, when another program, or another lock of this one, holds it.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace kerf
