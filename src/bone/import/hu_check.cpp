#include "bone/import/hu_check.h"

#include <fmt/format.h>

#include <algorithm>

#include "kerf/error.h"

namespace kerf {

namespace {

constexpr int kLargestLabel = 255;
constexpr std::size_t kMaxLabels = 128;  // whole-body segmentations have about 120

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
    for (int v = from; v < to; ++v) sum += counts[IndexOf(v)];
    return static_cast<double>(sum) / static_cast<double>(std::max<std::size_t>(total, 1));
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

}  // namespace

std::string CheckHu(const Volume& ct, double iso_hu, const std::string& name) {
  if (ct.hu.empty()) return "";
  const auto [lowest, highest] = std::minmax_element(ct.hu.begin(), ct.hu.end());
  const Histogram histogram(ct.hu);
  const auto different = static_cast<std::size_t>(
      std::count_if(histogram.counts.begin(), histogram.counts.end(), [](std::size_t n) { return n > 0; }));
  if (*lowest >= 0 && *highest <= kLargestLabel && different >= 2 && different <= kMaxLabels) {
    std::string what = fmt::format("this is a label map, not a CT: its voxels have {} different values from {} to {}",
                                   different, *lowest, *highest);
    if (iso_hu > *lowest && iso_hu <= *highest) return what;
    throw Error(
        fmt::format("{}: {}; import it with --mask, with the CT that was segmented or without one", name, what));
  }
  if (LacksOffset(histogram, *lowest)) {
    std::string what = fmt::format(
        "this is a CT without its offset: air lies near 0 and soft tissue near {}, but "
        "in HU they lie at -1000 and 0 to 80",
        kOffset);
    if (iso_hu >= kSoftTo) return what;
    throw NotHu(fmt::format("{}: {}; subtract {} from its values, or convert the scan again with its rescale intercept",
                            name, what, kOffset),
                what, kBoneFrom);
  }
  return "";
}

}  // namespace kerf
