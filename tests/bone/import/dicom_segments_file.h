// DICOM segmentations, which are written byte by byte, without the library that the program uses to read them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace kerf::test {

/// Writes elements with or without their types, as the transfer syntax wants it.
class SegmentFileBytes {
 public:
  explicit SegmentFileBytes(bool implicit) : implicit_(implicit) {}
  std::string Element(std::uint16_t group, std::uint16_t number, const std::string& vr, std::string value) const {
    if (value.size() % 2 != 0) value += vr == "UI" || vr == "OB" ? '\0' : ' ';
    const std::string tag = Little(group, 2) + Little(number, 2);
    if (implicit_ && group != 2) return tag + Little(value.size(), 4) + value;
    if (vr == "OB" || vr == "SQ") return tag + vr + Little(0, 2) + Little(value.size(), 4) + value;
    return tag + vr + Little(value.size(), 2) + value;
  }
  std::string Short(std::uint16_t group, std::uint16_t number, int value) const {
    return Element(group, number, "US", Little(static_cast<std::uint64_t>(value), 2));
  }
  std::string Sequence(std::uint16_t group, std::uint16_t number, const std::vector<std::string>& items) const {
    std::string all;
    for (const std::string& item : items) all += Little(0xfffe, 2) + Little(0xe000, 2) + Little(item.size(), 4) + item;
    return Element(group, number, "SQ", all);
  }
  static std::string Little(std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
  }

 private:
  bool implicit_;
};

/// Returns a segmentation of 2 segments, each with 2 slices of 4 x 3 pixels, in which the pixels of every second column
/// belong to segment 1 and the others to segment 2.
inline std::string DicomSegmentsFile(bool implicit, bool fractional) {
  const SegmentFileBytes b(implicit);
  const std::string seg_class = "1.2.840.10008.5.1.4.1.1.66.4";
  std::string meta = b.Element(2, 1, "OB", std::string("\0\1", 2)) + b.Element(2, 2, "UI", seg_class) +
                     b.Element(2, 3, "UI", "1.2.3") +
                     b.Element(2, 0x10, "UI", implicit ? "1.2.840.10008.1.2" : "1.2.840.10008.1.2.1");
  meta = b.Element(2, 0, "UL", SegmentFileBytes::Little(meta.size(), 4)) + meta;
  const auto code = [&b](const char* value) {
    return b.Element(8, 0x100, "SH", value) + b.Element(8, 0x102, "SH", "SCT");
  };
  std::vector<std::string> segments, frames;
  std::string values;
  for (int n = 1; n <= 2; ++n) {
    segments.push_back(b.Sequence(0x62, 3, {code("123037004")}) + b.Short(0x62, 4, n) +
                       b.Element(0x62, 5, "LO", n == 1 ? "Mandible" : "Tooth") +
                       b.Sequence(0x62, 0xf, {code(n == 1 ? "91609006" : "866006002")}));
    for (int k = 0; k < 2; ++k) {
      frames.push_back(b.Sequence(0x20, 0x9113, {b.Element(0x20, 0x32, "DS", fmt::format("-10\\20\\{}", 1.5 * k))}) +
                       b.Sequence(0x62, 0xa, {b.Short(0x62, 0xb, n)}));
      for (int pixel = 0; pixel < 12; ++pixel) values += (pixel + n) % 2 == 1 ? '\x64' : '\0';
    }
  }
  std::string pixels = values;
  if (!fractional) {
    pixels.assign(values.size() / 8, '\0');
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] != 0) pixels[i / 8] = static_cast<char>(static_cast<unsigned char>(pixels[i / 8]) | 1u << (i % 8));
    }
  }
  const int bits = fractional ? 8 : 1;
  const std::string data =
      b.Element(8, 0x16, "UI", seg_class) + b.Sequence(8, 0x1115, {b.Element(0x20, 0xe, "UI", "1.2.840.1")}) +
      b.Element(0x28, 8, "IS", "4") + b.Short(0x28, 0x10, 3) + b.Short(0x28, 0x11, 4) + b.Short(0x28, 0x100, bits) +
      b.Element(0x62, 1, "CS", fractional ? "FRACTIONAL" : "BINARY") + b.Sequence(0x62, 2, segments) +
      (fractional ? b.Short(0x62, 0xe, 200) : "") +
      b.Sequence(
          0x5200, 0x9229,
          {b.Sequence(0x20, 0x9116, {b.Element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")}) +
           b.Sequence(0x28, 0x9110, {b.Element(0x18, 0x50, "DS", "1.5") + b.Element(0x28, 0x30, "DS", "0.5\\0.4")})}) +
      b.Sequence(0x5200, 0x9230, frames) + b.Element(0x7fe0, 0x10, "OB", pixels);
  return std::string(128, '\0') + "DICM" + meta + data;
}

}  // namespace kerf::test
