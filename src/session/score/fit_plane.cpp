// Fits a plane to removed bone: first by volume, then half-way between the two walls of the kerf, whose positions are
// accurate to a small fraction of a voxel.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "session/plan/moments.h"
#include "session/score/cut_measures.h"

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

}  // namespace

std::optional<MidPlane> FitMidPlane(const Bone& before, const Bone& after, std::span<const RemovedCell> cells) {
  std::vector<WeightedPoint> removed;
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 > 0) removed.push_back({cell.p_W, cell.mm3});
  }
  const std::optional<MomentFit> fit = FitMoments(removed, 1);
  if (!fit || fit->breadth < kFlat * fit->thickness) return {};
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
