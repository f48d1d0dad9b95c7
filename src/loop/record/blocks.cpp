#include "loop/record/blocks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <thread>

#include "base/compress/bytes.h"
#include "base/compress/pack.h"
#include "base/core/errno_text.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::chrono::milliseconds kFlushInterval(250);

/// Flushes the folder to disk, so that the file's name is on disk as soon as its blocks are. Some file systems neither
/// support nor need this.
void SyncFolder(const std::string& path) {
  const std::string parent = std::filesystem::path(path).parent_path().string();
  const int folder = open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return;
  static_cast<void>(fsync(folder) == 0);
  close(folder);
}

}  // namespace

BlockLink FirstLink() {
  return {BlockKind::kMeta, CalcDigest(kRecordingMagic)};
}

BlockLink LinkAfter(BlockKind kind, std::string_view header, std::string_view packed) {
  return {kind, CalcDigest(header, packed)};
}

const char* ToString(BlockKind kind) {
  switch (kind) {
    case BlockKind::kMeta:
      return "header";
    case BlockKind::kFile:
      return "input";
    case BlockKind::kSteps:
      return "steps";
    case BlockKind::kPiece:
      return "piece";
    case BlockKind::kEvent:
      return "event";
    case BlockKind::kEnd:
      return "end";
    case BlockKind::kSeal:
      break;
  }
  return "seal";
}

std::string FormatBlock(BlockKind kind, std::string_view bytes, std::uint32_t number, const BlockLink* before,
                        int level) {
  const std::string packed = Pack(bytes, level);
  ByteWriter header;
  header.Put(static_cast<std::uint8_t>(kind));
  header.Put(static_cast<std::uint32_t>(packed.size()));
  header.Put(static_cast<std::uint32_t>(bytes.size()));
  header.Put(number);
  if (before != nullptr) {
    header.Put(static_cast<std::uint8_t>(before->kind));
    for (const unsigned char byte : before->digest) header.Put(byte);
  }
  ByteWriter sum;
  sum.Put(CalcCrc32c(packed, CalcCrc32c(header.bytes())));
  std::string whole(kBlockMagic);
  whole += header.bytes();
  whole += sum.bytes();
  whole += packed;
  return whole;
}

BlockHeader ParseBlockHeader(std::string_view raw) {
  ByteReader in(raw);
  const bool magic = in.GetBytes(kBlockMagic.size()) == kBlockMagic;
  const auto kind = in.Get<std::uint8_t>();
  BlockHeader header;
  header.kind = static_cast<BlockKind>(kind);
  header.packed_bytes = in.Get<std::uint32_t>();
  header.bytes = in.Get<std::uint32_t>();
  header.number = in.Get<std::uint32_t>();
  if (raw.size() == kBlockHeaderBytes) {
    header.before.kind = static_cast<BlockKind>(in.Get<std::uint8_t>());
    for (unsigned char& byte : header.before.digest) byte = in.Get<unsigned char>();
  }
  header.sum = in.Get<std::uint32_t>();
  const int most = raw.size() == kBlockHeaderBytes ? 7 : 6;
  header.is_plausible = magic && kind >= 1 && kind <= most && header.bytes <= MaxUnpackedBytes(header.kind);
  return header;
}

std::uint32_t CalcBlockSum(std::string_view raw_header, std::string_view packed) {
  const std::size_t sum_bytes = sizeof(std::uint32_t);
  const std::string_view summed =
      raw_header.substr(kBlockMagic.size(), raw_header.size() - kBlockMagic.size() - sum_bytes);
  return CalcCrc32c(packed, CalcCrc32c(summed));
}

std::size_t MaxUnpackedBytes(BlockKind kind) {
  switch (kind) {
    case BlockKind::kFile:
      return kMaxFileBytes;
    case BlockKind::kSteps:
      return kMaxStepsBytes;
    case BlockKind::kPiece:
      return kMaxPieceBytes;
    case BlockKind::kEvent:
    case BlockKind::kEnd:
    case BlockKind::kSeal:
      return kMaxEventBytes;
    case BlockKind::kMeta:
      break;
  }
  return kMaxMetaBytes;
}

/// Flushes written blocks to disk in a separate thread, so that the thread that writes them does not wait.
struct BlockFile::Flusher {
  explicit Flusher(int file) : thread([this, file] { Run(file); }) {}
  ~Flusher() {
    {
      const std::lock_guard lock(mutex);
      stop = true;
    }
    wake.notify_one();
    thread.join();
  }
  Flusher(const Flusher&) = delete;
  Flusher& operator=(const Flusher&) = delete;

  void Run(int file) {
    std::unique_lock lock(mutex);
    while (!stop) {
      wake.wait_for(lock, kFlushInterval);
      if (!written.exchange(false)) continue;
      lock.unlock();
      if (fdatasync(file) != 0) failure = errno;
      lock.lock();
    }
  }

  std::atomic<bool> written{false};
  std::atomic<int> failure{0};
  std::mutex mutex;
  std::condition_variable wake;
  bool stop = false;
  std::thread thread;  // last, because it uses the other members
};

BlockFile::BlockFile(const std::string& path) : path_(path) {
  CheckWritable(path);
  file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) {
    if (errno == EEXIST) throw Error(fmt::format("{}: already exists; a recording never replaces a file", path));
    throw Error(fmt::format("{}: can't be written: {}", path, FormatErrno(errno)));
  }
  flusher_ = std::make_unique<Flusher>(file_);
  try {
    Write(kRecordingMagic);
    SyncFolder(path);
  } catch (const Error&) {
    flusher_.reset();
    close(file_);
    unlink(path.c_str());
    throw;
  }
}

BlockFile::~BlockFile() {
  flusher_.reset();
  if (file_ >= 0) close(file_);
}

void BlockFile::Write(std::string_view bytes) {
  const std::uint64_t before = bytes_;
  while (!bytes.empty()) {
    const ssize_t written = write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int code = written < 0 ? errno : ENOSPC;
      // Truncate the file to whole blocks. If that fails too, a reader skips the rest.
      if (ftruncate(file_, static_cast<off_t>(before)) == 0) bytes_ = before;
      throw Error(fmt::format("{}: can't be written any further: {}", path_, FormatErrno(code)));
    }
    bytes_ += static_cast<std::uint64_t>(written);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  flusher_->written = true;
}

void BlockFile::Check() {
  if (file_ < 0) throw Error(fmt::format("{}: the recording has been closed", path_));
  if (const int code = flusher_->failure.load(); code != 0) {
    throw Error(fmt::format("{}: can't be written any further: {}", path_, FormatErrno(code)));
  }
  struct stat of_file {};
  struct stat of_name {};
  if (fstat(file_, &of_file) == 0 && (of_file.st_nlink == 0 || stat(path_.c_str(), &of_name) != 0 ||
                                      of_name.st_ino != of_file.st_ino || of_name.st_dev != of_file.st_dev)) {
    throw Error(fmt::format("{}: the recording file was removed or replaced while it was being written", path_));
  }
}

void BlockFile::Append(BlockKind kind, std::string_view bytes, int level) {
  if (bytes.size() > MaxUnpackedBytes(kind)) {
    throw Error(fmt::format("{}: can't be written any further: a block has {} bytes; the maximum is {}", path_,
                            bytes.size(), MaxUnpackedBytes(kind)));
  }
  Check();
  const std::string block = FormatBlock(kind, bytes, number_, &link_, level);
  if (bytes_ + block.size() > kMaxRecordingBytes) {
    throw Error(fmt::format("{}: can't be written any further: the maximum size of a recording is {} GiB", path_,
                            kMaxRecordingBytes >> 30));
  }
  // The block is written in one call, so that killing the program damages at most the last block.
  Write(block);
  ++number_;
  link_ = LinkAfter(kind, block, {});
}

void BlockFile::Close() {
  Check();
  flusher_.reset();
  const int failed = fdatasync(file_) != 0 ? errno : 0;
  const int closed = close(file_) != 0 ? errno : 0;
  file_ = -1;
  if (failed != 0 || closed != 0) {
    throw Error(fmt::format("{}: can't be written to its end: {}", path_, FormatErrno(failed != 0 ? failed : closed)));
  }
}

}  // namespace kerf
