// Synthetic CTs and CT files, which are written byte by byte, without the libraries that the program uses to read them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <sstream>
#include <string>

#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bone/import/volume.h"
#include "support/folder.h"

namespace kerf::test {

/// Samples a solid given by its signed distance (mm, negative inside): each voxel gets `inside` times the fraction of
/// it that the solid fills, as in a scanner, computed from 4 x 4 x 4 points.
inline Volume MakeCt(const std::array<int, 3>& size, const Vec3& spacing_mm, const Vec3& origin_W,
                     const glm::dmat3& axes_W, const std::function<double(const Vec3&)>& distance,
                     double inside = 1000) {
  Volume ct;
  ct.size = size;
  ct.spacing_mm = spacing_mm;
  ct.origin_W = origin_W;
  ct.axes_W = axes_W;
  ct.hu.reserve(ct.count());
  const double reach = glm::length(spacing_mm);
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const double d = distance(ct.WorldFromVoxel({i, j, k}));
        double fraction = d < 0 ? 1 : 0;
        if (std::abs(d) < reach) {
          int hits = 0;
          for (int n = 0; n < 64; ++n) {
            const Vec3 offset((n % 4 - 1.5) / 4, (n / 4 % 4 - 1.5) / 4, (n / 16 - 1.5) / 4);
            if (distance(ct.WorldFromVoxel(Vec3(i, j, k) + offset)) < 0) ++hits;
          }
          fraction = hits / 64.0;
        }
        ct.hu.push_back(static_cast<std::int16_t>(std::lround(inside * fraction)));
      }
    }
  }
  return ct;
}

inline std::function<double(const Vec3&)> Ball(const Vec3& centre_W, double radius_mm) {
  return [=](const Vec3& p) { return glm::length(p - centre_W) - radius_mm; };
}

inline std::string Bytes(const std::vector<std::int16_t>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]};
}

/// Returns the header text of an NRRD file for the volume, without the empty line at its end.
inline std::string NrrdHeader(const Volume& ct, const std::string& type = "short") {
  std::string text = fmt::format(
      "NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\nspace directions:", type,
      ct.size[0], ct.size[1], ct.size[2]);
  for (int a = 0; a < 3; ++a) {
    const Vec3 d = ct.axes_W[a] * ct.spacing_mm[a];
    text += fmt::format(" ({:.17g},{:.17g},{:.17g})", d.x, d.y, d.z);
  }
  return text +
         fmt::format(
             "\nkinds: domain domain domain\nendian: little\nencoding: raw\nspace origin: ({:.17g},{:.17g},{:.17g})\n",
             ct.origin_W.x, ct.origin_W.y, ct.origin_W.z);
}

inline void WriteNrrd(const Volume& ct, const std::string& path) {
  WriteBytes(path, NrrdHeader(ct) + "\n" + Bytes(ct.hu));
}

/// Replaces the bytes from `at` with those of `value`.
template <typename T>
void Put(std::string& bytes, std::size_t at, T value) {
  bytes.replace(at, sizeof value, reinterpret_cast<const char*>(&value), sizeof value);
}

/// Returns a NIfTI-1 header with an sform. Its frame is RAS: x and y have the opposite sign to LPS.
inline std::string NiftiHeader(const Volume& ct) {
  std::string h(352, '\0');
  Put(h, 0, std::int32_t{348});
  Put(h, 40, std::int16_t{3});
  for (std::size_t a = 0; a < 3; ++a) Put(h, 42 + 2 * a, static_cast<std::int16_t>(ct.size[a]));
  for (std::size_t a = 3; a < 7; ++a) Put(h, 42 + 2 * a, std::int16_t{1});
  Put(h, 70, std::int16_t{4});   // int16
  Put(h, 72, std::int16_t{16});  // bits
  Put(h, 76, 1.0f);
  for (int a = 0; a < 3; ++a) Put(h, 80 + 4 * static_cast<std::size_t>(a), static_cast<float>(ct.spacing_mm[a]));
  Put(h, 108, 352.0f);           // offset of the voxels
  h[123] = 2;                    // mm
  Put(h, 254, std::int16_t{1});  // sform code: sform is used
  for (int row = 0; row < 3; ++row) {
    const double sign = row < 2 ? -1 : 1;
    for (int a = 0; a < 3; ++a) {
      Put(h, 280 + 16 * static_cast<std::size_t>(row) + 4 * static_cast<std::size_t>(a),
          static_cast<float>(sign * ct.axes_W[a][row] * ct.spacing_mm[a]));
    }
    Put(h, 292 + 16 * static_cast<std::size_t>(row), static_cast<float>(sign * ct.origin_W[row]));
  }
  return h.replace(344, 4, std::string("n+1\0", 4));
}

inline void WriteNifti(const Volume& ct, const std::string& path) {
  WriteBytes(path, NiftiHeader(ct) + Bytes(ct.hu));
}

inline void WriteMeta(const Volume& ct, const std::string& path) {
  std::string text = fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "TransformMatrix =");
  for (int a = 0; a < 3; ++a)
    text += fmt::format(" {:.17g} {:.17g} {:.17g}", ct.axes_W[a].x, ct.axes_W[a].y, ct.axes_W[a].z);
  text += fmt::format(
      "\nOffset = {:.17g} {:.17g} {:.17g}\nElementSpacing = {:.17g} {:.17g} {:.17g}\nDimSize = {} {} {}\n"
      "ElementType = MET_SHORT\nElementDataFile = LOCAL\n",
      ct.origin_W.x, ct.origin_W.y, ct.origin_W.z, ct.spacing_mm.x, ct.spacing_mm.y, ct.spacing_mm.z, ct.size[0],
      ct.size[1], ct.size[2]);
  WriteBytes(path, text + Bytes(ct.hu));
}

/// Contents of a DICOM slice, and how the slice is damaged.
struct SliceSpec {
  std::string series_uid = "1.2.3.4.5";
  std::string modality = "CT";
  std::string description = "synthetic";
  std::string transfer_syntax = "1.2.840.10008.1.2.1";  // explicit VR little endian
  double slope = 1;
  double intercept = -1024;
  int samples = 1;
  std::string photometric = "MONOCHROME2";  // one sample per pixel
  std::string pixels;                       // replaces the slice's own pixels; for compressed pixels
  bool encapsulated = false;
};

inline std::string DicomSlice(const Volume& ct, int k, const SliceSpec& spec) {
  const auto element = [](std::uint16_t group, std::uint16_t number, const char* vr, std::string value) {
    if (value.size() % 2 != 0) value += std::string(vr) == "UI" || std::string(vr) == "OB" ? '\0' : ' ';
    std::string e;
    const auto put16 = [&e](std::uint16_t v) { e += {static_cast<char>(v & 0xff), static_cast<char>(v >> 8)}; };
    put16(group);
    put16(number);
    e += vr;
    if (std::string(vr) == "OW" || std::string(vr) == "OB") {
      put16(0);
      const auto n = static_cast<std::uint32_t>(value.size());
      put16(static_cast<std::uint16_t>(n & 0xffff));
      put16(static_cast<std::uint16_t>(n >> 16));
    } else {
      put16(static_cast<std::uint16_t>(value.size()));
    }
    return e + value;
  };
  const auto whole = [](int v) { return std::string{static_cast<char>(v & 0xff), static_cast<char>(v >> 8)}; };
  const auto text = [](const Vec3& v) { return fmt::format("{:.8f}\\{:.8f}\\{:.8f}", v.x, v.y, v.z); };
  const std::string uid = fmt::format("{}.{}", spec.series_uid, k + 1);
  const std::string ct_class = "1.2.840.10008.5.1.4.1.1.2";

  std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", ct_class) +
                     element(2, 3, "UI", uid) + element(2, 0x10, "UI", spec.transfer_syntax) +
                     element(2, 0x12, "UI", "1.2.3");
  const auto length = static_cast<std::uint32_t>(meta.size());
  meta = element(2, 0, "UL", std::string(reinterpret_cast<const char*>(&length), 4)) + meta;

  std::string data = element(8, 0x16, "UI", ct_class) + element(8, 0x18, "UI", uid) +
                     element(8, 0x60, "CS", spec.modality) + element(8, 0x103e, "LO", spec.description) +
                     element(0x10, 0x10, "PN", "SECRET^NAME") +
                     element(0x18, 0x50, "DS", fmt::format("{}", ct.spacing_mm.z)) + element(0x20, 0xd, "UI", "1.2.3") +
                     element(0x20, 0xe, "UI", spec.series_uid) + element(0x20, 0x13, "IS", std::to_string(k + 1)) +
                     element(0x20, 0x32, "DS", text(ct.WorldFromVoxel({0, 0, k}))) +
                     element(0x20, 0x37, "DS", text(ct.axes_W[0]) + "\\" + text(ct.axes_W[1])) +
                     element(0x20, 0x52, "UI", "1.2.4") + element(0x28, 2, "US", whole(spec.samples)) +
                     element(0x28, 4, "CS", spec.samples == 1 ? spec.photometric : "RGB");
  if (spec.samples != 1) data += element(0x28, 6, "US", whole(0));
  data += element(0x28, 0x10, "US", whole(ct.size[1])) + element(0x28, 0x11, "US", whole(ct.size[0])) +
          element(0x28, 0x30, "DS", fmt::format("{}\\{}", ct.spacing_mm.y, ct.spacing_mm.x));
  const int bits = spec.samples == 1 ? 16 : 8;
  data += element(0x28, 0x100, "US", whole(bits)) + element(0x28, 0x101, "US", whole(bits)) +
          element(0x28, 0x102, "US", whole(bits - 1)) + element(0x28, 0x103, "US", whole(0)) +
          element(0x28, 0x1052, "DS", fmt::format("{}", spec.intercept)) +
          element(0x28, 0x1053, "DS", fmt::format("{}", spec.slope));
  std::string pixels = spec.pixels;
  if (pixels.empty() && spec.samples == 1) {
    for (int v = 0; v < ct.size[0] * ct.size[1]; ++v) {
      const double hu = ct.hu[static_cast<std::size_t>(k) * ct.size[0] * ct.size[1] + v];
      pixels += whole(static_cast<int>(std::lround((hu - spec.intercept) / spec.slope)));
    }
  } else if (pixels.empty()) {
    pixels.assign(std::size_t{3} * ct.size[0] * ct.size[1], '\7');
  }
  if (spec.encapsulated) {
    const auto put32 = [](std::uint32_t v) { return std::string(reinterpret_cast<const char*>(&v), 4); };
    if (pixels.size() % 2 != 0) pixels += '\0';
    data += std::string("\xe0\x7f\x10\x00OB\0\0\xff\xff\xff\xff", 12);
    data += std::string("\xfe\xff\x00\xe0\0\0\0\0", 8);  // an empty offset table
    data += std::string("\xfe\xff\x00\xe0", 4) + put32(static_cast<std::uint32_t>(pixels.size())) + pixels;
    data += std::string("\xfe\xff\xdd\xe0\0\0\0\0", 8);
  } else {
    data += element(0x7fe0, 0x10, "OW", pixels);
  }
  std::string file(128, '\0');
  return file.append("DICM").append(meta).append(data);
}

/// Returns the specification of a slice with RLE-compressed pixels: two segments, high bytes and low bytes, each as
/// literal runs of up to 128.
inline SliceSpec RunLengthSpec(const Volume& ct, int k) {
  const int n = ct.size[0] * ct.size[1];
  std::array<std::string, 2> segments;
  for (std::size_t s = 0; s < 2; ++s) {
    for (int from = 0; from < n; from += 128) {
      const int count = std::min(128, n - from);
      segments[s] += static_cast<char>(count - 1);
      for (int v = from; v < from + count; ++v) {
        const int stored = ct.hu[static_cast<std::size_t>(k) * n + v] + 1024;
        segments[s] += static_cast<char>(s == 0 ? stored >> 8 : stored & 0xff);
      }
    }
    if (segments[s].size() % 2 != 0) segments[s] += '\x80';  // no operation
  }
  std::array<std::uint32_t, 16> header{2, 64, static_cast<std::uint32_t>(64 + segments[0].size())};
  SliceSpec spec;
  spec.transfer_syntax = "1.2.840.10008.1.2.5";
  spec.encapsulated = true;
  spec.pixels = std::string(reinterpret_cast<const char*>(header.data()), 64) + segments[0] + segments[1];
  return spec;
}

/// Writes all slices, with file names whose order differs from the order of the slices.
inline void WriteDicom(const Volume& ct, const std::string& folder, const SliceSpec& spec = {}) {
  for (int k = 0; k < ct.size[2]; ++k) {
    WriteBytes(fmt::format("{}/s{:03}_{}.dcm", folder, (k * 37 + 11) % ct.size[2], spec.series_uid),
               DicomSlice(ct, k, spec));
  }
}

}  // namespace kerf::test
