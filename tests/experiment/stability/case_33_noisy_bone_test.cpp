// Hard cases 33 and 34: bone with noisy stiffness, with a noisy surface, and with labelled layers one voxel thick.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <vector>

#include "bone/grid/build.h"
#include "cut/hand_sim/hands.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::PushingHand;
using test::Verdict;

constexpr double kVoxel = 0.2;

/// Returns a pseudo-random value from 0 to 255, always the same for the same voxel.
int NoiseAt(const Vec3& p_W, std::uint64_t seed) {
  std::uint64_t h = seed;
  for (int k = 0; k < 3; ++k) {
    h ^= static_cast<std::uint64_t>(std::llround(p_W[k] / kVoxel) + (1 << 20));
    h *= 0x9e3779b97f4a7c15U;
    h ^= h >> 29;
  }
  return static_cast<int>(h >> 56);
}

constexpr double kFull_MPa = 30000;
double ModulusOf(int id) {
  return kFull_MPa * (id + 0.5) / 256;
}

/// Returns the modulus whose reduced modulus with the saw is the mean over all 255 regions.
double CalcMeanModulus() {
  double mean = 0;
  for (int id = 1; id < 256; ++id) mean += CalcReducedModulus(kSaw.E_MPa, kSaw.nu, ModulusOf(id), 0.28) / 255;
  double low = 0;
  double high = kFull_MPa;
  for (int n = 0; n < 60; ++n) {
    const double E = 0.5 * (low + high);
    (CalcReducedModulus(kSaw.E_MPa, kSaw.nu, E, 0.28) < mean ? low : high) = E;
  }
  return low;
}

/// Returns a block of 26 x 3 x 10 mm with its top at z = 5. Each voxel has a random region, or all have one region with
/// the mean stiffness.
Bone MakeNoisyBlock(bool noisy, double surface_mm = 0) {
  SolidField field;
  field.value = [surface_mm](const Vec3& p) {
    return test::BoxDistance(p, {13, 1.5, 5}) + surface_mm * (NoiseAt(p, 2) / 127.5 - 1);
  };
  field.classify = [surface_mm](const Vec3& p, double radius) {
    const double d = test::BoxDistance(p, {13, 1.5, 5});
    const double far = radius + surface_mm;
    return d > far ? BlockClass::kOutside : d < -far ? BlockClass::kInside : BlockClass::kMixed;
  };
  field.region = [noisy](const Vec3& p) { return noisy ? std::max(1, NoiseAt(p, 1)) : 1; };
  MaterialTable table;
  const double mean = CalcMeanModulus();
  for (int id = 1; id < 256; ++id) {
    table.Add({id, "noise", Tissue::kCortical, noisy ? ModulusOf(id) : mean, 0.28, true, "test"});
  }
  return MakeBone(field, Box3{{-13, -1.5, -5}, {13, 1.5, 5}}.Grown(6 * kVoxel), {kVoxel, kVoxel, {}}, table);
}

struct NoisyCut {
  double noise_N = 0;
  double mean_N = 0;
  double feed_mm_per_s = 0;
};

/// Cuts 3 mm deep along the block at 5 mm/s or, if `pushed`, down into it with a push of 5 N.
NoisyCut CutNoisy(const Bone& bone, bool pushed) {
  const Pose start = DiscPose(Pose{}, pushed ? Vec3(0, 0, 5 + kR + 0.1) : Vec3(-23, 0, 5 + kR - 3));
  CoupledSimulation simulation(bone, test::DiscParams(), start);
  PushingHand hand(simulation, start);
  std::vector<Vec3> f;
  Vec3 sum(0);
  Vec3 from(0);
  CoupledOutput out;
  for (int i = 0; i < 12000; ++i) {
    Pose X = start;
    X.p_AB.x += 0.005 * i;
    out = pushed ? hand.Push({0, 0, -5}) : simulation.Tick(Handle(X));
    const Vec3 p = out.X_WT.p_AB;
    if (pushed ? p.z > 4 + kR : p.x < -7) continue;
    if (f.empty()) from = p;
    f.push_back(out.f_H_W_N);
    sum += out.f_H_W_N;
    if (pushed ? p.z < kR - 3 : p.x > 5) break;
  }
  EXPECT_GT(f.size(), 200U);
  NoisyCut heard;
  heard.noise_N = CalcNoise(f, 0.001);
  heard.mean_N = glm::length(sum) / static_cast<double>(f.size());
  heard.feed_mm_per_s = glm::length(out.X_WT.p_AB - from) / (0.001 * static_cast<double>(f.size()));
  return heard;
}

TEST(HardCase33, NoisyStiffnessAddsLittleNoiseAndKeepsTheMean) {
  Verdict verdict("holds");
  const Bone noisy = MakeNoisyBlock(true);
  const Bone even = MakeNoisyBlock(false);
  double worst_noise = -1e9;
  for (const bool pushed : {false, true}) {
    const NoisyCut rough = CutNoisy(noisy, pushed);
    const NoisyCut smooth = CutNoisy(even, pushed);
    worst_noise = std::max(worst_noise, 100 * (rough.noise_N / rough.mean_N - smooth.noise_N / smooth.mean_N));
    if (pushed) {
      verdict.AtMost("feed error at 5 N", 100 * std::abs(rough.feed_mm_per_s / smooth.feed_mm_per_s - 1), 3, "%");
    } else {
      verdict.AtMost("force error at 5 mm/s", 100 * std::abs(rough.mean_N / smooth.mean_N - 1), 3, "%");
    }
  }
  // At each of about fifty places along the arc there is a voxel with a different stiffness.
  verdict.AtMost("C1 in excess of that of uniform bone", worst_noise, 2, "% of the mean");
}

TEST(HardCase33, RaggedThresholdSurfaceAddsLittleNoise) {
  Verdict verdict("holds");
  // The surface deviates at random by up to half a voxel, like one from a CT threshold. The saw cuts along the block, 3
  // mm deep.
  const NoisyCut rough = CutNoisy(MakeNoisyBlock(false, 0.5 * kVoxel), false);
  const NoisyCut smooth = CutNoisy(MakeNoisyBlock(false), false);
  verdict.AtMost("C1 in excess of that of uniform bone",
                 100 * (rough.noise_N / rough.mean_N - smooth.noise_N / smooth.mean_N), 2, "% of the mean");
  verdict.AtMost("force error", 100 * std::abs(rough.mean_N / smooth.mean_N - 1), 5, "%");
}

/// Returns a block of 26 x 3 x 10 mm with its top at z = 5, of region 24 with a layer of region 7 (as soft as a nerve).
/// The layer is one voxel thick, and its middle is at z = `z_mm`. If `cell` is true, only one voxel of the layer has
/// region 7.
Bone MakeLayeredBlock(double z_mm, bool cell = false) {
  SolidField field;
  field.value = [](const Vec3& p) { return test::BoxDistance(p, {13, 1.5, 5}); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [=](const Vec3& p) {
    const bool in = std::abs(p.z - z_mm) < 0.5 * kVoxel;
    const bool beside = std::abs(p.x) < 0.5 * kVoxel && std::abs(p.y) < 0.5 * kVoxel;
    return in && (beside || !cell) ? 7 : 24;
  };
  MaterialTable table;
  table.Add({24, "bone", Tissue::kCortical, 19300, 0.28, true, "test"});
  table.Add({7, "nerve", Tissue::kCanal, 1.3, 0.49, true, "test"});
  return MakeBone(field, Box3{{-13, -1.5, -5}, {13, 1.5, 5}}.Grown(6 * kVoxel), {kVoxel, kVoxel, {}}, table);
}

TEST(HardCase34, ALayerOfOneVoxelIsReportedInTheTickThatReachesIt) {
  Verdict verdict(
      "applies in part, corrected: the tick now reports the regions that teeth cut; scores are computed afterwards");
  double latest_mm = 0;
  double earliest_mm = 0;
  for (const double push_N : {1.0, 5.0, 30.0}) {
    const double z_layer = 3.0;
    CoupledSimulation simulation(MakeLayeredBlock(z_layer), test::DiscParams(), DiscPose(Pose{}, {0, 0, 5 + kR + 0.1}));
    PushingHand hand(simulation, DiscPose(Pose{}, {0, 0, 5 + kR + 0.1}));
    bool reported = false;
    double before = 5.1;
    for (int i = 0; i < 6000 && !reported; ++i) {
      const CoupledOutput out = hand.Push({0, 0, -push_N});
      const double rim = out.X_WT.p_AB.z - kR;
      reported = out.HasCut(7);
      EXPECT_EQ(out.HasCut(24), out.thrust_sum_N > 0);
      EXPECT_FALSE(out.HasCut(0) || out.HasCut(255) || out.HasCut(-1) || out.HasCut(256));
      // The layer's upper face is half a voxel above its middle.
      const double face = z_layer + 0.5 * kVoxel;
      if (reported) {
        // Between the start and the end of the tick the rim reached the face, except for the look-ahead of a tooth.
        latest_mm = std::max(latest_mm, face - before);
        earliest_mm = std::max(earliest_mm, rim - face);
      } else {
        EXPECT_GT(rim, face - 0.5 * kVoxel);
      }
      before = rim;
    }
    EXPECT_TRUE(reported);
  }
  verdict.AtMost("distance by which it was reported early", earliest_mm, 0.25 * kVoxel, "mm");
  verdict.AtMost("distance of the rim beyond the layer's face at the start of the tick", latest_mm, 0, "mm");
}

TEST(HardCase34, RemovedVolumeOfALabelIsCountedExactly) {
  Verdict verdict(
      "applies in part: for each label, the count equals the decrease of the bone's volume exactly; the volumes are "
      "accurate to a fraction of a voxel");
  for (const bool cell : {false, true}) {
    const Bone bone = MakeLayeredBlock(3.0, cell);
    CoupledSimulation simulation(bone, test::DiscParams(), DiscPose(Pose{}, {0, 0, 5 + kR + 0.1}));
    double z = 0;
    for (int i = 0; i < 4000; ++i) {
      z = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 5 + kR + 0.1 - 0.006 * std::min(i, 1500)}))).X_WT.p_AB.z;
    }
    ASSERT_LT(z, kR + 2.5);
    const std::array<double, 256> removed = simulation.CalcRemovedByRegion();
    std::map<int, double> before = bone.CalcRegionVolumes();
    std::map<int, double> after = simulation.UpdateBone().CalcRegionVolumes();
    double worst = 0;
    for (const int id : {7, 24}) worst = std::max(worst, std::abs(before[id] - after[id] - removed[id]));
    const double total = std::accumulate(removed.begin(), removed.end(), 0.0);
    EXPECT_NEAR(removed[7] + removed[24], total, 1e-12);
    if (cell) {
      // The voxel is 0.2 mm wide and the kerf 0.25 mm, so all of the voxel is removed. But a cell between voxel centres
      // that is partly cut is attributed to each of its labels in the same proportion, which is 0.625 for cells at the
      // kerf's walls.
      verdict.AtMost("count error, single voxel", worst, 1e-9, "mm3");
      verdict.AtLeast("counted fraction of a single removed voxel", removed[7] / before[7], 0.6);
    } else {
      // The count is that of the length of the layer below the rim, one voxel high.
      verdict.AtMost("count error, layer", worst, 1e-9, "mm3");
      const auto half_chord = [&](double height) { return std::sqrt(kR * kR - (z - height) * (z - height)); };
      const double expected = 2 * half_chord(3.0) * kVoxel * kSaw.thickness_mm;
      EXPECT_NEAR(removed[7] / expected, 1, 0.05);
    }
  }
}

}  // namespace
}  // namespace kerf
