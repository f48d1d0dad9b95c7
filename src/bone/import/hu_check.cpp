#include "bone/import/hu_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kerf/error.h"

namespace kerf {

namespace {

constexpr int kLargestLabel = 255;
constexpr std::size_t kMaxLabels = 128;  // whole-body segmentations have about 120
constexpr std::size_t kFewLabels = 16;   // an 8-bit CT has more different values

// A CT whose values are stored 1024 higher than HU. Muscle has 20 to 80 HU, fat -120 to -50, bone more than 300.
constexpr int kOffset = 1024;
constexpr int kSoftFrom = kOffset - 130;
constexpr int kSoftTo = kOffset + 130;
constexpr int kAirTo = kOffset - 800;
constexpr int kBoneFrom = kOffset + 300;
constexpr double kMinSoft = 0.05;  // fractions of the voxels
constexpr double kMinAir = 0.02;
constexpr double kMinBone = 1e-3;
constexpr double kMaxBelow = 1e-3;  // of values that occur only in HU

constexpr double kIso_HU = 300;

struct Histogram {
  static std::size_t IndexOf(int value) {
    const int above_lowest = value + 32768;
    return static_cast<std::size_t>(above_lowest);
  }
  explicit Histogram(const std::vector<std::int16_t>& values) : counts(65536, 0), total(values.size()) {
    for (const std::int16_t v : values) ++counts[IndexOf(v)];
  }
  // Returns the fraction of the values from `from` up to but not including `to`.
  double Fraction(int from, int to) const {
    std::size_t sum = 0;
    for (int v = std::max(from, -32768); v < std::min(to, 32768); ++v) sum += counts[IndexOf(v)];
    return static_cast<double>(sum) / static_cast<double>(std::max<std::size_t>(total, 1));
  }
  // Returns the value below which a fraction of the values above `from` lie.
  int Quantile(double fraction, int from) const {
    const double wanted = fraction * Fraction(from, 32768) * static_cast<double>(total);
    double sum = 0;
    for (int v = from; v < 32767; ++v) {
      sum += static_cast<double>(counts[IndexOf(v)]);
      if (sum > wanted) return v;
    }
    return 32767;
  }
  std::vector<std::size_t> counts;
  std::size_t total;
};

// Returns whether the values are those of a CT without its offset. In such a CT, values below air are padding around
// the scan's circle and are all equal.
bool LacksOffset(const Histogram& h, int lowest) {
  const double padding = lowest < -200 ? h.Fraction(lowest, lowest + 1) : 0;
  const double soft = h.Fraction(kSoftFrom, kSoftTo);
  return h.Fraction(-32768, -200) - padding <= kMaxBelow && h.Fraction(-200, kAirTo) >= kMinAir && soft >= kMinSoft &&
         soft >= 2 * h.Fraction(kAirTo, kSoftFrom) && soft >= h.Fraction(kSoftTo, kBoneFrom) &&
         h.Fraction(kBoneFrom, 32768) >= kMinBone;
}

// Returns whether most values have no region of their own: a voxel whose neighbours along i, j and k equal it. Labels
// have regions; in an 8-bit CT, only the few values of even tissue have, and with noise none.
bool IsContinuous(const Volume& ct, std::size_t different) {
  if (different <= kFewLabels) return false;
  std::vector<bool> has_region(kLargestLabel + 1, false);
  const std::size_t row = static_cast<std::size_t>(ct.size[0]), slice = row * static_cast<std::size_t>(ct.size[1]);
  // The values may be in no lattice, in a test.
  for (std::size_t v = slice; ct.hu.size() == ct.count() && v + slice < ct.hu.size(); ++v) {
    const std::int16_t own = ct.hu[v];
    const bool alone = ct.hu[v - 1] != own || ct.hu[v + 1] != own || ct.hu[v - row] != own || ct.hu[v + row] != own ||
                       ct.hu[v - slice] != own || ct.hu[v + slice] != own;
    if (!alone) has_region[static_cast<std::size_t>(own)] = true;
  }
  const auto regions = static_cast<std::size_t>(std::count(has_region.begin(), has_region.end(), true));
  // Values that follow each other without a gap are those of a CT; labels made of noise have a few.
  return 2 * regions < different && ct.hu.size() == ct.count();
}

bool IsLabelMap(const Volume& ct, const Histogram& histogram, std::size_t& different) {
  const auto [lowest, highest] = std::minmax_element(ct.hu.begin(), ct.hu.end());
  different = static_cast<std::size_t>(
      std::count_if(histogram.counts.begin(), histogram.counts.end(), [](std::size_t n) { return n > 0; }));
  return ct.exact && *lowest >= 0 && *highest <= kLargestLabel && different >= 2 && different <= kMaxLabels;
}

// A part of the histogram between two valleys.
struct Peak {
  double at = 0;    // the most frequent value
  double mass = 0;  // fraction of all voxels
};

// Returns the distance between the values that occur, which is above 1 if they were stored in coarse steps: values in
// steps of 12.8 lie 12 and 13 apart.
double FindStep(const Histogram& h, int lower, int upper) {
  constexpr int kLeastSteps = 50;  // a scan without noise may have few values
  std::vector<int> gaps;
  for (int v = lower, last = lower; v <= upper; ++v) {
    if (h.counts[Histogram::IndexOf(v)] == 0) continue;
    if (v > last) gaps.push_back(v - last);
    last = v;
  }
  std::vector<std::size_t> counts(static_cast<std::size_t>((upper - lower) / kLeastSteps) + 1, 0);
  for (const int gap : gaps) {
    if (static_cast<std::size_t>(gap) < counts.size()) ++counts[static_cast<std::size_t>(gap)];
  }
  const auto usual = static_cast<double>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  if (usual < 2) return 1;
  double sum = 0, steps = 0;
  for (const int gap : gaps) {
    sum += gap;
    steps += std::max(1.0, std::round(gap / usual));
  }
  return sum / steps;
}

// Divides the histogram above `from` at the valleys of its smoothed form. Each bin holds equally many steps.
std::vector<Peak> FindPeaks(const Histogram& h, int from) {
  constexpr int kBins = 200;
  constexpr double kValley = 0.7;  // of the lower of two peaks
  const int lower = h.Quantile(0.0005, from), upper = std::max(h.Quantile(0.9995, from), lower + 1);
  const double step = FindStep(h, lower, upper);
  const double width = step * std::max(1.0, std::round((upper - lower) / step / kBins));
  const double begin = lower - 0.5 * step;
  const auto count = static_cast<std::size_t>((upper - begin) / width) + 5;
  std::vector<double> raw(count, 0);
  for (int v = lower; v <= upper; ++v) {
    raw[static_cast<std::size_t>((v - begin) / width) + 2] +=
        static_cast<double>(h.counts[Histogram::IndexOf(v)]) / static_cast<double>(h.total);
  }
  std::vector<double> smooth = raw;
  for (int pass = 0; pass < 2; ++pass) {
    const std::vector<double> was = smooth;
    for (std::size_t b = 1; b + 1 < count; ++b) smooth[b] = (was[b - 1] + 2 * was[b] + was[b + 1]) / 4;
  }
  std::vector<Peak> peaks;
  std::size_t top = 0, valley = 0;
  double mass = 0, mass_at_valley = 0;
  const auto close = [&](double part) {
    double sum = 0, moment = 0;
    for (std::size_t b = std::max<std::size_t>(top, 2) - 2; b < std::min(top + 3, count); ++b) {
      sum += smooth[b];
      moment += smooth[b] * (begin + (static_cast<double>(b) - 1.5) * width);
    }
    peaks.push_back({sum > 0 ? moment / sum : lower, part});
  };
  for (std::size_t b = 0; b < count; ++b) {
    mass += raw[b];
    if (smooth[b] < smooth[valley]) {
      valley = b;
      mass_at_valley = mass;
    }
    const bool rises = smooth[valley] < kValley * std::min(smooth[top], smooth[b]);
    if (rises) {
      close(mass_at_valley);
      mass -= mass_at_valley;
      top = valley = b;
      mass_at_valley = mass;
    } else if (smooth[b] > smooth[top]) {
      top = valley = b;
      mass_at_valley = mass;
    }
  }
  close(mass);
  return peaks;
}

// The least value if it is far from all others, so that it is padding, or else the air of a scan without noise.
std::optional<int> FindFarValue(const Histogram& h, int lowest) {
  constexpr double kFar = 0.5;  // of the range of the other values
  if (h.Fraction(lowest, lowest + 1) < 0.005 || h.Fraction(lowest + 1, 32768) <= 0) return std::nullopt;
  const int lower = h.Quantile(0.0005, lowest + 1), upper = h.Quantile(0.9995, lowest + 1);
  return lower - lowest > kFar * (upper - lower) ? std::optional(lowest) : std::nullopt;
}

// Returns the two peaks that can be air and soft tissue.
std::optional<GreyScale> FindAirAndSoft(const Histogram& h, int lowest) {
  constexpr double kMinPeak = 0.005, kApart = 0.3, kSameAir = 1.12, kBrightest_HU = 4000;
  const std::optional<int> far = FindFarValue(h, lowest);
  std::vector<Peak> peaks = FindPeaks(h, far ? *far + 1 : lowest);
  std::erase_if(peaks, [](const Peak& peak) { return peak.mass < kMinPeak; });
  if (peaks.empty()) return std::nullopt;
  // HU, whatever is below their air or more frequent than their soft tissue.
  const auto has_peak = [&peaks](double from, double to) {
    return std::any_of(peaks.begin(), peaks.end(), [&](const Peak& peak) { return peak.at >= from && peak.at <= to; });
  };
  if (has_peak(-1150, -850) && has_peak(-200, 280)) return std::nullopt;
  // Soft tissue is what is most above the lowest peak, but no second peak of air, above which nothing would be so
  // bright.
  const int bright = h.Quantile(0.99, lowest);
  auto soft = peaks.end();
  for (auto peak = peaks.begin() + (far || peaks.size() == 1 ? 0 : 1); peak != peaks.end(); ++peak) {
    const double below = peak == peaks.begin() ? far.value_or(lowest) : peaks.front().at;
    if (GreyScale{below, peak->at}.ToHu(bright) > kBrightest_HU) continue;
    if (soft == peaks.end() || peak->mass > soft->mass) soft = peak;
  }
  if (soft == peaks.end()) return std::nullopt;
  if (soft == peaks.begin()) {
    if (!far) return std::nullopt;
    return GreyScale{static_cast<double>(*far), soft->at};
  }
  // Fat lies near muscle, air farther below. Of two peaks of air, the lower one is that around the head.
  auto air = soft - 1;
  while (air != peaks.begin() && soft->at - air->at < kApart * (soft->at - peaks.front().at)) --air;
  while (air != peaks.begin() && soft->at - (air - 1)->at < kSameAir * (soft->at - air->at)) --air;
  return GreyScale{air->at, soft->at};
}

bool IsAirHu(double value) {
  return value >= -1150 && value <= -850;
}

// Returns the scale if the peaks are not those of HU, and there is as much bone above them as in a head.
std::optional<GreyScale> FindGreyScale(const Histogram& h, int lowest, int highest) {
  constexpr double kLeastSoft = 0.1, kLeastSoftAboveHuAir = 0.25, kLeastSoftToAir = 0.5, kMostBone = 0.5;
  constexpr double kAirToPartial = 1.5;
  const std::optional<GreyScale> found = FindAirAndSoft(h, lowest);
  if (!found) return std::nullopt;
  // Air that is no peak, such as that in the pharynx of a padded scan, is more than partly filled voxels.
  const bool has_air = h.Fraction(-1150, -850) > std::max(0.005, kAirToPartial * h.Fraction(-800, -500));
  const bool is_hu = found->soft >= -200 && found->soft <= 280 && (IsAirHu(found->air) || has_air);
  // HU that were limited to a window have a spike at its lower end instead of air.
  const bool is_window = found->soft >= -20 && found->soft <= 110 && lowest >= -900 && lowest < -50 &&
                         h.Fraction(lowest, lowest + 1) > 0.02;
  if (is_hu || is_window) return std::nullopt;
  const double scale = found->CalcScale();
  const bool is_8_bit = lowest >= 0 && highest <= kLargestLabel;
  // In a crop of a CT without air, the peaks are those of fat and muscle, or of muscle and spongy bone.
  if (lowest < -100 && found->air >= -250 && found->soft <= 280) return std::nullopt;
  if (scale > 10 || scale < (is_8_bit ? 0.04 : 0.15)) return std::nullopt;
  const auto at = [&](double hu) {
    return static_cast<int>(std::ceil(std::clamp(found->FromHu(hu), -32768.0, 32768.0)));
  };
  const double bone = h.Fraction(at(kIso_HU), 32768), soft = h.Fraction(at(-300), at(kIso_HU));
  const bool has_bone = bone >= kMinBone && bone <= kMostBone * soft;
  const double least = IsAirHu(found->air) ? kLeastSoftAboveHuAir : kLeastSoft;
  const bool may_be_muscle = !is_8_bit && found->air >= -200 && found->air <= 150 && found->soft <= 450;
  if (may_be_muscle && soft < kLeastSoftToAir * h.Fraction(-32768, at(-300))) return std::nullopt;
  return has_bone && soft >= least ? found : std::nullopt;
}

// Rounds to two digits, for a value that is stated as approximate.
double RoundRoughly(double value) {
  if (std::abs(value) < 10) return std::round(value) + 0.0;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(value))) - 1);
  return std::round(value / unit) * unit + 0.0;
}

std::string DescribeScale(const GreyScale& grey) {
  return fmt::format("these values are not HU: air lies near {:.0f}, soft tissue near {:.0f}, bone from about {:.0f}",
                     RoundRoughly(grey.air), RoundRoughly(grey.soft), RoundRoughly(grey.FromHu(kIso_HU)));
}

void Convert(const GreyScale& grey, Volume& ct) {
  for (std::int16_t& value : ct.hu) {
    value = static_cast<std::int16_t>(std::lround(std::clamp(grey.ToHu(value), -32768.0, 32767.0)));
  }
}

// The scale of values that are no HU, with its description.
struct FoundScale {
  std::optional<GreyScale> grey;
  std::string what;
  std::string advice;  // in place of an option
};

FoundScale FindScale(const Histogram& histogram, int lowest, int highest) {
  constexpr double kSameIso = 60;
  const GreyScale offset{kOffset - 1000.0, kOffset + 40.0};
  FoundScale found{FindGreyScale(histogram, lowest, highest), "", ""};
  if (LacksOffset(histogram, lowest) && (!found.grey || found.grey->air < -1150 ||
                                         std::abs(found.grey->FromHu(kIso_HU) - offset.FromHu(kIso_HU)) < kSameIso)) {
    return {
        offset,
        fmt::format("this is a CT without its offset: air lies near 0 and soft tissue near {}, but "
                    "in HU they lie at -1000 and 0 to 80",
                    kOffset),
        fmt::format("subtract {} from its values, convert the scan again with its rescale intercept, or ", kOffset)};
  }
  if (!found.grey) return found;
  found.what = DescribeScale(*found.grey);
  if (std::abs(found.grey->CalcScale() - 2) < 0.15) {
    found.advice =
        "they lie twice as far apart as in HU, as if the rescale slope were doubled: convert the scan again with its "
        "own slope, or ";
  }
  return found;
}

// Decides what the values are, and does not change them.
BoneLevel Judge(const Volume& ct, double iso, bool automatic, const std::string& name, std::optional<GreyScale>& grey) {
  constexpr double kLeastIso_HU = 130, kMostIso_HU = 2500;  // where a threshold can separate bone
  constexpr double kSameIso = 20;
  BoneLevel level;
  if (!automatic) level.iso = level.iso_hu = iso;
  if (ct.hu.empty()) return level;
  const auto [lowest, highest] = std::minmax_element(ct.hu.begin(), ct.hu.end());
  const Histogram histogram(ct.hu);
  std::size_t different = 0;
  if (IsLabelMap(ct, histogram, different) && !IsContinuous(ct, different)) {
    level.warning = fmt::format("this is a label map, not a CT: its voxels have {} different values from {} to {}",
                                different, *lowest, *highest);
    if (!automatic && iso > *lowest && iso <= *highest) return level;
    throw Error(fmt::format("{}: {}; import it with --mask, with the CT that was segmented or without one", name,
                            level.warning));
  }
  const FoundScale found = FindScale(histogram, *lowest, *highest);
  grey = found.grey;
  if (!grey) return level;
  if (automatic) level.iso = std::round(grey->FromHu(kIso_HU));
  level.iso_hu = grey->ToHu(level.iso);
  level.is_grey = true;
  const bool is_default = !automatic && iso == kIso_HU && std::abs(level.iso_hu - kIso_HU) > kSameIso;
  if (is_default || level.iso_hu < kLeastIso_HU || level.iso_hu > kMostIso_HU) {
    const double proposed = std::round(grey->FromHu(kIso_HU));
    throw NotHu(fmt::format("{}: {}; {}import with --iso auto (threshold {:.0f}) or --iso VALUE; CT numbers of such a "
                            "scan do not give moduli",
                            name, found.what, found.advice, proposed),
                found.what, proposed, *grey);
  }
  level.warning = fmt::format(
      "{}; the bone's surface was taken at {:.0f}{}, and the values were converted to approximate HU by air and soft "
      "tissue, so that cortical bone and teeth are only roughly distinguished and CT numbers do not give moduli",
      found.what, level.iso, automatic ? " (--iso auto)" : "");
  return level;
}

}  // namespace

ValueHistogram CalcHistogram(const Volume& ct, std::size_t bins, const Range& within) {
  constexpr std::size_t kSamples = 1 << 20;
  std::vector<std::int16_t> sample;
  const std::size_t step = ct.hu.size() / kSamples + 1;
  for (std::size_t v = 0; v < ct.hu.size(); v += step) sample.push_back(ct.hu[v]);
  const Histogram counts(sample);
  ValueHistogram histogram{.lower = within.lower, .upper = within.upper, .fractions = std::vector<double>(bins, 0)};
  if (sample.empty()) return histogram;
  histogram.lower = std::min<double>(counts.Quantile(0.01, -32768), within.lower);
  histogram.upper = std::max<double>(counts.Quantile(0.999, -32768), within.upper);
  for (const std::int16_t value : sample) {
    const double at = (value - histogram.lower) / (histogram.upper - histogram.lower) * static_cast<double>(bins);
    if (at < 0 || value > histogram.upper) continue;
    histogram.fractions[std::min(static_cast<std::size_t>(at), bins - 1)] += 1 / static_cast<double>(sample.size());
  }
  return histogram;
}

std::optional<GreyScale> FindGreyScale(const Volume& ct) {
  std::optional<GreyScale> grey;
  try {
    Judge(ct, kIso_HU, true, "", grey);
  } catch (const Error&) {  // a label map
    return std::nullopt;
  }
  return grey;
}

BoneLevel TakeAsHu(Volume& ct, double iso, bool automatic, const std::string& name) {
  std::optional<GreyScale> grey;
  BoneLevel level = Judge(ct, iso, automatic, name, grey);
  if (grey) Convert(*grey, ct);
  return level;
}

std::string CheckHu(const Volume& ct, double iso_hu, const std::string& name) {
  std::optional<GreyScale> grey;
  return Judge(ct, iso_hu, false, name, grey).warning;
}

}  // namespace kerf
