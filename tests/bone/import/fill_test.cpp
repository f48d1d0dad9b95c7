// Cavities of bone.
#include "bone/import/fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "bone/import/components.h"

namespace kerf {
namespace {

// FindCavities() as its description says, with each ray followed step by step.
std::vector<std::uint8_t> FindCavitiesStepByStep(const Volume& lattice, const std::vector<std::uint8_t>& bone,
                                                 const FillOptions& options) {
  constexpr int kRays = 60;
  const double step_mm = 0.67 * std::min({lattice.spacing_mm.x, lattice.spacing_mm.y, lattice.spacing_mm.z});
  const int steps = static_cast<int>(options.reach_mm / step_mm);
  const int allowed = static_cast<int>(std::floor(kRays * (1 - options.enclosed)));
  const Components voids = FindComponents(lattice, [&](std::size_t v) { return bone[v] == 0; });
  std::vector<std::uint8_t> cavity(bone.size(), 0);
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(lattice.size[2]); ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i, ++v) {
        if (bone[v] != 0) continue;
        const Component& part = voids.list[static_cast<std::size_t>(voids.labels[v] - 1)];
        bool leads_out = false;
        for (std::size_t a = 0; a < 3; ++a) leads_out |= part.lower[a] == 0 || part.upper[a] == lattice.size[a] - 1;
        int open = 0;
        for (int n = 0; n < kRays; ++n) {
          const double z = 1 - (2 * n + 1.0) / kRays, r = std::sqrt(1 - z * z);
          const double turn = std::numbers::pi * (3 - std::sqrt(5.0)) * n;
          const Vec3 ray = Vec3(r * std::cos(turn), r * std::sin(turn), z) * step_mm / lattice.spacing_mm;
          Vec3 p = Vec3(i, j, static_cast<double>(k)) + 0.5;
          bool met = false;
          for (int s = 0; s < steps && !met; ++s) {
            p += ray;
            const Vec3 at = glm::floor(p);
            const std::array<int, 3> ijk = {static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)};
            if (!lattice.Contains(ijk)) break;
            met = bone[lattice.Index(ijk[0], ijk[1], ijk[2])] != 0;
          }
          open += met ? 0 : 1;
        }
        cavity[v] = !leads_out || open <= allowed ? 1 : 0;
      }
    }
  }
  return cavity;
}

TEST(FindCavities, EqualsRaysThatAreFollowedStepByStep) {
  std::mt19937 random(7);
  for (const Vec3& spacing_mm : {Vec3(0.9), Vec3(0.6, 0.8, 1.5)}) {
    Volume lattice;
    lattice.size = {41, 34, 27};
    lattice.spacing_mm = spacing_mm;
    // A thick shell with holes, and crumbs.
    std::vector<std::uint8_t> bone(lattice.count(), 0);
    std::bernoulli_distribution is_hole(0.15), is_crumb(0.01);
    for (std::size_t v = 0; v < bone.size(); ++v) {
      const Vec3 at(v % 41, v / 41 % 34, v / (41 * 34));
      const double radius_mm = glm::length(spacing_mm * (at - Vec3(20, 16, 13)));
      bone[v] = (radius_mm > 7 && radius_mm < 8.5 && !is_hole(random)) || is_crumb(random) ? 1 : 0;
    }
    FillOptions options;
    options.reach_mm = 11;
    const std::vector<std::uint8_t> cavities = FindCavities(lattice, bone, options);
    EXPECT_EQ(cavities, FindCavitiesStepByStep(lattice, bone, options));
    EXPECT_EQ(cavities[lattice.Index(20, 16, 13)] | bone[lattice.Index(20, 16, 13)], 1);
    EXPECT_EQ(cavities[0], 0);
  }
}

}  // namespace
}  // namespace kerf
