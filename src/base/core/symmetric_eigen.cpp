#include "base/core/symmetric_eigen.h"

#include <cmath>
#include <utility>

namespace kerf {

SymmetricEigen CalcSymmetricEigen(std::array<std::array<double, 3>, 3> a) {
  std::array<Vec3, 3> v = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
      if (a[p][q] == 0) continue;
      const double angle = 0.5 * std::atan2(2 * a[p][q], a[q][q] - a[p][p]);
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      for (std::size_t k = 0; k < 3; ++k) {
        const double kp = a[k][p];
        const double kq = a[k][q];
        a[k][p] = c * kp - s * kq;
        a[k][q] = s * kp + c * kq;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const double pk = a[p][k];
        const double qk = a[q][k];
        a[p][k] = c * pk - s * qk;
        a[q][k] = s * pk + c * qk;
      }
      const Vec3 vp = v[p];
      v[p] = c * vp - s * v[q];
      v[q] = s * vp + c * v[q];
    }
  }
  return {{a[0][0], a[1][1], a[2][2]}, v};
}

PointSpread CalcPointSpread(const std::vector<Vec3>& points) {
  PointSpread spread;
  for (const Vec3& p : points) spread.mean += p / static_cast<double>(points.size());
  std::array<std::array<double, 3>, 3> scatter{};
  for (const Vec3& p : points) {
    const Vec3 d = p - spread.mean;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) scatter[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += d[i] * d[j];
    }
  }
  spread.scatter = CalcSymmetricEigen(scatter);
  return spread;
}

}  // namespace kerf
