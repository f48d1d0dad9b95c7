// The file of a recording: a line that names it, then blocks, each with its own checksum, only ever added to.
//
// A block: "KBLK", its kind, how many bytes it has packed and unpacked, its number, the kind and the digest of the
// block before it, a CRC-32C of all that and of the bytes, the bytes (Zstandard). Each block can be read without the
// others.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "loop/record/seal.h"

namespace kerf {

enum class BlockKind : std::uint8_t {
  kMeta = 1,   // JSON: what was recorded, where and by which program; the first
  kFile = 2,   // an input of the scene: its name and its bytes
  kSteps = 3,  // RecordedBlock
  kPiece = 4,  // a piece of bone that is going to leave
  kEvent = 5,  // JSON: for people, and for tools
  kEnd = 6,    // JSON: how it ended
  kSeal = 7,   // JSON: SealBlock; the last. Not in version 1
};
const char* ToString(BlockKind kind);

// The first line. Version 1 has no chain and no seal; it is read, and no longer written.
inline constexpr std::string_view kRecordingMagic1 = "kerf recording 1\n";
inline constexpr std::string_view kRecordingMagic = "kerf recording 2\n";
// Before memory is asked for, sizes are held against these.
inline constexpr std::size_t kMostMetaBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMostFileBytes = std::size_t{64} << 20;
inline constexpr std::size_t kMostStepsBytes = std::size_t{4} << 20;
inline constexpr std::size_t kMostPieceBytes = std::size_t{256} << 20;
inline constexpr std::size_t kMostEventBytes = 65536;
inline constexpr std::size_t kMostEvents = 100'000;                       // of a recording
inline constexpr std::size_t kMostBytesOfFiles = std::size_t{256} << 20;  // all together
inline constexpr std::uint64_t kMostRecordingBytes = std::uint64_t{4} << 30;

inline constexpr std::string_view kBlockMagic = "KBLK";
inline constexpr std::size_t kBlockHeadBytes1 = 4 + 1 + 4 + 4 + 4 + 4;
inline constexpr std::size_t kBlockHeadBytes = kBlockHeadBytes1 + 1 + 32;

/// What a block holds of the one before it.
struct BlockLink {
  BlockKind kind = BlockKind::kMeta;
  Digest digest{};  // of all its bytes, which hold that of the one before it in turn
};
/// Before the first block, which follows the first line.
BlockLink FirstLink();
/// After `block`, as it stands in the file.
BlockLink LinkAfter(BlockKind kind, std::string_view head, std::string_view packed);

/// What stands before a block's packed bytes.
struct BlockHead {
  BlockKind kind = BlockKind::kMeta;
  std::uint32_t packed_bytes = 0;
  std::uint32_t bytes = 0;
  std::uint32_t number = 0;
  BlockLink before;  // not in version 1
  std::uint32_t sum = 0;
  bool is_plausible = false;  // the magic, the kind and the size are possible ones
};
/// `raw`: kBlockHeadBytes of them, or kBlockHeadBytes1 of version 1.
BlockHead ParseBlockHead(std::string_view raw);
/// The checksum that a block must have.
std::uint32_t CalcBlockSum(std::string_view raw_head, std::string_view packed);

/// A block as it stands in the file. `number`: how many stand before it. `before`: null in version 1.
std::string FormatBlock(BlockKind kind, std::string_view bytes, std::uint32_t number, const BlockLink* before,
                        int level = 3);

/// Writes blocks to a file that was not there. A thread of its own asks the disk for them twice a second and more.
class BlockFile {
 public:
  /// Throws Error when there is such a file already, or it can't be made.
  explicit BlockFile(const std::string& path);
  /// What is written stays.
  ~BlockFile();
  BlockFile(const BlockFile&) = delete;
  BlockFile& operator=(const BlockFile&) = delete;

  /// Throws Error, with a sentence that says why, when it could not be written, now or since the last call: the disk is
  /// full, the file is gone. What was written before stays whole.
  void Append(BlockKind kind, std::string_view bytes, int level = 3);
  /// Of all blocks that were appended.
  const Digest& digest() const { return link_.digest; }
  /// Onto the disk. Throws Error likewise.
  void Close();
  std::uint64_t bytes() const { return bytes_; }
  const std::string& path() const { return path_; }

 private:
  struct Flusher;
  void Write(std::string_view bytes);
  void Check();

  std::string path_;
  int file_ = -1;
  std::uint64_t bytes_ = 0;
  std::uint32_t number_ = 0;
  BlockLink link_ = FirstLink();
  std::unique_ptr<Flusher> flusher_;
};

std::size_t MostBytes(BlockKind kind);

}  // namespace kerf
