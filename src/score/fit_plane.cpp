// A plane through what was removed: first by volume, then by the middles of squares of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <utility>

#include "core/symmetric_eigen.h"
#include "score/cut_measures.h"

namespace kerf {
namespace {

/// A removed volume has a plane where its shorter extent in it is so many times the extent across.
constexpr double kFlat = 1.5;
/// Edge of a square, in voxels; and the share of the usual volume that it must have lost to count.
constexpr double kSquare = 1.5;
constexpr double kFull = 0.6;
/// Fewer full squares than this: the fit by volume stands.
constexpr std::size_t kLeastSquares = 12;
constexpr int kTurns = 2;

using Matrix = std::array<std::array<double, 3>, 3>;

double Determinant(const Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// x of m x = y, by Cramer's rule; 0 for a matrix that has none.
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

/// What a square of the plane lost.
struct Square {
  double mm3 = 0;
  double u = 0;  // sums by volume
  double v = 0;
  double w = 0;
};

std::optional<CutPlane> Refine(const CutPlane& plane, std::span<const RemovedCell> cells, double voxel_mm) {
  const Vec3 n = plane.normal_W;
  const Vec3 least = std::abs(n.x) < 0.6 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 eu = glm::normalize(glm::cross(n, least));
  const Vec3 ev = glm::cross(n, eu);
  const double edge_mm = kSquare * voxel_mm;
  std::map<std::pair<int, int>, Square> squares;
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 <= 0) continue;
    const Vec3 d = cell.p_W - plane.p_W;
    const double u = glm::dot(d, eu);
    const double v = glm::dot(d, ev);
    Square& square = squares[{static_cast<int>(std::floor(u / edge_mm)), static_cast<int>(std::floor(v / edge_mm))}];
    square.mm3 += cell.mm3;
    square.u += cell.mm3 * u;
    square.v += cell.mm3 * v;
    square.w += cell.mm3 * glm::dot(d, n);
  }
  std::vector<double> volumes;
  for (const auto& [place, square] : squares) volumes.push_back(square.mm3);
  const auto middle = volumes.begin() + static_cast<std::ptrdiff_t>(volumes.size() / 2);
  std::nth_element(volumes.begin(), middle, volumes.end());
  const double least_mm3 = kFull * *middle;
  const auto is_full = [&](int i, int k) {
    const auto found = squares.find({i, k});
    return found != squares.end() && found->second.mm3 >= least_mm3;
  };
  Matrix m{};
  std::array<double, 3> y{};
  std::size_t count = 0;
  for (const auto& [place, square] : squares) {
    const auto [i, k] = place;
    if (!is_full(i, k) || !is_full(i - 1, k) || !is_full(i + 1, k) || !is_full(i, k - 1) || !is_full(i, k + 1)) {
      continue;
    }
    const std::array<double, 3> x{1, square.u / square.mm3, square.v / square.mm3};
    for (std::size_t a = 0; a < 3; ++a) {
      y[a] += x[a] * square.w / square.mm3;
      for (std::size_t b = 0; b < 3; ++b) m[a][b] += x[a] * x[b];
    }
    ++count;
  }
  if (count < kLeastSquares) return {};
  const std::array<double, 3> fit = Solve(m, y);
  return CutPlane{plane.p_W + fit[0] * n, glm::normalize(n - fit[1] * eu - fit[2] * ev)};
}

}  // namespace

std::optional<MiddlePlane> FitMiddlePlane(std::span<const RemovedCell> cells, double voxel_mm) {
  double sum = 0;
  Vec3 centre_W{0};
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 <= 0) continue;
    sum += cell.mm3;
    centre_W += cell.mm3 * cell.p_W;
  }
  if (!(sum > 0)) return {};
  centre_W /= sum;
  Matrix spread{};
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 <= 0) continue;
    const Vec3 d = cell.p_W - centre_W;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        spread[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] += cell.mm3 / sum * d[i] * d[k];
      }
    }
  }
  const SymmetricEigen eigen = CalcSymmetricEigen(spread);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return eigen.values[a] < eigen.values[b]; });
  MiddlePlane fitted;
  fitted.plane = {centre_W, glm::normalize(eigen.vectors[order[0]])};
  fitted.thickness_mm = std::sqrt(std::max(eigen.values[order[0]], 0.0));
  fitted.extent_mm = std::sqrt(std::max(eigen.values[order[1]], 0.0));
  if (fitted.extent_mm < kFlat * fitted.thickness_mm) return {};
  for (int turn = 0; turn < kTurns; ++turn) {
    const std::optional<CutPlane> refined = Refine(fitted.plane, cells, voxel_mm);
    if (!refined) break;
    fitted.plane = *refined;
  }
  return fitted;
}

}  // namespace kerf
