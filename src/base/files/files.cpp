#include "base/files/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <system_error>

#include "base/core/errno_text.h"
#include "base/files/temporary.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Resolves a link, so that the link's target is replaced and not the link itself.
std::string FollowLinks(const std::string& path) {
  constexpr int kMostLinks = 40;
  fs::path target(path);
  std::error_code error;
  for (int i = 0; i < kMostLinks && fs::is_symlink(target, error); ++i) {
    const fs::path link = fs::read_symlink(target, error);
    if (error) return path;
    target = link.is_absolute() ? link : target.parent_path() / link;
  }
  return target.string();
}

std::map<std::string, std::string>& Shelf() {
  static std::map<std::string, std::string> shelf;
  return shelf;
}

}  // namespace

FileShelf::FileShelf(std::map<std::string, std::string> files) {
  Shelf() = std::move(files);
}
FileShelf::~FileShelf() {
  Shelf().clear();
}

void CheckWritable(const std::string& path) {
  const fs::path folder = fs::path(path).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored)) {
    throw Error(fmt::format("{}: can't be written: there is no folder {}", path, folder.string()));
  }
  const fs::file_status status = fs::status(path, ignored);
  if (fs::is_directory(status)) throw Error(fmt::format("{}: can't be written: it is a folder", path));
  // A device or a pipe would be replaced by a file.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(fmt::format("{}: can't be written: it is not a regular file", path));
  }
}

void CheckIsRegularFile(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw Error(fmt::format("{}: there is no such file", path));
  if (fs::is_directory(status)) throw Error(fmt::format("{}: is a folder, not a file", path));
  if (!fs::is_regular_file(status)) throw Error(fmt::format("{}: is not a regular file", path));
}

std::string ReadTextFile(const std::string& path, std::size_t max_bytes) {
  if (const auto shelved = Shelf().find(path); shelved != Shelf().end()) return shelved->second;
  std::error_code error;
  CheckIsRegularFile(path);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(fmt::format("{}: can't be read: {}", path, FormatErrno(errno)));
  std::string content;
  // Reads in blocks and does not use the file's stated size, which is 0 in /proc and may change during reading.
  std::size_t block = std::size_t{1} << 20;
  const std::uintmax_t size = fs::file_size(path, error);
  if (!error && size <= max_bytes) content.reserve(static_cast<std::size_t>(size) + 1);
  if (!error && size > 0 && size < block) block = static_cast<std::size_t>(size) + 1;
  while (in) {
    const std::size_t old = content.size();
    content.resize(old + block);
    in.read(content.data() + old, static_cast<std::streamsize>(block));
    content.resize(old + static_cast<std::size_t>(in.gcount()));
    if (content.size() > max_bytes) {
      throw Error(fmt::format("{}: is larger than {} MiB, which is more than a file of this kind can need", path,
                              max_bytes >> 20));
    }
  }
  CheckReadable(in, path);
  return content;
}

void CheckReadable(const std::istream& in, const std::string& path) {
  if (in.bad()) throw Error(fmt::format("{}: can't be read: {}", path, FormatErrno(errno)));
}

struct PendingFile::State {
  std::string path;
  std::string target;
  std::unique_ptr<Temporary> temporary;  // null once a FileBatch has taken it
  State(std::string the_path, std::string the_target) : path(std::move(the_path)), target(std::move(the_target)) {}
};

PendingFile::PendingFile(const std::string& path) {
  CheckWritable(path);
  try {
    state_ = std::make_unique<State>(path, FollowLinks(path));
    state_->temporary = std::make_unique<Temporary>(state_->target);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: can't be written: {}", path, e.what()));
  }
}
PendingFile::~PendingFile() = default;
PendingFile::PendingFile(PendingFile&&) noexcept = default;
PendingFile& PendingFile::operator=(PendingFile&&) noexcept = default;

const std::string& PendingFile::path() const {
  return state_->path;
}
const std::string& PendingFile::temporary() const {
  return state_->temporary->path_to_write();
}

void PendingFile::Commit() {
  try {
    state_->temporary->Flush();
    state_->temporary->CheckName();  // before a batch takes it, so that a lost file does not hold up the others
    if (!FileBatch::Take(state_)) state_->temporary->RenameTo(state_->target);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: can't be written: {}", path(), e.what()));
  }
}

namespace {

std::mutex batches_mutex;  // also of their files
std::vector<FileBatch*> batches;

/// Returns the folder of a file, spelled in one way.
fs::path FolderOf(const std::string& file) {
  return fs::path(file).lexically_normal().parent_path();
}

}  // namespace

struct FileBatch::State {
  std::string folder;                        // as given
  fs::path list;                             // target of the list
  bool is_begun = false;                     // the earlier list is removed
  std::vector<PendingFile::State> complete;  // without a temporary: renamed

  bool IsList(const PendingFile::State& file) const { return fs::path(file.target).lexically_normal() == list; }
  bool ReplacesNothing() const;
  /// Removes the earlier list and renames the other files, in the order in which they were completed.
  void Rename();
  void RenameOne(PendingFile::State& file) const;
};

void FileBatch::State::RenameOne(PendingFile::State& file) const {
  try {
    file.temporary->RenameTo(file.target);
    file.temporary.reset();
  } catch (const Error& e) {
    throw Error(fmt::format("{}: can't be written: {}; {} may have files of two runs, and has no {}", file.path,
                            e.what(), folder, list.filename().string()));
  }
}

void FileBatch::State::Rename() {
  const RenamesTogether together;
  for (const PendingFile::State& file : complete) {
    try {
      if (file.temporary != nullptr) file.temporary->CheckName();  // RemoveTemporaries() may have come first
    } catch (const Error& e) {
      throw Error(fmt::format("{}: can't be written: {}", file.path, e.what()));
    }
  }
  if (!is_begun && unlink(list.c_str()) != 0 && errno != ENOENT) {
    throw Error(fmt::format("{}: can't be replaced: {}", list.string(), FormatErrno(errno)));
  }
  is_begun = true;
  for (PendingFile::State& file : complete) {
    if (file.temporary != nullptr && !IsList(file)) RenameOne(file);
  }
}

FileBatch::FileBatch(const std::string& folder, const std::string& list) : state_(std::make_unique<State>()) {
  state_->folder = folder;
  state_->list = fs::path(FollowLinks(folder + "/" + list)).lexically_normal();
  const std::lock_guard lock(batches_mutex);
  batches.push_back(this);
}

FileBatch::~FileBatch() {
  const std::lock_guard lock(batches_mutex);
  std::erase(batches, this);
  try {
    if (state_->ReplacesNothing()) state_->Rename();
  } catch (const std::exception&) {  // the error that ended the work is reported
  }
}

bool FileBatch::State::ReplacesNothing() const {
  std::error_code ignored;
  const auto replaces = [&](const auto& file) { return fs::exists(file.target, ignored); };
  return !fs::exists(list, ignored) && std::none_of(complete.begin(), complete.end(), replaces);
}

bool FileBatch::ReplacesNothing() const {
  const std::lock_guard lock(batches_mutex);
  return state_->ReplacesNothing();
}

std::string FileBatch::Find(const std::string& path) const {
  const std::lock_guard lock(batches_mutex);
  for (const PendingFile::State& file : state_->complete) {
    if (file.path == path && file.temporary != nullptr) return file.temporary->path();
  }
  return path;
}

bool FileBatch::Take(std::unique_ptr<PendingFile::State>& file) {
  const std::lock_guard lock(batches_mutex);
  for (FileBatch* batch : batches) {
    State& state = *batch->state_;
    if (FolderOf(file->path) != FolderOf(state.folder + "/file")) continue;
    PendingFile::State& taken = state.complete.emplace_back(file->path, file->target);
    taken.temporary = std::move(file->temporary);
    if (state.complete.size() > kMost) state.Rename();
    return true;
  }
  return false;
}

void FileBatch::Commit(const std::vector<std::string>& earlier) {
  const std::lock_guard lock(batches_mutex);
  const RenamesTogether together;
  state_->Rename();
  for (const std::string& name : earlier) {
    const auto is_new = [&](const auto& file) { return fs::path(file.path).filename() == name; };
    const fs::path path = fs::path(state_->folder) / name;
    if (std::none_of(state_->complete.begin(), state_->complete.end(), is_new)) unlink(path.c_str());
  }
  for (PendingFile::State& file : state_->complete) {
    if (file.temporary != nullptr) state_->RenameOne(file);
  }
  *state_ = {state_->folder, state_->list, false, {}};
}

GrowingFile::GrowingFile(const std::string& path) : pending_(path) {
  file_ = open(pending_.temporary().c_str(), O_WRONLY | O_CLOEXEC);
  if (file_ < 0) throw Error(fmt::format("{}: can't be written: {}", path, FormatErrno(errno)));
}

GrowingFile::~GrowingFile() {
  if (file_ >= 0) close(file_);
}

void GrowingFile::Append(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) throw Error(fmt::format("{}: can't be written: {}", pending_.path(), FormatErrno(errno)));
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

void GrowingFile::Commit() {
  const int result = close(file_);
  file_ = -1;
  if (result != 0) throw Error(fmt::format("{}: can't be written: {}", pending_.path(), FormatErrno(errno)));
  pending_.Commit();
}

void WriteAtomically(const std::string& path, const std::function<void(const std::string&)>& write) {
  PendingFile pending(path);
  write(pending.temporary());
  pending.Commit();
}

void WriteTextFile(const std::string& path, const std::string& content) {
  WriteAtomically(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (!out) throw Error(fmt::format("{}: can't be written: {}", path, FormatErrno(errno)));
  });
}

bool IsSameFile(const std::string& a, const std::string& b) {
  std::error_code failed;
  if (fs::equivalent(a, b, failed)) return true;
  const fs::path one = fs::weakly_canonical(fs::absolute(a, failed), failed);
  const fs::path other = fs::weakly_canonical(fs::absolute(b, failed), failed);
  return !failed && one == other;
}

void CheckInputsNotOverwritten(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  for (const std::string& input : inputs) {
    for (const std::string& output : outputs) {
      if (input.empty() || output.empty() || !IsSameFile(input, output)) continue;
      throw Error(fmt::format("{}: is an input and would be overwritten by {}; choose another output", input, output));
    }
  }
}

void RemoveTemporaries() {
  RemoveLiveTemporaries();
}

void MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  std::error_code none;
  if (fs::is_directory(path, none)) return;
  const bool taken = !error || fs::exists(path, none);
  throw Error(
      fmt::format("{}: the folder can't be created: {}", path, taken ? "a file of that name exists" : error.message()));
}

}  // namespace kerf
