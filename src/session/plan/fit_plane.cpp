#include "session/plan/fit_plane.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>
#include <vector>

#include "bone/grid/parts_reader.h"
#include "session/plan/lost_voxels.h"
#include "session/plan/moments.h"

namespace kerf {
namespace {

constexpr double kLevelVoxels = 1.25;        // depth inside the bone at which the kerf's sides are located
constexpr int kTries = 400;                  // number of planes tried, each through three changed voxels
constexpr std::size_t kMaxTryPoints = 2000;  // maximum number of changed voxels used for these tries
constexpr int kLinesAcross = 120;            // maximum number of lines along each side of the kerf
constexpr int kMinMidpoints = 12;
constexpr double kKept = 0.9;            // fraction of the midpoints that are kept, those closest to the plane
constexpr double kSpan = 0.85;           // minimum ratio of the extents of the kept midpoints to those of all
constexpr double kStray = 4.5;           // residual of a stray midpoint, in medians; three standard deviations
constexpr double kSameWidth = 0.6;       // minimum fraction of the midpoints that have the kerf's median width
constexpr double kFlatLoss = 3;          // minimum ratio of breadth to thickness of removed bone that has a plane
constexpr double kFlat = 1.5;            // minimum of that ratio from which midpoints are searched for
const double kExtent = std::sqrt(12.0);  // extent of equally spread points, in standard deviations
constexpr double kOwnSides = 0.1;        // minimum fraction of the midpoints of which both sides are of this kerf
constexpr int kIterations = 4;
constexpr double kMinDepth = 1.5;  // minimum depth of a kerf, in widths

/// Among planes through three of the points, finds the one with the most points within `near_mm`, and fits it to these.
std::optional<MomentFit> FindPlane(const std::vector<WeightedPoint>& points, double near_mm, const KerfSearch& search) {
  std::vector<WeightedPoint> some;
  const std::size_t stride = points.size() / kMaxTryPoints + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) some.push_back(points[i]);
  if (some.size() < 3) return {};
  std::minstd_rand random(1);
  std::uniform_int_distribution<std::size_t> pick(0, some.size() - 1);
  double best = -1;
  CutPlane plane;
  const auto score = [&](const CutPlane& p) {
    double sum = 0;
    for (const WeightedPoint& w : some) {
      const double off = std::abs(glm::dot(p.normal_W, w.p - p.p_W)) / near_mm;
      if (off < 1) sum += w.weight * (1 - off * off);
    }
    return sum;
  };
  for (int i = 0; i < kTries; ++i) {
    const Vec3 a = some[pick(random)].p;
    const Vec3 u = some[pick(random)].p - a;
    const Vec3 v = some[pick(random)].p - a;
    const Vec3 n = glm::cross(u, v);
    // Three points that are close together or collinear do not determine a plane.
    if (!(glm::length(n) > 4 * near_mm * near_mm)) continue;
    const CutPlane candidate{a, glm::normalize(n)};
    if (search.near && std::abs(glm::dot(candidate.normal_W, search.near->normal_W)) <
                           std::cos(search.max_tilt_deg / kDegreesPerRad)) {
      continue;
    }
    const double sum = score(candidate);
    if (sum > best) {
      best = sum;
      plane = candidate;
    }
  }
  if (best <= 0) return FitMoments(points);
  std::optional<MomentFit> fit;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::vector<WeightedPoint> inliers;
    for (const WeightedPoint& w : points) {
      if (std::abs(glm::dot(plane.normal_W, w.p - plane.p_W)) < near_mm) inliers.push_back(w);
    }
    fit = FitMoments(inliers);
    if (!fit) return {};
    plane = {fit->p, fit->normal};
  }
  return fit;
}

struct Midpoint {
  Vec3 p;
  double width;
};

/// Finds the midpoint between the two sides of the kerf on lines across the plane.
class MidpointFinder {
 public:
  MidpointFinder(const Bone& before, const Bone& after)
      : h_(before.voxel_mm()), level_(-kLevelVoxels * h_), before_(GridsOf(before)), after_(GridsOf(after)) {}

  /// Searches within `reach` on both sides of p. Returns none if one side of the kerf is missing.
  std::optional<Midpoint> Find(const Vec3& p, const Vec3& normal, double reach) {
    const int steps = static_cast<int>(std::ceil(2 * reach / (0.5 * h_)));
    std::optional<Midpoint> best;
    double best_off = 0;
    double up = 0;        // last point where the line left the bone
    bool inside = false;  // inside a gap that began in bone
    double last = 0;
    bool last_known = false;
    for (int i = 0; i <= steps; ++i) {
      const double z = -reach + i * 2 * reach / steps;
      const Vec3 at = (p + z * normal) / h_;
      const bool was_bone = before_.Sample(at) < level_;
      const double phi = after_.Sample(at);
      if (!was_bone) {
        inside = false;
        last_known = false;
        continue;
      }
      if (last_known) {
        const double step = 2 * reach / steps;
        const double cross = z - step * (phi - level_) / (phi - last);
        if (last < level_ && phi >= level_) {
          up = cross;
          inside = true;
        } else if (last >= level_ && phi < level_ && inside) {
          const double off = std::abs(0.5 * (up + cross));
          if (!best || off < best_off) {
            best = Midpoint{p + 0.5 * (up + cross) * normal, cross - up + 2 * level_};
            best_off = off;
          }
          inside = false;
        }
      }
      last = phi;
      last_known = true;
    }
    return best;
  }

 private:
  double h_;
  double level_;
  PartsReader before_;
  PartsReader after_;
};

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double MedianWidth(const std::vector<Midpoint>& midpoints) {
  std::vector<double> widths;
  for (const Midpoint& m : midpoints) widths.push_back(m.width);
  return Median(widths);
}

/// Returns by how much a midpoint of a kerf may differ from the others, in width or place.
double CalcTolerance(double width_mm, double h) {
  return std::max(h, 0.25 * width_mm);
}

/// Computes the least-squares fit to the midpoints that are at most `calc_limit(residuals)` from the plane, which are
/// then `kept`.
template <typename Limit>
std::optional<MomentFit> FitNearest(const std::vector<Midpoint>& midpoints, const MomentFit& start,
                                    const Limit& calc_limit, std::vector<WeightedPoint>& kept) {
  std::optional<MomentFit> fit = start;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    std::vector<double> off;
    for (const Midpoint& m : midpoints) off.push_back(std::abs(glm::dot(fit->normal, m.p - fit->p)));
    const double limit = calc_limit(off);
    kept.clear();
    for (std::size_t i = 0; i < midpoints.size(); ++i) {
      if (off[i] <= limit) kept.push_back({midpoints[i].p, 1});
    }
    fit = FitMoments(kept);
    if (!fit) return {};
  }
  return fit;
}

/// Returns the least ratio of the extents of some points, along the two directions of a plane, to those of all.
double CalcSpan(const std::vector<WeightedPoint>& some, const std::vector<WeightedPoint>& all, const MomentFit& fit) {
  const auto calc_variance = [](const std::vector<WeightedPoint>& points, const Vec3& direction) {
    double sum = 0;
    double squares = 0;
    for (const WeightedPoint& w : points) {
      const double x = glm::dot(direction, w.p);
      sum += x;
      squares += x * x;
    }
    const double count = static_cast<double>(points.size());
    return squares / count - sum * sum / (count * count);
  };
  double least = 1;
  for (const Vec3& direction : {fit.along, glm::cross(fit.normal, fit.along)}) {
    const double of_all = calc_variance(all, direction);
    if (of_all > 0) least = std::min(least, std::sqrt(std::max(0.0, calc_variance(some, direction)) / of_all));
  }
  return least;
}

/// Computes the least-squares fit to the midpoints, without the 10 % that are furthest from the plane. If these are an
/// end of the kerf, where little bone was, the plane would turn away from it; then only stray midpoints are left out.
std::optional<MomentFit> FitMidpoints(const std::vector<Midpoint>& midpoints, const MomentFit& start, double h) {
  std::vector<WeightedPoint> kept;
  const std::optional<MomentFit> fit = FitNearest(
      midpoints, start,
      [](std::vector<double> off) {
        std::sort(off.begin(), off.end());
        return off[static_cast<std::size_t>(kKept * static_cast<double>(off.size() - 1))];
      },
      kept);
  if (!fit) return {};
  std::vector<WeightedPoint> all;
  for (const Midpoint& m : midpoints) all.push_back({m.p, 1});
  if (CalcSpan(kept, all, *fit) >= kSpan) return fit;
  const std::optional<MomentFit> of_all = FitMoments(all);
  if (!of_all) return fit;
  const double tolerance_mm = CalcTolerance(MedianWidth(midpoints), h);
  return FitNearest(
      midpoints, *of_all, [&](const std::vector<double>& off) { return std::max(tolerance_mm, kStray * Median(off)); },
      kept);
}

/// Computes the extents of the points along the fit's axes: length and depth.
void Measure(const std::vector<Vec3>& points, const MomentFit& fit, FittedPlane& plane) {
  const Vec3 across = glm::cross(fit.normal, fit.along);
  double low[2] = {1e300, 1e300};
  double high[2] = {-1e300, -1e300};
  for (const Vec3& p : points) {
    const double along[2] = {glm::dot(fit.along, p - fit.p), glm::dot(across, p - fit.p)};
    for (int i = 0; i < 2; ++i) {
      low[i] = std::min(low[i], along[i]);
      high[i] = std::max(high[i], along[i]);
    }
  }
  plane.length_mm = high[0] - low[0];
  plane.depth_mm = high[1] - low[1];
}

std::vector<Midpoint> FindMidpoints(const Bone& before, const Bone& after, const MomentFit& fit,
                                    const std::vector<WeightedPoint>& points, double reach, const KerfSearch& search) {
  const Vec3 across = glm::cross(fit.normal, fit.along);
  double low[2] = {1e300, 1e300};
  double high[2] = {-1e300, -1e300};
  for (const WeightedPoint& w : points) {
    const Vec3 d = w.p - fit.p;
    if (std::abs(glm::dot(fit.normal, d)) > reach) continue;
    const double along[2] = {glm::dot(fit.along, d), glm::dot(across, d)};
    for (int i = 0; i < 2; ++i) {
      low[i] = std::min(low[i], along[i]);
      high[i] = std::max(high[i], along[i]);
    }
  }
  MidpointFinder finder(before, after);
  std::vector<Midpoint> midpoints;
  std::vector<Midpoint> own;  // those of which both sides, where they are located, belong to this kerf
  const double h = before.voxel_mm();
  const double step[2] = {std::max(h, (high[0] - low[0]) / kLinesAcross),
                          std::max(h, (high[1] - low[1]) / kLinesAcross)};
  for (double u = low[0]; u <= high[0]; u += step[0]) {
    for (double v = low[1]; v <= high[1]; v += step[1]) {
      const auto middle = finder.Find(fit.p + u * fit.along + v * across, fit.normal, reach);
      if (!middle || (search.belongs && !search.belongs(middle->p))) continue;
      midpoints.push_back(*middle);
      const Vec3 side = (0.5 * middle->width + kLevelVoxels * h) * fit.normal;
      if (search.belongs && search.belongs(middle->p - side) && search.belongs(middle->p + side))
        own.push_back(*middle);
    }
  }
  if (midpoints.empty()) return midpoints;
  // Where another kerf joins this one, a side may be a face of the other.
  if (own.size() >= kMinMidpoints &&
      static_cast<double>(own.size()) >= kOwnSides * static_cast<double>(midpoints.size())) {
    midpoints = std::move(own);
  }
  const double width = MedianWidth(midpoints);
  const std::size_t found = midpoints.size();
  std::erase_if(midpoints, [&](const Midpoint& m) { return std::abs(m.width - width) > CalcTolerance(width, h); });
  // If the widths vary widely, this is a hole and not a kerf.
  if (static_cast<double>(midpoints.size()) < kSameWidth * static_cast<double>(found)) midpoints.clear();
  return midpoints;
}

bool IsFlat(const MomentFit& fit) {
  return fit.breadth > kFlat * fit.thickness && fit.breadth > 0;
}

/// Plane of a kerf, fitted to the midpoints or, if these are empty, to the changed voxels near the plane.
struct KerfFit {
  std::optional<MomentFit> fit;  // none: no plane
  double off_mm = 0;             // largest distance of those voxels from the plane
  std::vector<Midpoint> midpoints;
};

/// Fits the plane that has the most changed voxels within `near_mm`, and then the midpoints.
KerfFit FitNear(const Bone& before, const Bone& after, const std::vector<WeightedPoint>& points, double near_mm,
                const KerfSearch& search) {
  KerfFit result;
  result.fit = FindPlane(points, near_mm, search);
  if (!result.fit || !IsFlat(*result.fit)) return result;
  for (const WeightedPoint& w : points) {
    const double d = std::abs(glm::dot(result.fit->normal, w.p - result.fit->p));
    if (d < near_mm) result.off_mm = std::max(result.off_mm, d);
  }
  for (int iteration = 0; iteration < 2; ++iteration) {
    std::vector<Midpoint> midpoints =
        FindMidpoints(before, after, *result.fit, points, result.off_mm + 4 * before.voxel_mm(), search);
    if (midpoints.size() < kMinMidpoints) break;
    const std::optional<MomentFit> better = FitMidpoints(midpoints, *result.fit, before.voxel_mm());
    if (!better || !IsFlat(*better)) break;
    result.fit = better;
    result.midpoints = std::move(midpoints);
  }
  return result;
}

/// Measures the removed bone, whose second extent would have to be another multiple of the third.
void ExplainShape(const Loss& loss, double least_ratio, NoKerf& why) {
  std::vector<WeightedPoint> cells;
  for (const LostCell& cell : loss.cells) cells.push_back({cell.p_W, std::max(cell.mm3, 0.0)});
  const std::optional<MomentFit> all = FitMoments(cells);
  if (!all) return;
  why.extents_mm[0] = kExtent * all->length;
  why.extents_mm[1] = kExtent * all->breadth;
  why.extents_mm[2] = kExtent * all->thickness;
  why.least_second_mm = least_ratio * why.extents_mm[2];
}

}  // namespace

std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, const KerfSearch& search, NoKerf* why) {
  NoKerf unused;
  NoKerf& reason = why != nullptr ? *why : unused;
  reason = {};
  const auto keep = [&](const Vec3& p) {
    if (search.near && std::abs(glm::dot(search.near->normal_W, p - search.near->p_W)) > search.reach_mm) return false;
    return !search.belongs || search.belongs(p);
  };
  const Loss loss = FindLoss(before, after, search.within, keep);
  FittedPlane plane;
  for (const LostCell& cell : loss.cells) plane.volume_mm3 += cell.mm3;
  reason.removed_mm3 = plane.volume_mm3;
  if (loss.voxels.size() < 3) return {};
  const double h = before.voxel_mm();
  std::vector<WeightedPoint> points;
  points.reserve(loss.voxels.size());
  for (const LostVoxel& voxel : loss.voxels) points.push_back({voxel.p_W, voxel.weight});

  // Near the surface, removed bone extends one to three voxels to either side of the kerf.
  const double near_mm = std::max(4 * h, 0.5);
  KerfFit found = FitNear(before, after, points, near_mm, search);
  if (!found.fit || !IsFlat(*found.fit)) {
    ExplainShape(loss, kFlat, reason);
    return {};
  }
  // Of a kerf wider than that, only a part is near, whose plane may lie so far from the middle that one of the sides is
  // out of reach.
  KerfFit wider = found;
  for (double wide_mm = near_mm; wider.midpoints.empty() && wider.off_mm > wide_mm - h;) {
    wide_mm *= 2;
    if (wide_mm > search.reach_mm) break;
    wider = FitNear(before, after, points, wide_mm, search);
  }
  if (!wider.midpoints.empty()) found = std::move(wider);
  const bool by_midpoints = !found.midpoints.empty();
  const std::vector<Midpoint>& midpoints = found.midpoints;
  std::optional<MomentFit>& fit = found.fit;
  std::vector<Vec3> span;
  if (by_midpoints) {
    plane.midpoints = static_cast<int>(midpoints.size());
    double sum = 0;
    for (const Midpoint& m : midpoints) {
      const double d = glm::dot(fit->normal, m.p - fit->p);
      sum += d * d;
      span.push_back(m.p);
    }
    plane.rms_mm = std::sqrt(sum / static_cast<double>(midpoints.size()));
    plane.width_mm = MedianWidth(midpoints);
  } else {
    std::vector<WeightedPoint> cells;
    for (const LostCell& cell : loss.cells) {
      if (cell.mm3 <= 0 || std::abs(glm::dot(fit->normal, cell.p_W - fit->p)) > found.off_mm + h) continue;
      cells.push_back({cell.p_W, cell.mm3});
    }
    const std::optional<MomentFit> by_volume = FitMoments(cells);
    if (!by_volume || by_volume->breadth < kFlatLoss * by_volume->thickness) {
      ExplainShape(loss, kFlatLoss, reason);
      return {};
    }
    fit = by_volume;
    plane.rms_mm = fit->thickness;
    plane.width_mm = kExtent * fit->thickness;
    for (const WeightedPoint& cell : cells) span.push_back(cell.p);
  }
  plane.p_W_mm = fit->p;
  plane.normal_W = fit->normal;
  const Vec3 n = glm::abs(plane.normal_W);
  const int largest = n.x >= n.y && n.x >= n.z ? 0 : n.y >= n.z ? 1 : 2;
  const bool flip = search.near ? glm::dot(plane.normal_W, search.near->normal_W) < 0 : plane.normal_W[largest] < 0;
  if (flip) plane.normal_W = -plane.normal_W;
  Measure(span, *fit, plane);
  const Vec3 across = glm::cross(fit->normal, fit->along);
  const double end_mm = 0.5 * plane.depth_mm + 3 * h;
  const auto phi_at = [&](double distance_mm) { return after.SignedDistance(plane.p_W_mm + distance_mm * across); };
  const double ahead = phi_at(end_mm);
  const double behind = phi_at(-end_mm);
  // For a through cut, the depth direction points downwards.
  const bool through = ahead > 0 && behind > 0;
  const bool back = through || behind == ahead ? across.z > 0 : behind < ahead;
  plane.depth_W = back ? -across : across;
  // The sides are found only inside the bone.
  if (plane.depth_mm + 2 * kLevelVoxels * h < kMinDepth * plane.width_mm) {
    ExplainShape(loss, kMinDepth, reason);
    return {};
  }
  return plane;
}

std::optional<FittedPlane> FitKerf(const Bone& before, const Bone& after, std::optional<Box3> within) {
  return FitKerf(before, after, KerfSearch{.within = within, .near = {}, .belongs = {}});
}

}  // namespace kerf
