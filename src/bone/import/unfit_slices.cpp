#include "bone/import/unfit_slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <set>

namespace kerf {

namespace {

constexpr double kShown_HU = 300;      // range of a row that shows something
constexpr double kMinSpread_HU = 100;  // standard deviation of a slice that shows a patient

// The values of a series, slice by slice, and a sample of each slice, limited to a range in which metal does not
// outweigh all else: every n-th pixel of every n-th row.
class SliceSamples {
 public:
  SliceSamples(const std::array<int, 2>& size, std::size_t count, const std::int16_t* hu)
      : columns_(static_cast<std::size_t>(size[0])), rows_(static_cast<std::size_t>(size[1])), hu_(hu) {
    constexpr std::size_t kSamples = 64;  // along a row
    const std::size_t step = std::max<std::size_t>(1, std::min(rows_, columns_) / kSamples);
    for (std::size_t k = 0; k < count; ++k) {
      std::vector<std::int16_t>& sample = samples_.emplace_back();
      for (std::size_t row = 0; row < rows_; row += step) {
        for (std::size_t column = 0; column < columns_; column += step)
          sample.push_back(std::clamp<std::int16_t>(Row(k, row)[column], -1000, 1000));
      }
      means_.push_back(std::accumulate(sample.begin(), sample.end(), 0.0) / static_cast<double>(sample.size()));
      spreads_.push_back(std::sqrt(std::max(CalcCovariance(k, k), 0.0)));
    }
  }
  std::size_t count() const { return samples_.size(); }
  std::size_t rows() const { return rows_; }
  const std::vector<std::int16_t>& Sample(std::size_t k) const { return samples_[k]; }
  /// Returns the standard deviation of a slice.
  double CalcSpread(std::size_t k) const { return spreads_[k]; }
  /// Returns 1 minus the correlation of two slices.
  double CalcUnlikeness(std::size_t a, std::size_t b) const {
    const double most = spreads_[a] * spreads_[b];
    return most > 0 ? 1 - CalcCovariance(a, b) / most : 1;
  }
  std::int16_t FirstOf(std::size_t k, std::size_t row) const { return *Row(k, row); }
  bool AreEqual(std::size_t a, std::size_t b) const {
    return std::memcmp(Row(a, 0), Row(b, 0), rows_ * columns_ * sizeof *hu_) == 0;
  }
  /// Returns the range of the values of a row.
  int CalcRange(std::size_t k, std::size_t row) const {
    const auto [least, most] = std::minmax_element(Row(k, row), Row(k, row) + columns_);
    return *most - *least;
  }
  bool IsOneValue(std::size_t k, std::size_t row) const {
    const std::int16_t* const first = Row(k, row);
    return std::all_of(first, first + columns_, [first](std::int16_t hu) { return hu == *first; });
  }

 private:
  const std::int16_t* Row(std::size_t k, std::size_t row) const { return hu_ + (k * rows_ + row) * columns_; }
  double CalcCovariance(std::size_t a, std::size_t b) const {
    const double sum = std::inner_product(samples_[a].begin(), samples_[a].end(), samples_[b].begin(), 0.0);
    return sum / static_cast<double>(samples_[a].size()) - means_[a] * means_[b];
  }

  std::size_t columns_, rows_;
  const std::int16_t* hu_;
  std::vector<std::vector<std::int16_t>> samples_;
  std::vector<double> means_, spreads_;
};

// Returns how many rows of a slice have one value each and in both neighbours show something; 0 if that is no damage:
// if they are few, or have, as less than half of the slice, the value of rows of the neighbours that show nothing.
std::size_t CountFlatRows(const SliceSamples& all, std::size_t k) {
  constexpr std::size_t kFewest = 8;
  std::size_t flat = 0, shown = 0;
  std::set<std::int16_t> values, background;
  for (std::size_t row = 0; row < all.rows(); ++row) {
    for (const std::size_t beside : {k - 1, k + 1}) {
      if (all.IsOneValue(beside, row)) background.insert(all.FirstOf(beside, row));
    }
    if (all.CalcRange(k - 1, row) <= kShown_HU || all.CalcRange(k + 1, row) <= kShown_HU) continue;
    ++shown;
    if (!all.IsOneValue(k, row)) continue;
    ++flat;
    values.insert(all.FirstOf(k, row));
  }
  const bool is_background = std::includes(background.begin(), background.end(), values.begin(), values.end());
  return flat < std::max(kFewest, all.rows() / 16) || (is_background && 2 * flat < shown) ? 0 : flat;
}

// Returns whether a slice is unlike both neighbours, and these are like each other.
bool IsUnlike(const SliceSamples& all, std::size_t k) {
  if (std::min(all.CalcSpread(k - 1), all.CalcSpread(k + 1)) < kMinSpread_HU) return false;
  const double own = std::min(all.CalcUnlikeness(k - 1, k), all.CalcUnlikeness(k, k + 1));
  return own > std::max(0.25, 4 * all.CalcUnlikeness(k - 1, k + 1));
}

// Returns whether slices differ more than those of a shape that ends, or hardly changes, in an image without noise.
bool Differ(const SliceSamples& all, std::size_t a, std::size_t b) {
  constexpr double kMinDifferent = 0.01;
  const std::vector<std::int16_t>&x = all.Sample(a), &y = all.Sample(b);
  const int equal = std::inner_product(x.begin(), x.end(), y.begin(), 0, std::plus<>(), std::equal_to<>());
  return equal <= (1 - kMinDifferent) * static_cast<double>(x.size());
}

// Returns whether a slice is the copy of the other of two equal ones: that which fits its place less well.
bool IsCopy(const SliceSamples& all, std::size_t k, std::size_t other) {
  const auto misfit = [&all](std::size_t at, std::size_t equal) {
    double worst = 0;  // the greater distance from its neighbours
    for (const std::size_t beside : {at - 1, at + 1}) {
      if (beside != equal) worst = std::max(worst, all.CalcUnlikeness(at, beside));
    }
    return worst;
  };
  return misfit(k, other) > misfit(other, k);
}

// Finds pairs of equal slices. More than a few are what the series is like: doubled slices, or an image without noise.
void AddRepeated(const std::vector<DicomSlice>& slices, const SliceSamples& all, UnfitSlices& found) {
  constexpr std::size_t kMaxPairs = 2;
  std::map<std::vector<std::int16_t>, std::vector<std::size_t>> equal;
  for (std::size_t k = 0; k < all.count(); ++k) {
    if (all.CalcSpread(k) >= kMinSpread_HU) equal[all.Sample(k)].push_back(k);
  }
  std::vector<std::array<std::size_t, 2>> pairs;
  for (const auto& [sample, of] : equal) {
    if (of.size() == 2 && all.AreEqual(of[0], of[1])) pairs.push_back({of[0], of[1]});
  }
  if (pairs.size() > kMaxPairs) return;
  for (const auto& [a, b] : pairs) {
    if (a == 0 || b + 1 == all.count() || !Differ(all, a - 1, a) || !Differ(all, b, b + 1)) continue;
    const bool is_a = IsCopy(all, a, b);
    (b == a + 1 ? found.doubtful : found.damaged)[is_a ? a : b] =
        fmt::format("its values are exactly those of {}", NameOf(slices[is_a ? b : a]));
  }
}

}  // namespace

UnfitSlices FindUnfitSlices(const std::vector<DicomSlice>& slices, const std::int16_t* hu) {
  constexpr std::size_t kMinSlices = 5;
  constexpr int kMinPixels = 1000;
  UnfitSlices found;
  const std::array<int, 2>& size = slices.front().size;
  if (slices.size() < kMinSlices || size[0] * size[1] < kMinPixels) return found;
  const SliceSamples all(size, slices.size(), hu);
  for (std::size_t k = 1; k + 1 < all.count(); ++k) {
    if (const std::size_t flat = CountFlatRows(all, k); flat > 0) {
      found.damaged[k] =
          fmt::format("{} of its {} rows have one value each, unlike those of both slices beside it", flat, all.rows());
    } else if (IsUnlike(all, k)) {
      found.doubtful[k] =
          "its values have little in common with those of both slices beside it, which resemble each other";
    }
  }
  // Many such slices are what the series is like, such as phases that alternate.
  if (found.doubtful.size() > std::max<std::size_t>(2, all.count() / 10)) found.doubtful.clear();
  if (found.damaged.empty() && found.doubtful.empty()) AddRepeated(slices, all, found);
  return found;
}

}  // namespace kerf
