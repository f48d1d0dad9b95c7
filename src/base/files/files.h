// Safe reading and writing of whole files.
#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace kerf {

/// Call right after reading `path`. Throws kerf::Error with the system's reason if reading failed instead of reaching
/// the end of the file. The content is then unknown and must not be reported as damaged.
void CheckReadable(const std::istream& in, const std::string& path);

/// Throws kerf::Error with one sentence unless `path` is an existing regular file. Reading a pipe may block forever.
void CheckIsRegularFile(const std::string& path);
/// Returns the file's bytes. Throws kerf::Error if it cannot be read or is larger than `max_bytes`.
std::string ReadTextFile(const std::string& path, std::size_t max_bytes = std::size_t{256} << 20);
/// Throws kerf::Error if a file cannot be written at `path`: the folder does not exist, or `path` is a folder, a device
/// or a pipe. Call it before lengthy work.
void CheckWritable(const std::string& path);
/// While an object exists, ReadTextFile() returns these contents for the given names, whether or not such files exist.
/// Used for inputs that are embedded in another file. At most one may exist at a time. It must not be created or
/// destroyed while files are read.
class FileShelf {
 public:
  explicit FileShelf(std::map<std::string, std::string> files);
  ~FileShelf();
  FileShelf(const FileShelf&) = delete;
  FileShelf& operator=(const FileShelf&) = delete;
};
/// Writes to a temporary file next to `path`, flushes it and renames it: an existing file stays intact until the new
/// one is complete. Throws kerf::Error.
void WriteTextFile(const std::string& path, const std::string& content);
/// Does the same for a writer that needs a file name: calls write(temporary) and renames the temporary file to `path`.
/// The temporary file already exists and is empty; its name has no extension. If `write` throws, it is removed and the
/// exception is propagated.
void WriteAtomically(const std::string& path, const std::function<void(const std::string&)>& write);
/// File that is written over a long time. It is written to a temporary file next to `path` (files/temporary.h), which
/// Commit() renames. If it is destroyed earlier, nothing is left behind and an existing file is unchanged.
class PendingFile {
 public:
  /// Throws kerf::Error as CheckWritable() does.
  explicit PendingFile(const std::string& path);
  ~PendingFile();
  PendingFile(PendingFile&&) noexcept;
  PendingFile& operator=(PendingFile&&) noexcept;

  const std::string& path() const;       // final path
  const std::string& temporary() const;  // path to write to
  /// Flushes and renames. Throws kerf::Error. Call once, after every writer has closed the temporary file.
  void Commit();

 private:
  friend class FileBatch;
  struct State;
  std::unique_ptr<State> state_;
};

/// While an object exists, the files of one folder that are complete replace earlier ones only together, with Commit():
/// if the work fails or a signal ends the program, the folder is as it was. The files may be written by several
/// threads.
class FileBatch {
 public:
  static constexpr std::size_t kMost = 200;  // if there are more files, each is renamed as soon as it is complete

  /// `folder`: as in the paths of the files. `list`: name of the file that describes the others. It is removed before
  /// the first file is replaced and renamed last: a folder with files of two runs, which only an error of the disk or a
  /// loss of power while they are renamed can leave (or an error with more than kMost files), has no list.
  FileBatch(const std::string& folder, const std::string& list);
  /// If Commit() was not called: removes the files, or gives them their names if they and the list would replace none.
  ~FileBatch();
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;

  /// Returns true if there is neither an earlier list nor an earlier file of the same name as one that is complete.
  bool ReplacesNothing() const;
  /// Returns the path at which a complete file can be read before Commit().
  std::string Find(const std::string& path) const;
  /// Renames the files and removes those in `earlier`, names in the folder, that are not among them. Throws
  /// kerf::Error.
  void Commit(const std::vector<std::string>& earlier = {});

 private:
  friend class PendingFile;
  struct State;
  /// Takes a complete file of the folder, if an object exists and has room for it.
  static bool Take(std::unique_ptr<PendingFile::State>& file);
  std::unique_ptr<State> state_;
};

/// A PendingFile to which bytes are appended.
class GrowingFile {
 public:
  /// Throws kerf::Error if the file cannot be created.
  explicit GrowingFile(const std::string& path);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Appends without buffering, so pass large blocks. Throws kerf::Error, for instance if the disk is full.
  void Append(std::string_view bytes);
  /// Does the same as PendingFile::Commit().
  void Commit();

 private:
  PendingFile pending_;
  int file_ = -1;
};

/// Returns true if both names refer, or would refer, to the same file. Follows links.
bool IsSameFile(const std::string& a, const std::string& b);
/// Throws kerf::Error if one of `outputs` is also one of `inputs` and would be overwritten, by name or through a link.
/// Ignores empty names. Call it before lengthy work; list every file that may be written.
void CheckInputsNotOverwritten(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);
/// Removes the temporary files that are being written. For a signal handler that ends the program: async-signal-safe.
void RemoveTemporaries();
/// Creates the folder and its parents. Throws kerf::Error.
void MakeFolder(const std::string& path);

}  // namespace kerf
