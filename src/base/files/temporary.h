// File that is written under a temporary name next to its target, and removal of the files that killed programs left.
#pragma once

#include <sys/types.h>

#include <csignal>

#include <string>

namespace kerf {

struct LivePath;  // entry that a signal handler can read

/// Notes a file that RemoveLiveTemporaries() removes or, with `folders` > 0, a folder that it removes if it is empty,
/// and then in turn its parents, up to that number of folders; kWithContent: a folder with all that it contains.
/// Returns nullptr if there is no room for it.
inline constexpr int kWithContent = -1;
LivePath* AddLive(const std::string& path, int folders = 0);
/// Removes the note; null: does nothing.
void RemoveLive(LivePath* entry);

/// New, empty file next to `target`. A link planted under its name cannot redirect it.
///
///   .NAME.kerf-HOST-RANDOM.EXT     HOST identifies this machine, RANDOM is 64 random bits
///
/// It is created with O_EXCL and O_NOFOLLOW and locked (flock) while this object exists, so that others can tell
/// without process ids whether its owner is alive. The destructor removes it unless it was renamed.
class Temporary {
 public:
  /// First removes what killed programs left in the folder (SweepLeftovers()). Throws kerf::Error if the file cannot be
  /// created.
  explicit Temporary(const std::string& target);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  /// Path for a writer that needs a name: /proc/self/fd/N, which refers to this file even if another file takes its
  /// name. Without /proc it is the file's name.
  const std::string& path_to_write() const { return path_to_write_.empty() ? path_ : path_to_write_; }
  const std::string& path() const { return path_; }
  int file() const { return file_; }
  /// Writes the file's content to the disk; call it before RenameTo() if a loss of power must not leave an incomplete
  /// file. Throws kerf::Error that states only the reason.
  void Flush() const;
  /// Throws kerf::Error that states only the reason unless the file still has its name.
  void CheckName() const;
  /// Gives the file the permissions of an existing target, and renames it. Throws kerf::Error that states only the
  /// reason.
  void RenameTo(const std::string& target);

 private:
  bool Create(mode_t mode);

  int file_ = -1;
  bool renamed_ = false;
  std::string path_;
  std::string path_to_write_;
  LivePath* live_ = nullptr;
};

/// Removes temporary files of dead programs from the folder of `target`: those named as above, and those of earlier
/// versions (.NAME.PID-N.EXT) that were meant for `target`. A program searches each folder only once.
///
/// A temporary file is removed only if it is a regular file of this user with a single link and its owner is dead, that
/// is, its lock is free. If the file system may be shared with other machines, HOST must also be this machine. A file
/// of an earlier version is removed only on a local file system, if no process has its process id and no program has it
/// open.
void SweepLeftovers(const std::string& target);

/// Removes the temporary files that are being written, and then the noted folders. If files are being renamed together
/// (RenamesTogether), waits for that. Async-signal-safe.
void RemoveLiveTemporaries();

/// While an object exists, a signal that ends the program (SIGHUP, SIGINT, SIGTERM) is not handled by this thread, and
/// RemoveLiveTemporaries() waits in another: files are all renamed or none. For a few milliseconds only. Objects may be
/// nested.
class RenamesTogether {
 public:
  RenamesTogether();
  ~RenamesTogether();
  RenamesTogether(const RenamesTogether&) = delete;
  RenamesTogether& operator=(const RenamesTogether&) = delete;

 private:
  sigset_t before_;
};

/// Private folder with a random name (mkdtemp) in the system's folder for temporary files. The destructor, and a signal
/// that ends the program, remove it and its content.
class TemporaryFolder {
 public:
  /// Throws kerf::Error if it cannot be created.
  explicit TemporaryFolder(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  LivePath* live_ = nullptr;
};

}  // namespace kerf
