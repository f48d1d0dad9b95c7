// The plane is fitted first by volume, then half-way between the two walls of the kerf, whose positions are accurate to
// a small fraction of a voxel.
#include "session/score/fit_plane.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include "session/plan/moments.h"

namespace kerf {
namespace {

/// Removed volume has a plane if its shorter extent in the plane is at least this multiple of the extent across it.
constexpr double kFlat = 1.5;
/// Distance from the surface, in voxels, within which walls are not searched for because the kerf's edge is rounded.
constexpr double kSkin = 1.25;
/// Maximum distance of a wall from the middle.
constexpr double kWall_mm = 5;
/// Places where the kerf is narrower than this fraction of the median width, such as its bottom, are left out.
constexpr double kNarrow = 0.75;
/// With fewer places than kMinPlaces, or if they extend less than kMinExtent (in voxels), the fit by volume is used.
constexpr std::size_t kMinPlaces = 12;
constexpr double kMinExtent = 0.8;
constexpr int kRefinements = 2;
/// Removed bone is in parts if they are apart by more than two cubes of this size; cubes that lost less than kLeast_mm3
/// do not connect them. A part whose centre is further from
/// the plane of the largest one than kStray_mm is a stray cut.
constexpr double kCube_mm = 1;
constexpr double kLeast_mm3 = 0.01;
constexpr double kStray_mm = 2;

using Matrix = std::array<std::array<double, 3>, 3>;

double Determinant(const Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Solves m x = y by Cramer's rule; returns 0 for a singular matrix.
std::array<double, 3> Solve(const Matrix& m, const std::array<double, 3>& y) {
  const double all = Determinant(m);
  std::array<double, 3> x{};
  if (!(std::abs(all) > 1e-12)) return x;
  for (std::size_t k = 0; k < 3; ++k) {
    Matrix with = m;
    for (std::size_t i = 0; i < 3; ++i) with[i][k] = y[i];
    x[k] = Determinant(with) / all;
  }
  return x;
}

/// A place in the plane, with position and width of the kerf there.
struct Place {
  double u;
  double v;
  double middle_mm;
  double width_mm;
};

/// Returns the distance from a point in the kerf to its wall along a direction. Returns none if there is no wall within
/// reach, or if it is the bone's own surface.
std::optional<double> FindWall(const PhiSampler& before, const PhiSampler& after, const Vec3& p_W,
                               const Vec3& direction_W) {
  const double step_mm = 0.25 * after.voxel_mm();
  double last = after.Calc(p_W);
  for (double x = step_mm; x < kWall_mm; x += step_mm) {
    const Vec3 q_W = p_W + x * direction_W;
    const double now = after.Calc(q_W);
    if (now < 0) {
      if (before.Calc(q_W) > -kSkin * after.voxel_mm()) return {};
      return x - step_mm * now / (now - last);
    }
    last = now;
  }
  return {};
}

std::optional<Place> FindPlace(const PhiSampler& before, const PhiSampler& after, const CutPlane& plane, const Vec3& eu,
                               const Vec3& ev, const Vec3& uvw) {
  const Vec3 n = plane.normal_W;
  const double h = after.voxel_mm();
  for (const double offset : {0.0, 0.5, -0.5, 1.0, -1.0}) {
    const double w = uvw.z + offset * h;
    const Vec3 p_W = plane.p_W + uvw.x * eu + uvw.y * ev + w * n;
    if (after.Calc(p_W) <= 0 || before.Calc(p_W) > -kSkin * h) continue;
    const std::optional<double> up = FindWall(before, after, p_W, n);
    const std::optional<double> down = FindWall(before, after, p_W, -n);
    if (!up || !down) return {};
    return Place{uvw.x, uvw.y, w + 0.5 * (*up - *down), *up + *down};
  }
  return {};
}

std::optional<CutPlane> Refine(const PhiSampler& before, const PhiSampler& after, const CutPlane& plane,
                               std::span<const RemovedCell> cells) {
  const Vec3 n = plane.normal_W;
  const Vec3 axis = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 eu = glm::normalize(glm::cross(n, axis));
  const Vec3 ev = glm::cross(n, eu);
  const double h = before.voxel_mm();
  // Use one place per square of a voxel's size: the one where the most bone was removed.
  struct Start {
    double mm3 = 0;
    Vec3 uvw{0};
  };
  std::map<std::pair<int, int>, Start> starts;
  for (const RemovedCell& cell : cells) {
    if (cell.in_mm < kSkin * h) continue;
    const Vec3 d = cell.p_W - plane.p_W;
    const Vec3 uvw(glm::dot(d, eu), glm::dot(d, ev), glm::dot(d, n));
    Start& start = starts[{static_cast<int>(std::floor(uvw.x / h)), static_cast<int>(std::floor(uvw.y / h))}];
    if (cell.mm3 > start.mm3) start = {cell.mm3, uvw};
  }
  std::vector<Place> places;
  std::vector<double> widths;
  for (const auto& [square, start] : starts) {
    if (const std::optional<Place> place = FindPlace(before, after, plane, eu, ev, start.uvw)) {
      places.push_back(*place);
      widths.push_back(place->width_mm);
    }
  }
  if (places.size() < kMinPlaces) return {};
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  Matrix m{};
  std::array<double, 3> y{};
  for (const Place& place : places) {
    if (place.width_mm < kNarrow * *middle) continue;
    const std::array<double, 3> x{1, place.u, place.v};
    for (std::size_t a = 0; a < 3; ++a) {
      y[a] += x[a] * place.middle_mm;
      for (std::size_t b = 0; b < 3; ++b) m[a][b] += x[a] * x[b];
    }
  }
  // Smallest variance of the places over the directions in the plane.
  const double count = m[0][0];
  if (count < static_cast<double>(kMinPlaces)) return {};
  const double uu = m[1][1] / count - m[0][1] * m[0][1] / (count * count);
  const double vv = m[2][2] / count - m[0][2] * m[0][2] / (count * count);
  const double uv = m[1][2] / count - m[0][1] * m[0][2] / (count * count);
  const double smallest = 0.5 * (uu + vv) - std::hypot(0.5 * (uu - vv), uv);
  if (smallest < kMinExtent * kMinExtent * h * h) return {};
  const std::array<double, 3> fit = Solve(m, y);
  return CutPlane{plane.p_W + fit[0] * n, glm::normalize(n - fit[1] * eu - fit[2] * ev)};
}

using Cube = std::array<int, 3>;

Cube CubeOf(const Vec3& p_W) {
  Cube cube{};
  for (int a = 0; a < 3; ++a) cube[static_cast<std::size_t>(a)] = static_cast<int>(std::floor(p_W[a] / kCube_mm));
  return cube;
}

/// Returns the number of the part to which each cube belongs, without cubes that lost less than kLeast_mm3.
std::map<Cube, std::size_t> FindParts(std::span<const RemovedCell> cells) {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::map<Cube, double> lost_mm3;
  for (const RemovedCell& cell : cells) lost_mm3[CubeOf(cell.p_W)] += cell.mm3;
  std::map<Cube, std::size_t> parts;
  for (const auto& [cube, mm3] : lost_mm3) {
    if (mm3 >= kLeast_mm3) parts.emplace(cube, kNone);
  }
  std::size_t count = 0;
  for (auto& [start, number] : parts) {
    if (number != kNone) continue;
    number = count++;
    for (std::vector<Cube> open{start}; !open.empty();) {
      const Cube at = open.back();
      open.pop_back();
      for (int i = 0; i < 27; ++i) {
        const auto near = parts.find({at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1});
        if (near == parts.end() || near->second != kNone) continue;
        near->second = number;
        open.push_back(near->first);
      }
    }
  }
  return parts;
}

std::optional<MomentFit> FitRemoved(std::span<const RemovedCell> cells) {
  std::vector<WeightedPoint> removed;
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 > 0) removed.push_back({cell.p_W, cell.mm3});
  }
  const std::optional<MomentFit> fit = FitMoments(removed, 1);
  return fit && fit->breadth >= kFlat * fit->thickness ? fit : std::nullopt;
}

/// Returns the cells without those of stray cuts, which are not in the plane of the others.
std::vector<RemovedCell> LeaveOutStrayCuts(std::span<const RemovedCell> cells) {
  const std::map<Cube, std::size_t> parts = FindParts(cells);
  const auto part_of = [&](const RemovedCell& cell) {
    const auto found = parts.find(CubeOf(cell.p_W));
    return found == parts.end() ? std::optional<std::size_t>() : found->second;
  };
  std::vector<double> mm3;
  std::vector<Vec3> moment;
  for (const RemovedCell& cell : cells) {
    const std::optional<std::size_t> part = part_of(cell);
    if (!part || !(cell.mm3 > 0)) continue;
    if (mm3.size() <= *part) {
      mm3.resize(*part + 1);
      moment.resize(*part + 1, Vec3(0));
    }
    mm3[*part] += cell.mm3;
    moment[*part] += cell.mm3 * cell.p_W;
  }
  std::vector<RemovedCell> kept(cells.begin(), cells.end());
  if (mm3.size() < 2) return kept;
  const auto largest = static_cast<std::size_t>(std::max_element(mm3.begin(), mm3.end()) - mm3.begin());
  std::vector<RemovedCell> main;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(main),
               [&](const RemovedCell& cell) { return part_of(cell) == largest; });
  const std::optional<MomentFit> fit = FitRemoved(main);
  if (!fit) return kept;
  std::vector<bool> is_stray(mm3.size());
  for (std::size_t i = 0; i < mm3.size(); ++i) {
    is_stray[i] = i != largest && std::abs(glm::dot(moment[i] / mm3[i] - fit->p, fit->normal)) > kStray_mm;
  }
  if (std::find(is_stray.begin(), is_stray.end(), true) == is_stray.end()) return kept;
  std::erase_if(kept, [&](const RemovedCell& cell) {
    const std::optional<std::size_t> part = part_of(cell);
    return !part || is_stray[*part];
  });
  return kept;
}

}  // namespace

std::optional<MidPlane> FitMidPlane(const Bone& before, const Bone& after, std::span<const RemovedCell> removed) {
  const std::vector<RemovedCell> cells = LeaveOutStrayCuts(removed);
  const std::optional<MomentFit> fit = FitRemoved(cells);
  if (!fit) return {};
  MidPlane fitted{.plane = {fit->p, fit->normal}, .extent_mm = fit->breadth, .thickness_mm = fit->thickness};
  const PhiSampler phi_before(before);
  const PhiSampler phi_after(after);
  for (int refinement = 0; refinement < kRefinements; ++refinement) {
    const std::optional<CutPlane> refined = Refine(phi_before, phi_after, fitted.plane, cells);
    if (!refined) break;
    fitted.plane = *refined;
  }
  return fitted;
}

}  // namespace kerf
