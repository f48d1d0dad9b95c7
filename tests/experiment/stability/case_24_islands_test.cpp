// Hard case 24: single voxels, dust, and a checkerboard. Many tiny contacts cause no more force than the same bone in
// one piece.
#include <algorithm>
#include <numeric>
#include <random>

#include "base/core/high_pass.h"
#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "kerf/surface.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::InKerf;

constexpr double kVoxel_mm = 0.2;
const Vec3 kHalf(6, 1, 2);

/// Returns a block in which `is_bone` decides from a voxel's index whether it is bone. All distances are half a voxel,
/// positive or negative, because nothing else is known.
template <typename IsBone>
Bone Speckled(IsBone is_bone) {
  SolidField field;
  field.value = [is_bone](const Vec3& p) {
    const int i = static_cast<int>(std::lround(p.x / kVoxel_mm));
    const int j = static_cast<int>(std::lround(p.y / kVoxel_mm));
    const int k = static_cast<int>(std::lround(p.z / kVoxel_mm));
    const double block = test::BoxDistance(p, kHalf);
    return block < 0 && is_bone(i, j, k) ? -0.5 * kVoxel_mm : std::max(block, 0.5 * kVoxel_mm);
  };
  field.classify = [](const Vec3&, double) { return BlockClass::kMixed; };
  field.region = [](const Vec3&) { return 24; };
  return MakeBone(field, Box3{-kHalf, kHalf}.Grown(6 * kVoxel_mm), {kVoxel_mm, kVoxel_mm, {}}, test::OneRegionTable());
}

bool IsDust(int i, int j, int k, double fraction) {
  auto x = static_cast<std::uint64_t>(std::int64_t{i + 512} * 1048576 + std::int64_t{j + 512} * 1024 + (k + 512));
  x = (x ^ (x >> 31)) * 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 29)) * 0xBF58476D1CE4E5B9u;
  return static_cast<double>((x ^ (x >> 32)) >> 11) < fraction * 9007199254740992.0;
}

struct Cut {
  double volume_mm3 = 0;
  double max_N = 0;
  double max_step = 0;  // between ticks, in just-noticeable differences
  double noise_mN = 0;  // above 20 Hz
};

/// Cuts a kerf along x, 2 mm deep, at 5 mm/s.
Cut CutSlot(const Bone& bone) {
  Cut cut;
  const double z = kHalf.z + kR - 2;
  const double x_from = -kHalf.x - std::sqrt(kR * kR - (kR - 2) * (kR - 2)) - 0.5;
  test::Sawing saw(bone, DiscParams(), DiscPose(Pose{}, {x_from, 0, z}));
  Vec3 f_before(0);
  std::vector<double> f;
  for (int i = 1; i <= 2600; ++i) {
    saw.To(DiscPose(Pose{}, {x_from + 0.005 * i, 0, z}));
    const double now_N = glm::length(saw.out.f_H_W_N);
    cut.max_N = std::max(cut.max_N, now_N);
    cut.max_step = std::max(cut.max_step, glm::length(saw.out.f_H_W_N - f_before) / (0.07 * std::max(now_N, 0.5)));
    f_before = saw.out.f_H_W_N;
    if (i > 1200) f.push_back(saw.out.f_H_W_N.x);
  }
  cut.volume_mm3 = saw.invariants.removed_mm3();
  cut.noise_mN = 1000 * CalcHighPassRms(f, 0.001, 20);
  saw.invariants.CheckBone();
  return cut;
}

/// Returns the thrust of all teeth in each tick of the same cut, with the tool led along its path.
std::vector<double> ThrustAlongPath(const Bone& bone) {
  const double z = kHalf.z + kR - 2;
  const double x_from = -kHalf.x - std::sqrt(kR * kR - (kR - 2) * (kR - 2)) - 0.5;
  Simulation simulation(bone, {}, DiscPose(Pose{}, {x_from, 0, z}));
  std::vector<double> thrust_N;
  for (int i = 1; i <= 2600; ++i) {
    thrust_N.push_back(simulation.Tick({DiscPose(Pose{}, {x_from + 0.005 * i, 0, z}), 0.001, 7500}).thrust_sum_N);
  }
  return thrust_N;
}

TEST(HardCase24, IslandsNeedNoMoreForceThanOnePiece) {
  test::Verdict verdict("holds: a tooth's force depends on how much of its edge is engaged");
  const Cut bulk = CutSlot(Speckled([](int, int, int) { return true; }));
  ASSERT_GT(bulk.max_N, 0.3);
  const std::vector<double> bulk_N = ThrustAlongPath(Speckled([](int, int, int) { return true; }));
  const double bulk_sum_N = std::accumulate(bulk_N.begin(), bulk_N.end(), 0.0);
  const double bulk_max_N = *std::max_element(bulk_N.begin(), bulk_N.end());
  ASSERT_GT(bulk_max_N, 0.3);
  double max_force = 0;
  double max_thrust = 0;
  double max_sum = 0;
  double max_step = 0;
  double max_noise_mN = 0;
  const std::vector<std::pair<const char*, Bone>> bones = [] {
    std::vector<std::pair<const char*, Bone>> all;
    all.emplace_back("checkerboard", Speckled([](int i, int j, int k) { return (i + j + k) % 2 == 0; }));
    all.emplace_back("every third",
                     Speckled([](int i, int j, int k) { return i % 3 == 0 && j % 3 == 0 && k % 3 == 0; }));
    all.emplace_back("sheets", Speckled([](int i, int, int) { return i % 2 == 0; }));
    all.emplace_back("dust 10 %", Speckled([](int i, int j, int k) { return IsDust(i, j, k, 0.1); }));
    all.emplace_back("dust 50 %", Speckled([](int i, int j, int k) { return IsDust(i, j, k, 0.5); }));
    all.emplace_back("dust 90 %", Speckled([](int i, int j, int k) { return IsDust(i, j, k, 0.9); }));
    return all;
  }();
  for (const auto& [name, bone] : bones) {
    const Cut cut = CutSlot(bone);
    EXPECT_GT(cut.volume_mm3, 0.01) << name;
    EXPECT_LT(cut.volume_mm3, bulk.volume_mm3) << name;
    max_force = std::max(max_force, cut.max_N / bulk.max_N);
    double sum_N = 0;
    double most = 0;
    const std::vector<double> thrust_N = ThrustAlongPath(bone);
    for (std::size_t i = 0; i < thrust_N.size(); ++i) {
      sum_N += thrust_N[i];
      most = std::max(most, (thrust_N[i] - bulk_N[i]) / bulk_max_N);
    }
    max_thrust = std::max(max_thrust, most);
    max_sum = std::max(max_sum, sum_N / bulk_sum_N);
    max_step = std::max(max_step, cut.max_step);
    max_noise_mN = std::max(max_noise_mN, cut.noise_mN);
  }
  verdict.AtMost("largest force relative to that in a solid block", max_force, 1);
  // The islands are a part of the block, so along the same path at most the same teeth are engaged. Cuts in a hand
  // can't be compared by their work for a volume: the tool goes deeper where there is less bone, by up to 0.8 mm here,
  // and in the block the work for a volume is 1.5 times as large there.
  verdict.AtMost("thrust in a tick along the same path above that in a solid block", max_thrust, 1e-9);
  verdict.AtMost("work along the same path relative to that in a solid block", max_sum, 1);
  // When a grain breaks off, its force disappears at once.
  verdict.AtMost("largest force step in a tick in JND", max_step, 3);
  verdict.AtMost("force above 20 Hz", max_noise_mN, 20, "mN");
}

TEST(HardCase24, IslandsAreCountedExactlyAndSmallOnesLeftOutOnRequest) {
  test::Verdict verdict("holds");
  const Bone bone = Speckled([](int i, int j, int k) { return i % 3 == 0 && j % 3 == 0 && k % 3 == 0; });
  int expected = 0;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -10; j <= 10; ++j) {
      for (int k = -20; k <= 20; ++k) {
        const Vec3 p = kVoxel_mm * Vec3(i, j, k);
        expected += i % 3 == 0 && j % 3 == 0 && k % 3 == 0 && test::BoxDistance(p, kHalf) < -1e-9 ? 1 : 0;
      }
    }
  }
  verdict.Equal("one-voxel islands", static_cast<double>(SplitPieces(bone).pieces.size()), expected);
  const Pieces large = SplitPieces(bone, 1.5 * kVoxel_mm * kVoxel_mm * kVoxel_mm);
  EXPECT_EQ(large.pieces.size(), 0u);
  EXPECT_EQ(large.dust_count, static_cast<std::size_t>(expected));
}

TEST(HardCase24, AStoppedDiscRestsOnDustWithoutHammering) {
  test::Verdict verdict("holds, but single grains smaller than the spacing of the edge points may pass between them");
  double noise = 0;
  for (const double fraction : {0.5, 0.9}) {
    const Bone bone = Speckled([fraction](int i, int j, int k) { return IsDust(i, j, k, fraction); });
    test::Sawing saw(bone, DiscParams(), DiscPose(Pose{}, {0, 0.03, kHalf.z + kR + 0.3}));
    std::vector<double> f[3];
    for (int i = 1; i <= 2500; ++i) {
      saw.To(DiscPose(Pose{}, {0.0003 * i, 0.03, kHalf.z + kR + 0.3 - std::min(0.005 * i, 4.0)}), 0);
      if (i <= 1200) continue;
      for (int k = 0; k < 3; ++k) f[k].push_back(saw.out.f_H_W_N[k]);
    }
    EXPECT_GT(saw.out.f_H_W_N.z, 1) << fraction;
    EXPECT_EQ(saw.invariants.removed_mm3(), 0);
    double sum = 0;
    for (const auto& axis : f) sum += std::pow(CalcHighPassRms(axis, 0.001, 20), 2);
    noise = std::max(noise, std::sqrt(sum) / saw.out.f_H_W_N.z);
  }
  // The disc slides at 0.3 mm/s over grains of 0.2 mm.
  verdict.AtMost("force above 20 Hz while sliding over grains relative to the force", noise, 0.01);
}

}  // namespace
}  // namespace kerf
