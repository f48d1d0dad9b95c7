// Lock that lets only one program at a time write results into a folder.
#pragma once

#include <string>

namespace kerf {

/// Locks the folder for this program's results; creates it if it is missing. The lock is flock(2) on the folder itself:
/// it leaves no file behind, is released when the program ends, even if it is killed, and does not affect readers. If a
/// folder cannot be locked (NFS), the file ".lock" in it is locked. On file systems without locks, as on some clusters,
/// there is no lock.
class FolderLock {
 public:
  /// Throws kerf::Error immediately if another program, or another lock of this program, holds the folder.
  explicit FolderLock(const std::string& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace kerf
