// Choice of the series that is imported.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>

#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "bone/import/dicom.h"
#include "bone/import/dicom_division.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Found = std::vector<const DicomSeries*>;

constexpr std::size_t kFewestOfVolume = 3;

std::string FirstFile(const DicomSeries& s) {
  return Printable(std::filesystem::path(s.slices.front().path).filename().string());
}

std::string Describe(const DicomSeries& s) {
  const DicomSlice& first = s.slices.front();
  std::string text = fmt::format("{} ({}, {}", s.name(), s.modality.empty() ? "no modality" : s.modality,
                                 FormatCount(s.slices.size(), "slice", "slices"));
  if (s.stated_gap_mm() > 0) text += fmt::format(" {:.4g} mm apart", s.stated_gap_mm());
  if (!first.kernel.empty()) text += ", kernel " + first.kernel;
  if (!s.description.empty()) text += ", " + s.description;
  if (!s.part_name.empty()) text += ", " + s.part_name;
  return text + ")";
}

template <typename Series>
std::string DescribeAll(const Series& all) {
  std::string list;
  for (const DicomSeries* s : all) list += (list.empty() ? "" : "; ") + Describe(*s);
  return list;
}

[[noreturn]] void Ask(const std::string& what, const std::string& why, const Found& found) {
  std::vector<DicomSeries> series;
  for (const DicomSeries* s : found) series.push_back(*s);
  throw UnclearSeries(what, why, std::move(series));
}

// Returns a hint if one of several series is too short for a volume and another is not; the first is the longest.
std::string DescribeStray(const Found& found) {
  const DicomSeries& last = *found.back();
  if (last.slices.size() >= kFewestOfVolume || found.front()->slices.size() < kFewestOfVolume) return "";
  return fmt::format("; one of them has {} and may be a scout view or a damaged file: {}",
                     FormatCount(last.slices.size(), "slice", "slices"), FirstFile(last));
}

// Returns whether the series is long, wide and fine enough to show a jaw.
bool CanShowJaw(const DicomSeries& s) {
  constexpr double kLeastWidth_mm = 40, kLeastLength_mm = 25, kWidestGap_mm = 3.5;
  const DicomSlice& first = s.slices.front();
  return first.size[0] * first.pixel_mm[0] >= kLeastWidth_mm && first.size[1] * first.pixel_mm[1] >= kLeastWidth_mm &&
         CalcLength(s) >= kLeastLength_mm && s.gap_mm <= kWidestGap_mm;
}

// Projections and rendered pictures have no CT numbers of points.
bool ShowsPoints(const DicomSeries& s) {
  const std::string& type = s.slices.front().image_type;
  constexpr std::array kPictures{"MIP", "PROJECTION IMAGE", "VRT", "RENDER"};
  return std::none_of(kPictures.begin(), kPictures.end(),
                      [&type](const char* word) { return type.find(word) != std::string::npos; });
}

bool IsOriginal(const DicomSeries& s) {
  return !s.slices.front().image_type.starts_with("DERIVED");
}

// Returns whether the kernel is for bone (true) or soft tissue (false), by the names of the large makers.
std::optional<bool> IsForBone(const std::string& kernel) {
  std::string name;
  for (const char c : kernel) name += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const char* sharp : {"BONE", "EDGE", "LUNG", "SHARP"}) {
    if (name.find(sharp) != std::string::npos) return true;
  }
  for (const char* soft : {"STANDARD", "STND", "STD", "SOFT", "SMOOTH"}) {
    if (name.find(soft) != std::string::npos) return false;
  }
  // B31f, H60s, Hr64h, FC30: one or two letters and a number of two digits.
  const std::size_t digits = name.find_first_of("0123456789");
  if (digits == std::string::npos || digits < 1 || digits > 2) return std::nullopt;
  int number = 0;
  std::from_chars(name.data() + digits, name.data() + name.size(), number);
  if (name.starts_with("FC")) return (number >= 30 && number < 40) || (number >= 50 && number < 60) || number >= 80;
  constexpr int kSharp = 55;
  return number >= kSharp;
}

// Returns whether `s` is clearly better for a jaw than `other`: it has many more slices and is not much shorter or,
// with as many slices, it alone has a kernel for bone.
bool IsClearlyBetter(const DicomSeries& s, const DicomSeries& other) {
  constexpr double kMore = 1.5, kShorter = 0.6, kAlike = 0.1;
  const auto slices = static_cast<double>(s.slices.size());
  const auto others = static_cast<double>(other.slices.size());
  if (slices >= kMore * others) return CalcLength(s) >= kShorter * CalcLength(other);
  const bool alike = std::abs(slices - others) <= kAlike * std::max(slices, others) &&
                     std::abs(CalcLength(s) - CalcLength(other)) <= kAlike * CalcLength(other);
  return alike && IsForBone(s.slices.front().kernel) == true && IsForBone(other.slices.front().kernel) == false;
}

Found KeepIfAny(const Found& found, bool (*is)(const DicomSeries&)) {
  Found kept;
  std::copy_if(found.begin(), found.end(), std::back_inserter(kept), [is](const DicomSeries* s) { return is(*s); });
  return kept.empty() ? found : kept;
}

// Returns the series that is clearly the CT of a jaw; null if none is.
const DicomSeries* FindClearOne(Found found) {
  for (const auto is : {ShowsPoints, CanShowJaw, IsOriginal}) found = KeepIfAny(found, is);
  for (const DicomSeries* s : found) {
    const bool is_best = std::all_of(found.begin(), found.end(),
                                     [s](const DicomSeries* o) { return o == s || IsClearlyBetter(*s, *o); });
    if (is_best) return s;
  }
  return nullptr;
}

bool IsVolume(const DicomSeries& s) {
  return s.slices.size() >= kFewestOfVolume;
}

// Throws kerf::Error if the series are of several patients: those of one UID, or several volumes.
void CheckOnePatient(const Found& found, const std::string& folder) {
  std::set<std::uint64_t> seen;
  std::string files;
  Found listed;
  for (const DicomSeries* s : found) {
    const bool shares_uid =
        std::any_of(found.begin(), found.end(), [s](const DicomSeries* o) { return o != s && o->uid == s->uid; });
    if (!IsVolume(*s) && !shares_uid) continue;
    listed.push_back(s);
    if (!seen.insert(s->slices.front().patient).second) continue;
    files += fmt::format("{}{}", files.empty() ? "" : " and ", FirstFile(*s));
  }
  if (seen.size() < 2) return;
  const std::string why = fmt::format("the CT slices are of {} patients", seen.size());
  Ask(fmt::format("{}: {}, such as {}; choose one with --series: {}", folder, why, files, DescribeAll(listed)), why,
      listed);
}

// Returns the series to take among several; adds to `warnings` why it is taken.
const DicomSeries& ChooseAmong(const Found& found, const std::string& folder, std::vector<std::string>& warnings) {
  if (found.size() == 1) return *found.front();
  CheckOnePatient(found, folder);
  Found volumes;
  std::copy_if(found.begin(), found.end(), std::back_inserter(volumes), [](const auto* s) { return IsVolume(*s); });
  const DicomSeries* const best = volumes.empty() ? nullptr : FindClearOne(volumes);
  const std::string what = fmt::format("the folder contains {} CT series", found.size());
  if (best == nullptr) {
    Ask(fmt::format("{}: {}; choose one with --series UID: {}{}", folder, what, DescribeAll(found),
                    DescribeStray(found)),
        what, found);
  }
  Found others;
  std::copy_if(found.begin(), found.end(), std::back_inserter(others), [best](const auto* s) { return s != best; });
  warnings.push_back(
      fmt::format("{}; the one that suits a jaw best was taken: {}; choose another with --series UID: {}{}", what,
                  Describe(*best), DescribeAll(others), DescribeStray(found)));
  return *best;
}

// Returns the series that `uid` names: their names or UIDs, or else the ends of these.
Found FindNamed(const std::vector<DicomSeries>& all, const std::string& uid) {
  const auto find = [&all](const auto& matches) {
    Found found;
    for (const DicomSeries& s : all) {
      if (matches(s)) found.push_back(&s);
    }
    return found;
  };
  Found found = find([&uid](const DicomSeries& s) { return s.name() == uid; });
  if (found.empty()) found = find([&uid](const DicomSeries& s) { return s.uid == uid; });
  if (found.empty()) found = find([&uid](const DicomSeries& s) { return s.name().ends_with(uid); });
  if (found.empty()) found = find([&uid](const DicomSeries& s) { return s.uid.ends_with(uid); });
  return found;
}

// Returns the CT series; if there is none, the only volume of a modality that may be a CT's. Throws UnclearSeries if
// there are several.
Found FindCts(const std::vector<DicomSeries>& all, const std::string& folder) {
  Found cts, others;
  for (const DicomSeries& s : all) {
    if (s.modality == "CT") {
      cts.push_back(&s);
    } else if (IsVolume(s) && MayBeCt(s.modality)) {
      others.push_back(&s);
    }
  }
  if (cts.empty() && others.size() == 1) return others;
  if (cts.empty() && others.size() > 1) {
    const std::string why = "no series is stated to be a CT";
    Ask(fmt::format("{}: {}; choose one with --series UID, and confirm with --as-ct that it is a CT: {}", folder, why,
                    DescribeAll(others)),
        why, others);
  }
  if (cts.empty() && all.size() == 1) return {&all.front()};  // CheckSeries() reports the reason
  return cts;
}

}  // namespace

bool MayBeCt(const std::string& modality) {
  constexpr std::array kPossible{"", "OT", "SC", "XA", "RF", "DX", "PX", "IO", "RG", "CR"};
  return std::find(kPossible.begin(), kPossible.end(), modality) != kPossible.end();
}

DicomSeries ChooseSeries(const std::vector<DicomSeries>& all, const std::string& uid, const std::string& folder) {
  Found everything;
  for (const DicomSeries& s : all) everything.push_back(&s);
  const Found found = uid.empty() ? FindCts(all, folder) : FindNamed(all, uid);
  const bool of_one_uid =
      std::all_of(found.begin(), found.end(), [&found](const auto* s) { return s->uid == found.front()->uid; });
  if (!uid.empty() && (found.empty() || !of_one_uid)) {
    throw Error(fmt::format("{}: {} series match '{}'; there are: {}", folder, found.empty() ? "no" : "several",
                            Printable(uid), DescribeAll(everything)));
  }
  if (found.empty()) throw Error(fmt::format("{}: no CT among the series: {}", folder, DescribeAll(everything)));
  std::vector<std::string> warnings;
  DicomSeries chosen = ChooseAmong(found, folder, warnings);
  chosen.warnings.insert(chosen.warnings.end(), warnings.begin(), warnings.end());
  return chosen;
}

}  // namespace kerf
