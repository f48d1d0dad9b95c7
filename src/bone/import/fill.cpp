#include "bone/import/fill.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

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

// Lowers `row` to one more than the least of a row beside it and of its neighbours there.
void LowerByRow(const std::uint8_t* beside, int count, std::uint8_t* row) {
  const auto plus_one = [](int steps) { return static_cast<std::uint8_t>(std::min(steps, 254) + 1); };
  for (int x = 1; x + 1 < count; ++x) {
    row[x] = std::min(row[x], plus_one(std::min({beside[x - 1], beside[x], beside[x + 1]})));
  }
  for (const int x : {0, count - 1}) {
    row[x] = std::min(row[x], plus_one(std::min(beside[std::max(x - 1, 0)], beside[std::min(x + 1, count - 1)])));
    row[x] = std::min(row[x], plus_one(beside[x]));
  }
}

// Returns for each voxel the number of steps to the nearest bone, at most 255, where a step goes to any of the 26
// voxels around: no bone lies in the box of fewer steps around it. Two sweeps, each over the half of the neighbours
// before.
std::vector<std::uint8_t> CountStepsToBone(const Volume& lattice, const std::vector<std::uint8_t>& bone) {
  std::vector<std::uint8_t> steps(bone.size());
  for (std::size_t v = 0; v < bone.size(); ++v) steps[v] = bone[v] != 0 ? 0 : 255;
  const std::array<int, 3>& n = lattice.size;
  for (const int way : {1, -1}) {
    for (int z = 0; z < n[2]; ++z) {
      const int k = way > 0 ? z : n[2] - 1 - z;
      for (int y = 0; y < n[1]; ++y) {
        const int j = way > 0 ? y : n[1] - 1 - y;
        std::uint8_t* const row = &steps[lattice.Index(0, j, k)];
        for (const auto& [dj, dk] : {std::pair(-way, 0), std::pair(-1, -way), std::pair(0, -way), std::pair(1, -way)}) {
          if (j + dj < 0 || j + dj >= n[1] || k + dk < 0 || k + dk >= n[2]) continue;
          LowerByRow(&steps[lattice.Index(0, j + dj, k + dk)], n[0], row);
        }
        for (int x = 1; x < n[0]; ++x) {
          const int i = way > 0 ? x : n[0] - 1 - x;
          row[i] = static_cast<std::uint8_t>(std::min<int>(row[i], row[i - way] + 1));
        }
      }
    }
  }
  return steps;
}

// Returns whether bone is found along a ray from the middle of a voxel, in as many steps. Where no bone is near, it
// takes several steps at once.
bool MeetsBone(const Volume& lattice, const std::vector<std::uint8_t>& steps_to_bone, const std::array<int, 3>& from,
               const Vec3& ray, int steps) {
  const double fastest = std::max({std::abs(ray.x), std::abs(ray.y), std::abs(ray.z)});  // voxels in a step, below 1
  Vec3 p = Vec3(from[0], from[1], from[2]) + 0.5;
  int near = steps_to_bone[lattice.Index(from[0], from[1], from[2])];
  for (int done = 0; done < steps;) {
    const int ahead = std::max(1, static_cast<int>(std::ceil((near - 1) / fastest)));
    done += ahead;
    if (done > steps) return false;
    p += static_cast<double>(ahead) * ray;
    if (p.x < 0 || p.y < 0 || p.z < 0) return false;
    const std::array<int, 3> at = {static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)};
    if (at[0] >= lattice.size[0] || at[1] >= lattice.size[1] || at[2] >= lattice.size[2]) return false;
    near = steps_to_bone[lattice.Index(at[0], at[1], at[2])];
    if (near == 0) return true;
  }
  return false;
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
  const std::vector<std::uint8_t> steps_to_bone = CountStepsToBone(lattice, bone);
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
          if (!MeetsBone(lattice, steps_to_bone, {i, j, k}, rays[r], steps)) ++open;
        }
        if (open <= allowed) cavity[v] = 1;
      }
    }
  });
  return cavity;
}

}  // namespace kerf
