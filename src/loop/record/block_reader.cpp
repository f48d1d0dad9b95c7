#include "loop/record/block_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "base/compress/bytes.h"
#include "base/compress/pack.h"
#include "base/core/errno_text.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kSearchBytes = 65536;    // number of bytes searched at a time
constexpr std::uint64_t kMaxSearchFactor = 8;  // search limit, as a multiple of the file size

}  // namespace

BlockReader::BlockReader(const std::string& path) : path_(path) {
  Open();
  ReadMagic();
  search_bytes_ = kMaxSearchFactor * size_ + kSearchBytes;
  std::uint64_t good = kRecordingMagic.size();
  while (good < size_) {
    std::optional<BlockPlace> place = TryBlock(good);
    if (!place) place = FindBlock(good + 1);
    if (!place) {
      gaps_.push_back({places_.size(), size_ - good, 0, std::nullopt, LooksTorn(good)});
      break;
    }
    Take(*place, good);
    good = place->offset + place->packed_bytes;
  }
  in_.clear();
}

/// Adds the last block examined to places_. `good`: end of the block before it.
void BlockReader::Take(const BlockPlace& place, std::uint64_t good) {
  const std::uint64_t skipped = place.offset - header_bytes() - good;
  const bool follows = place.number == next_number_;
  if (skipped > 0 || !follows) {
    gaps_.push_back({places_.size(), skipped, place.number - next_number_, std::nullopt, false});
    if (version_ > 1 && !follows) gaps_.back().last_kind = header_.before.kind;
  }
  if (version_ > 1 && follows && !broken_link_ && header_.before.digest != link_.digest) broken_link_ = place.number;
  last_link_ = header_.before;
  link_ = next_link_;
  places_.push_back(place);
  next_number_ = place.number + 1;
}

void BlockReader::Open() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path_, error);
  if (!fs::exists(status)) throw Error(fmt::format("{}: there is no such file", path_));
  if (!fs::is_regular_file(status)) throw Error(fmt::format("{}: is not a regular file", path_));
  in_.open(path_, std::ios::binary);
  if (!in_) throw Error(fmt::format("{}: can't be read: {}", path_, FormatErrno(errno)));
  size_ = fs::file_size(path_, error);
  if (error) throw Error(fmt::format("{}: can't be read: {}", path_, error.message()));
  if (size_ > kMaxRecordingBytes) {
    throw Error(
        fmt::format("{}: is larger than {} GiB, the maximum size of a recording", path_, kMaxRecordingBytes >> 30));
  }
}

void BlockReader::ReadMagic() {
  std::string magic(kRecordingMagic.size(), '\0');
  const bool read = ReadAt(0, magic.data(), magic.size());
  if (read && magic == kRecordingMagic) return;
  if (read && magic == kRecordingMagic1) {
    version_ = 1;
    return;
  }
  // A damaged first line is accepted if a valid block follows it.
  first_line_is_bad_ = true;
  for (version_ = 2; read && version_ >= 1; --version_) {
    if (TryBlock(kRecordingMagic.size())) return;
  }
  if (read && magic.starts_with("kerf recording ")) {
    throw Error(fmt::format("{}: was recorded by another version of kerf", path_));
  }
  throw Error(fmt::format("{}: is not a kerf recording", path_));
}

bool BlockReader::ReadAt(std::uint64_t at, char* to, std::size_t count) {
  in_.clear();
  in_.seekg(static_cast<std::streamoff>(at));
  in_.read(to, static_cast<std::streamsize>(count));
  CheckReadable(in_, path_);
  return static_cast<bool>(in_);
}

/// Returns the block that begins at `at` if it is whole and its number is higher than those read before.
std::optional<BlockPlace> BlockReader::TryBlock(std::uint64_t at) {
  std::array<char, kBlockHeaderBytes> raw{};
  const std::string_view raw_header(raw.data(), header_bytes());
  if (at > size_ || size_ - at < raw_header.size() || !ReadAt(at, raw.data(), raw_header.size())) return std::nullopt;
  header_ = ParseBlockHeader(raw_header);
  const BlockPlace place{header_.kind, header_.number, at + raw_header.size(), header_.packed_bytes, header_.bytes};
  if (!header_.is_plausible || place.number < next_number_ || place.packed_bytes > size_ - place.offset) {
    return std::nullopt;
  }
  packed_.resize(place.packed_bytes);
  if (!ReadAt(place.offset, packed_.data(), packed_.size())) return std::nullopt;
  if (CalcBlockSum(raw_header, packed_) != header_.sum) {
    search_bytes_ -= std::min<std::uint64_t>(search_bytes_, packed_.size());
    return std::nullopt;
  }
  if (version_ > 1) next_link_ = LinkAfter(place.kind, raw_header, packed_);
  return place;
}

/// Returns the next whole block at or after `from`. A file full of block headers without valid blocks must not take
/// quadratic time: the search ends when kMaxSearchFactor times the file size has been checksummed without finding a
/// block.
std::optional<BlockPlace> BlockReader::FindBlock(std::uint64_t from) {
  std::string bytes;
  for (std::uint64_t at = from; at + header_bytes() <= size_;) {
    bytes.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kSearchBytes, size_ - at)));
    if (!ReadAt(at, bytes.data(), bytes.size())) return std::nullopt;
    for (std::size_t found = bytes.find(kBlockMagic); found != std::string::npos;
         found = bytes.find(kBlockMagic, found + 1)) {
      if (search_bytes_ == 0) return std::nullopt;
      if (const std::optional<BlockPlace> place = TryBlock(at + found)) return place;
    }
    at += bytes.size() - (kBlockMagic.size() - 1);
  }
  return std::nullopt;
}

/// Returns true if the rest of the file, which has no whole block, looks like an interrupted write.
bool BlockReader::LooksTorn(std::uint64_t at) {
  std::string raw(static_cast<std::size_t>(std::min<std::uint64_t>(header_bytes(), size_ - at)), '\0');
  if (!ReadAt(at, raw.data(), raw.size())) return false;
  if (raw.size() < header_bytes()) return raw.substr(0, kBlockMagic.size()) == kBlockMagic.substr(0, raw.size());
  const BlockHeader header = ParseBlockHeader(raw);
  return header.is_plausible && header.number == next_number_ && header.packed_bytes > size_ - at - header_bytes();
}

std::string BlockReader::Read(const BlockPlace& place) {
  std::string packed(place.packed_bytes, '\0');
  if (!ReadAt(place.offset, packed.data(), packed.size())) {
    throw Error(fmt::format("{}: can't be read to its end", path_));
  }
  try {
    std::string bytes = Unpack(packed, MaxUnpackedBytes(place.kind));
    if (bytes.size() != place.bytes) throw Error("does not have its declared length when unpacked");
    return bytes;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: a block at byte {} {}", path_, place.offset, e.what()));
  }
}

}  // namespace kerf
