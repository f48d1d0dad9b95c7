#include "bone/import/dicom_segments.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/files/child.h"
#include "bone/import/dicom_header.h"
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
constexpr const char* kLabelMapStorage = "1.2.840.10008.5.1.4.1.1.66.7";
constexpr std::uint64_t kMaxBytes = std::uint64_t{2} << 30;

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

DicomSegments ReadDicomSegments(const std::string& path) {
  CheckDicomHeader(path);
  std::error_code failed;
  const std::uintmax_t file_bytes = std::filesystem::file_size(path, failed);
  if (failed || file_bytes > kMaxBytes) throw Error(fmt::format("{}: is larger than 2 GiB or can't be read", path));
  const SharedMemory bytes(static_cast<std::size_t>(file_bytes));
  const std::span<char> pixels(bytes.data(), bytes.size());
  const auto pack = [&](ChildReport&) { return PackSegments(path, pixels); };
  const ChildLimits limits{std::min(kMaxMemory, kLeastMemory + kMemoryPerByte * file_bytes), kSilent_s};
  return UnpackSegments(RunInChild(path, limits, pack, {}), pixels, path);
}

}  // namespace kerf
