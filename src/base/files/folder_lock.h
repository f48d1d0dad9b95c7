// Lock that lets only one program at a time write results into a folder.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace kerf {

struct LivePath;

/// Locks the folder for this program's results; creates it, and its parents, if it is missing. The lock is flock(2) on
/// the folder itself: it leaves no file behind, is released when the program ends, even if it is killed, and does not
/// affect readers. If a folder cannot be locked (NFS), the file ".lock" in it is locked. On file systems without locks,
/// as on some clusters, there is no lock.
class FolderLock {
 public:
  /// Throws kerf::Error immediately if another program, or another lock of this program, holds the folder.
  explicit FolderLock(const std::string& folder);
  /// Does the same as RemoveFolderIfUnused().
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Removes the folders that this object has created, as far as they are empty: a run that failed, or wrote nothing,
  /// leaves no folder behind. RemoveLiveTemporaries() does so too, for a run that is interrupted.
  void RemoveFolderIfUnused();

 private:
  struct RemoveNote {
    void operator()(LivePath* entry) const;
  };
  int file_ = -1;
  std::vector<std::string> created_;  // innermost last
  std::unique_ptr<LivePath, RemoveNote> live_;
};

}  // namespace kerf
