#include "base/core/symmetric_eigen.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <random>

namespace kerf {
namespace {

TEST(SymmetricEigen, VectorsAreOrthonormalAndScaledByTheirValues) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> draw(-10, 10);
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<std::array<double, 3>, 3> a{};
    for (std::size_t i = 0; i < 3; ++i) {
      // Every fourth matrix is diagonal, with two equal values.
      for (std::size_t j = i; j < 3; ++j) a[i][j] = a[j][i] = i == j || trial % 4 ? draw(random) : 0;
    }
    if (trial % 4 == 0) a[1][1] = a[0][0];
    const SymmetricEigen eigen = CalcSymmetricEigen(a);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& v = eigen.vectors[k];
      const Vec3 av(a[0][0] * v.x + a[0][1] * v.y + a[0][2] * v.z, a[1][0] * v.x + a[1][1] * v.y + a[1][2] * v.z,
                    a[2][0] * v.x + a[2][1] * v.y + a[2][2] * v.z);
      // Values are up to 30, and there are some dozens of rotations, each rounded to 1e-16.
      EXPECT_NEAR(glm::length(av - eigen.values[k] * v), 0, 1e-12);
      EXPECT_NEAR(glm::length(v), 1, 1e-13);
      EXPECT_NEAR(glm::dot(v, eigen.vectors[(k + 1) % 3]), 0, 1e-13);
    }
  }
}

}  // namespace
}  // namespace kerf
