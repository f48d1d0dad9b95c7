#include "bone/import/dicom.h"

#include <fmt/format.h>
#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <sstream>

#include "base/core/number_text.h"
#include "base/files/child.h"
#include "bone/import/itk_read.h"
#include "bone/import/limits.h"
#include "kerf/error.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

constexpr ChildLimits kReadingSlices{std::uint64_t{3} << 30, 120};

std::uint64_t CalcPixelBytes(const DicomSlice& slice) {
  return static_cast<std::uint64_t>(slice.size[0]) * slice.size[1] * ((slice.bits + 7) / 8);
}

// Throws kerf::Error if the slice's file is larger than kMaxSliceBytes or too short to contain its pixels. Must be
// called before memory is allocated for them.
void CheckFileSize(const DicomSlice& slice) {
  std::error_code failed;
  const std::uint64_t bytes = fs::file_size(slice.path, failed);
  if (failed) throw Error(fmt::format("{}: can't be read: {}", slice.path, failed.message()));
  if (bytes > kMaxSliceBytes) {
    throw Error(fmt::format("{}: a slice of {} MiB, more than the {} MiB that kerf reads", slice.path, bytes >> 20,
                            kMaxSliceBytes >> 20));
  }
  const double reach = (slice.compressed ? kMaxUnpackRatio : 1) * static_cast<double>(bytes);
  if (static_cast<double>(CalcPixelBytes(slice)) > reach) {
    throw Error(
        fmt::format("{}: the slice is cut off; its header states {} x {} pixels of {} bits, but not all are present",
                    slice.path, slice.size[0], slice.size[1], slice.bits));
  }
}

// Throws kerf::Error unless the file holds the pixels that its header states: GDCM silently fills in missing ones.
// Searches the bytes for the tag and the length of the pixel data element. Compressed pixels have no explicit length;
// the decoder detects errors there.
void CheckLength(const DicomSlice& slice) {
  if (slice.compressed) return;
  std::ifstream in(slice.path, std::ios::binary);
  std::ostringstream stream;
  stream << in.rdbuf();
  const std::string bytes = stream.str();
  const std::uint64_t needed = CalcPixelBytes(slice);
  const auto byte = [&bytes](std::size_t at) -> std::uint64_t { return static_cast<unsigned char>(bytes[at]); };
  bool found = false;
  bool whole = false;
  for (const bool big : {false, true}) {
    const std::string tag = big ? std::string("\x7f\xe0\x00\x10", 4) : std::string("\xe0\x7f\x10\x00", 4);
    for (std::size_t at = bytes.find(tag); at != std::string::npos && !found; at = bytes.find(tag, at + 1)) {
      // Explicit VR: VR, two bytes, length. Implicit VR: length.
      for (const std::size_t length_at : {at + 8, at + 4}) {
        if (length_at + 4 > bytes.size()) continue;
        std::uint64_t length = 0;
        for (std::size_t n = 0; n < 4; ++n) length |= byte(length_at + n) << (8 * (big ? 3 - n : n));
        if (length < needed || length > needed + 1) continue;
        found = true;
        whole = bytes.size() >= length_at + 4 + needed;
        break;
      }
    }
  }
  if (!found || !whole) {
    throw Error(
        fmt::format("{}: the slice is cut off; its header states {} x {} pixels of {} bits, but not all are present",
                    slice.path, slice.size[0], slice.size[1], slice.bits));
  }
}

// Reads the slice's pixels as HU.
Overflow ReadSlice(const DicomSlice& s, std::size_t pixels, std::vector<std::int16_t>& hu) {
  CheckLength(s);
  const QuietItk quiet;
  const auto io = itk::GDCMImageIO::New();
  io->SetFileName(s.path);
  // GDCM gives no specific reason: it has one message for all of these faults.
  const std::string complaint =
      s.compressed ? fmt::format(
                         "the transfer syntax {} can't be unpacked, or the slice's pixels are damaged; convert "
                         "the series to uncompressed DICOM",
                         s.transfer_syntax)
                   : std::string("the slice's pixels are damaged, or the header describes them wrongly");
  try {
    io->ReadImageInformation();
  } catch (const itk::ExceptionObject&) {
    throw Error(fmt::format("{}: {}", s.path, complaint));
  }
  // GDCM may have interpreted the header differently, and it allocates memory according to its own interpretation.
  if (static_cast<double>(io->GetImageSizeInBytes()) > kMaxVoxelBytes * s.size[0] * s.size[1]) {
    throw Error(fmt::format("{}: the header states {} x {} pixels, but the image has a different size", s.path,
                            s.size[0], s.size[1]));
  }
  const Overflow overflow = AppendPixels(*io, s.path, hu, complaint);
  if (hu.size() != pixels) {
    throw Error(fmt::format("{}: the header states {} x {} pixels, but a different number was read", s.path, s.size[0],
                            s.size[1]));
  }
  return overflow;
}

}  // namespace

Vec3 CalcNormal(const DicomSlice& slice) {
  return glm::normalize(glm::cross(slice.row_W, slice.column_W));
}

void CheckSeries(const DicomSeries& series) {
  const auto fail = [&series](const std::string& what) { throw Error(fmt::format("series {}: {}", series.uid, what)); };
  if (series.modality != "CT") {
    fail(fmt::format("the modality is {}, not CT; kerf needs Hounsfield units",
                     series.modality.empty() ? "not given" : series.modality));
  }
  const DicomSlice& first = series.slices.front();
  for (const DicomSlice& s : series.slices) {
    const std::string file = fs::path(s.path).filename().string();
    if (s.samples != 1) fail(fmt::format("{} is a colour image ({} samples per pixel), not CT", file, s.samples));
    if (s.frames > 1) fail(fmt::format("{} contains {} frames; kerf reads CT with one slice per file", file, s.frames));
    if (s.inverted) {
      fail(
          fmt::format("{} is stored for inverted display (MONOCHROME1), which kerf does not read; convert the series "
                      "to MONOCHROME2",
                      file));
    }
    if (!s.has_geometry) fail(fmt::format("{} has no valid position, orientation or pixel spacing", file));
    if (s.size != first.size) {
      fail(fmt::format("{} has {} x {} pixels where others have {} x {}; the series is a mixture", file, s.size[0],
                       s.size[1], first.size[0], first.size[1]));
    }
    if (glm::length(s.row_W - first.row_W) > 1e-3 || glm::length(s.column_W - first.column_W) > 1e-3) {
      fail(fmt::format(
          "{} has a different orientation from the others; the series is a mixture (a localizer among the slices?)",
          file));
    }
    if (std::abs(s.pixel_mm[0] - first.pixel_mm[0]) > 1e-4 || std::abs(s.pixel_mm[1] - first.pixel_mm[1]) > 1e-4) {
      fail(fmt::format("{} has a different pixel spacing from the others; the series is a mixture", file));
    }
  }
  if (series.slices.size() < 3)
    fail(fmt::format("{} not a volume; kerf needs at least 3",
                     FormatCount(series.slices.size(), "slice is", "slices are")));
  const Vec3 normal = CalcNormal(first);
  const double gap = series.gap_mm;
  for (std::size_t i = 1; i < series.slices.size(); ++i) {
    const DicomSlice& a = series.slices[i - 1];
    const DicomSlice& b = series.slices[i];
    const double z = glm::dot(normal, a.origin_W);
    const double step = glm::dot(normal, b.origin_W) - z;
    const std::string files =
        fmt::format("{} and {}", fs::path(a.path).filename().string(), fs::path(b.path).filename().string());
    if (step < 1e-3) {
      fail(fmt::format("{} lie at the same place ({:.2f} mm along the normal); the series has duplicate slices", files,
                       z));
    }
    // Scanners round positions to about 0.01 mm.
    if (std::abs(step - gap) <= std::max(0.02 * gap, 0.02)) continue;
    const double multiple = step / gap;
    if (multiple > 1.5 && std::abs(multiple - std::round(multiple)) < 0.1) {
      fail(fmt::format("{} missing between {} (at {:.2f} and {:.2f} mm; slices elsewhere are {:.2f} mm apart)",
                       FormatCount(static_cast<std::size_t>(std::lround(multiple) - 1), "slice is", "slices are"),
                       files, z, z + step, gap));
    }
    fail(fmt::format(
        "the slices are unequally spaced: {:.2f} mm between {}, {:.2f} mm elsewhere; resample the scan evenly", step,
        files, gap));
  }
}

Volume ReadDicomSeries(const DicomSeries& series, const std::function<void(double)>& progress) {
  CheckSeries(series);
  const DicomSlice& first = series.slices.front();
  const DicomSlice& last = series.slices.back();
  const auto n = static_cast<int>(series.slices.size());
  Volume volume;
  volume.size = {first.size[0], first.size[1], n};
  volume.origin_W = first.origin_W;
  // Step from slice to slice: along the normal, or sheared if the gantry was tilted.
  const Vec3 step = (last.origin_W - first.origin_W) / static_cast<double>(n - 1);
  volume.spacing_mm = {first.pixel_mm[0], first.pixel_mm[1], glm::length(step)};
  volume.axes_W = glm::dmat3(first.row_W, first.column_W, step / glm::length(step));
  CheckLattice(volume, fmt::format("series {}", series.uid));
  for (int k = 0; k < n; ++k) {
    const DicomSlice& s = series.slices[k];
    const Vec3 expected = first.origin_W + step * static_cast<double>(k);
    const Vec3 off = s.origin_W - expected;
    const double sideways = glm::length(off - CalcNormal(first) * glm::dot(off, CalcNormal(first)));
    if (sideways > 0.5 * std::min(first.pixel_mm[0], first.pixel_mm[1])) {
      throw Error(fmt::format("series {}: {} is shifted sideways by {:.2f} mm relative to the others", series.uid,
                              fs::path(s.path).filename().string(), sideways));
    }
  }

  if (volume.count() > kMaxVoxels) {
    throw Error(fmt::format("series {}: {} x {} x {} voxels, more than the 2^31 that kerf reads", series.uid,
                            volume.size[0], volume.size[1], volume.size[2]));
  }
  for (const DicomSlice& slice : series.slices) CheckFileSize(slice);
  const std::size_t slice_pixels = volume.count() / static_cast<std::size_t>(n);
  const SharedMemory pixels(volume.count() * sizeof(std::int16_t));
  const auto read = [&](ChildReport& report) {
    std::vector<std::int16_t> hu;
    Overflow overflow;
    for (int k = 0; k < n; ++k) {
      report.SetName(series.slices[k].path);
      hu.clear();
      overflow.Add(ReadSlice(series.slices[k], slice_pixels, hu));
      std::memcpy(pixels.data() + k * slice_pixels * sizeof hu[0], hu.data(), slice_pixels * sizeof hu[0]);
      report.SetProgress(static_cast<double>(k + 1) / n);
    }
    return overflow.count > 0 ? Describe(overflow, volume.count()) : "";
  };
  const std::string warning = RunInChild(first.path, kReadingSlices, read, progress);
  if (!warning.empty()) volume.warnings.push_back(warning);
  volume.hu.resize(volume.count());
  std::memcpy(volume.hu.data(), pixels.data(), pixels.size());
  return volume;
}

}  // namespace kerf
