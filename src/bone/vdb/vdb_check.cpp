#include "bone/vdb/vdb_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <vector>

#include "bone/vdb/limits.h"
#include "bone/vdb/vdb_checksum.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::int64_t kMagic = 0x56444220;
constexpr std::size_t kValueBytes = 4;  // of both float and int32
constexpr std::size_t kHalfBytes = 2;
constexpr std::uint32_t kZip = 1;
constexpr std::uint32_t kActiveMask = 2;
constexpr std::uint32_t kBlosc = 4;

/// Number of voxels or children along a node's side, as a power of 2, from the leaf up; side of a root's child; memory
/// of a node in addition to its table.
constexpr std::array<int, 3> kLog2Sides{3, 4, 5};
constexpr std::int32_t kRootChildSide_vox = 1 << 12;
constexpr std::uint64_t kNodeBytes = 128;

/// Buffered stream with a known end.
class Source {
 public:
  Source(std::istream& in, const std::string& path) : in_(in), path_(path) {
    in_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(0, in_.tellg()));
    buffer_.resize(kBlock);
  }

  [[noreturn]] void Refuse(std::string_view why) const {
    throw Error(fmt::format("{}: not a valid OpenVDB file ({})", path_, why));
  }
  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return size_ - std::min(size_, at_); }
  void Jump(std::uint64_t to) { at_ = to; }
  void Skip(std::uint64_t bytes) {
    if (bytes > left()) Refuse("it ends early");
    at_ += bytes;
  }
  void Read(void* to, std::size_t bytes) {
    if (bytes > left()) Refuse("it ends early");
    auto* out = static_cast<char*>(to);
    while (bytes > 0) {
      if (at_ < begin_ || at_ >= begin_ + buffered_) Fill();
      const std::size_t from = at_ - begin_;
      const std::size_t n = std::min(bytes, buffered_ - from);
      std::memcpy(out, buffer_.data() + from, n);
      out += n;
      at_ += n;
      bytes -= n;
    }
  }
  template <typename T>
  T Number() {
    T value{};
    Read(&value, sizeof value);
    return value;
  }
  std::string Text() {
    const auto bytes = Number<std::uint32_t>();
    CheckText(bytes);
    std::string text(bytes, '\0');
    Read(text.data(), bytes);
    return text;
  }
  void CheckText(std::uint64_t bytes) const {
    if (bytes > kMaxVdbTextBytes || bytes > left()) {
      Refuse(
          fmt::format("a text of {} bytes, but {} are left and at most {} are read", bytes, left(), kMaxVdbTextBytes));
    }
  }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 16;

  void Fill() {
    begin_ = at_;
    buffered_ = static_cast<std::size_t>(std::min<std::uint64_t>(kBlock, left()));
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(begin_));
    in_.read(buffer_.data(), static_cast<std::streamsize>(buffered_));
    if (static_cast<std::size_t>(in_.gcount()) != buffered_) Refuse("its bytes can't be read");
  }

  std::istream& in_;
  const std::string& path_;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;
  std::vector<char> buffer_;
  std::uint64_t begin_ = 0;   // offset of the buffer in the file
  std::size_t buffered_ = 0;  // bytes in the buffer
};

/// Metadata type with a fixed size, which OpenVDB reads regardless of the size given in the file.
struct SizedType {
  std::string_view name;
  std::uint32_t bytes;
};
constexpr std::array<SizedType, 16> kSizedTypes{{{"bool", 1},
                                                 {"int32", 4},
                                                 {"int64", 8},
                                                 {"float", 4},
                                                 {"double", 8},
                                                 {"vec2i", 8},
                                                 {"vec2s", 8},
                                                 {"vec2d", 16},
                                                 {"vec3i", 12},
                                                 {"vec3s", 12},
                                                 {"vec3d", 24},
                                                 {"vec4i", 16},
                                                 {"vec4s", 16},
                                                 {"vec4d", 32},
                                                 {"mat4s", 64},
                                                 {"mat4d", 128}}};
constexpr std::string_view kDelayedLoad = "__delayedload";

/// Transforms and their sizes in the file.
constexpr std::array<SizedType, 7> kMaps{{{"UniformScaleMap", 120},
                                          {"ScaleMap", 120},
                                          {"UniformScaleTranslateMap", 144},
                                          {"ScaleTranslateMap", 144},
                                          {"TranslationMap", 24},
                                          {"AffineMap", 128},
                                          {"UnitaryMap", 128}}};

template <std::size_t N>
const SizedType* Find(const std::array<SizedType, N>& types, std::string_view name) {
  const auto found = std::find_if(types.begin(), types.end(), [name](const SizedType& t) { return t.name == name; });
  return found == types.end() ? nullptr : &*found;
}

using Mask = std::vector<std::uint64_t>;

std::uint64_t CountOn(const Mask& mask) {
  std::uint64_t count = 0;
  for (const std::uint64_t word : mask) count += static_cast<std::uint64_t>(std::popcount(word));
  return count;
}

class Check {
 public:
  Check(std::istream& in, const std::string& path, const std::set<std::string>& wanted)
      : source_(in, path), wanted_(wanted) {}

  void File() {
    if (source_.Number<std::int64_t>() != kMagic) source_.Refuse("it does not begin with the magic number");
    const auto version = source_.Number<std::uint32_t>();
    if (version < 222 || version > 224) source_.Refuse(fmt::format("version {}; kerf reads 222 to 224", version));
    source_.Skip(2 * sizeof(std::uint32_t));  // library version
    const bool has_offsets = source_.Number<char>() != 0;
    identity_.resize(kVdbIdentityBytes);
    source_.Read(identity_.data(), identity_.size());
    Metadata(true);
    const auto grids = source_.Number<std::int32_t>();
    if (grids < 0 || grids > static_cast<std::int32_t>(kMaxVdbEntries)) {
      source_.Refuse(fmt::format("{} grids; kerf reads up to {}", grids, kMaxVdbEntries));
    }
    for (int n = 0; n < grids; ++n) Descriptor(has_offsets);
  }

  /// Returns the entry of the checksum; empty for files of earlier versions and of other programs.
  const std::optional<VdbChecksumEntry>& checksum() const { return checksum_; }
  const std::string& identity() const { return identity_; }

 private:
  void Descriptor(bool has_offsets) {
    std::string name = source_.Text();
    name.resize(std::min(name.find('\x1e'), name.size()));  // removes the suffix that makes the name unique
    std::string type = source_.Text();
    constexpr std::string_view kHalf = "_HalfFloat";
    half_ = type.ends_with(kHalf);
    if (half_) type.resize(type.size() - kHalf.size());
    const bool instance = !source_.Text().empty();
    source_.Skip(2 * sizeof(std::int64_t));
    const auto end = source_.Number<std::int64_t>();
    if (wanted_.count(name) == 0) {
      if (!has_offsets) source_.Refuse("an unknown grid whose end is not stated");
      // Jumps forward only, so that the loop ends.
      if (end <= static_cast<std::int64_t>(source_.at())) source_.Refuse("a grid that ends before it begins");
      return source_.Jump(static_cast<std::uint64_t>(end));
    }
    is_float_ = type == "Tree_float_5_4_3";
    if (!is_float_ && type != "Tree_int32_5_4_3") {
      source_.Refuse(fmt::format("grid \"{}\" is of neither type float nor type int32", name));
    }
    compression_ = source_.Number<std::uint32_t>();
    if (compression_ > (kZip | kActiveMask | kBlosc)) source_.Refuse("an unknown compression");
    Metadata(false);
    const std::string map = source_.Text();
    const SizedType* known = Find(kMaps, map);
    if (known == nullptr) source_.Refuse("a transform of an unknown type");
    source_.Skip(known->bytes);
    if (!instance) Tree();
  }

  void Metadata(bool of_file) {
    const auto count = source_.Number<std::uint32_t>();
    if (count > kMaxVdbEntries)
      source_.Refuse(fmt::format("{} entries of metadata; kerf reads up to {}", count, kMaxVdbEntries));
    for (std::uint32_t n = 0; n < count; ++n) {
      const std::string name = source_.Text();
      const std::string type = source_.Text();
      const auto bytes = source_.Number<std::uint32_t>();
      source_.CheckText(bytes);
      const SizedType* sized = Find(kSizedTypes, type);
      if (sized != nullptr && sized->bytes != bytes) source_.Refuse(fmt::format("a {} of {} bytes", type, bytes));
      if (type == "bool" && bytes == 1) {
        if (source_.Number<unsigned char>() > 1) source_.Refuse("a bool that is neither true nor false");
      } else if (type == kDelayedLoad) {
        DelayedLoad(bytes);
      } else if (of_file && type == "string") {
        const std::uint64_t place = source_.at();
        std::string value(bytes, '\0');
        source_.Read(value.data(), value.size());
        if (IsVdbChecksum(name, value)) checksum_ = {place, std::move(value)};
      } else if (sized != nullptr || type == "string") {
        source_.Skip(bytes);
      } else {
        source_.Refuse("metadata of an unknown type");
      }
    }
  }

  /// Checks the positions of the leaves, stored for readers that load leaves later: one byte per leaf, then optionally
  /// eight, each list packed or not.
  void DelayedLoad(std::uint32_t bytes) {
    const std::uint64_t end = source_.at() + bytes;
    if (bytes == 0) return;
    const auto count = source_.Number<std::uint32_t>();
    AddMemory(count * std::uint64_t{9});
    constexpr std::uint64_t kPadded = 128;  // shorter lists are padded to this length before they are packed
    for (const std::uint64_t size : {std::uint64_t{1}, std::uint64_t{8}}) {
      const auto packed = source_.Number<std::uint32_t>();
      if (size == 8 && packed == 0xffffffff) break;
      const std::uint64_t unpacked = count * size;
      if (packed == 0) {
        source_.Skip(unpacked);
      } else {
        Blosc(packed, std::max(unpacked, kPadded));
      }
    }
    if (source_.at() != end) source_.Refuse("a list of leaves of the wrong length");
  }

  /// Checks a Blosc buffer, because Blosc trusts the lengths in its header.
  void Blosc(std::uint64_t packed, std::uint64_t unpacked) {
    constexpr std::uint64_t kHeader = 16;
    if (packed < kHeader || packed > source_.left()) source_.Refuse("packed values of an impossible length");
    std::array<char, kHeader> header{};
    source_.Read(header.data(), header.size());
    std::uint32_t nbytes = 0;
    std::uint32_t cbytes = 0;
    std::memcpy(&nbytes, header.data() + 4, sizeof nbytes);
    std::memcpy(&cbytes, header.data() + 12, sizeof cbytes);
    if (cbytes != packed || nbytes != unpacked) source_.Refuse("packed values whose lengths contradict each other");
    source_.Skip(packed - kHeader);
  }

  void AddMemory(std::uint64_t bytes) {
    memory_ += bytes;
    if (memory_ > kMaxVdbMemoryBytes) {
      source_.Refuse(fmt::format("its grids would need more than the {} GiB of memory that kerf allows for a bone",
                                 kMaxVdbMemoryBytes >> 30));
    }
  }

  Mask ReadMask(int log2_side) {
    Mask mask((std::size_t{1} << (3 * log2_side)) / 64);
    source_.Read(mask.data(), mask.size() * sizeof(std::uint64_t));
    return mask;
  }

  /// Checks the values of a node: all of them, or only the active ones, with up to two inactive values and a mask that
  /// selects between these.
  void Values(const Mask& mask) {
    const auto kind = source_.Number<std::int8_t>();
    if (kind < 0 || kind > 6) source_.Refuse("values of an unknown kind");
    const std::uint64_t others = kind == 5 ? 2 : kind == 2 || kind == 4 ? 1 : 0;
    source_.Skip(others * kValueBytes);
    if (kind >= 3 && kind <= 5) source_.Skip(mask.size() * sizeof(std::uint64_t));
    const bool active_only = (compression_ & kActiveMask) != 0 && kind != 6;
    const std::uint64_t count = active_only ? CountOn(mask) : 64 * mask.size();
    const bool half = half_ && is_float_;
    if (half && count == 0) return;
    const std::uint64_t bytes = count * (half ? kHalfBytes : kValueBytes);
    if ((compression_ & (kBlosc | kZip)) == 0) return source_.Skip(bytes);
    const auto packed = source_.Number<std::int64_t>();
    if (packed <= 0) {
      if (0 - static_cast<std::uint64_t>(packed) != bytes) source_.Refuse("values of the wrong length");
      source_.Skip(bytes);
    } else if ((compression_ & kBlosc) != 0) {
      Blosc(static_cast<std::uint64_t>(packed), bytes);
    } else {
      // Data that zlib cannot compress grow slightly.
      if (static_cast<std::uint64_t>(packed) > 2 * bytes + 1024)
        source_.Refuse("packed values of an impossible length");
      source_.Skip(static_cast<std::uint64_t>(packed));
    }
  }

  /// Walks an inner node and everything below it; counts the leaves.
  void Node(int level) {
    const int log2_side = kLog2Sides[static_cast<std::size_t>(level)];
    const Mask children = ReadMask(log2_side);
    const Mask values = ReadMask(log2_side);
    AddMemory(kNodeBytes + children.size() * (2 * sizeof(std::uint64_t) + 64 * sizeof(void*)));
    for (std::size_t i = 0; i < children.size(); ++i) {
      if ((children[i] & values[i]) != 0) source_.Refuse("a node with a value where it has a child");
    }
    Values(values);
    const std::uint64_t count = CountOn(children);
    if (level == 1) {
      constexpr std::uint64_t kMaskBytes = 64;
      leaves_ += count;
      AddMemory(count * (kNodeBytes + kMaskBytes + 512 * kValueBytes));
      source_.Skip(count * kMaskBytes);
    } else {
      for (std::uint64_t n = 0; n < count; ++n) Node(level - 1);
    }
  }

  void Origin(std::set<std::array<std::int32_t, 3>>& origins) {
    std::array<std::int32_t, 3> origin{};
    source_.Read(origin.data(), sizeof origin);
    for (const std::int32_t x : origin) {
      if (x % kRootChildSide_vox != 0 || x < -kMaxVdbCoordinate_vox || x > kMaxVdbCoordinate_vox) {
        source_.Refuse(fmt::format("a node at voxel {}, outside the allowed positions", x));
      }
    }
    if (!origins.insert(origin).second) source_.Refuse("two nodes at the same position");
  }

  void Tree() {
    source_.Skip(sizeof(std::int32_t) + kValueBytes);  // buffer count, always one; background
    const auto tiles = source_.Number<std::uint32_t>();
    const auto children = source_.Number<std::uint32_t>();
    std::set<std::array<std::int32_t, 3>> origins;
    leaves_ = 0;
    for (std::uint32_t n = 0; n < tiles; ++n) {
      Origin(origins);
      AddMemory(kNodeBytes);
      source_.Skip(kValueBytes);
      if (source_.Number<unsigned char>() > 1) source_.Refuse("a tile that is neither active nor inactive");
    }
    for (std::uint32_t n = 0; n < children; ++n) {
      Origin(origins);
      Node(2);
    }
    for (std::uint64_t n = 0; n < leaves_; ++n) Values(ReadMask(kLog2Sides[0]));
  }

  Source source_;
  const std::set<std::string>& wanted_;
  std::string identity_;
  std::optional<VdbChecksumEntry> checksum_;
  std::uint64_t memory_ = 0;
  // State of the grid that is being checked.
  std::uint32_t compression_ = 0;
  bool half_ = false;
  bool is_float_ = false;
  std::uint64_t leaves_ = 0;
};

}  // namespace

void CheckVdb(std::istream& in, const std::string& path, const std::set<std::string>& wanted) {
  Check check(in, path, wanted);
  check.File();
  if (check.checksum()) CheckVdbChecksum(in, path, *check.checksum(), check.identity());
  in.clear();
  in.seekg(0);
}

}  // namespace kerf
