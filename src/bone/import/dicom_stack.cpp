#include "bone/import/dicom_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>

#include "base/core/number_text.h"
#include "base/core/printable.h"
#include "bone/import/dicom_division.h"
#include "kerf/error.h"

namespace kerf {

namespace {

[[noreturn]] void RefuseSeries(const DicomSeries& series, const std::string& what) {
  throw Error(fmt::format("series {}: {}", series.uid, what));
}

// Slices `first` to `last` with equal steps.
struct EvenRun {
  std::size_t first = 0, last = 0;
  double step_mm = 0;
};

// Scanners round positions to about 0.01 mm.
bool IsStep(double step_mm, double expected_mm) {
  return std::abs(step_mm - expected_mm) <= std::max(0.02 * expected_mm, 0.02);
}

// Leaves out all but the stack with the most slices.
void KeepLargestStack(SliceStack& stack) {
  std::map<std::string, std::size_t> sizes;
  for (const DicomSlice& s : stack.slices) ++sizes[s.stack];
  if (sizes.size() < 2) return;
  const auto largest =
      std::max_element(sizes.begin(), sizes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const std::string kept = largest->first;
  std::string others;
  for (const auto& [name, size] : sizes) {
    if (name != kept) others += fmt::format("{}'{}' ({})", others.empty() ? "" : ", ", name, size);
  }
  stack.warnings.push_back(
      fmt::format("the scan has several stacks: '{}' with {} was taken and the others left out: {}", kept,
                  FormatCount(largest->second, "slice", "slices"), others));
  std::erase_if(stack.slices, [&kept](const DicomSlice& s) { return s.stack != kept; });
}

// Returns which element gives the distance between frames, and the one that contradicts it.
std::string DescribeSpacing(const DicomSlice& slice, double spacing_mm) {
  if (slice.thickness_mm == 0 || IsStep(spacing_mm, slice.thickness_mm)) return slice.spacing_from;
  return fmt::format("{}, although SliceThickness (0018,0050) is {:.4g} mm", slice.spacing_from, slice.thickness_mm);
}

// Places frames without positions, and states what was assumed.
void PlaceFrames(const DicomSeries& series, double spacing_z_mm, SliceStack& stack) {
  if (std::any_of(stack.slices.begin(), stack.slices.end(), [](const DicomSlice& s) { return !s.has_orientation; })) {
    stack.warnings.emplace_back(
        "the file gives no ImageOrientationPatient (0020,0037): rows were taken from right to left and columns from "
        "front to back; check the sides of the bone, and correct them with --frame");
  }
  const auto assumed = std::find_if(stack.slices.begin(), stack.slices.end(),
                                    [](const DicomSlice& s) { return !s.spacing_from.empty(); });
  if (assumed == stack.slices.end()) {
    if (spacing_z_mm != 0) {
      RefuseSeries(series, "its files state where the slices lie; leave out --spacing-z");
    }
    return;
  }
  const std::string file = Printable(std::filesystem::path(assumed->path).filename().string());
  if (!assumed->has_spacing && spacing_z_mm == 0) {
    RefuseSeries(series, fmt::format("{} gives neither the positions of its {} frames nor their distance, by "
                                     "SliceThickness (0018,0050) or SpacingBetweenSlices (0018,0088); state it in mm "
                                     "with --spacing-z",
                                     file, assumed->frames));
  }
  const Vec3 normal = CalcNormal(*assumed);
  double spacing = spacing_z_mm;
  if (spacing_z_mm != 0) {
    std::map<std::string, Vec3> firsts_W;  // by file
    for (const DicomSlice& s : stack.slices) {
      if (s.frame == 0) firsts_W[s.path] = s.origin_W;
    }
    for (DicomSlice& s : stack.slices) {
      // Undoes the placing by the file's own distance, which lies along the normal.
      if (!s.spacing_from.empty()) s.origin_W = firsts_W[s.path] + normal * (spacing_z_mm * s.frame);
    }
  } else {
    const auto other = std::find_if(stack.slices.begin(), stack.slices.end(), [&](const DicomSlice& s) {
      return s.path == assumed->path && s.frame != assumed->frame;
    });
    if (other != stack.slices.end())
      spacing = glm::length(other->origin_W - assumed->origin_W) / std::abs(other->frame - assumed->frame);
  }
  if (assumed->has_orientation) {
    stack.warnings.emplace_back(
        "the frames were placed in their order along the normal of their plane; check the sides of the bone, and "
        "correct them with --frame");
  } else {
    stack.warnings.emplace_back(
        "the frames were placed from the feet to the head; check the sides of the bone, and correct them with --frame");
  }
  if (spacing_z_mm != 0) return;
  stack.warnings.push_back(fmt::format(
      "the file {} gives no positions of its {} frames: they are assumed to be {:.4g} mm apart, by {}; check "
      "the size of the bone, and correct it with --spacing-z",
      file, assumed->frames, spacing, DescribeSpacing(*assumed, spacing)));
}

std::vector<double> CalcPlaces(const std::vector<DicomSlice>& slices) {
  const Vec3 normal = CalcNormal(slices.front());
  std::vector<double> places;
  places.reserve(slices.size());
  for (const DicomSlice& s : slices) places.push_back(glm::dot(normal, s.origin_W));
  return places;
}

// Returns the median; of an even number of values, the mean of the two in the middle.
double CalcMedian(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return values.size() % 2 != 0 ? *middle : 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double CalcMedianStep(const std::vector<double>& z) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < z.size(); ++i) steps.push_back(z[i] - z[i - 1]);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

std::string DescribePair(const SliceStack& stack, std::size_t i) {
  return fmt::format("{} and {}", NameOf(stack.slices[i - 1]), NameOf(stack.slices[i]));
}

// Returns runs of at least three equal steps.
std::vector<EvenRun> FindRuns(const std::vector<double>& z) {
  std::vector<EvenRun> runs;
  for (std::size_t i = 0; i + 1 < z.size();) {
    std::size_t j = i + 1;
    while (j + 1 < z.size() && IsStep(z[j + 1] - z[j], z[i + 1] - z[i])) ++j;
    if (j - i >= 3) runs.push_back({i, j, (z[j] - z[i]) / static_cast<double>(j - i)});
    i = j;
  }
  return runs;
}

const EvenRun& FindLongest(const std::vector<EvenRun>& runs) {
  return *std::max_element(runs.begin(), runs.end(),
                           [](const auto& a, const auto& b) { return a.last - a.first < b.last - b.first; });
}

// If the places are even but for rounding, places the planes on the line that fits them best.
bool FitRounded(const std::vector<double>& z, double median_mm, SliceStack& stack) {
  const std::size_t n = z.size();
  if (n < 6) return false;  // a missing slice would look like rounding
  // So would many: steps that are multiples of the shortest.
  std::vector<double> steps;
  for (std::size_t k = 1; k < n; ++k) steps.push_back(z[k] - z[k - 1]);
  const auto [shortest, longest] = std::minmax_element(steps.begin(), steps.end());
  const bool whole = std::all_of(steps.begin(), steps.end(), [step = *shortest](double s) {
    return std::abs(s / step - std::round(s / step)) < 0.05;
  });
  if (whole && *longest > 1.5 * *shortest) return false;
  const double middle = 0.5 * static_cast<double>(n - 1);
  double sum = 0, moment = 0, weight = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double from_middle = static_cast<double>(k) - middle;
    sum += z[k];
    moment += from_middle * z[k];
    weight += from_middle * from_middle;
  }
  const double step = moment / weight;
  const double start = sum / static_cast<double>(n) - step * middle;
  double error = 0;
  for (std::size_t k = 0; k < n; ++k) error = std::max(error, std::abs(z[k] - start - step * static_cast<double>(k)));
  if (!(error < 0.25 * step)) return false;
  const Vec3 along = (stack.slices.back().origin_W - stack.slices.front().origin_W) / (z.back() - z.front());
  stack.origin_W = stack.slices.front().origin_W + along * (start - z.front());
  stack.step_W = along * step;
  for (std::size_t k = 0; k < n; ++k) stack.places.push_back(static_cast<double>(k));
  stack.warnings.push_back(
      fmt::format("the positions of the slices are rounded: their steps differ from {:.4g} mm, by up to {:.2g} mm, and "
                  "were made even; no slice moves by more than {:.2g} mm",
                  step, std::abs(median_mm - step) > error ? std::abs(median_mm - step) : 2 * error, error));
  return true;
}

std::string DescribeGap(const SliceStack& stack, const std::vector<double>& z, std::size_t i, double step_mm) {
  const double missing = std::max(1.0, std::round((z[i] - z[i - 1]) / step_mm) - 1);
  return fmt::format("{} missing between {} (at {:.2f} and {:.2f} mm; slices elsewhere are {:.2f} mm apart)",
                     FormatCount(static_cast<std::size_t>(missing), "slice is", "slices are"), DescribePair(stack, i),
                     z[i - 1], z[i], step_mm);
}

// Returns a damaged slice between two places; nullptr: there is none.
const DicomSlice* FindDamaged(const SliceStack& stack, double from_mm, double to_mm) {
  const Vec3 normal = CalcNormal(stack.slices.front());
  const auto damaged = std::find_if(stack.damaged.begin(), stack.damaged.end(), [&](const DicomSlice& s) {
    const double at_mm = glm::dot(normal, s.origin_W);
    return at_mm > from_mm && at_mm < to_mm;
  });
  return damaged == stack.damaged.end() ? nullptr : &*damaged;
}

// Returns why slices are missing between two places: the fault of a file there, or of one whose place is unknown.
std::string DescribeReason(const DicomSeries& series, const SliceStack& stack, double from_mm, double to_mm) {
  if (const DicomSlice* damaged = FindDamaged(stack, from_mm, to_mm)) return "; " + damaged->damage;
  const auto file = std::find_if(series.left_out.begin(), series.left_out.end(),
                                 [](const LeftOutFile& left_out) { return left_out.may_be_slice; });
  return file == series.left_out.end() ? "" : "; perhaps " + file->fault;
}

// Lists the steps over a damaged slice, and those that are neither those of a run nor between two spacings. Throws
// kerf::Error for one that no missing slices explain.
std::vector<std::size_t> FindGaps(const DicomSeries& series, const SliceStack& stack, const std::vector<double>& z,
                                  const std::vector<EvenRun>& runs) {
  std::vector<std::size_t> gaps;
  const double median = CalcMedianStep(z);
  for (std::size_t i = 1; i < z.size(); ++i) {
    const double step = z[i] - z[i - 1];
    if (!runs.empty() && FindDamaged(stack, z[i - 1], z[i]) != nullptr) {
      gaps.push_back(i);
      continue;
    }
    double before = 0, after = 0;  // spacing of the nearest runs
    for (const EvenRun& run : runs) {
      if (run.first <= i - 1) before = run.step_mm;
      if (run.last >= i && after == 0) after = run.step_mm;
    }
    if (before == 0) before = after;
    if (after == 0) after = before;
    const double finer = std::min(before, after);
    const double coarser = std::max(before, after);
    if (before > 0 ? IsStep(step, before) || IsStep(step, after) : IsStep(step, median)) continue;
    if (before > 0 && !IsStep(before, after) && step < 1.05 * coarser) continue;
    if (before > 0 && step > 1.5 * coarser) {
      gaps.push_back(i);
      continue;
    }
    const double multiple = step / median;
    if (multiple > 1.5 && std::abs(multiple - std::round(multiple)) < 0.1) {
      RefuseSeries(series, DescribeGap(stack, z, i, median) + DescribeReason(series, stack, z[i - 1], z[i]));
    }
    RefuseSeries(series, fmt::format("the slices are unequally spaced: {:.2f} mm between {}, {:.2f} mm elsewhere; "
                                     "resample the scan evenly",
                                     step, DescribePair(stack, i), finer > 0 ? finer : median));
  }
  return gaps;
}

void AddGap(const DicomSeries& series, double from_mm, double to_mm, const std::string& what, SliceStack& stack) {
  stack.gaps.push_back(
      {CalcNormal(stack.slices.front()), from_mm, to_mm, fmt::format("series {}: {}", series.uid, what)});
}

// Leaves out what lies beyond a gap that is too wide to be interpolated, and then the gaps there.
void CutAtWideGaps(const DicomSeries& series, double step_mm, SliceStack& stack, std::vector<double>& z,
                   std::vector<std::size_t>& gaps) {
  constexpr double kCutGap_mm = 10;
  std::vector<std::size_t> ends;  // first slices of the parts, and the end
  ends.push_back(0);
  for (const std::size_t i : gaps) {
    if (z[i] - z[i - 1] > std::max(kCutGap_mm, 3 * step_mm)) ends.push_back(i);
  }
  ends.push_back(z.size());
  if (ends.size() == 2) return;
  std::size_t best = 0;
  for (std::size_t p = 1; p + 1 < ends.size(); ++p) {
    if (ends[p + 1] - ends[p] > ends[best + 1] - ends[best]) best = p;
  }
  const std::size_t first = ends[best];
  const std::size_t last = ends[best + 1];
  for (const std::size_t i : {first, last}) {
    if (i == 0 || i == z.size()) continue;
    const std::string what = DescribeGap(stack, z, i, step_mm);
    stack.warnings.push_back(fmt::format("{}; only the {} on the larger side were read", what,
                                         FormatCount(last - first, "slice", "slices")));
    const double edge_mm = z[i == first ? i : i - 1];
    AddGap(series, edge_mm, edge_mm, what + DescribeReason(series, stack, z[i - 1], z[i]), stack);
  }
  std::erase_if(gaps, [&](std::size_t i) { return i <= first || i >= last; });
  for (std::size_t& i : gaps) i -= first;
  stack.slices = {stack.slices.begin() + static_cast<std::ptrdiff_t>(first),
                  stack.slices.begin() + static_cast<std::ptrdiff_t>(last)};
  z = {z.begin() + static_cast<std::ptrdiff_t>(first), z.begin() + static_cast<std::ptrdiff_t>(last)};
}

// Places planes evenly, one at each slice of the finest run, over all slices.
void Resample(const DicomSeries& series, const std::vector<EvenRun>& runs, std::vector<double> z, SliceStack& stack) {
  constexpr double kMaxMore = 8;  // planes per slice
  std::vector<std::size_t> gaps = FindGaps(series, stack, z, runs);
  const auto length = [](const EvenRun& run) { return run.last - run.first; };
  EvenRun finest = FindLongest(runs);
  for (const EvenRun& run : runs) {
    if (4 * length(run) >= z.size() && run.step_mm < finest.step_mm) finest = run;
  }
  const double step = finest.step_mm;
  const double anchor = z[finest.first];
  const bool two_spacings =
      std::any_of(runs.begin(), runs.end(), [&](const auto& run) { return !IsStep(run.step_mm, step); });
  CutAtWideGaps(series, step, stack, z, gaps);
  for (const std::size_t i : gaps) {
    const std::string what = DescribeGap(stack, z, i, step);
    stack.warnings.push_back(what + "; the gap was interpolated");
    AddGap(series, z[i - 1], z[i], what + DescribeReason(series, stack, z[i - 1], z[i]), stack);
  }
  if (two_spacings) {
    stack.warnings.push_back(fmt::format(
        "the slices are {:.2f} mm apart between {:.2f} and {:.2f} mm along their normal, and farther or nearer "
        "elsewhere; all were resampled to {:.2f} mm by linear interpolation, so that the bone is less exact elsewhere",
        step, anchor, anchor + step * static_cast<double>(length(finest)), step));
  }
  const double slack = std::max(0.02 * step, 0.02);
  const double before = std::floor((anchor - z.front() + slack) / step);
  const double after = std::floor((z.back() + slack - anchor) / step);
  if (!(before + after + 1 <= kMaxMore * static_cast<double>(z.size())) || before + after < 2) {
    RefuseSeries(
        series, fmt::format("the slices are unequally spaced, from {:.2f} to {:.2f} mm; resample the scan evenly", step,
                            z.back() - z.front()));
  }
  const Vec3 along = (stack.slices.back().origin_W - stack.slices.front().origin_W) / (z.back() - z.front());
  stack.step_W = along * step;
  stack.origin_W = stack.slices.front().origin_W + along * (anchor - before * step - z.front());
  std::size_t i = 1;
  for (double k = -before; k <= after; ++k) {
    const double at = std::clamp(anchor + k * step, z.front(), z.back());
    while (i + 1 < z.size() && z[i] < at) ++i;
    double place = static_cast<double>(i - 1) + (at - z[i - 1]) / (z[i] - z[i - 1]);
    if (at - z[i - 1] <= slack) place = static_cast<double>(i - 1);
    if (z[i] - at <= slack) place = static_cast<double>(i);
    stack.places.push_back(place);
  }
}

// Leaves out damaged slices. Throws kerf::Error if too few are left.
void LeaveOutDamaged(const DicomSeries& series, SliceStack& stack) {
  std::vector<LeftOutFile> files;
  for (const DicomSlice& s : stack.slices) {
    if (s.damage.empty()) continue;
    stack.damaged.push_back(s);
    files.push_back(s.fault.empty() ? LeftOutFile{s.path, "cut off or damaged", s.damage, true}
                                    : LeftOutFile{NameOf(s), s.fault, s.damage, true});
  }
  std::erase_if(stack.slices, [](const DicomSlice& s) { return !s.damage.empty(); });
  if (stack.slices.size() < 3) {
    if (!files.empty()) throw Error(files.front().fault);
    RefuseSeries(series, fmt::format("{} not a volume; kerf needs at least 3",
                                     FormatCount(stack.slices.size(), "slice is", "slices are")));
  }
  for (const std::string& warning : DescribeLeftOut(files)) stack.warnings.push_back(warning);
}

// Finds slices that lie at the same place.
SliceFaults FindRepeated(const SliceStack& stack, const std::vector<double>& z) {
  SliceFaults faults;
  for (std::size_t i = 1; i < z.size(); ++i) {
    if (z[i] - z[i - 1] >= 1e-3) continue;
    const std::string what =
        fmt::format("{} lie at the same place ({:.2f} mm along the normal)", DescribePair(stack, i), z[i - 1]);
    faults.emplace(i - 1, what);
    faults.emplace(i, what);
  }
  return faults;
}

// Finds slices beside the line of the others, whose direction is the median of those between slices that lie half the
// stack apart.
SliceFaults FindSideways(const SliceStack& stack, const std::vector<double>& z) {
  const std::vector<DicomSlice>& slices = stack.slices;
  const std::size_t half = z.size() / 2;
  Vec3 along, start;
  for (int a = 0; a < 3; ++a) {
    std::vector<double> slopes, starts;
    for (std::size_t k = half; k < z.size(); ++k) {
      slopes.push_back((slices[k].origin_W[a] - slices[k - half].origin_W[a]) / (z[k] - z[k - half]));
    }
    along[a] = CalcMedian(slopes);
    for (std::size_t k = 0; k < z.size(); ++k) starts.push_back(slices[k].origin_W[a] - along[a] * z[k]);
    start[a] = CalcMedian(starts);
  }
  const DicomSlice& first = slices.front();
  const Vec3 normal = CalcNormal(first);
  SliceFaults faults;
  for (std::size_t k = 0; k < z.size(); ++k) {
    const Vec3 off = slices[k].origin_W - start - along * z[k];
    const double sideways = glm::length(off - normal * glm::dot(off, normal));
    if (sideways > 0.5 * std::min(first.pixel_mm[0], first.pixel_mm[1]))
      faults[k] = fmt::format("it is shifted sideways by {:.2f} mm relative to the others", sideways);
  }
  return faults;
}

// Finds a few slices that belong to no run and lie between the even places of the others.
SliceFaults FindStrays(const std::vector<double>& z) {
  const std::vector<EvenRun> runs = FindRuns(z);
  SliceFaults faults;
  if (runs.empty()) return faults;
  const EvenRun& run = FindLongest(runs);
  for (std::size_t k = 0; k < z.size(); ++k) {
    const double off = std::remainder(z[k] - z[run.first], run.step_mm);
    const bool in_run =
        std::any_of(runs.begin(), runs.end(), [k](const EvenRun& r) { return k >= r.first && k <= r.last; });
    if (!in_run && std::abs(off) > 0.1 * run.step_mm)
      faults[k] = fmt::format("it lies {:.2f} mm beside the even places of the others", std::abs(off));
  }
  const bool alike =
      std::all_of(runs.begin(), runs.end(), [&](const EvenRun& r) { return IsStep(r.step_mm, run.step_mm); });
  return alike && AreFew(faults.size(), z.size()) ? faults : SliceFaults();
}

bool AreEven(const std::vector<double>& z) {
  const double median = CalcMedianStep(z);
  for (std::size_t i = 1; i < z.size(); ++i) {
    if (!IsStep(z[i] - z[i - 1], median)) return false;
  }
  return true;
}

}  // namespace

std::string NameOf(const DicomSlice& slice) {
  const std::string file = Printable(std::filesystem::path(slice.path).filename().string());
  return slice.frames == 1 ? file : fmt::format("{} (frame {})", file, slice.frame + 1);
}

void MarkFaulty(const DicomSeries& series, const SliceFaults& faults, std::vector<DicomSlice>& slices) {
  if (faults.empty()) return;
  if (!AreFew(faults.size(), slices.size())) {
    const auto& [k, fault] = *faults.begin();
    RefuseSeries(series, fmt::format("{} of its {} slices can't be read, such as {}: {}; export the series again",
                                     faults.size(), slices.size(), NameOf(slices[k]), fault));
  }
  for (const auto& [k, fault] : faults) {
    slices[k].fault = fault;
    slices[k].damage = fmt::format("{}: {}", slices[k].path, fault);
  }
}

SliceStack PlaceSlices(const DicomSeries& series, double spacing_z_mm) {
  SliceStack stack;
  stack.slices = series.slices;
  KeepLargestStack(stack);
  PlaceFrames(series, spacing_z_mm, stack);
  LeaveOutDamaged(series, stack);
  const Vec3 normal = CalcNormal(stack.slices.front());
  std::stable_sort(stack.slices.begin(), stack.slices.end(), [&normal](const DicomSlice& a, const DicomSlice& b) {
    return glm::dot(normal, a.origin_W) < glm::dot(normal, b.origin_W);
  });
  std::vector<double> z = CalcPlaces(stack.slices);
  const auto leave_out = [&](const SliceFaults& faults) {
    MarkFaulty(series, faults, stack.slices);
    LeaveOutDamaged(series, stack);
    z = CalcPlaces(stack.slices);
  };
  leave_out(FindRepeated(stack, z));
  leave_out(FindSideways(stack, z));
  const bool rounded = !AreEven(z) && FitRounded(z, CalcMedianStep(z), stack);
  if (!rounded) leave_out(FindStrays(z));
  for (const DicomSlice& s : stack.damaged) {
    const double at_mm = glm::dot(normal, s.origin_W);
    if (at_mm < z.front()) AddGap(series, z.front(), z.front(), s.damage, stack);
    if (at_mm > z.back()) AddGap(series, z.back(), z.back(), s.damage, stack);
  }
  if (rounded) return stack;
  if (AreEven(z)) {
    stack.origin_W = stack.slices.front().origin_W;
    stack.step_W =
        (stack.slices.back().origin_W - stack.slices.front().origin_W) / static_cast<double>(stack.slices.size() - 1);
    for (std::size_t k = 0; k < z.size(); ++k) stack.places.push_back(static_cast<double>(k));
    return stack;
  }
  const std::vector<EvenRun> runs = FindRuns(z);
  if (runs.empty()) {
    FindGaps(series, stack, z, runs);  // throws for the first uneven step
    RefuseSeries(series, "the slices are unequally spaced; resample the scan evenly");
  }
  Resample(series, runs, z, stack);
  return stack;
}

}  // namespace kerf
