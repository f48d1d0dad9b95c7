// Reads the blocks of a recording's file, past those that are damaged.
#pragma once

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loop/record/blocks.h"

namespace kerf {

/// A whole block of a file.
struct BlockPlace {
  BlockKind kind = BlockKind::kMeta;
  std::uint32_t number = 0;
  std::uint64_t offset = 0;  // of its packed bytes
  std::uint32_t packed_bytes = 0;
  std::uint32_t bytes = 0;
};

/// Bytes of a file that could not be read as blocks.
struct BlockGap {
  std::size_t before_place = 0;  // the index of the place that follows; as many as there are: none follows
  std::uint64_t bytes = 0;
  std::uint32_t lost_blocks = 0;       // by the number of the block that follows; 0 where none does
  std::optional<BlockKind> last_kind;  // of the last one of them, where the block that follows tells
  bool torn = false;  // at the end of the file: the beginning of a block that was not written to its end
};

/// Reads such a file. Memory: a block, and 24 bytes for each block of the file.
class BlockReader {
 public:
  /// Looks through all of it. Throws Error when it is no recording or can't be read. What is cut short or damaged
  /// somewhere is no error: after a damaged block it continues at the next block whose checksum is right and whose
  /// number is higher than all before.
  explicit BlockReader(const std::string& path);

  const std::vector<BlockPlace>& places() const { return places_; }
  const std::vector<BlockGap>& gaps() const { return gaps_; }
  /// 2, or 1 for a file without a chain.
  int version() const { return version_; }
  /// The file's first line is not as it was written.
  bool first_line_is_bad() const { return first_line_is_bad_; }
  /// The first block whose digest of the one before it is not that block's; none in version 1. Across a gap it can't
  /// be known.
  const std::optional<std::uint32_t>& broken_link() const { return broken_link_; }
  /// What the last block holds of the one before it.
  const BlockLink& last_link() const { return last_link_; }
  /// Throws Error.
  std::string Read(const BlockPlace& place);
  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

 private:
  void Open();
  void ReadMagic();
  void Take(const BlockPlace& place, std::uint64_t good);
  std::size_t head_bytes() const { return version_ == 1 ? kBlockHeadBytes1 : kBlockHeadBytes; }
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
  BlockHead head_;                // of the block that was looked at last
  BlockLink link_ = FirstLink();  // that the next block must hold
  BlockLink next_link_;           // and after the block that was looked at last
  BlockLink last_link_;
  std::optional<std::uint32_t> broken_link_;
  std::uint64_t search_bytes_ = 0;  // that may still be summed in vain
  std::string packed_;
  std::vector<BlockPlace> places_;
  std::vector<BlockGap> gaps_;
};

}  // namespace kerf
