#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmStringFilter.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>

#include "base/core/number_text.h"
#include "base/files/child.h"
#include "base/files/extension.h"
#include "bone/import/dicom.h"
#include "bone/import/dicom_header.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/dicom_slices.h"
#include "bone/import/dicom_text.h"
#include "bone/import/itk_read.h"
#include "bone/import/series_bytes.h"
#include "kerf/error.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

// For a damaged header GDCM allocates as much memory as the header states, up to 4 GiB for one element.
constexpr ChildLimits kListing{std::uint64_t{512} << 20, 120};

constexpr const char* kCtImageStorage = "1.2.840.10008.5.1.4.1.1.2";

bool ClaimsToBeDicom(const fs::path& path) {
  const std::string extension = LowerExtension(path.string());
  return extension == ".dcm" || extension == ".dicom" || extension == ".ima";
}

// Returns YYYY-MM-DD for YYYYMMDD; empty for anything else.
std::string Date(const std::string& text) {
  if (text.size() != 8 || text.find_first_not_of("0123456789") != std::string::npos) return "";
  return fmt::format("{}-{}-{}", text.substr(0, 4), text.substr(4, 2), text.substr(6));
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
    if (GetText(filter, 0x0002, 0x0002) == kCtImageStorage)
      throw Error(
          fmt::format("{}: a CT slice without rows and columns; the file is damaged or cut off", path.string()));
    return;  // not an image: a report, a directory, a structure set
  }

  const std::string uid = GetText(filter, 0x0020, 0x000e);
  DicomSeries& series = all[uid];
  if (series.slices.empty()) {
    series.uid = uid;
    series.description = GetText(filter, 0x0008, 0x103e);
    series.modality = GetText(filter, 0x0008, 0x0060);
    series.study_date = Date(GetText(filter, 0x0008, 0x0020));
  }
  for (DicomSlice& slice : ListSlices(reader, filter, path.string())) series.slices.push_back(std::move(slice));
}
void SortSlices(DicomSeries& series) {
  const bool placed =
      std::all_of(series.slices.begin(), series.slices.end(), [](const auto& s) { return s.has_geometry; });
  if (!placed) {
    std::sort(series.slices.begin(), series.slices.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
    return;
  }
  const Vec3 normal = CalcNormal(series.slices.front());
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

}  // namespace kerf
