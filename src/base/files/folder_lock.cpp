#include "base/files/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "base/core/errno_text.h"
#include "base/files/files.h"
#include "base/files/temporary.h"
#include "kerf/error.h"

namespace kerf {

FolderLock::FolderLock(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  for (fs::path at = fs::absolute(folder, unknown).lexically_normal(); !at.empty() && !fs::exists(at, unknown);
       at = at.parent_path()) {
    if (at.has_filename()) created_.insert(created_.begin(), at.string());
  }
  if (!created_.empty()) live_.reset(AddLive(created_.back(), static_cast<int>(created_.size())));
  MakeFolder(folder);
  file_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file_ < 0) {
    throw Error(fmt::format("{}: can't be opened: {}", folder, FormatErrno(errno)));
  }
  if (flock(file_, LOCK_EX | LOCK_NB) == 0) return;
  if (errno != EWOULDBLOCK) {
    close(file_);
    const std::string name = folder + "/.lock";
    file_ = open(name.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file_ < 0) throw Error(fmt::format("{}: can't be written: {}", name, FormatErrno(errno)));
    if (flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  }
  close(file_);
  throw Error(
      fmt::format("{}: another kerf is writing results into this folder; wait until it has finished, or choose "
                  "another folder",
                  folder));
}

void FolderLock::RemoveNote::operator()(LivePath* entry) const {
  RemoveLive(entry);
}

FolderLock::~FolderLock() {
  RemoveFolderIfUnused();
  close(file_);
}

void FolderLock::RemoveFolderIfUnused() {
  for (; !created_.empty(); created_.pop_back()) {
    if (rmdir(created_.back().c_str()) != 0) break;  // fails unless the folder is empty
  }
  created_.clear();
  live_.reset();
}

}  // namespace kerf
