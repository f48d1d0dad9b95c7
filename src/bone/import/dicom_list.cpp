#include <fmt/format.h>
#include <gdcmReader.h>
#include <gdcmStringFilter.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "base/files/child.h"
#include "base/files/extension.h"
#include "bone/import/dicom.h"
#include "bone/import/dicom_charset.h"
#include "bone/import/dicom_division.h"
#include "bone/import/dicom_header.h"
#include "bone/import/dicom_segments.h"
#include "bone/import/dicom_slices.h"
#include "bone/import/dicom_text.h"
#include "bone/import/dicom_zip.h"
#include "bone/import/image_header.h"
#include "bone/import/import.h"
#include "bone/import/itk_read.h"
#include "bone/import/series_bytes.h"
#include "kerf/error.h"

namespace kerf {

namespace {

namespace fs = std::filesystem;

// For a damaged header GDCM allocates as much memory as the header states, up to 4 GiB for one element.
constexpr ChildLimits kListing{std::uint64_t{512} << 20, 120};

constexpr const char* kCtImageStorage = "1.2.840.10008.5.1.4.1.1.2";
constexpr const char* kDirectoryStorage = "1.2.840.10008.1.3.10";

bool IsPacked(const fs::path& path) {
  return LowerExtension(path.string()) == ".gz";
}

bool ClaimsToBeDicom(const fs::path& path) {
  const std::string extension = LowerExtension(IsPacked(path) ? path.stem().string() : path.string());
  return extension == ".dcm" || extension == ".dicom" || extension == ".ima";
}

// Files of macOS that accompany others on media without resource forks.
bool IsAppleDouble(const fs::path& path) {
  return path.filename().string().starts_with("._");
}

// Returns YYYY-MM-DD for YYYYMMDD; empty for anything else.
std::string Date(const std::string& text) {
  if (text.size() != 8 || text.find_first_not_of("0123456789") != std::string::npos) return "";
  return fmt::format("{}-{}-{}", text.substr(0, 4), text.substr(4, 2), text.substr(6));
}

// Files at which the library that reads them failed, with the faults.
using Failures = std::map<std::string, std::string>;

// What a folder contains.
class Listing {
 public:
  explicit Listing(const Failures& failures) : failures_(failures) {}

  // Adds a file. Returns the number of its slices.
  std::size_t Add(const fs::path& path) {
    try {
      if (const auto failed = failures_.find(path.string()); failed != failures_.end()) throw Error(failed->second);
      if (IsAppleDouble(path)) return 0;
      if (IsDicomFile(path)) return AddDicom(path);
      if (!ClaimsToBeDicom(path)) return 0;
      std::error_code failed;
      const bool is_empty = fs::file_size(path, failed) == 0 && !failed;
      if (IsPacked(path)) {
        AddUnread(path, "", "packed by gzip", fmt::format("{}: is packed by gzip; unpack it", path.string()));
        return 0;
      }
      AddUnread(path, "", is_empty ? "empty" : "no DICOM file despite its name",
                fmt::format("{}: {}", path.string(), is_empty ? "is empty" : "not a DICOM file despite its name"));
    } catch (const Error& e) {
      AddUnread(path, "", "damaged or cut off", e.what());
    }
    return 0;
  }

  bool empty() const { return by_uid_.empty(); }
  // Whether a file states that other files continue it.
  bool is_part() const { return is_part_; }
  // The fault of the first file that could not be read; empty: none.
  std::string first_fault() const {
    const auto found =
        std::find_if(unread_.begin(), unread_.end(), [](const Unread& unread) { return unread.is_image; });
    return found == unread_.end() ? "" : found->file.fault;
  }

  std::vector<DicomSeries> Finish() {
    std::vector<DicomSeries> all;
    for (auto& [uid, series] : by_uid_) {
      for (DicomSlice& slice : series.slices) {
        const auto exact = exact_patients_.find(slice.patient);
        if (exact != exact_patients_.end() && exact->second.size() == 1) slice.patient = *exact->second.begin();
      }
      for (DicomSeries& stack : DivideIntoStacks(std::move(series))) all.push_back(std::move(stack));
    }
    for (DicomSeries& series : all) {
      for (const Unread& unread : unread_) AddTo(series, unread);
      const std::vector<std::string> left_out = DescribeLeftOut(series.left_out);
      series.warnings.insert(series.warnings.begin(), left_out.begin(), left_out.end());
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.slices.size() > b.slices.size(); });
    return all;
  }

 private:
  struct Unread {
    LeftOutFile file;
    std::string series_uid;  // empty: unknown
    bool is_image = true;
  };

  void AddUnread(const fs::path& path, const std::string& uid, const std::string& kind, const std::string& fault) {
    unread_.push_back({{path.string(), kind, fault, true}, uid, true});
  }

  // A file of unknown series may be a slice of any series in its folder.
  static void AddTo(DicomSeries& series, const Unread& unread) {
    if (!unread.is_image && unread.series_uid != series.uid) return;
    LeftOutFile file = unread.file;
    const fs::path folder = fs::path(file.path).parent_path();
    const bool is_beside = std::any_of(series.slices.begin(), series.slices.end(), [&folder](const DicomSlice& s) {
      return fs::path(s.path).parent_path() == folder;
    });
    file.may_be_slice = unread.is_image && (unread.series_uid.empty() ? is_beside : unread.series_uid == series.uid);
    series.left_out.push_back(std::move(file));
  }

  std::size_t AddDicom(const fs::path& path) {
    DicomOutline outline;
    const auto fail = [&](const std::string& fault) {
      AddUnread(path, Printable(outline.series_uid), "damaged or cut off", fault);
      return std::size_t{0};
    };
    try {
      CheckDicomHeader(path.string(), &outline);
    } catch (const Error& e) {
      return fail(e.what());
    }
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    bool read = false;
    try {
      read = reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010));
    } catch (const std::exception&) {
      read = false;
    }
    if (!read) {
      return fail(fmt::format("{}: the DICOM header can't be read; the file is damaged or cut off", path.string()));
    }
    gdcm::StringFilter filter;
    filter.SetFile(reader.GetFile());
    const std::string uid = Printable(GetText(filter, 0x0020, 0x000e));
    if (GetInteger(filter, 0x0028, 0x0010, 0) == 0 || GetInteger(filter, 0x0028, 0x0011, 0) == 0) {
      if (outline.class_uid == kCtImageStorage) {
        return fail(
            fmt::format("{}: a CT slice without rows and columns; the file is damaged or cut off", path.string()));
      }
      if (outline.class_uid != kDirectoryStorage) {  // a report, a structure set
        unread_.push_back(
            {{path.string(), "no image", fmt::format("{}: contains no image", path.string()), false}, uid, false});
      }
      return 0;
    }
    std::vector<DicomSlice> slices;
    try {
      slices = ListSlices(reader, filter, path.string());
    } catch (const Error& e) {
      return fail(e.what());
    }
    is_part_ = is_part_ || !GetText(filter, 0x0020, 0x9161).empty();  // a concatenation
    const std::string charset = GetText(filter, 0x0008, 0x0005);
    DicomSeries& series = by_uid_[uid];
    if (series.slices.empty()) {
      series.uid = uid;
      series.description = DecodeDicomText(GetText(filter, 0x0008, 0x103e), charset);
      series.modality = Printable(GetText(filter, 0x0008, 0x0060));
      series.study_date = Date(GetText(filter, 0x0008, 0x0020));
      series.frame_uid = Printable(GetText(filter, 0x0020, 0x0052));
    }
    if (static_cast<int>(slices.size()) < slices.front().frames) {
      series.warnings.push_back(fmt::format(
          "{} has {} frames, but PerFrameFunctionalGroupsSequence (5200,9230) describes only the first {}: the others "
          "were left out",
          Printable(path.filename().string()), slices.front().frames, slices.size()));
    }
    Identify(filter, charset, outline, slices);
    for (DicomSlice& slice : slices) series.slices.push_back(std::move(slice));
    return slices.size();
  }

  // Sets what tells the stacks of a series apart, where the frames do not state it.
  void Identify(gdcm::StringFilter& filter, const std::string& charset, const DicomOutline& outline,
                std::vector<DicomSlice>& slices) {
    const auto text = [&filter](std::uint16_t group, std::uint16_t element) {
      return Printable(GetText(filter, group, element));
    };
    const auto normal = [&filter](std::uint16_t group, std::uint16_t element) {
      // Programs differ in the case, the spaces and the empty parts of a name.
      std::string value = GetText(filter, group, element);
      while (!value.empty() && (value.back() == '^' || value.back() == ' ')) value.pop_back();
      value.erase(0, value.find_first_not_of(' '));
      std::transform(value.begin(), value.end(), value.begin(), [](unsigned char c) { return std::tolower(c); });
      return value;
    };
    const auto hash = [](const std::string& value) { return std::uint64_t{std::hash<std::string>()(value)}; };
    // From the least to the most exact: name, identifier, identifier with its issuer.
    const std::string id = normal(0x0010, 0x0020);
    const std::string issuer = id.empty() ? "" : normal(0x0010, 0x0021);
    std::vector<std::uint64_t> known;
    for (const std::string& by :
         {normal(0x0010, 0x0010), id, issuer.empty() ? "" : fmt::format("{}\n{}", id, issuer)}) {
      if (!by.empty()) known.push_back(hash(by));
    }
    for (const std::uint64_t by : known) {
      if (by != known.back()) exact_patients_[by].insert(known.back());
    }
    const std::vector<double> thickness = GetNumbers(filter, 0x0018, 0x0050);
    const auto set = [](std::string& field, const std::string& value) {
      if (field.empty()) field = value;
    };
    const std::string phase = text(0x0020, 0x0100);
    std::vector<std::string> telling;
    for (const TellingTag& tag : kTellingTags) {
      telling.push_back(DecodeDicomText(GetText(filter, tag.group, tag.element), charset));
    }
    for (DicomSlice& slice : slices) {
      set(slice.class_uid, text(0x0008, 0x0016));
      set(slice.instance_uid, text(0x0008, 0x0018));
      set(slice.modality, text(0x0008, 0x0060));
      set(slice.image_type, text(0x0008, 0x0008));
      slice.patient = known.empty() ? 0 : known.back();
      slice.study = hash(normal(0x0020, 0x000d));
      set(slice.phase, phase.empty() ? text(0x0020, 0x9128) : phase);
      set(slice.acquisition, text(0x0020, 0x0012));
      set(slice.acquisition_time, text(0x0008, 0x0032));
      set(slice.kernel, DecodeDicomText(GetText(filter, 0x0018, 0x1210), charset));
      slice.telling = telling;
      if (slice.thickness_mm == 0 && !thickness.empty()) slice.thickness_mm = thickness.front();
      slice.pixels_at = outline.pixels_at;
      if (outline.ends_early) slice.damage = fmt::format("{}: the slice is cut off", slice.path);
    }
  }

  const Failures& failures_;
  std::map<std::string, DicomSeries> by_uid_;
  std::vector<Unread> unread_;
  bool is_part_ = false;
  // Of a hash that is less exact than others: all more exact ones of the same files.
  std::map<std::uint64_t, std::set<std::uint64_t>> exact_patients_;
};

std::vector<fs::path> FindFiles(const std::string& folder, bool with_subfolders) {
  std::error_code failed;
  std::vector<fs::path> paths;
  for (auto it = fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied, failed);
       it != fs::recursive_directory_iterator(); it.increment(failed)) {
    if (failed) break;
    if (!with_subfolders) it.disable_recursion_pending();
    if (it->is_regular_file(failed)) paths.push_back(it->path());
  }
  if (failed) throw Error(fmt::format("{}: the folder can't be read ({})", folder, failed.message()));
  if (paths.empty()) throw Error(fmt::format("{}: the folder is empty", folder));
  std::sort(paths.begin(), paths.end());
  return paths;
}

// Name of the file that a child process reads, for its parent.
class CurrentFile {
 public:
  std::string Get() const { return std::string(name_.data()); }
  void Set(const std::string& name) {
    const std::size_t count = name.size() < name_.size() ? name.size() : 0;
    std::copy_n(name.data(), count, name_.data());
    name_.data()[count] = '\0';
  }

 private:
  SharedMemory name_{ChildReport::kNameBytes};
};

// Does the work of ListDicomSeries() within a child process.
std::vector<DicomSeries> ListInChild(const std::string& path, const Failures& failures, CurrentFile& current,
                                     ChildReport& report) {
  const QuietItk quiet;
  std::error_code failed;
  const bool is_folder = fs::is_directory(path, failed);
  if (!is_folder && (!fs::exists(path, failed) || !IsDicomFile(path))) {
    throw Error(
        fmt::format("{}: {}", path, fs::exists(path, failed) ? "is not a folder of DICOM files" : "no such folder"));
  }
  std::string folder = path;
  if (!is_folder) {
    Listing only(failures);
    report.SetName(path);
    if (only.Add(path) > 1 && !only.is_part()) return only.Finish();
    if (only.empty() && !only.first_fault().empty()) throw Error(only.first_fault());
    folder = fs::path(path).parent_path().string();
    if (folder.empty()) folder = ".";
  }
  const std::vector<fs::path> paths = FindFiles(folder, is_folder || IsDicomDirectory(path));
  Listing listing(failures);
  for (const fs::path& file : paths) {
    report.SetName(file.string());
    current.Set(file.string());
    listing.Add(file);
    report.SetProgress(0);  // shows that the process is alive
  }
  current.Set("");
  if (listing.empty() && !listing.first_fault().empty()) throw Error(listing.first_fault());
  if (listing.empty()) {
    const auto other = std::find_if(paths.begin(), paths.end(), [](const fs::path& file) {
      return IsZipFile(file) || HasImageExtension(file) || IsSurfacePath(file);
    });
    throw Error(fmt::format("{}: none of the {} files in the folder is a DICOM image{}", folder, paths.size(),
                            other == paths.end() ? "" : "; give the path of " + Printable(other->filename().string())));
  }
  return listing.Finish();
}

}  // namespace

bool IsDicomDirectory(const std::string& path) {
  if (!IsDicomFile(path)) return false;
  DicomOutline outline;
  try {
    CheckDicomHeader(path, &outline);
  } catch (const Error&) {  // of no importance here: its content is not read
  }
  return outline.class_uid == kDirectoryStorage;
}

std::vector<DicomSeries> ListDicomSeries(const std::string& path, const std::function<void(double)>& progress) {
  constexpr std::size_t kMaxFailures = 20;
  CurrentFile current;
  Failures failures;
  while (true) {
    try {
      return DecodeSeries(RunInChild(
          path, kListing, [&](ChildReport& report) { return Encode(ListInChild(path, failures, current, report)); },
          progress));
    } catch (const Error& e) {
      // The library failed at a file, which is left out from now on.
      const std::string failed_at = current.Get();
      current.Set("");
      if (failed_at.empty() || failures.size() == kMaxFailures || !failures.emplace(failed_at, e.what()).second) throw;
    }
  }
}

}  // namespace kerf
