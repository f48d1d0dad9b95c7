// Reads the blocks of a recording file and skips damaged ones.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loop/record/blocks.h"

namespace kerf {

/// Position of an undamaged block in the file.
struct BlockPlace {
  BlockKind kind = BlockKind::kMeta;
  std::uint32_t number = 0;
  std::uint64_t offset = 0;  // offset of its packed bytes
  std::uint32_t packed_bytes = 0;
  std::uint32_t bytes = 0;
};

/// Bytes of a file that could not be read as blocks.
struct BlockGap {
  std::size_t before_place = 0;  // index in places() of the block after the gap; places().size() if there is none
  std::uint64_t bytes = 0;
  std::uint32_t lost_blocks = 0;       // derived from the number of the following block; 0 if none follows
  std::optional<BlockKind> last_kind;  // kind of the last lost block, if the following block states it
  bool torn = false;                   // at the end of the file: the beginning of a block whose writing was interrupted
};

/// Reads a recording file block by block. Needs memory for one block, and 24 bytes for each block of the file.
class BlockReader {
 public:
  /// Scans the whole file. Throws kerf::Error if it is not a recording or cannot be read. A truncated or damaged file
  /// is not an error: after a damaged block, reading continues at the next block that has a correct checksum and a
  /// number higher than all before.
  explicit BlockReader(const std::string& path);

  const std::vector<BlockPlace>& places() const { return places_; }
  const std::vector<BlockGap>& gaps() const { return gaps_; }
  /// Version of the format: 2, or 1 for a file without a chain.
  int version() const { return version_; }
  /// True if the file's first line is damaged.
  bool first_line_is_bad() const { return first_line_is_bad_; }
  /// Number of the first block whose link does not match the block before it. None in version 1. A wrong link after a
  /// gap cannot be detected.
  const std::optional<std::uint32_t>& broken_link() const { return broken_link_; }
  /// The link in the last block to the block before it.
  const BlockLink& last_link() const { return last_link_; }
  /// Reads and unpacks a block. Throws kerf::Error if that fails.
  std::string Read(const BlockPlace& place);
  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

 private:
  void Open();
  void ReadMagic();
  void Take(const BlockPlace& place, std::uint64_t good);
  std::size_t header_bytes() const { return version_ == 1 ? kBlockHeaderBytes1 : kBlockHeaderBytes; }
  std::optional<BlockPlace> TryBlock(std::uint64_t at);
  std::optional<BlockPlace> FindBlock(std::uint64_t from);
  bool LooksTorn(std::uint64_t at);
  bool ReadAt(std::uint64_t at, char* to, std::size_t count);

  std::string path_;
  std::ifstream in_;
  std::uint64_t size_ = 0;
  int version_ = 2;
  bool first_line_is_bad_ = false;
  std::uint32_t next_number_ = 0;
  BlockHeader header_;            // header of the last block examined
  BlockLink link_ = FirstLink();  // link that the next block must contain
  BlockLink next_link_;           // link that the block after the last one examined must contain
  BlockLink last_link_;
  std::optional<std::uint32_t> broken_link_;
  std::uint64_t search_bytes_ = 0;  // number of bytes that may still be checksummed without finding a block
  std::string packed_;
  std::vector<BlockPlace> places_;
  std::vector<BlockGap> gaps_;
};

}  // namespace kerf
