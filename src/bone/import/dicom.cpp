#include "bone/import/dicom.h"

#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmStringFilter.h>
#include <itkGDCMImageIO.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <sstream>

#include "base/core/number_text.h"
#include "base/files/child.h"
#include "base/files/extension.h"
#include "bone/import/dicom_header.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/itk_read.h"
#include "bone/import/limits.h"
#include "bone/import/series_bytes.h"
#include "kerf/error.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

// For a damaged header GDCM allocates as much memory as the header states, up to 4 GiB for one element.
constexpr ChildLimits kListing{std::uint64_t{512} << 20, 120};
constexpr ChildLimits kReadingSlices{std::uint64_t{3} << 30, 120};

constexpr const char* kCtImageStorage = "1.2.840.10008.5.1.4.1.1.2";

bool ClaimsToBeDicom(const fs::path& path) {
  const std::string extension = LowerExtension(path.string());
  return extension == ".dcm" || extension == ".dicom" || extension == ".ima";
}

std::vector<double> Numbers(std::string text) {
  std::replace(text.begin(), text.end(), '\\', ' ');
  std::istringstream in(text);
  std::vector<double> numbers;
  for (double v = 0; in >> v;) numbers.push_back(v);
  return numbers;
}

std::string Text(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element) {
  std::string text = filter.ToString(gdcm::Tag(group, element));
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

// Returns YYYY-MM-DD for YYYYMMDD; empty for anything else.
std::string Date(const std::string& text) {
  if (text.size() != 8 || text.find_first_not_of("0123456789") != std::string::npos) return "";
  return fmt::format("{}-{}-{}", text.substr(0, 4), text.substr(4, 2), text.substr(6));
}

int GetInteger(gdcm::StringFilter& filter, std::uint16_t group, std::uint16_t element, int otherwise) {
  const std::vector<double> numbers = Numbers(Text(filter, group, element));
  return numbers.empty() ? otherwise : static_cast<int>(std::clamp(numbers[0], 0.0, 1e6));
}

// Adds the file to its series.
void AddFile(const fs::path& path, std::map<std::string, DicomSeries>& all) {
  CheckDicomHeader(path.string());
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  bool read = false;
  try {
    read = reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010));
  } catch (const std::exception&) {
    read = false;
  }
  if (!read)
    throw Error(fmt::format("{}: the DICOM header can't be read; the file is damaged or cut off", path.string()));
  gdcm::StringFilter filter;
  filter.SetFile(reader.GetFile());
  const int rows = GetInteger(filter, 0x0028, 0x0010, 0);
  const int columns = GetInteger(filter, 0x0028, 0x0011, 0);
  if (rows == 0 || columns == 0) {
    if (Text(filter, 0x0002, 0x0002) == kCtImageStorage)
      throw Error(
          fmt::format("{}: a CT slice without rows and columns; the file is damaged or cut off", path.string()));
    return;  // not an image: a report, a directory, a structure set
  }

  DicomSlice slice;
  slice.path = path.string();
  slice.size = {columns, rows};
  if (static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(columns) > kMaxSlicePixels) {
    throw Error(
        fmt::format("{}: a slice of {} x {} pixels, more than the 2^26 that kerf reads", path.string(), columns, rows));
  }
  slice.samples = GetInteger(filter, 0x0028, 0x0002, 1);
  slice.bits = GetInteger(filter, 0x0028, 0x0100, 16);
  slice.inverted = Text(filter, 0x0028, 0x0004) == "MONOCHROME1";
  slice.frames = std::max(1, GetInteger(filter, 0x0028, 0x0008, 1));
  const std::vector<double> spacing = Numbers(Text(filter, 0x0028, 0x0030));  // the distance between rows comes first
  const std::vector<double> position = Numbers(Text(filter, 0x0020, 0x0032));
  const std::vector<double> orientation = Numbers(Text(filter, 0x0020, 0x0037));
  if (spacing.size() == 2 && position.size() == 3 && orientation.size() == 6) {
    slice.pixel_mm = {spacing[1], spacing[0]};
    slice.origin_W = {position[0], position[1], position[2]};
    slice.row_W = {orientation[0], orientation[1], orientation[2]};
    slice.column_W = {orientation[3], orientation[4], orientation[5]};
    const double row = glm::length(slice.row_W);
    const double column = glm::length(slice.column_W);
    slice.has_geometry = std::abs(row - 1) < 1e-2 && std::abs(column - 1) < 1e-2 &&
                         std::abs(glm::dot(slice.row_W, slice.column_W)) < 1e-2;
    if (slice.has_geometry) {
      slice.row_W /= row;
      slice.column_W /= column;
    }
  }
  const gdcm::TransferSyntax& syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
  slice.compressed = syntax.IsEncapsulated() || syntax == gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  const char* name = gdcm::TransferSyntax::GetTSString(syntax);
  slice.transfer_syntax = name == nullptr ? "unknown" : name;

  const std::string uid = Text(filter, 0x0020, 0x000e);
  DicomSeries& series = all[uid];
  if (series.slices.empty()) {
    series.uid = uid;
    series.description = Text(filter, 0x0008, 0x103e);
    series.modality = Text(filter, 0x0008, 0x0060);
    series.study_date = Date(Text(filter, 0x0008, 0x0020));
  }
  series.slices.push_back(std::move(slice));
}

Vec3 Normal(const DicomSlice& slice) {
  return glm::normalize(glm::cross(slice.row_W, slice.column_W));
}

void SortSlices(DicomSeries& series) {
  const bool placed =
      std::all_of(series.slices.begin(), series.slices.end(), [](const auto& s) { return s.has_geometry; });
  if (!placed) {
    std::sort(series.slices.begin(), series.slices.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return;
  }
  const Vec3 normal = Normal(series.slices.front());
  std::sort(series.slices.begin(), series.slices.end(), [&normal](const auto& a, const auto& b) {
    const double za = glm::dot(normal, a.origin_W);
    const double zb = glm::dot(normal, b.origin_W);
    return za != zb ? za < zb : a.path < b.path;
  });
  std::vector<double> gaps;
  for (std::size_t i = 1; i < series.slices.size(); ++i) {
    gaps.push_back(glm::dot(normal, series.slices[i].origin_W - series.slices[i - 1].origin_W));
  }
  if (gaps.empty()) return;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  series.gap_mm = *middle;
}

std::string Describe(const DicomSeries& s) {
  return fmt::format("{} ({}, {}{}{})", s.uid, s.modality.empty() ? "no modality" : s.modality,
                     FormatCount(s.slices.size(), "slice", "slices"), s.description.empty() ? "" : ", ", s.description);
}

// Returns a hint if one of several series is too short for a volume and another is not; the first is the longest.
std::string DescribeStray(const std::vector<const DicomSeries*>& found) {
  const DicomSeries& last = *found.back();
  if (last.slices.size() > 2 || found.front()->slices.size() <= 2) return "";
  return fmt::format("; one of them has {} and may be a scout view or a damaged file: {}",
                     FormatCount(last.slices.size(), "slice", "slices"),
                     fs::path(last.slices.front().path).filename().string());
}

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

/// Does the work of ListDicomSeries() within a child process.
std::vector<DicomSeries> ListInChild(const std::string& folder, ChildReport& report) {
  const QuietItk quiet;
  std::error_code failed;
  if (!fs::is_directory(folder, failed)) {
    throw Error(fmt::format("{}: {}", folder,
                            fs::exists(folder, failed) ? "is not a folder of DICOM files" : "no such folder"));
  }
  std::vector<fs::path> paths;
  for (auto it = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, failed);
       it != fs::recursive_directory_iterator(); it.increment(failed)) {
    if (failed) break;
    if (it->is_regular_file(failed)) paths.push_back(it->path());
  }
  if (failed) throw Error(fmt::format("{}: the folder can't be read ({})", folder, failed.message()));
  if (paths.empty()) throw Error(fmt::format("{}: the folder is empty", folder));
  std::sort(paths.begin(), paths.end());

  std::map<std::string, DicomSeries> by_uid;
  for (const fs::path& path : paths) {
    if (IsDicomFile(path)) {
      report.SetName(path.string());
      AddFile(path, by_uid);
      report.SetProgress(0);  // shows that the process is alive
    } else if (ClaimsToBeDicom(path)) {
      throw Error(
          fmt::format("{}: not a DICOM file despite its name; remove it from the folder or repair it", path.string()));
    }
  }
  if (by_uid.empty())
    throw Error(fmt::format("{}: none of the {} files in the folder is a DICOM image", folder, paths.size()));
  std::vector<DicomSeries> all;
  for (auto& [uid, series] : by_uid) {
    SortSlices(series);
    all.push_back(std::move(series));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.slices.size() > b.slices.size(); });
  return all;
}

}  // namespace

std::vector<DicomSeries> ListDicomSeries(const std::string& folder, const std::function<void(double)>& progress) {
  return DecodeSeries(RunInChild(
      folder, kListing, [&folder](ChildReport& report) { return Encode(ListInChild(folder, report)); }, progress));
}

const DicomSeries& ChooseSeries(const std::vector<DicomSeries>& all, const std::string& uid,
                                const std::string& folder) {
  std::vector<const DicomSeries*> found;
  for (const DicomSeries& s : all) {
    if (uid.empty() ? s.modality == "CT" : s.uid == uid) found.push_back(&s);
  }
  if (found.empty() && !uid.empty()) {
    for (const DicomSeries& s : all) {
      if (s.uid.size() > uid.size() && s.uid.compare(s.uid.size() - uid.size(), uid.size(), uid) == 0)
        found.push_back(&s);
    }
  }
  if (found.size() == 1) return *found.front();
  if (uid.empty() && found.empty() && all.size() == 1) return all.front();  // CheckSeries() reports the reason
  std::string list;
  for (const DicomSeries& s : all) list += (list.empty() ? "" : "; ") + Describe(s);
  if (!uid.empty()) {
    throw Error(
        fmt::format("{}: {} series match '{}'; there are: {}", folder, found.empty() ? "no" : "several", uid, list));
  }
  if (found.empty()) throw Error(fmt::format("{}: no CT among the series: {}", folder, list));
  throw Error(fmt::format("{}: the folder contains {} CT series; choose one with --series UID: {}{}", folder,
                          found.size(), list, DescribeStray(found)));
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
  const Vec3 normal = Normal(first);
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
    const double sideways = glm::length(off - Normal(first) * glm::dot(off, Normal(first)));
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
