// Reading and writing whole files safely.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace kerf {

/// The file's bytes. Throws Error when it can't be read or is larger than `max_bytes`.
std::string ReadTextFile(const std::string& path, std::size_t max_bytes = std::size_t{256} << 20);
/// Throws Error when a file can't be written there: no such folder, a folder, or a device or pipe of that name. For
/// asking early, before long work.
void CheckWritable(const std::string& path);
/// Writes to a temporary beside `path`, flushes and renames: an earlier file is whole until the new one is. Throws
/// Error.
void WriteTextFile(const std::string& path, const std::string& content);
/// The same for a writer that wants a file name: calls write(temporary) and renames it to `path`. The temporary keeps
/// the extension of `path`. When `write` throws, the temporary is removed and the exception goes on.
void WriteAtomically(const std::string& path, const std::function<void(const std::string&)>& write);
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
