#include "bone/import/dicom_division.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/core/number_text.h"
#include "base/core/printable.h"

namespace kerf {
namespace {

using Slices = std::vector<DicomSlice>;

constexpr std::size_t kFewestSlices = 3;  // of a stack

std::string FileName(const std::string& path) {
  return Printable(std::filesystem::path(path).filename().string());
}

// Removes the slices for which `leaves(slice)` returns a reason, unless that would remove all. Lists their files.
template <typename Leaves>
void LeaveOut(Slices& slices, std::vector<LeftOutFile>& left_out, const std::string& kind, bool may_be_slice,
              const Leaves& leaves) {
  Slices kept;
  std::vector<LeftOutFile> files;
  for (DicomSlice& slice : slices) {
    const std::string why = leaves(slice);
    if (why.empty()) {
      kept.push_back(std::move(slice));
    } else if (files.empty() || files.back().path != slice.path) {  // once for all frames of a file
      files.push_back({slice.path, kind, fmt::format("{}: {}", slice.path, why), may_be_slice});
    }
  }
  if (kept.empty()) return;  // CheckSeries() says why this is no CT
  slices = std::move(kept);
  left_out.insert(left_out.end(), files.begin(), files.end());
}

bool AnyOf(const Slices& slices, bool (*is)(const DicomSlice&)) {
  return std::any_of(slices.begin(), slices.end(), is);
}

bool IsLocalizer(const DicomSlice& slice) {
  return slice.image_type.find("LOCALIZER") != std::string::npos ||
         slice.image_type.find("SCOUT") != std::string::npos || slice.image_type.find("TOPOGRAM") != std::string::npos;
}

bool IsCapture(const DicomSlice& slice) {
  return slice.class_uid.starts_with("1.2.840.10008.5.1.4.1.1.7");  // secondary capture, of one or more frames
}

void LeaveOutOthers(Slices& slices, std::vector<LeftOutFile>& left_out) {
  LeaveOut(slices, left_out, "localizer by ImageType", false,
           [](const DicomSlice& s) { return std::string(IsLocalizer(s) ? "is a localizer" : ""); });
  LeaveOut(slices, left_out, "colour image", false, [](const DicomSlice& s) {
    return s.samples == 1 ? "" : fmt::format("is a colour image ({} samples per pixel), not CT", s.samples);
  });
  if (AnyOf(slices, [](const DicomSlice& s) { return s.modality == "CT"; })) {
    LeaveOut(slices, left_out, "modality other than CT", false, [](const DicomSlice& s) {
      return s.modality == "CT" ? "" : fmt::format("has the modality {} among slices of a CT", s.modality);
    });
  }
  if (AnyOf(slices, [](const DicomSlice& s) { return !IsCapture(s); })) {
    LeaveOut(slices, left_out, "secondary capture", false, [](const DicomSlice& s) {
      return std::string(IsCapture(s) ? "is a secondary capture among slices of a CT" : "");
    });
  }
  if (AnyOf(slices, [](const DicomSlice& s) { return s.has_geometry; })) {
    LeaveOut(slices, left_out, "without position, orientation or pixel spacing", true, [](const DicomSlice& s) {
      return std::string(s.has_geometry ? "" : "has no valid position, orientation or pixel spacing");
    });
  }
}

// Returns whether the last `from_end` bytes of two files are the same; 0: all bytes.
bool HaveSameBytes(const std::string& a, const std::string& b, std::uint64_t from_end) {
  std::ifstream first(a, std::ios::binary);
  std::ifstream second(b, std::ios::binary);
  if (from_end > 0) {
    first.seekg(-static_cast<std::streamoff>(from_end), std::ios::end);
    second.seekg(-static_cast<std::streamoff>(from_end), std::ios::end);
  }
  if (!first || !second) return false;
  constexpr std::size_t kBlock = 1 << 16;
  std::vector<char> one(kBlock);
  std::vector<char> other(kBlock);
  while (true) {
    first.read(one.data(), static_cast<std::streamsize>(kBlock));
    second.read(other.data(), static_cast<std::streamsize>(kBlock));
    if (first.gcount() != second.gcount()) return false;
    if (first.gcount() == 0) return true;
    if (!std::equal(one.begin(), one.begin() + first.gcount(), other.begin())) return false;
  }
}

bool AreOfOneAcquisition(const DicomSlice& a, const DicomSlice& b) {
  const auto what = [](const DicomSlice& s) {
    return std::tie(s.patient, s.study, s.phase, s.acquisition, s.acquisition_time, s.kernel);
  };
  return what(a) == what(b);
}

// Returns whether both files, of slices at one place, hold the same image: they are the same byte by byte; or their
// pixels are, with one identifier or of one acquisition; or these are packed differently, with one identifier.
bool AreCopies(const DicomSlice& a, const DicomSlice& b) {
  std::error_code failed;
  if (std::filesystem::file_size(a.path, failed) == std::filesystem::file_size(b.path, failed) &&
      HaveSameBytes(a.path, b.path, 0)) {
    return true;
  }
  const auto what = [](const DicomSlice& s) {
    return std::tie(s.class_uid, s.image_type, s.row_W, s.column_W, s.frames, s.slope, s.intercept);
  };
  if (what(a) != what(b)) return false;
  const bool one_uid = !a.instance_uid.empty() && a.instance_uid == b.instance_uid;
  if (a.transfer_syntax != b.transfer_syntax) return one_uid;
  // Compressed pixels are most of a file.
  const std::uint64_t pixels = a.compressed ? std::filesystem::file_size(a.path, failed) / 2
                                            : std::uint64_t{1} * a.size[0] * a.size[1] * a.frames * ((a.bits + 7) / 8);
  return (one_uid || AreOfOneAcquisition(a, b)) && !failed && pixels > 0 && HaveSameBytes(a.path, b.path, pixels);
}

// Leaves out files that hold the same image as another one, and cut off ones of which there is a whole one. Keeps the
// file with the shorter name: a copy is called "IM0007 (1).dcm".
void LeaveOutCopies(Slices& slices, std::vector<LeftOutFile>& left_out) {
  std::map<std::string, std::vector<const DicomSlice*>> at_place;
  std::set<std::string> seen;
  for (const DicomSlice& s : slices) {
    if (!seen.insert(s.path).second) continue;  // another frame
    const Vec3& o = s.origin_W;
    at_place[s.has_geometry ? fmt::format("{:.4f} {:.4f} {:.4f} {}x{}", o.x, o.y, o.z, s.size[0], s.size[1])
                            : s.instance_uid]
        .push_back(&s);
  }
  std::map<std::string, std::string> copies;   // path of the file that is kept, by that of the copy
  std::map<std::string, std::string> damaged;  // likewise
  for (auto& [place, files] : at_place) {
    if (files.size() < 2) continue;
    std::sort(files.begin(), files.end(), [](const DicomSlice* a, const DicomSlice* b) {
      return std::tuple(!a->damage.empty(), a->path.size(), a->path) <
             std::tuple(!b->damage.empty(), b->path.size(), b->path);
    });
    std::vector<const DicomSlice*> kept;
    for (const DicomSlice* s : files) {
      const auto is_copy = [s](const DicomSlice* k) {
        return s->damage.empty() ? AreCopies(*k, *s) : k->damage.empty() && AreOfOneAcquisition(*k, *s);
      };
      const auto found = std::find_if(kept.begin(), kept.end(), is_copy);
      if (found == kept.end()) {
        kept.push_back(s);
      } else {
        (s->damage.empty() ? copies : damaged)[s->path] = (*found)->path;
      }
    }
  }
  LeaveOut(slices, left_out, "copy of another slice", false, [&copies](const DicomSlice& s) {
    const auto found = copies.find(s.path);
    return found == copies.end() ? "" : fmt::format("is a copy of {}", FileName(found->second));
  });
  LeaveOut(slices, left_out, "cut off; there is a whole file of the same slice", false,
           [&damaged](const DicomSlice& s) {
             const auto found = damaged.find(s.path);
             return found == damaged.end() ? "" : fmt::format("is cut off, but {} is whole", FileName(found->second));
           });
}

// Distances between neighbours along the normal; none if a slice has no position.
std::vector<double> CalcGaps(const DicomSeries& series) {
  std::vector<double> gaps;
  if (std::any_of(series.slices.begin(), series.slices.end(), [](const auto& s) { return !s.has_geometry; })) return {};
  const Vec3 normal = CalcNormal(series.slices.front());
  for (std::size_t i = 1; i < series.slices.size(); ++i) {
    gaps.push_back(glm::dot(normal, series.slices[i].origin_W - series.slices[i - 1].origin_W));
  }
  return gaps;
}

void SortSlices(DicomSeries& series) {
  const bool placed =
      std::all_of(series.slices.begin(), series.slices.end(), [](const auto& s) { return s.has_geometry; });
  if (!placed) {
    std::stable_sort(series.slices.begin(), series.slices.end(),
                     [](const auto& a, const auto& b) { return a.path < b.path; });
    return;
  }
  const Vec3 normal = CalcNormal(series.slices.front());
  std::stable_sort(series.slices.begin(), series.slices.end(), [&normal](const auto& a, const auto& b) {
    const double za = glm::dot(normal, a.origin_W);
    const double zb = glm::dot(normal, b.origin_W);
    return za != zb ? za < zb : a.path < b.path;
  });
  std::vector<double> gaps = CalcGaps(series);
  if (gaps.empty()) return;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  series.gap_mm = *middle;
}

bool RepeatsPlaces(const DicomSeries& series) {
  const std::vector<double> gaps = CalcGaps(series);
  return std::any_of(gaps.begin(), gaps.end(), [](double gap) { return gap < 1e-3; });
}

bool IsEven(const DicomSeries& series) {
  const double gap_mm = series.gap_mm;
  const std::vector<double> gaps = CalcGaps(series);
  return std::all_of(gaps.begin(), gaps.end(), [gap_mm](double gap) {
    return gap > 1e-3 && std::abs(gap - gap_mm) <= std::max(0.02 * gap_mm, 0.02);
  });
}

// Returns the same series with other slices.
DicomSeries WithSlices(const DicomSeries& series, Slices slices) {
  DicomSeries other = series;
  other.slices = std::move(slices);
  SortSlices(other);
  return other;
}

// Groups the slices by what `key` returns, in the order of their first ones.
template <typename Key>
std::vector<std::pair<std::string, Slices>> GroupBy(const Slices& slices, const Key& key) {
  std::vector<std::pair<std::string, Slices>> groups;
  std::map<std::string, std::size_t> index;
  for (const DicomSlice& s : slices) {
    const auto [found, is_new] = index.emplace(key(s), groups.size());
    if (is_new) groups.emplace_back(found->first, Slices());
    groups[found->second].second.push_back(s);
  }
  return groups;
}

std::string StudyOf(const DicomSlice& s) {
  return fmt::format("{:x}", s.study);
}

struct Property {
  std::string name;
  std::function<std::string(const DicomSlice&)> value;
  bool tells_apart = false;  // also stacks between each other's slices, which are even together
  bool by_chance = false;    // its values may differ for other reasons, so that each stack must be whole
  bool follows = false;      // see TellingTag
};

// In the order in which they are tried.
std::vector<Property> ListProperties() {
  std::vector<Property> all{
      {"study", StudyOf},
      {"phase", [](const DicomSlice& s) { return s.phase; }, true},
      {"acquisition", [](const DicomSlice& s) { return s.acquisition; }, true, false, true},
      {"acquisition at", [](const DicomSlice& s) { return s.acquisition_time; }, false, false, true},
      {"kernel", [](const DicomSlice& s) { return s.kernel; }},
      {"image type", [](const DicomSlice& s) { return s.image_type; }},
      {"thickness in mm", [](const DicomSlice& s) { return fmt::format("{:g}", s.thickness_mm); }}};
  for (std::size_t t = 0; t < kTellingTags.size(); ++t) {
    const TellingTag& tag = kTellingTags[t];
    all.push_back({tag.name, [t](const DicomSlice& s) { return s.telling.at(t); }, false, true, tag.follows});
  }
  all.push_back({"folder",
                 [](const DicomSlice& s) { return FileName(std::filesystem::path(s.path).parent_path().string()); },
                 false, true});
  return all;
}

std::size_t CountPlaces(const DicomSeries& series) {
  const std::vector<double> gaps = CalcGaps(series);
  return 1 + static_cast<std::size_t>(std::count_if(gaps.begin(), gaps.end(), [](double gap) { return gap >= 1e-3; }));
}

// Returns whether the stack has a slice at each place of the series, or even ones.
bool IsWhole(const DicomSeries& stack, const DicomSeries& series) {
  return !RepeatsPlaces(stack) && (stack.slices.size() == CountPlaces(series) || IsEven(stack));
}

// Returns whether two of the stacks share more than half of the shorter one's length.
bool Overlap(const std::vector<DicomSeries>& stacks) {
  std::vector<std::pair<double, double>> ranges;
  const Vec3 normal = CalcNormal(stacks.front().slices.front());
  for (const DicomSeries& stack : stacks) {
    const auto [low, high] =
        std::minmax({glm::dot(normal, stack.slices.front().origin_W), glm::dot(normal, stack.slices.back().origin_W)});
    ranges.emplace_back(low, high);
  }
  std::sort(ranges.begin(), ranges.end());
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    const auto& [low, high] = ranges[i - 1];
    const auto& [next_low, next_high] = ranges[i];
    if (std::min(high, next_high) - next_low > 0.5 * std::min(high - low, next_high - next_low)) return true;
  }
  return false;
}

// Returns the stacks that differ in the property; none if it does not explain that the slices of the series repeat
// places or are uneven.
std::vector<DicomSeries> DivideBy(const Property& property, const DicomSeries& series) {
  const auto groups = GroupBy(series.slices, property.value);
  if (groups.size() < 2 || groups.size() * kFewestSlices > series.slices.size() + kFewestSlices) return {};
  std::vector<DicomSeries> stacks;
  std::vector<LeftOutFile> left_out;
  for (const auto& [value, slices] : groups) {
    if (slices.size() < kFewestSlices) {
      for (const DicomSlice& s : slices) {
        left_out.push_back({s.path, fmt::format("another {}", property.name),
                            fmt::format("{}: belongs to another {} than the other slices", s.path, property.name),
                            false});
      }
      continue;
    }
    stacks.push_back(WithSlices(series, slices));
    stacks.back().part_name += fmt::format("{}{} {}", series.part_name.empty() ? "" : ", ", property.name,
                                           value.empty() ? "not stated" : value);
  }
  if (stacks.empty()) return {};
  const bool repeats = RepeatsPlaces(series);
  const bool solved = std::all_of(stacks.begin(), stacks.end(), [&](const DicomSeries& stack) {
    if (!repeats) return IsEven(stack);
    return property.by_chance ? IsWhole(stack, series) : !RepeatsPlaces(stack);
  });
  if (!solved || (property.by_chance && !AreFew(left_out.size(), series.slices.size()))) return {};
  if (!repeats && (stacks.size() < 2 || !left_out.empty() || !Overlap(stacks))) return {};
  for (DicomSeries& stack : stacks) stack.left_out.insert(stack.left_out.end(), left_out.begin(), left_out.end());
  return stacks;
}

// Returns the slices with the number of each, in the order of these numbers; none if the property of one is no number.
std::vector<std::pair<double, DicomSlice>> SortByNumber(const Property& property, const Slices& slices) {
  std::vector<std::pair<double, DicomSlice>> sorted;
  for (const DicomSlice& s : slices) {
    const std::string text = property.value(s);
    double number = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (fault != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return {};
    sorted.emplace_back(number, s);
  }
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return sorted;
}

// Returns the whole stacks that follow each other in the property, such as a time; none if it does not explain that the
// slices repeat places.
std::vector<DicomSeries> DivideIntoBlocks(const Property& property, const DicomSeries& series) {
  const Vec3 normal = CalcNormal(series.slices.front());
  std::vector<Slices> blocks;
  std::set<std::int64_t> taken;  // places of the last block, in thousandths of mm
  double last = 0;
  for (const auto& [number, slice] : SortByNumber(property, series.slices)) {
    const std::int64_t place = std::llround(1e3 * glm::dot(normal, slice.origin_W));
    const bool repeats = taken.contains(place);
    if (repeats && number == last) return {};
    if (blocks.empty() || repeats) {
      blocks.emplace_back();
      taken.clear();
    }
    blocks.back().push_back(slice);
    taken.insert(place);
    last = number;
  }
  std::vector<DicomSeries> stacks;
  for (const Slices& block : blocks) {
    DicomSeries stack = WithSlices(series, block);
    if (block.size() < kFewestSlices || !IsWhole(stack, series)) return {};
    stack.part_name += fmt::format("{}{} {} to {}", series.part_name.empty() ? "" : ", ", property.name,
                                   property.value(block.front()), property.value(block.back()));
    stacks.push_back(std::move(stack));
  }
  return stacks;
}

// Returns the parts of slices that have the same shape.
std::vector<DicomSeries> DivideByProperties(DicomSeries series) {
  SortSlices(series);
  const bool is_even = IsEven(series);
  const std::vector<Property> properties = ListProperties();
  for (const Property& property : properties) {
    if (is_even && !property.tells_apart) continue;
    std::vector<DicomSeries> stacks = DivideBy(property, series);
    if (!stacks.empty()) return stacks;
  }
  if (RepeatsPlaces(series)) {
    for (const Property& property : properties) {
      if (!property.follows) continue;
      std::vector<DicomSeries> stacks = DivideIntoBlocks(property, series);
      if (!stacks.empty()) return stacks;
    }
  }
  return {std::move(series)};
}

std::vector<DicomSeries> DivideByShape(DicomSeries series) {
  std::vector<Slices> groups;
  for (DicomSlice& s : series.slices) {
    const auto fits = [&s](const Slices& group) { return FindMisfit(s, group.front()).empty(); };
    auto found = std::find_if(groups.begin(), groups.end(), fits);
    if (found == groups.end()) found = groups.insert(groups.end(), Slices());
    found->push_back(std::move(s));
  }
  std::stable_sort(groups.begin(), groups.end(), [](const Slices& a, const Slices& b) { return a.size() > b.size(); });
  const DicomSlice& usual = groups.front().front();
  const auto few =
      std::find_if(groups.begin() + 1, groups.end(), [](const Slices& group) { return group.size() < kFewestSlices; });
  for (auto group = few; group != groups.end(); ++group) {
    for (const DicomSlice& s : *group) {
      const bool turned = s.size == usual.size;
      series.left_out.push_back({s.path, turned ? "another orientation or spacing" : "another size",
                                 fmt::format("{}: {}", s.path, FindMisfit(s, usual)), false});
    }
  }
  std::vector<DicomSeries> parts;
  for (auto group = groups.begin(); group != few; ++group) {
    DicomSeries part = series;
    part.slices = std::move(*group);
    if (few - groups.begin() > 1) {
      const DicomSlice& s = part.slices.front();
      part.part_name += fmt::format("{}{} x {} pixels of {:.4g} mm", part.part_name.empty() ? "" : ", ", s.size[0],
                                    s.size[1], s.pixel_mm[0]);
    }
    for (DicomSeries& stack : DivideByProperties(std::move(part))) parts.push_back(std::move(stack));
  }
  return parts;
}

// Returns a part for each study. One or two slices that name another study are added to the largest.
std::vector<DicomSeries> DivideByStudy(const DicomSeries& series) {
  std::vector<Slices> kept;
  Slices few;
  for (const auto& [study, slices] : GroupBy(series.slices, StudyOf)) {
    if (slices.size() >= kFewestSlices)
      kept.push_back(slices);
    else
      few.insert(few.end(), slices.begin(), slices.end());
  }
  if (kept.empty()) kept.emplace_back();
  const auto largest =
      std::max_element(kept.begin(), kept.end(), [](const Slices& a, const Slices& b) { return a.size() < b.size(); });
  largest->insert(largest->end(), few.begin(), few.end());
  std::vector<DicomSeries> parts;
  for (std::size_t n = 0; n < kept.size(); ++n) {
    DicomSeries& part = parts.emplace_back(series);
    part.slices = std::move(kept[n]);
    if (kept.size() > 1) part.part_name += fmt::format("{}study {}", part.part_name.empty() ? "" : ", ", n + 1);
  }
  return parts;
}

// Returns the slices of each patient. A few slices that name others than the rest are left out.
std::vector<Slices> DivideByPatient(const Slices& slices, std::vector<LeftOutFile>& left_out) {
  std::vector<Slices> persons;
  for (auto& [patient, own] : GroupBy(slices, [](const DicomSlice& s) { return fmt::format("{:x}", s.patient); })) {
    persons.push_back(std::move(own));
  }
  Slices strangers;
  for (const Slices& own : persons) {
    if (own.size() < kFewestSlices) strangers.insert(strangers.end(), own.begin(), own.end());
  }
  if (!AreFew(strangers.size(), slices.size()) || slices.size() < 2 * kFewestSlices) return persons;
  std::erase_if(persons, [](const Slices& own) { return own.size() < kFewestSlices; });
  for (const DicomSlice& s : strangers) {
    left_out.push_back(
        {s.path, "of another patient", fmt::format("{}: names another patient than the other slices", s.path), true});
  }
  return persons;
}

}  // namespace

std::vector<DicomSeries> DivideIntoStacks(DicomSeries series) {
  LeaveOutCopies(series.slices, series.left_out);
  std::vector<DicomSeries> stacks;
  const std::vector<Slices> persons = DivideByPatient(series.slices, series.left_out);
  for (std::size_t p = 0; p < persons.size(); ++p) {
    DicomSeries of_person = series;
    of_person.slices = persons[p];
    if (persons.size() > 1) of_person.part_name = fmt::format("patient {}", p + 1);
    LeaveOutOthers(of_person.slices, of_person.left_out);
    for (DicomSeries& study : DivideByStudy(of_person)) {
      for (DicomSeries& stack : DivideByShape(std::move(study))) stacks.push_back(std::move(stack));
    }
  }
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    DicomSeries& stack = stacks[i];
    if (stacks.size() > 1) stack.part = static_cast<int>(i) + 1;
    stack.modality = stack.slices.front().modality;
    if (IsLocalizer(stack.slices.front())) stack.part_name += stack.part_name.empty() ? "localizer" : ", localizer";
    const auto studies = GroupBy(stack.slices, StudyOf);
    const auto fewest = std::min_element(
        studies.begin(), studies.end(), [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    if (studies.size() < 2) continue;
    stack.warnings.push_back(fmt::format("{} names another study than the other slices, and was read with them",
                                         FileName(fewest->second.front().path)));
  }
  return stacks;
}

std::string FindMisfit(const DicomSlice& slice, const DicomSlice& first) {
  if (slice.size != first.size) {
    return fmt::format("has {} x {} pixels where others have {} x {}; the series is a mixture", slice.size[0],
                       slice.size[1], first.size[0], first.size[1]);
  }
  if (!slice.has_geometry || !first.has_geometry) return "";
  if (glm::length(slice.row_W - first.row_W) > 1e-3 || glm::length(slice.column_W - first.column_W) > 1e-3)
    return "has a different orientation from the others; the series is a mixture";
  if (std::abs(slice.pixel_mm[0] - first.pixel_mm[0]) > 1e-4 || std::abs(slice.pixel_mm[1] - first.pixel_mm[1]) > 1e-4)
    return "has a different pixel spacing from the others; the series is a mixture";
  return "";
}

bool AreFew(std::size_t slices, std::size_t all) {
  return slices <= std::max<std::size_t>(1, all / 10);
}

std::vector<std::string> DescribeLeftOut(const std::vector<LeftOutFile>& files) {
  std::vector<std::pair<std::string, std::vector<std::string>>> kinds;
  for (const LeftOutFile& file : files) {
    auto found = std::find_if(kinds.begin(), kinds.end(), [&](const auto& kind) { return kind.first == file.kind; });
    if (found == kinds.end()) found = kinds.insert(kinds.end(), {file.kind, {}});
    const std::string name = FileName(file.path);
    if (found->second.empty() || found->second.back() != name) found->second.push_back(name);
  }
  std::vector<std::string> sentences;
  for (const auto& [kind, names] : kinds) {
    sentences.push_back(fmt::format("{} left out: {}{} ({})", FormatCount(names.size(), "file was", "files were"),
                                    names.front(),
                                    names.size() == 1 ? "" : fmt::format(" and {} more", names.size() - 1), kind));
  }
  return sentences;
}

double CalcLength(const DicomSeries& series) {
  const std::vector<double> gaps = CalcGaps(series);
  if (gaps.empty()) return static_cast<double>(series.slices.size()) * series.slices.front().thickness_mm;
  double length_mm = series.gap_mm;
  for (const double gap : gaps) length_mm += gap;
  return length_mm;
}

}  // namespace kerf
