#include "session/marks/label_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "kerf/error.h"
#include "session/marks/segment.h"

namespace kerf {
namespace {

constexpr double kLayer_mm = 1;
constexpr double kThinned_mm = 0.2;
// Radii over which the curve is smoothed to either side. In a tube of radius r that bends with radius R, the centroid
// of a layer lies r^2 / 4R outside of the middle. The mean over a length of 2 a lies a^2 / 6R inside of it, which is
// the same for this length.
constexpr double kSmoothing = 1.22;
constexpr int kPasses = 3;                         // after which the line moves by less than a tenth of a voxel
constexpr std::size_t kMaxDistances = 50'000'000;  // of voxels from segments, in a pass
constexpr float kFar = std::numeric_limits<float>::infinity();

using Index3 = std::array<int, 3>;

struct Step {
  Index3 offset{};
  float mm = 0;
};

/// A connected part of a label.
struct Part {
  std::int16_t label = 0;
  Index3 first{};
  std::size_t voxels = 0;
  Index3 lower{};
  Index3 upper{};
};

double CalcTubeVolume(double radius_mm, double length_mm) {
  return std::numbers::pi * radius_mm * radius_mm * (length_mm + 4.0 / 3.0 * radius_mm);
}

/// Returns the value in [0, upper] at which the rising function reaches `wanted`.
template <typename Function>
double FindRoot(const Function& rising, double wanted, double upper) {
  double low = 0;
  double high = upper;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (rising(middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double CalcBallRadius(double volume_mm3) {
  return std::cbrt(0.75 * volume_mm3 / std::numbers::pi);
}

/// Returns the radius of a tube with the given volume and distance between its tips; nullopt if it would be shorter
/// than wide.
std::optional<double> CalcRadius(double volume_mm3, double tips_mm) {
  if (CalcTubeVolume(0.5 * tips_mm, 0) <= volume_mm3) return std::nullopt;
  return FindRoot([tips_mm](double r) { return CalcTubeVolume(r, tips_mm - 2 * r); }, volume_mm3, 0.5 * tips_mm);
}

double CalcLength(const std::vector<Vec3>& line) {
  double length_mm = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length_mm += glm::length(line[i] - line[i - 1]);
  return length_mm;
}

class LabelParts {
 public:
  explicit LabelParts(const LabelLattice& lattice) : lattice_(lattice) {
    for (int k = -1; k <= 1; ++k) {
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          if (i == 0 && j == 0 && k == 0) continue;
          const double mm = glm::length(VectorOf({i, j, k}));
          steps_.push_back({{i, j, k}, static_cast<float>(mm)});
          shortest_mm_ = std::min(shortest_mm_, mm);
          longest_mm_ = std::max(longest_mm_, mm);
        }
      }
    }
    const auto& s = lattice.steps_W;
    voxel_mm3_ = std::abs(glm::dot(s[0], glm::cross(s[1], s[2])));
    voxel_mm_ = std::max({glm::length(s[0]), glm::length(s[1]), glm::length(s[2])});
  }

  double CalcVolume(const Part& part) const { return voxel_mm3_ * static_cast<double>(part.voxels); }

  std::vector<Part> FindParts() const {
    std::vector<Part> parts;
    std::vector<bool> seen(lattice_.labels.size());
    std::vector<Index3> open;
    for (Index3 at{}; at[2] < lattice_.size[2]; ++at[2]) {
      for (at[1] = 0; at[1] < lattice_.size[1]; ++at[1]) {
        for (at[0] = 0; at[0] < lattice_.size[0]; ++at[0]) {
          if (LabelAt(at) == 0 || seen[IndexOf(at)]) continue;
          Part part{.label = LabelAt(at), .first = at, .lower = at, .upper = at};
          seen[IndexOf(at)] = true;
          open.push_back(at);
          while (!open.empty()) {
            const Index3 v = open.back();
            open.pop_back();
            ++part.voxels;
            for (std::size_t a = 0; a < 3; ++a) {
              part.lower[a] = std::min(part.lower[a], v[a]);
              part.upper[a] = std::max(part.upper[a], v[a]);
            }
            for (const Step& step : steps_) {
              const Index3 next = Moved(v, step);
              if (!Contains(next) || LabelAt(next) != part.label || seen[IndexOf(next)]) continue;
              seen[IndexOf(next)] = true;
              open.push_back(next);
            }
          }
          parts.push_back(part);
        }
      }
    }
    return parts;
  }

  /// Makes curve and radius.
  Mark MakeMark(const Part& part) const {
    // The voxel that is farthest from any one is at an end; the one that is farthest from that, at the other end.
    const std::vector<Reached> from_any = Walk(part, part.first);
    const std::vector<Reached> reached = Walk(part, from_any.back().at);
    const double volume_mm3 = CalcVolume(part);
    Vec3 centre(0);
    for (const Reached& r : reached) centre += PointOf(r.at) / static_cast<double>(reached.size());
    Mark ball{.radius_mm = CalcBallRadius(volume_mm3), .points_W = {centre}};

    const double walked_mm = static_cast<double>(reached.back().mm);
    const std::optional<double> about_mm = CalcRadius(volume_mm3, walked_mm + voxel_mm_);
    if (!about_mm) return ball;
    // Layers at the ends are cut off obliquely, and their centroids lie beside the middle.
    const double layer_mm = std::max(kLayer_mm, 1.5 * longest_mm_);
    const double margin_mm = *about_mm + 0.5 * layer_mm;
    std::vector<Vec3> line = FindCentroids(reached, layer_mm, margin_mm, walked_mm - margin_mm);
    if (line.size() < 2) {
      const Vec3 half = 0.25 * (PointOf(reached.back().at) - PointOf(reached.front().at));
      line = {centre - half, centre + half};
    }

    // Layers across the line are not oblique, so they are used up to half a radius before the tips.
    for (int pass = 0; pass < kPasses; ++pass) {
      ExtendToTips(reached, *about_mm, margin_mm + layer_mm, line);
      line = FindCrossCentroids(reached, line, layer_mm, *about_mm);
      if (line.size() < 2) return ball;
    }
    ExtendToTips(reached, *about_mm, margin_mm + layer_mm, line);
    const double tips_mm = CalcLength(line);
    const std::optional<double> radius_mm = CalcRadius(volume_mm3, tips_mm);
    if (!radius_mm || tips_mm < 4 * *radius_mm) return ball;
    const double length_mm = tips_mm - 2 * *radius_mm;
    line = Cut(line, *radius_mm, *radius_mm + length_mm);

    Mark mark{.points_W = Thin(line, std::min(voxel_mm_ / 4, kThinned_mm))};
    mark.radius_mm = *radius_mm;
    return mark;
  }

 private:
  struct Reached {
    Index3 at{};
    float mm = 0;  // shortest way from the start, through neighbours
  };

  std::size_t IndexOf(const Index3& v) const {
    const auto n = [](int i) { return static_cast<std::size_t>(i); };
    return n(v[0]) + n(lattice_.size[0]) * (n(v[1]) + n(lattice_.size[1]) * n(v[2]));
  }
  std::int16_t LabelAt(const Index3& v) const { return lattice_.labels[IndexOf(v)]; }
  bool Contains(const Index3& v) const {
    for (std::size_t a = 0; a < 3; ++a) {
      if (v[a] < 0 || v[a] >= lattice_.size[a]) return false;
    }
    return true;
  }
  static Index3 Moved(const Index3& v, const Step& step) {
    return {v[0] + step.offset[0], v[1] + step.offset[1], v[2] + step.offset[2]};
  }
  Vec3 VectorOf(const Index3& v) const {
    const auto& s = lattice_.steps_W;
    return static_cast<double>(v[0]) * s[0] + static_cast<double>(v[1]) * s[1] + static_cast<double>(v[2]) * s[2];
  }
  Vec3 PointOf(const Index3& v) const { return lattice_.origin_W + VectorOf(v); }

  /// Returns all voxels of the part, nearest first. Dijkstra's algorithm, with a queue of buckets that are not wider
  /// than the shortest step: no step leads from a bucket into the same one, so the order within a bucket does not
  /// matter.
  std::vector<Reached> Walk(const Part& part, const Index3& start) const {
    Index3 size{};
    for (std::size_t a = 0; a < 3; ++a) size[a] = part.upper[a] - part.lower[a] + 1;
    const auto index = [&](const Index3& v) {
      const auto n = [](int i) { return static_cast<std::size_t>(i); };
      return n(v[0] - part.lower[0]) + n(size[0]) * (n(v[1] - part.lower[1]) + n(size[1]) * n(v[2] - part.lower[2]));
    };
    const auto n = [&](std::size_t a) { return static_cast<std::size_t>(size[a]); };
    std::vector<float> best(n(0) * n(1) * n(2), kFar);
    const auto width = static_cast<float>(0.999 * shortest_mm_);
    std::vector<std::vector<Reached>> buckets(static_cast<std::size_t>(longest_mm_ / static_cast<double>(width)) + 2);
    const auto bucket_of = [&](float mm) { return static_cast<std::size_t>(mm / width); };
    std::vector<Reached> reached;
    reached.reserve(part.voxels);
    best[index(start)] = 0;
    buckets[0].push_back({start, 0});
    for (std::size_t at = 0, empty = 0; empty < buckets.size(); ++at) {
      const std::vector<Reached> now = std::exchange(buckets[at % buckets.size()], {});
      empty = now.empty() ? empty + 1 : 0;
      for (const Reached& r : now) {
        if (r.mm > best[index(r.at)]) continue;  // a shorter way was found later
        reached.push_back(r);
        for (const Step& step : steps_) {
          const Index3 next = Moved(r.at, step);
          if (!Contains(next) || LabelAt(next) != part.label) continue;
          float& mm = best[index(next)];
          if (r.mm + step.mm >= mm) continue;
          mm = r.mm + step.mm;
          buckets[bucket_of(mm) % buckets.size()].push_back({next, mm});
        }
      }
    }
    std::stable_sort(reached.begin(), reached.end(), [](const Reached& a, const Reached& b) { return a.mm < b.mm; });
    return reached;
  }

  /// Returns the centroids of the layers between two distances from the start.
  std::vector<Vec3> FindCentroids(const std::vector<Reached>& reached, double layer_mm, double from_mm,
                                  double to_mm) const {
    // Layers of equal thickness, about `layer_mm`.
    const double count = std::floor((to_mm - from_mm) / layer_mm);
    if (!(count >= 1)) return {};
    std::vector<Vec3> sums(static_cast<std::size_t>(count), Vec3(0));
    std::vector<double> voxels(sums.size(), 0);
    for (const Reached& r : reached) {
      const double at = (static_cast<double>(r.mm) - from_mm) / (to_mm - from_mm) * count;
      if (at < 0 || at >= count) continue;
      sums[static_cast<std::size_t>(at)] += PointOf(r.at);
      voxels[static_cast<std::size_t>(at)] += 1;
    }
    std::vector<Vec3> centroids;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (voxels[i] > 0) centroids.push_back(sums[i] / voxels[i]);
    }
    return centroids;
  }

  /// Returns the smoothed centroids of layers across the line, which ends at the part's tips, without those within half
  /// a radius of a tip. Of a large part it uses a share of the voxels.
  std::vector<Vec3> FindCrossCentroids(const std::vector<Reached>& reached, const std::vector<Vec3>& line,
                                       double layer_mm, double radius_mm) const {
    const double margin_mm = 0.5 * radius_mm;
    std::vector<double> along_mm{0};
    for (std::size_t i = 1; i < line.size(); ++i)
      along_mm.push_back(along_mm.back() + glm::length(line[i] - line[i - 1]));
    const double inner_mm = along_mm.back() - 2 * margin_mm;
    const double count = std::max(2.0, std::round(inner_mm / layer_mm));
    std::vector<Vec3> sums(static_cast<std::size_t>(count), Vec3(0));
    std::vector<double> voxels(sums.size(), 0);
    const std::size_t stride = 1 + reached.size() * line.size() / kMaxDistances;
    for (std::size_t n = 0; n < reached.size(); n += stride) {
      const Vec3 p_W = PointOf(reached[n].at);
      double best = std::numeric_limits<double>::infinity();
      double at_mm = 0;
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const Vec3 q_W = FindNearestOnSegment(p_W, line[i], line[i + 1]);
        const double distance2 = glm::dot(p_W - q_W, p_W - q_W);
        if (distance2 >= best) continue;
        best = distance2;
        at_mm = along_mm[i] + glm::length(q_W - line[i]);
      }
      const double layer = (at_mm - margin_mm) / inner_mm * count;
      if (!(layer >= 0 && layer < count)) continue;
      sums[static_cast<std::size_t>(layer)] += p_W;
      voxels[static_cast<std::size_t>(layer)] += 1;
    }
    std::vector<Layer> layers;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (voxels[i] > 0) layers.push_back({(static_cast<double>(i) + 0.5) / count * inner_mm, sums[i] / voxels[i]});
    }
    return Smooth(layers, std::max(kSmoothing * radius_mm, 1.01 * inner_mm / count));
  }

  struct Layer {
    double at_mm = 0;  // along the line
    Vec3 centroid_W{0};
  };

  /// Returns at each layer the straight line that fits the layers within `reach_mm` best. Without this, layers that are
  /// thinner than the tube is wide would let the line zigzag.
  static std::vector<Vec3> Smooth(const std::vector<Layer>& layers, double reach_mm) {
    std::vector<Vec3> smooth;
    for (const Layer& at : layers) {
      double n = 0, sum_x = 0, sum_xx = 0;
      Vec3 sum_p(0), sum_xp(0);
      for (const Layer& layer : layers) {
        const double x = layer.at_mm - at.at_mm;
        if (std::abs(x) > reach_mm) continue;
        n += 1;
        sum_x += x;
        sum_xx += x * x;
        sum_p += layer.centroid_W;
        sum_xp += x * layer.centroid_W;
      }
      const double determinant = n * sum_xx - sum_x * sum_x;
      smooth.push_back(determinant > 0 ? (sum_xx * sum_p - sum_x * sum_xp) / determinant : at.centroid_W);
    }
    return smooth;
  }

  /// Continues the line straight to both tips of the part. `radius_mm`: also the length at the line's end that gives
  /// the direction. `end_mm`: distance from the first and the last voxel within which a tip is looked for.
  void ExtendToTips(const std::vector<Reached>& reached, double radius_mm, double end_mm,
                    std::vector<Vec3>& line) const {
    const auto walked_mm = static_cast<double>(reached.back().mm);
    // A round tip has the volume pi r d^2 within the depth d. If that is at most a voxel's volume, it is the chance
    // that the tip contains a voxel's centre, so the outermost centre lies at two thirds of the largest such d on
    // average.
    const double beyond_mm =
        std::min(0.5 * voxel_mm_, 2.0 / 3.0 * std::sqrt(voxel_mm3_ / (std::numbers::pi * radius_mm)));
    for (const bool first : {false, true}) {
      std::reverse(line.begin(), line.end());
      std::size_t i = 1;
      while (i + 1 < line.size() && glm::length(line[i] - line[0]) < radius_mm) ++i;
      const std::optional<Vec3> out = CalcDirection(line[0] - line[i]);
      if (!out) continue;
      double tip_mm = 0;
      for (const Reached& r : reached) {
        const auto mm = static_cast<double>(r.mm);
        if ((first ? mm : walked_mm - mm) > end_mm) continue;
        tip_mm = std::max(tip_mm, glm::dot(PointOf(r.at) - line[0], *out));
      }
      line.insert(line.begin(), line[0] + (tip_mm + beyond_mm) * *out);
    }
  }

  /// Returns the part of the line between two lengths along it.
  static std::vector<Vec3> Cut(const std::vector<Vec3>& line, double from_mm, double to_mm) {
    std::vector<Vec3> part;
    double before_mm = 0;
    for (std::size_t i = 1; i < line.size(); ++i) {
      const double step_mm = glm::length(line[i] - line[i - 1]);
      const double after_mm = before_mm + step_mm;
      const auto at = [&](double mm) { return line[i - 1] + (mm - before_mm) / step_mm * (line[i] - line[i - 1]); };
      if (before_mm <= from_mm && from_mm < after_mm) part.push_back(at(from_mm));
      if (from_mm < after_mm && after_mm < to_mm) part.push_back(line[i]);
      if (before_mm < to_mm && to_mm <= after_mm) part.push_back(at(to_mm));
      before_mm = after_mm;
    }
    return part;
  }

  /// Returns those points through which a curve stays within `tolerance_mm` of the others.
  static std::vector<Vec3> Thin(const std::vector<Vec3>& line, double tolerance_mm) {
    std::vector<std::size_t> kept{0, line.size() - 1};
    while (true) {
      std::vector<Vec3> points;
      for (const std::size_t i : kept) points.push_back(line[i]);
      if (points.size() == std::min(line.size(), kMaxMarkPoints)) return points;
      std::vector<std::size_t> first;
      const std::vector<Vec3> curve = CalcCurve(points, &first);
      first.push_back(curve.size() - 1);
      // In each span, the point that is farthest from it is kept if it is too far away.
      std::vector<std::size_t> next{0};
      for (std::size_t span = 0; span + 1 < kept.size(); ++span) {
        double farthest_mm = tolerance_mm;
        std::size_t farthest = 0;
        for (std::size_t i = kept[span] + 1; i < kept[span + 1]; ++i) {
          double near_mm = std::numeric_limits<double>::infinity();
          for (std::size_t k = first[span]; k < first[span + 1]; ++k) {
            near_mm = std::min(near_mm, CalcSegmentDistance(line[i], curve[k], curve[k + 1]));
          }
          if (near_mm <= farthest_mm) continue;
          farthest_mm = near_mm;
          farthest = i;
        }
        if (farthest > 0 && next.size() + kept.size() - span <= kMaxMarkPoints) next.push_back(farthest);
        next.push_back(kept[span + 1]);
      }
      if (next.size() == kept.size()) return points;
      kept = std::move(next);
    }
  }

  const LabelLattice& lattice_;
  std::vector<Step> steps_;
  double shortest_mm_ = std::numeric_limits<double>::infinity();
  double longest_mm_ = 0;
  double voxel_mm3_ = 0;
  double voxel_mm_ = 0;  // longest edge
};

}  // namespace

std::vector<Mark> MakeMarksFromLabels(const LabelLattice& lattice, MarkKind kind, std::size_t max_marks,
                                      std::size_t* left_out) {
  std::size_t count = 1;
  for (const int n : lattice.size) count *= static_cast<std::size_t>(std::max(n, 0));
  if (count != lattice.labels.size()) {
    throw Error(fmt::format("the label map has {} labels for {} voxels", lattice.labels.size(), count));
  }
  const LabelParts finder(lattice);
  std::vector<Part> parts = finder.FindParts();
  std::erase_if(parts, [&](const Part& part) { return finder.CalcVolume(part) < kMinLabelMark_mm3; });
  if (parts.empty()) {
    throw Error(fmt::format("the label map has no structure of at least {} mm3", kMinLabelMark_mm3));
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.voxels > b.voxels; });
  if (left_out != nullptr) *left_out = parts.size() - std::min(parts.size(), max_marks);
  if (parts.size() > max_marks) parts.resize(max_marks);
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.label < b.label; });
  std::vector<Mark> marks;
  for (const Part& part : parts) {
    Mark mark = finder.MakeMark(part);
    mark.kind = kind;
    mark.name = fmt::format("{} {}", ToString(kind), marks.size() + 1);
    marks.push_back(std::move(mark));
  }
  return marks;
}

bool LooksLikeNerve(const Mark& mark) {
  return CalcLength(CalcCurve(mark.points_W)) > 6 * mark.radius_mm;
}

}  // namespace kerf
