// Bit-identical results for any number of threads: bones are built in parallel, which must not affect a cut.
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <bit>

#include "kerf/coupled.h"
#include "support/solids.h"

namespace kerf {
namespace {

struct Hashes {
  std::uint64_t bone_before = 0;
  std::uint64_t bone_after = 0;
  std::uint64_t forces = 0;
  bool operator==(const Hashes&) const = default;
};

Hashes CutWith(int threads) {
  const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                            static_cast<std::size_t>(threads));
  Bone bone =
      test::MakeBox({glm::angleAxis(0.3, glm::normalize(Vec3(1, 2, 3))), Vec3(0.01, 0.02, -4)}, {10, 8, 8}, 0.2);
  Hashes hashes;
  hashes.bone_before = bone.CalcHash();
  CoupledParams params;
  const Quat R = glm::angleAxis(1.57, glm::normalize(Vec3(1, 0.02, 0.01)));
  CoupledSimulation simulation(std::move(bone), params, {R, Vec3(0, 0, 12)});
  for (int i = 1; i <= 1500; ++i) {
    const CoupledOutput out = simulation.Tick({.X_WH = {R, Vec3(0.0003 * i, 0, 12 - 0.004 * i)}});
    for (const double value : {out.f_H_W_N.x, out.f_H_W_N.y, out.f_H_W_N.z, out.removed_mm3}) {
      hashes.forces = std::rotl(hashes.forces, 5) ^ std::bit_cast<std::uint64_t>(value);
    }
  }
  hashes.bone_after = simulation.UpdateBone().CalcHash();
  return hashes;
}

TEST(CoupledThreads, AnyNumberGivesTheSameBits) {
  const Hashes one = CutWith(1);
  EXPECT_NE(one.bone_before, one.bone_after);
  for (const int threads : {2, 3, 8}) {
    const Hashes hashes = CutWith(threads);
    EXPECT_EQ(hashes.bone_before, one.bone_before) << threads;
    EXPECT_EQ(hashes.bone_after, one.bone_after) << threads;
    EXPECT_EQ(hashes.forces, one.forces) << threads;
  }
}

}  // namespace
}  // namespace kerf
