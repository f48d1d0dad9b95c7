// Reading and writing whole files safely.
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

/// Right after a read of `path`: throws Error with the system's reason when the disk failed, rather than the file
/// ended. What such a file holds is not known, so it is not to be called damaged.
void CheckReadable(const std::istream& in, const std::string& path);

/// The file's bytes. Throws Error when it can't be read or is larger than `max_bytes`.
std::string ReadTextFile(const std::string& path, std::size_t max_bytes = std::size_t{256} << 20);
/// Throws Error when a file can't be written there: no such folder, a folder, or a device or pipe of that name. For
/// asking early, before long work.
void CheckWritable(const std::string& path);
/// While it lives ReadTextFile() reads these in place of files of those names, whether there are such or not: inputs
/// that came along in another file. One at a time; not while others read.
class FileShelf {
 public:
  explicit FileShelf(std::map<std::string, std::string> files);
  ~FileShelf();
  FileShelf(const FileShelf&) = delete;
  FileShelf& operator=(const FileShelf&) = delete;
};
/// Writes to a temporary beside `path`, flushes and renames: an earlier file is whole until the new one is. Throws
/// Error.
void WriteTextFile(const std::string& path, const std::string& content);
/// The same for a writer that wants a file name: calls write(temporary) and renames it to `path`. The temporary is
/// there and empty, its name has no extension. When `write` throws, it is removed and the exception goes on.
void WriteAtomically(const std::string& path, const std::function<void(const std::string&)>& write);
/// A file that is written over a long time, to a temporary beside `path` (files/temporary.h); it gets its name when it
/// is whole. Destroyed before, it leaves nothing behind, and an earlier file is as it was.
class PendingFile {
 public:
  /// Throws Error as CheckWritable.
  explicit PendingFile(const std::string& path);
  ~PendingFile();
  PendingFile(PendingFile&&) noexcept;
  PendingFile& operator=(PendingFile&&) noexcept;

  const std::string& path() const;       // asked for
  const std::string& temporary() const;  // where to write
  /// Flushes and renames. Throws Error. Once, when nothing holds the temporary open for writing any more.
  void Commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same, of bytes added at its end.
class GrowingFile {
 public:
  /// Throws Error when it can't be made.
  explicit GrowingFile(const std::string& path);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Straight into the file: give it large blocks. Throws Error, as when the disk is full.
  void Append(std::string_view bytes);
  /// As PendingFile.
  void Commit();

 private:
  PendingFile pending_;
  int file_ = -1;
};

/// Whether both names are, or would be, one file: links are followed.
bool IsSameFile(const std::string& a, const std::string& b);
/// Throws Error when one of `outputs` is one of `inputs` and would be written over, by name or through a link. Empty
/// names are passed over. For asking before long work; name every file that may be written.
void CheckInputsStay(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs);
/// Removes the temporaries that are being written. For a signal's handler that ends the program: async-signal-safe.
void RemoveTemporaries();
/// Makes the folder and its parents. Throws Error.
void MakeFolder(const std::string& path);

}  // namespace kerf
