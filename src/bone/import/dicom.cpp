#include "bone/import/dicom.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "base/files/child.h"
#include "bone/import/dicom_division.h"
#include "bone/import/dicom_pixels.h"
#include "bone/import/dicom_stack.h"
#include "bone/import/limits.h"
#include "bone/import/padding.h"
#include "bone/import/unfit_slices.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr ChildLimits kReadingSlices{std::uint64_t{3} << 30, 120};
constexpr std::size_t kMaxDamaged = 3;  // slices at which the library that unpacks them may fail

// Returns which rescale values most of the slices give.
int FindUsualRescale(const std::vector<DicomSlice>& slices) {
  std::map<int, std::size_t> counts;
  for (const DicomSlice& s : slices) ++counts[s.rescale];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// Returns why the slice can't be read as one of a CT with the others; empty if it can.
std::string FindFault(const DicomSlice& s, int usual_rescale, const DicomSlice& first) {
  if (s.samples != 1) return fmt::format("it is a colour image ({} samples per pixel), not CT", s.samples);
  if (s.inverted) return "it is stored for inverted display (MONOCHROME1), not as MONOCHROME2";
  if (!s.fault.empty()) return s.fault;
  if (s.rescale != usual_rescale) {
    const int missing = usual_rescale & ~s.rescale;
    const int named = missing != 0 ? missing : s.rescale & ~usual_rescale;
    return fmt::format("it has {}{}{}{}, unlike the other slices", missing != 0 ? "no " : "",
                       (named & DicomSlice::kHasSlope) != 0 ? "RescaleSlope (0028,1053)" : "",
                       named == (DicomSlice::kHasSlope | DicomSlice::kHasIntercept) ? " and " : "",
                       (named & DicomSlice::kHasIntercept) != 0 ? "RescaleIntercept (0028,1052)" : "");
  }
  if (!s.has_geometry) return "it has no valid position, orientation or pixel spacing";
  const std::string misfit = FindMisfit(s, first);
  return misfit.empty() ? "" : "it " + misfit;
}

// Marks the slices that can't be read as those of a CT with the others. Throws kerf::Error if they are many.
DicomSeries CheckSlices(DicomSeries series) {
  if (series.modality != "CT") {
    throw Error(fmt::format("series {}: the modality is {}, not CT; kerf needs Hounsfield units", series.uid,
                            series.modality.empty() ? "not given" : series.modality));
  }
  const int usual_rescale = FindUsualRescale(series.slices);
  std::map<std::string, const DicomSlice*> firsts;  // of the stacks, of which one is read
  SliceFaults faults;
  for (std::size_t k = 0; k < series.slices.size(); ++k) {
    const DicomSlice& s = series.slices[k];
    if (!s.damage.empty()) continue;
    const std::string fault = FindFault(s, usual_rescale, *firsts.try_emplace(s.stack, &s).first->second);
    if (!fault.empty()) faults[k] = fault;
  }
  MarkFaulty(series, faults, series.slices);
  return series;
}

// Adds the path of a file that can't be read and the fault, each followed by a zero byte.
void AddFault(const DicomSlice& slice, const Error& fault, std::string& faults) {
  faults += slice.path + '\0' + fault.what() + '\0';
}

// Returns the bytes that hold one bit for each pixel of a slice.
std::size_t CalcMaskBytes(std::size_t slice_pixels) {
  return (slice_pixels + 7) / 8;
}

// Reads the slices' HU into `pixels` and what is padding into `padding`, one slice after the other. For a child
// process. Returns the faults.
std::string ReadSlices(const std::vector<DicomSlice>& slices, std::size_t slice_pixels, char* pixels, char* padding,
                       SliceValues& found, ChildReport& report) {
  const std::size_t mask_bytes = CalcMaskBytes(slice_pixels);
  std::string faults;
  HuTable table;
  std::vector<std::int16_t> hu(slice_pixels);
  std::map<std::string, std::vector<std::size_t>> by_path;
  for (std::size_t k = 0; k < slices.size(); ++k) by_path[slices[k].path].push_back(k);
  std::size_t done = 0;
  for (const DicomSlice& next : slices) {
    const auto of_file = by_path.find(next.path);
    if (of_file == by_path.end()) continue;
    report.SetName(next.path);
    try {
      const FilePixels file(next);
      found.behind += file.bytes_behind();
      for (const std::size_t k : of_file->second) {
        table.Convert(file, slices[k], hu, {padding + k * mask_bytes, mask_bytes}, found);
        std::memcpy(pixels + k * slice_pixels * sizeof hu[0], hu.data(), slice_pixels * sizeof hu[0]);
        report.SetProgress(static_cast<double>(++done) / static_cast<double>(slices.size()));
      }
    } catch (const Error& e) {
      AddFault(next, e, faults);
    }
    by_path.erase(of_file);
  }
  return faults;
}

// Marks the slices of these files as damaged. Throws kerf::Error if they are no others than before.
void MarkDamaged(const std::string& faults, DicomSeries& series) {
  bool any = false;
  std::istringstream in(faults);
  for (std::string path, fault; std::getline(in, path, '\0') && std::getline(in, fault, '\0');) {
    for (DicomSlice& s : series.slices) {
      if (s.path != path || !s.damage.empty()) continue;
      s.damage = fault;
      any = true;
    }
  }
  if (!any) throw Error(fmt::format("series {}: the process that read the slices sent invalid data", series.uid));
}

// Marks the slices of the series.
void MarkDamaged(const SliceFaults& faults, SliceStack& stack, DicomSeries& series) {
  MarkFaulty(series, faults, stack.slices);
  for (const auto& [k, why] : faults) {
    const DicomSlice& marked = stack.slices[k];
    for (DicomSlice& s : series.slices) {
      if (s.path != marked.path || s.frame != marked.frame) continue;
      s.fault = marked.fault;
      s.damage = marked.damage;
    }
  }
}

// Names slices that may be damaged. They are kept.
void WarnOfDoubtful(const SliceFaults& doubtful, const SliceStack& stack, Volume& volume) {
  if (doubtful.empty()) return;
  const auto& [k, why] = *doubtful.begin();
  volume.warnings.push_back(fmt::format(
      "{}{} may be damaged: {}; metal and motion do the same, so that what it shows was kept: look at the bone there",
      NameOf(stack.slices[k]), doubtful.size() == 1 ? "" : fmt::format(" and {} others", doubtful.size() - 1), why));
}

// Fills the planes of the volume from the slices at their places, interpolating between two.
void FillPlanes(const SliceStack& stack, const char* pixels, Volume& volume) {
  const std::size_t n = static_cast<std::size_t>(volume.size[0]) * volume.size[1];
  const auto* const hu = reinterpret_cast<const std::int16_t*>(pixels);
  volume.hu.resize(volume.count());
  for (std::size_t plane = 0; plane < stack.places.size(); ++plane) {
    const double below = std::floor(stack.places[plane]);
    const double fraction = stack.places[plane] - below;
    const std::int16_t* const a = hu + static_cast<std::size_t>(below) * n;
    std::int16_t* const out = &volume.hu[plane * n];
    if (fraction == 0) {
      std::memcpy(out, a, n * sizeof *a);
      continue;
    }
    for (std::size_t v = 0; v < n; ++v) {
      out[v] = static_cast<std::int16_t>(std::lround((1 - fraction) * a[v] + fraction * a[v + n]));
    }
  }
}

// Marks the voxels that are padding in a slice beside them.
void MarkPadding(const SliceStack& stack, const char* padding, Volume& volume) {
  const std::size_t n = static_cast<std::size_t>(volume.size[0]) * volume.size[1];
  volume.padding.resize(volume.count());
  for (std::size_t plane = 0; plane < stack.places.size(); ++plane) {
    for (const double place : {std::floor(stack.places[plane]), std::ceil(stack.places[plane])}) {
      const char* const mask = padding + static_cast<std::size_t>(place) * CalcMaskBytes(n);
      for (std::size_t v = 0; v < n; ++v) {
        if ((mask[v / 8] >> v % 8 & 1) != 0) volume.padding[plane * n + v] = true;
      }
    }
  }
}

// Makes untagged padding air, and describes values that were clamped or taken as air.
void WarnOfValues(const SliceValues& found, Volume& volume) {
  if (found.padding > 0) {
    volume.warnings.push_back(fmt::format("{} voxels that are stored as {} are padding and were taken as air",
                                          found.padding, found.padding_value));
  }
  if (found.behind > 0) {
    volume.warnings.push_back(fmt::format(
        "the slices have {} bytes more than their rows and columns need, which were ignored", found.behind));
  }
  const std::size_t cleared = ClearPadding(volume);
  if (found.overflow > cleared) {
    volume.warnings.push_back(Describe(Overflow{.count = found.overflow, .extreme = found.extreme}, volume.count()));
  }
}

// Reads a series. If slices turn out to be damaged, it marks them and returns nothing.
std::optional<Volume> ReadWhole(const std::function<void(double)>& progress, double spacing_z_mm, DicomSeries& series) {
  std::string faults;
  SliceStack stack = PlaceSlices(CheckSlices(series), spacing_z_mm);
  const DicomSlice& first = stack.slices.front();
  Volume volume;
  volume.size = {first.size[0], first.size[1], static_cast<int>(stack.places.size())};
  volume.origin_W = stack.origin_W;
  const double step_mm = glm::length(stack.step_W);
  volume.spacing_mm = {first.pixel_mm[0], first.pixel_mm[1], step_mm};
  volume.axes_W = glm::dmat3(first.row_W, first.column_W, stack.step_W / step_mm);
  volume.warnings = stack.warnings;
  volume.gaps = stack.gaps;
  CheckLattice(volume, fmt::format("series {}", series.uid));
  const std::size_t slice_pixels = static_cast<std::size_t>(first.size[0]) * first.size[1];
  if (std::max(volume.count(), slice_pixels * stack.slices.size()) > kMaxVoxels) {
    throw Error(fmt::format("series {}: {} x {} x {} voxels, more than the 2^31 that kerf reads", series.uid,
                            volume.size[0], volume.size[1], volume.size[2]));
  }
  for (const DicomSlice& slice : stack.slices) {
    if (&slice != &first && slice.path == (&slice - 1)->path) continue;
    try {
      CheckFileSize(slice);
    } catch (const Error& e) {
      AddFault(slice, e, faults);
    }
  }
  if (!faults.empty()) {
    MarkDamaged(faults, series);
    return std::nullopt;
  }
  const SharedMemory pixels(slice_pixels * stack.slices.size() * sizeof(std::int16_t));
  const SharedMemory padding(CalcMaskBytes(slice_pixels) * stack.slices.size());
  const SharedMemory values(sizeof(SliceValues));
  const auto read = [&](ChildReport& report) {
    SliceValues found;
    std::string unread = ReadSlices(stack.slices, slice_pixels, pixels.data(), padding.data(), found, report);
    std::memcpy(values.data(), &found, sizeof found);
    return unread;
  };
  try {
    faults = RunInChild(first.path, kReadingSlices, read, progress);
  } catch (const Error& e) {
    // The library may have failed at a file.
    const auto failed = std::find_if(stack.slices.begin(), stack.slices.end(), [&e](const DicomSlice& s) {
      return std::string_view(e.what()).starts_with(s.path + ": ");
    });
    if (failed == stack.slices.end() || stack.damaged.size() >= kMaxDamaged) throw;
    AddFault(*failed, e, faults);
  }
  if (!faults.empty()) MarkDamaged(faults, series);
  const UnfitSlices unfit = faults.empty()
                                ? FindUnfitSlices(stack.slices, reinterpret_cast<const std::int16_t*>(pixels.data()))
                                : UnfitSlices();
  MarkDamaged(unfit.damaged, stack, series);
  if (!faults.empty() || !unfit.damaged.empty()) return std::nullopt;
  WarnOfDoubtful(unfit.doubtful, stack, volume);
  FillPlanes(stack, pixels.data(), volume);
  SliceValues found;
  std::memcpy(&found, values.data(), sizeof found);
  if (found.is_marked) MarkPadding(stack, padding.data(), volume);
  WarnOfValues(found, volume);
  return volume;
}

}  // namespace

Vec3 CalcNormal(const DicomSlice& slice) {
  return glm::normalize(glm::cross(slice.row_W, slice.column_W));
}

DicomSeries CheckSeries(const DicomSeries& series, double spacing_z_mm) {
  DicomSeries placed = CheckSlices(series);
  SliceStack stack = PlaceSlices(placed, spacing_z_mm);
  placed.slices = std::move(stack.slices);
  placed.warnings.insert(placed.warnings.end(), stack.warnings.begin(), stack.warnings.end());
  return placed;
}

Volume ReadDicomSeries(const DicomSeries& series, const std::function<void(double)>& progress, double spacing_z_mm) {
  DicomSeries marked = series;
  std::optional<Volume> volume;
  while (!volume) volume = ReadWhole(progress, spacing_z_mm, marked);
  return std::move(*volume);
}

}  // namespace kerf
