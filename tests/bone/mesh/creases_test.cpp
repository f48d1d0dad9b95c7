// Normals for drawing.
#include "bone/mesh/creases.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace kerf {
namespace {

/// Makes a prism with a regular polygon of `sides` corners around the z axis, and triangles around the middles of its
/// two faces.
TriangleMesh MakePrism(std::uint32_t sides) {
  TriangleMesh mesh;
  for (const double z : {0.0, 1.0}) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      mesh.points.emplace_back(std::cos(angle), std::sin(angle), z);
    }
  }
  mesh.points.emplace_back(0, 0, 0);
  mesh.points.emplace_back(0, 0, 1);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t j = (i + 1) % sides;
    mesh.triangles.push_back({i, j, sides + j});
    mesh.triangles.push_back({i, sides + j, sides + i});
    mesh.triangles.push_back({2 * sides, j, i});
    mesh.triangles.push_back({2 * sides + 1, sides + i, sides + j});
  }
  return mesh;
}

TEST(Creases, SharpEdgesAreSplitAndKeepTheNormalsOfTheirSides) {
  const TriangleMesh cube = MakePrism(4);
  const CreasedMesh creased = SplitAtCreases(cube);
  // Each of the eight corners is on three faces.
  EXPECT_EQ(creased.repeated.size(), 16u);
  ASSERT_EQ(creased.mesh.points.size(), cube.points.size() + 16);
  ASSERT_EQ(creased.normals.size(), creased.mesh.points.size());
  ASSERT_EQ(creased.mesh.triangles.size(), cube.triangles.size());
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) {
    const auto& [a, b, c] = cube.triangles[t];
    const Vec3 n = glm::normalize(glm::cross(cube.points[b] - cube.points[a], cube.points[c] - cube.points[a]));
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = creased.mesh.triangles[t][k];
      EXPECT_EQ(creased.mesh.points[p], cube.points[cube.triangles[t][k]]);
      // Single precision.
      EXPECT_NEAR(glm::length(Vec3(creased.normals[p]) - n), 0, 1e-6);
    }
  }
  for (std::size_t i = 0; i < creased.repeated.size(); ++i) {
    EXPECT_EQ(creased.mesh.points[cube.points.size() + i], cube.points[creased.repeated[i]]);
  }
}

TEST(Creases, SmoothSurfacesShareNormals) {
  // The sides of this prism meet at 10 degrees, and its two faces meet them at a right angle.
  constexpr std::uint32_t kSides = 36;
  const CreasedMesh creased = SplitAtCreases(MakePrism(kSides));
  EXPECT_EQ(creased.repeated.size(), 2 * kSides);
  std::size_t radial = 0;
  for (std::size_t p = 0; p < creased.normals.size(); ++p) {
    const Vec3 n(creased.normals[p]);
    EXPECT_NEAR(glm::length(n), 1, 1e-6);
    const Vec3& at = creased.mesh.points[p];
    if (std::abs(n.z) > 0.5) continue;
    ++radial;
    // A corner has one triangle of one side and two of the other: the mean of the normals is at most a sixth of 10
    // degrees off the radius.
    EXPECT_GT(glm::dot(n, glm::normalize(Vec3(at.x, at.y, 0))), std::cos(2 * std::numbers::pi / 180));
  }
  EXPECT_EQ(radial, 2 * kSides);
}

TEST(Creases, EmptyAndDegenerateMeshes) {
  EXPECT_TRUE(SplitAtCreases({}).normals.empty());
  TriangleMesh flat;
  flat.points.assign(3, Vec3(1, 2, 3));
  flat.triangles.push_back({0, 1, 2});
  const CreasedMesh creased = SplitAtCreases(flat);
  EXPECT_TRUE(creased.repeated.empty());
  for (const glm::vec3& n : creased.normals) EXPECT_EQ(n, glm::vec3(0));
}

}  // namespace
}  // namespace kerf
