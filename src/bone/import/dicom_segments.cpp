#include "bone/import/dicom_segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/files/child.h"
#include "bone/import/dicom_header.h"
#include "bone/import/limits.h"
#include "bone/import/packed_segments.h"
#include "bone/import/unpack.h"
#include "kerf/error.h"

namespace kerf {
namespace {

// Memory of the child: GDCM allocates what a length states, also if the file is shorter.
constexpr std::uint64_t kMaxMemory = std::uint64_t{5} << 30;
constexpr std::uint64_t kLeastMemory = std::uint64_t{512} << 20;
constexpr std::uint64_t kMemoryPerByte = 64;  // of the file: elements of a few bytes take a hundred
constexpr double kSilent_s = 120;
constexpr std::uint64_t kMaxBytes = std::uint64_t{2} << 30;

constexpr std::size_t kMaxMeta = 1 << 16;   // bytes of a file in which its transfer syntax is sought
constexpr std::size_t kMetaLengthAt = 140;  // after the preamble, "DICM" and the first element's tag, type and length
constexpr std::size_t kMetaAt = 144;

// The bytes that GDCM reads, if they are not those of the file, and how the pixels are stored.
struct DicomBytes {
  std::optional<std::string> text;
  SegmentPacking packing = SegmentPacking::kNative;
};

// Finds the transfer syntax. If the whole data set or each frame is deflated, returns the file with a syntax that GDCM
// reads safely.
DicomBytes FindPacking(const std::string& path, std::uint64_t most_bytes) {
  constexpr std::string_view kBegin("DICM\2\0\0\0", 8), kSyntax("\2\0\x10\0UI", 6);
  std::ifstream in(path, std::ios::binary);
  std::string head(kMaxMeta, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  const std::size_t at = head.find(kSyntax, std::min(kMetaAt, head.size()));
  if (head.size() < kMetaAt || head.compare(128, kBegin.size(), kBegin) != 0 || at == std::string::npos) return {};
  const std::size_t uid_at = std::min(at + kSyntax.size() + 2, head.size());
  const std::string uid = head.substr(uid_at, head.find('\0', uid_at) - uid_at);
  const auto is = [&uid](std::string_view syntax) { return uid.compare(0, syntax.size(), syntax) == 0; };
  const bool deflated_frames = is("1.2.840.10008.1.2.8.1");
  if (!deflated_frames && !is("1.2.840.10008.1.2.1.99")) {
    return {std::nullopt, is("1.2.840.10008.1.2.4") || is("1.2.840.10008.1.2.5") ? SegmentPacking::kCompressed
                                                                                 : SegmentPacking::kNative};
  }
  std::uint64_t meta_end = kMetaAt;
  for (int i = 0; i < 4; ++i) {
    meta_end += std::uint64_t{static_cast<unsigned char>(head[kMetaLengthAt + static_cast<std::size_t>(i)])} << (8 * i);
  }
  if (meta_end > head.size() || uid_at > meta_end) return {};  // the check of the header refuses it
  std::string text = head.substr(0, meta_end);
  in.clear();
  in.seekg(static_cast<std::streamoff>(meta_end));
  if (deflated_frames) {
    std::ostringstream rest;
    rest << in.rdbuf();
    text += rest.str();
    text.replace(uid_at, 21, std::string("1.2.840.10008.1.2.5\0\0", 21));
    return {std::move(text), SegmentPacking::kDeflatedFrames};
  }
  text += UnpackDeflated(in, most_bytes, path);
  text.replace(uid_at, 22, std::string("1.2.840.10008.1.2.1\0\0\0", 22));
  return {std::move(text), SegmentPacking::kNative};
}

}  // namespace

bool IsDicomFile(const std::string& path) {
  std::ifstream in = OpenImageFile(path);
  std::array<char, 132> head{};
  in.read(head.data(), head.size());
  return BeginsLikeDicom({head.data(), static_cast<std::size_t>(in.gcount())});
}

bool IsDicomSegmentation(const std::string& path) {
  if (!IsDicomFile(path)) return false;
  DicomOutline outline;
  try {
    CheckDicomHeader(path, &outline);
  } catch (const Error&) {  // its reader reports the reason
  }
  return outline.class_uid == kSegmentationStorage || outline.class_uid == kLabelMapStorage;
}

DicomSegments ReadDicomSegments(const std::string& path, double threshold) {
  std::error_code failed;
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, failed);
  if (failed) throw Error(fmt::format("{}: the file can't be opened", path));
  if (file_bytes > kMaxBytes) throw Error(fmt::format("{}: is larger than 2 GiB", path));
  const std::uint64_t unpacked_bytes =
      std::min(kMaxBytes, static_cast<std::uint64_t>(kMaxUnpackRatio) * std::uint64_t{file_bytes});
  DicomBytes file = FindPacking(path, unpacked_bytes);
  if (file.text) {
    std::istringstream in(*file.text);
    CheckDicomHeader(in, path);
  } else {
    CheckDicomHeader(path);
  }
  const bool packed = file.packing != SegmentPacking::kNative;
  const std::uint64_t bytes = file.text ? file.text->size() : std::uint64_t{file_bytes};
  const SharedMemory memory(static_cast<std::size_t>(packed ? unpacked_bytes : bytes));
  const std::span<char> pixels(memory.data(), memory.size());
  const auto pack = [&](ChildReport&) {
    std::unique_ptr<std::istream> in;
    if (file.text) {
      in = std::make_unique<std::istringstream>(std::move(*file.text));
    } else {
      in = std::make_unique<std::ifstream>(path, std::ios::binary);
    }
    return PackSegments(*in, file.packing, pixels, path);
  };
  // GDCM holds compressed frames and, several times, what they unpack to.
  const std::uint64_t per_byte = packed ? static_cast<std::uint64_t>(kMaxUnpackRatio) : kMemoryPerByte;
  const ChildLimits limits{std::min(kMaxMemory, kLeastMemory + per_byte * bytes), kSilent_s};
  return UnpackSegments(RunInChild(path, limits, pack, {}), pixels, threshold, path);
}

}  // namespace kerf
