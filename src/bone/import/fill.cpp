#include "bone/import/fill.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include "bone/import/components.h"

namespace kerf {

namespace {

constexpr int kDirections = 60;

std::array<Vec3, kDirections> SpreadDirections() {
  std::array<Vec3, kDirections> all{};
  const double turn = std::numbers::pi * (3 - std::sqrt(5.0));  // golden angle: a Fibonacci sphere
  for (int n = 0; n < kDirections; ++n) {
    const double z = 1 - (2 * n + 1.0) / kDirections;
    const double r = std::sqrt(1 - z * z);
    all[n] = {r * std::cos(turn * n), r * std::sin(turn * n), z};
  }
  return all;
}

}  // namespace

std::vector<std::uint8_t> FindCavities(const Volume& lattice, const std::vector<std::uint8_t>& bone,
                                       const FillOptions& options, const std::function<void(double)>& progress) {
  const std::array<int, 3> n = lattice.size;
  // Voids that are completely enclosed.
  const Components voids = FindComponents(lattice, [&](std::size_t v) { return bone[v] == 0; });
  std::vector<bool> leads_out(voids.list.size() + 1, false);
  for (std::size_t c = 0; c < voids.list.size(); ++c) {
    for (int a = 0; a < 3; ++a) {
      if (voids.list[c].lower[a] == 0 || voids.list[c].upper[a] == n[a] - 1) leads_out[c + 1] = true;
    }
  }
  // The steps, in index space, have a length of two thirds of the smallest spacing.
  const double step_mm = 0.67 * std::min({lattice.spacing_mm.x, lattice.spacing_mm.y, lattice.spacing_mm.z});
  const int steps = static_cast<int>(options.reach_mm / step_mm);
  std::array<Vec3, kDirections> rays = SpreadDirections();
  for (Vec3& ray : rays) ray = ray * step_mm / lattice.spacing_mm;
  const int allowed = static_cast<int>(std::floor(kDirections * (1 - options.enclosed)));

  std::vector<std::uint8_t> cavity(bone.size(), 0);
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<int> done{0};
  tbb::parallel_for(0, n[2], [&](int k) {
    const int now = done.fetch_add(1);
    if (progress && std::this_thread::get_id() == caller) progress(static_cast<double>(now) / n[2]);
    for (int j = 0; j < n[1]; ++j) {
      for (int i = 0; i < n[0]; ++i) {
        const std::size_t v = lattice.Index(i, j, k);
        if (bone[v] != 0) continue;
        if (!leads_out[voids.labels[v]]) {
          cavity[v] = 1;
          continue;
        }
        int open = 0;
        for (int r = 0; r < kDirections && open <= allowed; ++r) {
          Vec3 p = Vec3(i, j, k) + 0.5;
          bool met = false;
          for (int s = 0; s < steps && !met; ++s) {
            p += rays[r];
            if (p.x < 0 || p.y < 0 || p.z < 0) break;
            const std::array<int, 3> at = {static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)};
            if (at[0] >= n[0] || at[1] >= n[1] || at[2] >= n[2]) break;
            met = bone[lattice.Index(at[0], at[1], at[2])] != 0;
          }
          if (!met) ++open;
        }
        if (open <= allowed) cavity[v] = 1;
      }
    }
  });
  return cavity;
}

}  // namespace kerf
