// File format of a recording: a first line that identifies it, followed by blocks that are only ever appended, each
// with a checksum.
//
// A block consists of "KBLK", its kind, its packed and unpacked size in bytes, its number, the kind and digest of the
// block before it, a CRC-32C of all these fields and of the packed bytes, and the packed bytes (Zstandard). Each block
// can be read without the others.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "loop/record/seal.h"

namespace kerf {

enum class BlockKind : std::uint8_t {
  kMeta = 1,   // JSON: what was recorded, where and by which program; the first block
  kFile = 2,   // an input of the scene: its name and its bytes
  kSteps = 3,  // RecordedBlock
  kPiece = 4,  // a piece of bone that may leave; see recording.h
  kEvent = 5,  // JSON: an event, for users and tools
  kEnd = 6,    // JSON: the reason for the end, and the results
  kSeal = 7,   // JSON: SealBlock; the last block. Not in version 1
};
const char* ToString(BlockKind kind);

// First line. Version 1 has no chain and no seal; it can be read but is no longer written.
inline constexpr std::string_view kRecordingMagic1 = "kerf recording 1\n";
inline constexpr std::string_view kRecordingMagic = "kerf recording 2\n";
// Limits against which sizes are checked before memory is allocated.
inline constexpr std::size_t kMaxMetaBytes = std::size_t{16} << 20;
inline constexpr std::size_t kMaxFileBytes = std::size_t{64} << 20;
inline constexpr std::size_t kMaxStepsBytes = std::size_t{4} << 20;
inline constexpr std::size_t kMaxPieceBytes = std::size_t{256} << 20;
inline constexpr std::size_t kMaxEventBytes = 65536;
inline constexpr std::size_t kMaxEvents = 100'000;                       // per recording
inline constexpr std::size_t kMaxBytesOfFiles = std::size_t{256} << 20;  // total of all files
inline constexpr std::uint64_t kMaxRecordingBytes = std::uint64_t{4} << 30;

inline constexpr std::string_view kBlockMagic = "KBLK";
inline constexpr std::size_t kBlockHeaderBytes1 = 4 + 1 + 4 + 4 + 4 + 4;
inline constexpr std::size_t kBlockHeaderBytes = kBlockHeaderBytes1 + 1 + 32;

/// Link in a block to the block before it.
struct BlockLink {
  BlockKind kind = BlockKind::kMeta;
  Digest digest{};  // of all bytes of that block, including its own link
};
/// Returns the link in the first block: the digest of the first line.
BlockLink FirstLink();
/// Returns the link to a block, for the block after it. `header` and `packed` are the bytes of the block as in the
/// file.
BlockLink LinkAfter(BlockKind kind, std::string_view header, std::string_view packed);

/// Header of a block, before its packed bytes.
struct BlockHeader {
  BlockKind kind = BlockKind::kMeta;
  std::uint32_t packed_bytes = 0;
  std::uint32_t bytes = 0;
  std::uint32_t number = 0;
  BlockLink before;  // not in version 1
  std::uint32_t sum = 0;
  bool is_plausible = false;  // magic, kind and size are valid
};
/// Parses a header. `raw`: kBlockHeaderBytes bytes, or kBlockHeaderBytes1 in version 1.
BlockHeader ParseBlockHeader(std::string_view raw);
/// Computes the checksum of a block.
std::uint32_t CalcBlockSum(std::string_view raw_header, std::string_view packed);

/// Returns a block's bytes as in the file. `number`: zero-based index of the block. `before`: null in version 1.
std::string FormatBlock(BlockKind kind, std::string_view bytes, std::uint32_t number, const BlockLink* before,
                        int level = 3);

/// Writes blocks to a new file. A separate thread flushes them to disk at least twice a second.
class BlockFile {
 public:
  /// Throws kerf::Error if the file exists or cannot be created.
  explicit BlockFile(const std::string& path);
  /// Closes the file and keeps it.
  ~BlockFile();
  BlockFile(const BlockFile&) = delete;
  BlockFile& operator=(const BlockFile&) = delete;

  /// Appends a block. Throws kerf::Error with the reason if writing has failed, in this call or since the last one
  /// (disk full, file removed). Blocks written earlier remain intact.
  void Append(BlockKind kind, std::string_view bytes, int level = 3);
  /// Digest of the chain of all appended blocks.
  const Digest& digest() const { return link_.digest; }
  /// Flushes the file to disk and closes it. Throws kerf::Error like Append().
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

/// Returns the maximum unpacked size of a block of this kind, bytes.
std::size_t MaxUnpackedBytes(BlockKind kind);

}  // namespace kerf
