// A file that is written under a temporary name beside its target, and the leftovers of programs that were killed.
#pragma once

#include <sys/types.h>

#include <string>

namespace kerf {

struct LiveTemporary;  // where a signal's handler finds it

/// An own, empty file beside `target`, which a planted link can't redirect:
///
///   .NAME.kerf-HOST-RANDOM.EXT     HOST names this machine, RANDOM is 64 random bits
///
/// It is made by O_EXCL and O_NOFOLLOW and is locked (flock) as long as this object lives. So whether its owner is
/// alive is known without process numbers. Removed by the destructor unless it was renamed.
class Temporary {
 public:
  /// First removes what dead programs left in the folder (SweepLeftovers). Throws Error.
  explicit Temporary(const std::string& target);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  /// For a writer that wants a name: /proc/self/fd/N, which leads to this file whatever has been put in the place of
  /// its name. Without /proc it is the name.
  const std::string& path_to_write() const { return path_to_write_.empty() ? path_ : path_to_write_; }
  int file() const { return file_; }
  /// Flushes it to the disk and renames it; an earlier file's permissions stay. Throws Error with the reason alone.
  void RenameTo(const std::string& target, bool flush = true);

 private:
  bool Create(mode_t mode);

  int file_ = -1;
  bool renamed_ = false;
  std::string path_;
  std::string path_to_write_;
  LiveTemporary* live_ = nullptr;
};

/// Removes the temporaries of dead programs from the folder of `target`: those of the form above, and those of earlier
/// versions (.NAME.PID-N.EXT) that were to become `target`. Each folder is searched once by a program.
///
/// A temporary is removed only if it is a regular file of this user with a single name and its owner is dead: its lock
/// can be taken. Where the file system may be shared with other machines, HOST has to be this one too. One of an
/// earlier version needs a local file system, a process number that is not in use, and no program that has the file
/// open.
void SweepLeftovers(const std::string& target);

/// Removes the temporaries that are being written. Async-signal-safe.
void RemoveLiveTemporaries();

/// A folder of this program's own in the system's folder for temporary files, with a random name (mkdtemp). It goes,
/// with all that is in it, when the object does.
class TemporaryFolder {
 public:
  /// Throws Error.
  explicit TemporaryFolder(const std::string& name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace kerf
