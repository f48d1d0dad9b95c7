#include "bone/import/dicom_pixels.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gdcmImageReader.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>

#include "bone/import/dicom_stack.h"
#include "bone/import/itk_read.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr const char* kBigEndianPixels = "1.2.840.113619.5.2";  // of GE; the header is little-endian
constexpr std::int16_t kPaddingHu = -1024;

std::uint64_t CalcPixelBytes(const DicomSlice& slice) {
  return static_cast<std::uint64_t>(slice.size[0]) * slice.size[1] * ((slice.bits + 7) / 8);
}

[[noreturn]] void RefuseCutOff(const DicomSlice& slice) {
  throw Error(fmt::format("{}: the {} cut off; its header states {}{} x {} pixels of {} bits, but not all are present",
                          slice.path, slice.frames == 1 ? "slice is" : "frames are",
                          slice.frames == 1 ? "" : fmt::format("{} times ", slice.frames), slice.size[0], slice.size[1],
                          slice.bits));
}

// GDCM gives no specific reason: it has one message for all of these faults.
[[noreturn]] void RefusePixels(const DicomSlice& slice) {
  throw Error(fmt::format("{}: {}", slice.path,
                          slice.compressed
                              ? fmt::format("the transfer syntax {} can't be unpacked, or the slice's pixels are "
                                            "damaged; convert the series to uncompressed DICOM",
                                            slice.transfer_syntax)
                              : "the slice's pixels are damaged, or the header describes them wrongly"));
}

std::uint32_t ReadWord(const char* bytes, int count, bool big_endian) {
  std::uint32_t word = 0;
  for (int n = 0; n < count; ++n) {
    const int shift = 8 * (big_endian ? count - 1 - n : n);
    word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[n])) << shift;
  }
  return word;
}

// Returns the number that the lowest `bits` bits of a word are.
std::int64_t ReadBits(std::uint32_t word, int bits, bool is_signed) {
  const std::int64_t beyond = std::int64_t{1} << bits;
  const std::int64_t value = word & static_cast<std::uint64_t>(beyond - 1);
  return is_signed && 2 * value >= beyond ? value - beyond : value;
}

}  // namespace

void CheckFileSize(const DicomSlice& slice) {
  std::error_code failed;
  const std::uint64_t bytes = std::filesystem::file_size(slice.path, failed);
  if (failed) throw Error(fmt::format("{}: can't be read: {}", slice.path, failed.message()));
  const std::uint64_t pixels = CalcPixelBytes(slice) * static_cast<std::uint64_t>(slice.frames);
  const std::uint64_t most = std::max(kMaxSliceBytes, 2 * pixels);
  if (bytes > most) {
    throw Error(fmt::format("{}: a {} of {} MiB, more than the {} MiB that kerf reads", slice.path,
                            slice.frames == 1 ? "slice" : "file", bytes >> 20, most >> 20));
  }
  const double reach = (slice.compressed ? kMaxUnpackRatio : 1) * static_cast<double>(bytes);
  if (static_cast<double>(pixels) > reach) RefuseCutOff(slice);
}

FilePixels::FilePixels(const DicomSlice& any) {
  const bool as_stored = !any.compressed && (any.bits == 8 || any.bits == 16 || any.bits == 32);
  if (as_stored) {
    FindPixels(any);
    bytes_per_value_ = any.bits / 8;
  }
  // Bytes in words of the other order are left to GDCM.
  if (!as_stored || (any.bits == 8 && big_endian_)) Unpack(any);
}

FilePixels::~FilePixels() {
  if (!mapped_.empty()) munmap(const_cast<char*>(mapped_.data()), mapped_.size());
}

// Searches the bytes for the tag and the length of the pixel data element.
void FilePixels::FindPixels(const DicomSlice& any) {
  std::error_code failed;
  const std::uint64_t size = std::filesystem::file_size(any.path, failed);
  const int file = open(any.path.c_str(), O_RDONLY | O_CLOEXEC);
  void* const start =
      failed || file < 0 || size == 0 ? MAP_FAILED : mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
  if (file >= 0) close(file);
  if (start == MAP_FAILED) throw Error(fmt::format("{}: the file can't be opened", any.path));
  mapped_ = {static_cast<const char*>(start), size};
  bytes_ = CalcPixelBytes(any);
  const std::uint64_t needed = bytes_ * static_cast<std::uint64_t>(any.frames);
  for (const bool big : {false, true}) {
    const std::string_view tag =
        big ? std::string_view("\x7f\xe0\x00\x10", 4) : std::string_view("\xe0\x7f\x10\x00", 4);
    for (std::size_t at = mapped_.find(tag, any.pixels_at); at != std::string_view::npos;
         at = mapped_.find(tag, at + 1)) {
      // Explicit VR: VR, two bytes, length. Implicit VR: length.
      for (const std::size_t length_at : {at + 8, at + 4}) {
        if (length_at + 4 > size) continue;
        const std::uint64_t length = ReadWord(mapped_.data() + length_at, 4, big);
        if (length < needed || length > 2 * needed + 1) continue;
        if (size < length_at + 4 + needed) RefuseCutOff(any);
        pixels_ = mapped_.substr(length_at + 4, needed);
        if (length > needed + 1) bytes_behind_ = length - needed;
        big_endian_ = big || any.transfer_syntax == kBigEndianPixels;
        return;
      }
    }
  }
  RefuseCutOff(any);
}

void FilePixels::Unpack(const DicomSlice& any) {
  const QuietItk quiet;
  gdcm::ImageReader reader;
  reader.SetFileName(any.path.c_str());
  bool read = false;
  try {
    read = reader.Read();
  } catch (const std::exception&) {
    read = false;
  }
  if (!read) RefusePixels(any);
  // GDCM may have interpreted the header differently, and it allocates memory according to its own interpretation.
  const gdcm::Image& image = reader.GetImage();
  const std::uint64_t values = static_cast<std::uint64_t>(any.size[0]) * any.size[1] * any.frames;
  const std::uint64_t bytes = image.GetBufferLength();
  if (static_cast<double>(bytes) > kMaxVoxelBytes * static_cast<double>(values) || bytes < values ||
      image.GetPixelFormat().GetSamplesPerPixel() != 1) {
    throw Error(fmt::format("{}: the header states {} x {} pixels, but the image has a different size", any.path,
                            any.size[0], any.size[1]));
  }
  unpacked_.resize(bytes);
  try {
    read = image.GetBuffer(unpacked_.data());
  } catch (const std::exception&) {
    read = false;
  }
  if (!read) RefusePixels(any);
  bytes_per_value_ = static_cast<int>(bytes / values);
  bytes_ = bytes / static_cast<std::uint64_t>(any.frames);
  if (bytes % values != 0 || (bytes_per_value_ != 1 && bytes_per_value_ != 2 && bytes_per_value_ != 4)) {
    throw Error(fmt::format("{}: the header states {} x {} pixels, but a different number was read", any.path,
                            any.size[0], any.size[1]));
  }
  pixels_ = {unpacked_.data(), unpacked_.size()};
  big_endian_ = std::endian::native == std::endian::big;
}

HuTable::Entry HuTable::MakeEntry(const DicomSlice& slice, std::uint32_t word, int bytes, double& exact_hu) {
  constexpr double kAirTo = -900;  // values up to here, and not far below air, need no mention
  constexpr double kAirFrom = -4000, kLowestAir = -1200;
  constexpr double kTissueTo = 3000;  // a tag with a value that tissue has is wrong
  const int bits = std::min(slice.bits_stored > 0 ? slice.bits_stored : 8 * bytes, 8 * bytes);
  const std::int64_t whole = ReadBits(word, 8 * bytes, slice.is_signed);
  const std::int64_t value = ReadBits(word, bits, slice.is_signed);
  Entry entry;
  exact_hu = slice.slope * static_cast<double>(value) + slice.intercept;
  entry.above = !slice.is_signed && whole != value;
  if (slice.has_padding && ((whole >= slice.padding[0] && whole <= slice.padding[1]) ||
                            (value >= slice.padding[0] && value <= slice.padding[1]))) {
    const double stored_hu = slice.slope * static_cast<double>(whole) + slice.intercept;
    if (stored_hu <= kAirTo || stored_hu > kTissueTo) {
      exact_hu = stored_hu;
      entry.hu = kPaddingHu;
      entry.padding = stored_hu > kAirTo || stored_hu < kAirFrom;
      entry.marked = stored_hu > kAirTo || stored_hu < kLowestAir;
      entry.above = false;
      return entry;
    }
  }
  const double hu = std::clamp(exact_hu, -32768.0, 32767.0);
  entry.clamped = hu != exact_hu;
  entry.hu = static_cast<std::int16_t>(std::lround(hu));
  return entry;
}

void HuTable::Fill(const DicomSlice& slice, int bytes) {
  const std::size_t count = std::size_t{1} << (8 * bytes);
  const bool same = entries_.size() == count && filled_.slope == slice.slope && filled_.intercept == slice.intercept &&
                    filled_.bits_stored == slice.bits_stored && filled_.is_signed == slice.is_signed &&
                    filled_.has_padding == slice.has_padding && filled_.padding == slice.padding;
  if (same) return;
  filled_ = slice;
  entries_.resize(count);
  double exact_hu = 0;
  for (std::size_t word = 0; word < count; ++word) {
    entries_[word] = MakeEntry(slice, static_cast<std::uint32_t>(word), bytes, exact_hu);
  }
}

void HuTable::Convert(const FilePixels& file, const DicomSlice& slice, std::span<std::int16_t> hu,
                      std::span<char> padding, SliceValues& found) {
  const auto mark = [&](std::size_t v) {
    padding[v / 8] = static_cast<char>(padding[v / 8] | 1 << v % 8);
    found.is_marked = true;
  };
  const int bytes = file.bytes_per_value();
  const std::string_view frame = file.Frame(slice.frame);
  const bool big = file.big_endian();
  if (bytes <= 2) Fill(slice, bytes);
  double exact_hu = 0;
  std::size_t above = 0;  // values with bits above those of the value, if all are the same
  std::uint32_t above_word = 0;
  bool above_differ = false;
  for (std::size_t v = 0; v < hu.size(); ++v) {
    const std::uint32_t word = ReadWord(frame.data() + v * static_cast<std::size_t>(bytes), bytes, big);
    const Entry entry = bytes <= 2 ? entries_[word] : MakeEntry(slice, word, bytes, exact_hu);
    hu[v] = entry.hu;
    if (entry.clamped) {
      ++found.overflow;
      MakeEntry(slice, word, bytes, exact_hu);
      if (std::abs(exact_hu) > std::abs(found.extreme)) found.extreme = exact_hu;
    }
    if (entry.padding) {
      ++found.padding;
      found.padding_value = static_cast<int>(ReadBits(word, 8 * bytes, slice.is_signed));
    }
    if (entry.marked) mark(v);
    if (entry.above) {
      above_differ = above_differ || (above > 0 && word != above_word);
      above_word = word;
      ++above;
    }
  }
  // One value beyond the bits of the others that fills a part of the slice is padding; overlays have several.
  if (above_differ || 200 * above < hu.size() || above == 0) return;
  for (std::size_t v = 0; v < hu.size(); ++v) {
    if (ReadWord(frame.data() + v * static_cast<std::size_t>(bytes), bytes, big) != above_word) continue;
    hu[v] = kPaddingHu;
    mark(v);
  }
  found.padding += above;
  found.padding_value = static_cast<int>(above_word);
}

}  // namespace kerf
