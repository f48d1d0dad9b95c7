// Curve of unknown length in bounded memory.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

/// Keeps all points until there are `MaxPoints`. Then it merges pairs of neighbours with T::Merge(earlier, later), and
/// from then on merges as many new points into one as each of points() contains. This repeats whenever the memory is
/// full. points() includes the latest points. Not for the tick.
template <typename T, std::size_t MaxPoints>
class Thinned {
 public:
  static_assert(MaxPoints % 2 == 0);
  /// Reserves memory for `count` points, at most `MaxPoints`.
  void Reserve(std::size_t count) { points_.reserve(count < MaxPoints ? count + 1 : MaxPoints); }

  void Add(const T& point) {
    const bool begins = waiting_ == 0;
    if (begins) {
      points_.push_back(point);
    } else {
      points_.back() = T::Merge(points_.back(), point);
    }
    if (++waiting_ < each_) return;
    waiting_ = 0;
    if (points_.size() == MaxPoints) Halve();
  }

  const std::vector<T>& points() const { return points_; }
  /// Number of added points in each of points() except the last.
  std::size_t each() const { return each_; }

 private:
  void Halve() {
    for (std::size_t i = 0; i < MaxPoints / 2; ++i) points_[i] = T::Merge(points_[2 * i], points_[2 * i + 1]);
    points_.resize(MaxPoints / 2);
    each_ *= 2;
  }

  std::vector<T> points_;
  std::size_t each_ = 1;
  std::size_t waiting_ = 0;  // number of points merged into the last of points() so far, 0 if it is complete
};

}  // namespace kerf
