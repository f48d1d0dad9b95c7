// Hard cases 21 to 23: the disc in its own kerf. It returns into the kerf without force, binds when it is tilted and
// comes free again. When it is pushed sideways, its flats remove nothing.
#include <numbers>

#include "bone/grid/grids.h"
#include "bone/grid/leaf_table.h"
#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscParams;
using test::InKerf;

constexpr double kDegree = std::numbers::pi / 180;

TEST(HardCase21, SawBackInItsKerfCutsNothingAndFeelsNoForce) {
  test::Verdict verdict("holds: a repeated cut removes nothing more, bit for bit");
  double max_fraction = 0;
  double max_again_mm3 = 0;
  double max_lateral_N = 0;
  for (const double h : {0.1, 0.2}) {
    const std::vector<Pose> poses = BlockPoses(h);
    for (const std::size_t n : {0u, 1u, 3u, 5u}) {
      if (h < 0.15 && n != 5) continue;
      InKerf kerf(poses[n], {22, 2, 8}, h, 3, DiscParams());
      // For comparison: the force of cutting the kerf 0.2 mm deeper, at 2 mm/s.
      double cutting_N = 0;
      kerf.Move(kerf.OffsetPose({0, 0, -0.2}), 100, 7500,
                [&](const CoupledOutput& out) { cutting_N = std::max(cutting_N, glm::length(out.f_H_W_N)); });
      for (int i = 0; i < 2000 && glm::length(kerf.out.f_H_W_N) > 1e-4; ++i) kerf.Hold(1, {0, 0, -0.2});
      kerf.p_B = kerf.Place();
      kerf.Hold(20);
      ASSERT_GT(cutting_N, 0.15);
      const double before_mm3 = kerf.invariants.removed_mm3();
      // The disc moves out, and in again to a voxel above the floor, twice. (Closer to the floor, the blur of the grid
      // causes a force.)
      for (int times = 0; times < 2; ++times) {
        for (const double up : {6.0, h}) {
          kerf.Move(kerf.OffsetPose({0, 0, up}), 1000, 7500, [&](const CoupledOutput&) {
            max_fraction = std::max(max_fraction, std::abs(kerf.ForceInBlock().z) / cutting_N);
            max_lateral_N = std::max(max_lateral_N, std::abs(kerf.ForceInBlock().y));
          });
        }
      }
      kerf.Move(kerf.OffsetPose(Vec3(0)), 200);
      max_again_mm3 = std::max(max_again_mm3, kerf.invariants.removed_mm3() - before_mm3);
      kerf.invariants.CheckBone();
    }
  }
  verdict.AtMost("feed force in the kerf relative to the force of cutting it", max_fraction, 0.02);
  verdict.AtMost("force across the kerf", max_lateral_N, 0.002, "N");
  verdict.AtMost("volume removed again", max_again_mm3, 1e-3, "mm^3");
}

TEST(HardCase21, WallsCentreASawDisplacedByAFifthOfTheKerf) {
  test::Verdict verdict("holds: only the walls push, and towards the middle");
  CoupledParams params = DiscParams();
  SetEffect(params.effects, "kerf_friction", "coefficient", 0);
  params.coupling.p_TC_mm = {0, kR - 1.5, 0};
  double max_feed_N = 0;
  double min_centring = 1e9;
  for (const double side : {-1.0, 1.0}) {
    InKerf kerf(BlockPoses(0.1)[5], {22, 2, 8}, 0.1, 3, params);
    kerf.Hold(200, {0, 0.05 * side, 0.02});
    // The spring is stretched by 50 um at 1 N/mm, and the walls bear all of its force.
    min_centring = std::min(min_centring, -side * kerf.ForceInBlock().y);
    max_feed_N = std::max(max_feed_N, std::abs(kerf.ForceInBlock().z));
  }
  verdict.AtLeast("force towards the middle at 50 um and 1 N/mm", min_centring, 0.045, "N");
  verdict.AtMost("force along the feed", max_feed_N, 0.005, "N");
}

TEST(HardCase22, TiltedSawBindsInADeepKerfAndComesFreeAgain) {
  test::Verdict verdict("holds");
  double min_growth = 1e9;
  double max_left_Nmm = 0;
  double max_Nmm = 0;
  double min_fraction = 1e9;
  for (const double rpm : {7500.0, 0.0}) {
    CoupledParams params = DiscParams();
    InKerf kerf(BlockPoses(0.2)[4], {26, 2, 14}, 0.2, 7, params);  // deeper than half the radius
    if (rpm == 0) kerf.Hold(50, {0, 0, 0.4}, 0, rpm);
    const double up = rpm == 0 ? 0.4 : 0.1;
    for (const double sign : {1.0, -1.0}) {
      double last = 0;
      for (const double degrees : {1.0, 2.0, 3.0, 4.0, 5.0}) {
        for (int i = 1; i <= 100; ++i) kerf.Hold(1, {0, 0, up}, sign * (degrees - 1 + 0.01 * i) * kDegree, rpm);
        kerf.Hold(100, {0, 0, up}, sign * degrees * kDegree, rpm);
        const double torque = -sign * kerf.TorqueInBlock().x;  // against the tilt
        min_growth = std::min(min_growth, torque - last);
        min_fraction = std::min(min_fraction, torque / (params.coupling.torsion_Nmm_per_rad * degrees * kDegree));
        max_Nmm = std::max(max_Nmm, torque);
        last = torque;
      }
      for (int i = 1; i <= 200; ++i) kerf.Hold(1, {0, 0, up}, sign * (5 - 0.025 * i) * kDegree, rpm);
      kerf.Hold(100, {0, 0, up}, 0, rpm);
      max_left_Nmm = std::max(max_left_Nmm, glm::length(kerf.out.tau_H_W_Nmm));
    }
    kerf.invariants.CheckBone();
    // When it is drawn out while tilted by 3 degrees, it comes free.
    kerf.Hold(100, {0, 0, up}, 3 * kDegree, rpm);
    Pose X_out = kerf.OffsetPose({0, 0, 12}, 3 * kDegree);
    kerf.Move(X_out, 3000, rpm);
    EXPECT_EQ(kerf.out.f_H_W_N, Vec3(0)) << rpm;
    EXPECT_EQ(kerf.out.tau_H_W_Nmm, Vec3(0)) << rpm;
  }
  verdict.AtLeast("minimum growth of the torque per degree", min_growth, 50, "N mm");
  verdict.AtLeast("fraction of the hand's torque borne by the walls", min_fraction, 0.9);
  verdict.AtMost("largest torque", max_Nmm, 5000 * 5 * kDegree * 1.001, "N mm");
  verdict.AtMost("torque left after straightening", max_left_Nmm, 0.1, "N mm");
}

/// Returns the smallest distance from the spindle at which phi differs, mm; a large number if phi is the same
/// everywhere.
double FindInnermostChange(const Bone& before, const Bone& after, const Pose& X_WT) {
  double innermost = 1e9;
  const auto& old_tree = GridsOf(before).phi->constTree();
  const auto& new_tree = GridsOf(after).phi->constTree();
  const double h = before.voxel_mm();
  for (auto leaf = new_tree.cbeginLeaf(); leaf; ++leaf) {
    for (openvdb::Index i = 0; i < 512; ++i) {
      const openvdb::Coord ijk = leaf->offsetToGlobalCoord(i);
      if (leaf->getValue(i) == old_tree.getValue(ijk)) continue;
      const Vec3 p_T = X_WT.InversePoint(h * Vec3(ijk.x(), ijk.y(), ijk.z()));
      innermost = std::min(innermost, std::hypot(p_T.x, p_T.y));
    }
  }
  return innermost;
}

TEST(HardCase23, FlatsPushedAsideAndPivotedRemoveNothing) {
  test::Verdict verdict("holds: only the rim removes bone, at most three voxels inside it; the flats remove none");
  const double h = 0.2;
  double innermost_mm = 1e9;
  double max_rate = 0;
  double max_motion_mm = 0;
  for (const double push_N : {5.0, 20.0}) {
    CoupledParams params = DiscParams();
    params.coupling.p_TC_mm = {0, kR - 3, 0};  // in the middle of the buried part
    SetEffect(params.effects, "kerf_friction", "coefficient",
              0);  // friction would move it along the kerf and cut there
    InKerf kerf(BlockPoses(h)[5], {26, 4, 12}, h, 6, params);
    kerf.Hold(100, {0, 0, 0.05});
    const Bone before = kerf.simulation.UpdateBone();
    const Vec3 was = kerf.Place();
    const double removed_mm3 = kerf.invariants.removed_mm3();
    for (int n = 0; n < 8; ++n) {
      const double side = n % 2 == 0 ? 1 : -1;
      kerf.Move(kerf.OffsetPose({0, side * push_N, 0.05}), 50);
      kerf.Hold(200, {0, side * push_N, 0.05});
      max_motion_mm = std::max(max_motion_mm, std::abs(kerf.Place().y - was.y));
    }
    kerf.Hold(100, {0, 0, 0.05});
    for (int n = 0; n < 8; ++n) {
      const double side = n % 2 == 0 ? 1 : -1;
      for (int i = 1; i <= 100; ++i) kerf.Hold(1, {0, 0, 0.05}, side * 0.01 * i * kDegree * push_N / 5);
      kerf.Hold(150, {0, 0, 0.05}, side * kDegree * push_N / 5);
    }
    innermost_mm = std::min(innermost_mm, FindInnermostChange(before, kerf.simulation.UpdateBone(), kerf.out.X_WT));
    max_rate = std::max(max_rate, kerf.invariants.removed_mm3() - removed_mm3);
    kerf.invariants.CheckBone();
  }
  verdict.AtLeast("smallest distance of a change from the spindle", innermost_mm, kR - 3 * h - 0.01, "mm");
  verdict.AtMost("sideways motion under 20 N", max_motion_mm, 0.002, "mm");
  verdict.AtMost("volume removed from the walls by the rim in 16 pushes", max_rate, 0.5, "mm^3");
}

/// Returns the distance that a turning disc moves sideways in a kerf `depth_mm` deep, divided by the handle's distance.
/// The handle moves 0.5 mm sideways in half a second and stays there for as long.
double CalcSkating(double h, double depth_mm, double rpm) {
  CoupledParams params = DiscParams();
  params.coupling.p_TC_mm = {0, kR, 0};  // at the rim, so that it cannot roll out
  InKerf kerf(BlockPoses(h)[0], {22, 4, 8}, h, depth_mm, params);
  const Vec3 was = kerf.Place();
  kerf.Move(kerf.OffsetPose({0, 0.5, 0}), 500, rpm);
  kerf.Hold(500, {0, 0.5, 0}, 0, rpm);
  kerf.invariants.CheckBone();
  return (kerf.Place().y - was.y) / 0.5;
}

TEST(HardCase23, KerfHoldsTheTurningDiscFromAFewVoxelsOfDepthOn) {
  test::Verdict verdict(
      "holds from a depth of 6 voxels on; in a shallower kerf a turning disc skates, because the rim cuts the walls "
      "there");
  double deep = 0;
  double stopped = 0;
  double less_deep = 0;
  double shallow = 0;
  for (const double h : {0.1, 0.2}) {
    deep = std::max(deep, CalcSkating(h, 6 * h, 7500));
    less_deep = std::max(less_deep, CalcSkating(h, 4 * h, 7500));
    shallow = std::max(shallow, CalcSkating(h, 2.5 * h, 7500));
    stopped = std::max(stopped, CalcSkating(h, 4 * h, 0));
  }
  verdict.AtMost("motion relative to the handle's, 6 voxels deep", deep, 0.02);
  verdict.AtMost("motion relative to the handle's, 4 voxels deep, spindle stopped", stopped, 0.02);
  verdict.Note("motion relative to the handle's, 4 voxels deep, spindle turning", less_deep);
  verdict.Note("motion relative to the handle's, 2.5 voxels deep, spindle turning", shallow);
}

}  // namespace
}  // namespace kerf
