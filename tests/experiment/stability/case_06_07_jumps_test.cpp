// Hard cases 6 and 7: the hand jumps, and rotates, within one tick.
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "cut/contact/probe.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched.h"
#include "support/saw.h"

namespace kerf::test {
namespace {

constexpr double kJumps_mm[] = {1, 5, 20, 100};

Vec3 DrawDirection(std::mt19937_64& random) {
  while (true) {
    Vec3 v;
    for (int i = 0; i < 3; ++i) v[i] = static_cast<double>(random() >> 11) * 0x1p-52 - 1;
    const double length = glm::length(v);
    if (length > 0.1 && length < 1) return v / length;
  }
}

// ---- 6: on a path the tool removes everything that it sweeps, whatever the distance in a tick

/// Moves a disc 3 mm deep in the block from -d/2 to d/2. Returns the area swept below the block's top, by columns.
double CalcSweptArea(double jump_mm, const Vec3& size) {
  const double z = 0.5 * size.z - 3 + kR;
  constexpr int kColumns = 20000;
  double area = 0;
  for (int i = 0; i < kColumns; ++i) {
    const double x = size.x * ((i + 0.5) / kColumns - 0.5);
    const double off = std::max(0.0, std::abs(x) - 0.5 * jump_mm);
    if (off < kR) area += std::max(0.0, 0.5 * size.z - (z - std::sqrt(kR * kR - off * off))) * size.x / kColumns;
  }
  return area;
}

TEST(HardCase06, JumpOnAPathRemovesItsSweepWhateverTheNumberOfTicks) {
  Verdict verdict("holds");
  const Vec3 size(6, 3, 5);
  const double z = 0.5 * size.z - 3 + kR;
  double worst = 0;
  double worst_split = 0;
  for (const double jump : kJumps_mm) {
    double first = 0;
    for (const int ticks : {1, 3, 16}) {
      const Pose X_start = DiscPose({}, {-0.5 * jump, 0, z});
      WatchedPath path(MakeBox({}, size, 0.1), {}, X_start);
      for (int i = 1; i <= ticks; ++i) {
        EXPECT_EQ(path.Tick(DiscPose({}, {jump * (static_cast<double>(i) / ticks - 0.5), 0, z})).status, kTickOk);
      }
      path.invariants.CheckBone();
      const double removed = path.CalcRemoved();
      worst = std::max(worst, std::abs(removed / (kSaw.thickness_mm * CalcSweptArea(jump, size)) - 1));
      if (ticks == 1) first = removed;
      worst_split = std::max(worst_split, std::abs(removed / first - 1));
    }
  }
  // The bound is the same as for any kerf at this voxel size (RemovalClosedForm). The stadiums of the parts add up to
  // the stadium of the whole motion.
  verdict.AtMost("error of the swept volume in a jump of 1 to 100 mm", 100 * worst, 1, "%");
  verdict.AtMost("difference between 1, 3 and 16 ticks", 100 * worst_split, 0.001, "%");
}

TEST(HardCase06, JumpOnAPathAlongTheSpindleLeavesNoLayer) {
  Verdict verdict("holds");
  const Vec3 size(4, 6, 3);
  const double below = kR * 4 - (2 * std::sqrt(kR * kR - 4) + kR * kR * std::asin(2 / kR));
  const double expected = size.y * (4 * 1.5 - below);
  double worst = 0;
  for (const double jump : {10.0, 20.0, 100.0}) {
    WatchedPath path(MakeBox({}, size, 0.2), {}, DiscPose({}, {0, -0.5 * jump, kR}));
    EXPECT_EQ(path.Tick(DiscPose({}, {0, 0.5 * jump, kR})).status, kTickOk);
    path.invariants.CheckBone();
    worst = std::max(worst, std::abs(path.CalcRemoved() / expected - 1));
  }
  verdict.AtMost("error of the swept volume", 100 * worst, 1, "%");
  // The motion is longer than 4096 substeps can resolve. A status bit is set, and still no layer is skipped.
  WatchedPath path(MakeBox({}, size, 0.05), {}, DiscPose({}, {0, -50, kR}));
  EXPECT_EQ(path.Tick(DiscPose({}, {0, 50, kR})).status, kTickSubstepsLimited);
  path.invariants.CheckBone();
  verdict.AtMost("error of the swept volume with limited substeps", 100 * std::abs(path.CalcRemoved() / expected - 1),
                 1, "%");
}

// ---- 6: a tool that is held by bone does not get through it

enum class DiscPart { kFlat, kEdge, kTip };

/// Returns a pose in front of a plate of two voxels with normal y. The disc's flat, edge or tip faces the plate.
Pose InFrontOfPlate(DiscPart part, double y) {
  if (part == DiscPart::kFlat) return DiscPose({}, {0.3, y, 0.2});
  // The disc's edge faces the plate, with the spindle along x or along z.
  const Vec3 axis = part == DiscPart::kEdge ? Vec3(0, 1, 0) : Vec3(1, 0, 0);
  return {glm::angleAxis(part == DiscPart::kEdge ? std::numbers::pi / 2 : 0.0, axis), {0.3, y - kR, 0.2}};
}

TEST(HardCase06, StoppedSawDoesNotPassThroughAPlateOfTwoVoxels) {
  Verdict verdict("holds");
  const Bone plate = MakeBox({}, {30, 0.4, 30}, 0.2);
  const std::uint64_t hash = plate.CalcHash();
  double furthest_mm = -INFINITY;
  for (const DiscPart part : {DiscPart::kFlat, DiscPart::kEdge, DiscPart::kTip}) {
    for (const double jump : kJumps_mm) {
      const double y = -0.2 - (part == DiscPart::kFlat ? 0.5 * kSaw.thickness_mm : 0) - 0.6;
      WatchedTool tool(plate, DiscParams(), InFrontOfPlate(part, y));
      const double touching = y + 0.6;
      CoupledOutput out;
      for (int i = 0; i < 120; ++i) {
        out = tool.Tick(InFrontOfPlate(part, y + jump), 0);
        const double at = out.X_WT.p_AB.y + (part == DiscPart::kFlat ? 0 : kR);
        furthest_mm = std::max(furthest_mm, at - touching);
      }
      EXPECT_NEAR(glm::length(out.f_H_W_N), std::min(40.0, jump - 0.6), 0.1) << jump;
      // Back in free air there is no force.
      for (int i = 0; i < 60; ++i) out = tool.Tick(InFrontOfPlate(part, y - 0.5), 0);
      EXPECT_EQ(out.f_H_W_N, Vec3(0));
      tool.invariants.CheckBone();
      EXPECT_EQ(tool.simulation.UpdateBone().CalcHash(), hash);
    }
  }
  // A few points of 2000 N/mm bear the 40 N. The grid represents a plate of two voxels without rounding.
  verdict.AtMost("maximum penetration of the plate", furthest_mm, 0.03, "mm");
}

TEST(HardCase06, StoppedEdgeYieldsByTheStiffnessOfItsSprings) {
  Verdict verdict("holds");
  // The lowest point of the rim and its neighbours are springs of 2000 N/mm per eighth of a pitch.
  const int samples = CoupledParams{}.rim_samples_per_pitch;
  double worst = 0;
  for (const double push_N : {2.0, 10.0, 30.0}) {
    double upper = 0.1, lower = 0;
    for (int i = 0; i < 60; ++i) {
      const double depth = 0.5 * (lower + upper);
      double force = 0;
      for (int k = -40; k <= 40; ++k) {
        const double angle = 2 * std::numbers::pi / (samples * kSaw.teeth) * k;
        force += 2000 * 8.0 / samples * std::max(0.0, depth - kR * (1 - std::cos(angle))) * std::cos(angle);
      }
      (force < push_N ? lower : upper) = depth;
    }
    WatchedTool tool(MakeBox({}, {26, 2, 8}, 0.2), DiscParams(), DiscPose({}, {0, 0, 4 + kR + 0.1}));
    for (int i = 0; i < 100; ++i) tool.Tick(DiscPose({}, {0, 0, 4 + kR - push_N}), 0);
    worst = std::max(worst, std::abs((4 + kR - tool.X_WT.p_AB.z) / lower - 1));
    tool.invariants.CheckBone();
  }
  verdict.AtMost("error of the penetration depth at 2 to 30 N", 100 * worst, 3, "%");
}

TEST(HardCase06, TurningSawPassesOnlyWhereItHasCut) {
  Verdict verdict("holds");
  double max_mm = 0;
  int lagging = 0;
  for (const DiscPart part : {DiscPart::kEdge, DiscPart::kTip}) {
    for (const double jump : kJumps_mm) {
      WatchedTool tool(MakeBox({}, {30, 0.4, 30}, 0.2), DiscParams(), InFrontOfPlate(part, -0.8));
      for (int i = 0; i < 400; ++i) {
        const Pose X = tool.X_WT;
        const CoupledOutput out = tool.Tick(InFrontOfPlate(part, -0.8 + jump));
        // While the edge is between the faces, a substep is at most half a voxel long; through air it may be longer.
        if (X.p_AB.y + kR > -0.2 && out.X_WT.p_AB.y + kR < 0.2) {
          max_mm = std::max(max_mm, glm::length(out.X_WT.p_AB - X.p_AB) / out.substeps);
        }
        lagging += (out.status & kCoupledSubstepsUsedUp) != 0;
      }
      // The look-ups of the bone along the motion leave no gaps: the bone is removed wherever a point of the rim has
      // been.
      tool.invariants.CheckBone();
      const double through = std::min(jump - 0.6, 0.4);
      EXPECT_GT(tool.CalcRemoved(), through * 0.5 * kSaw.thickness_mm);
    }
  }
  verdict.AtMost("motion per substep in bone", max_mm / 0.2, 0.5 + 1e-9, "voxels");
  verdict.AtLeast("ticks in which the tool lags behind the hand", lagging, 1);
}

TEST(HardCase06, RestingPositionDoesNotDependOnTheSubsteps) {
  Verdict verdict("holds");
  double depth[4], removed[4];
  const int substeps[4] = {1, 4, 24, 400};
  for (int n = 0; n < 4; ++n) {
    CoupledParams params = DiscParams();
    params.max_substeps = substeps[n];
    params.coupling.stiffness_N_per_mm = 2;
    WatchedTool tool(MakeBox({}, {26, 2, 16}, 0.2), params, DiscPose({}, {0, 0, 8 + kR + 0.5}));
    for (int i = 0; i < 2500; ++i) tool.Tick(DiscPose({}, {0, 0, 8 + kR + 0.5 - 5}));
    depth[n] = 8 + kR - tool.X_WT.p_AB.z;
    removed[n] = tool.CalcRemoved();
    tool.invariants.CheckBone();
  }
  double max_depth = 0, max_removed = 0;
  for (int n = 0; n < 4; ++n) {
    max_depth = std::max(max_depth, std::abs(depth[n] - depth[2]));
    max_removed = std::max(max_removed, std::abs(removed[n] / removed[2] - 1));
  }
  EXPECT_GT(depth[2], 3.5);
  // The bound is a tenth of a voxel. At this time the tool still moves slowly, and its position depends on how long it
  // lagged.
  verdict.AtMost("difference in depth, 1 to 400 substeps", max_depth, 0.02, "mm");
  verdict.AtMost("difference in volume", 100 * max_removed, 1, "%");
}

TEST(HardCase06, SolverThatRunsOutOfIterationsCreatesNoEnergy) {
  Verdict verdict("holds");
  const int seeds = std::max(1, static_cast<int>(6 * Effort()));
  int ran_out = 0;
  double min_mJ = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(3000 + seed));
    const double rpm = seed % 2 == 0 ? 0 : 7500;
    CoupledParams params = DiscParams();
    params.max_iterations = 1 + seed % 3;
    SetEffect(params.effects, "kerf_friction", "coefficient", seed < 3 ? 2 : 0.2);
    params.coupling.stiffness_N_per_mm = seed % 4 < 2 ? 5 : 500;
    params.coupling.p_TC_mm = {0, 0, seed % 2 == 0 ? 40.0 : 0.0};
    const Vec3 home(0, 0, 4 + kR - 0.5);
    WatchedTool tool(MakeBox({}, {12, 3, 8}, 0.2), params, DiscPose({}, {0, 0, 4 + kR + 0.5}));
    for (int i = 0; i < 120; ++i) {
      Pose X_WH = DiscPose({}, home + kJumps_mm[random() % 2] * DrawDirection(random));
      X_WH.R_AB = glm::normalize(X_WH.R_AB * glm::angleAxis(0.1, DrawDirection(random)));
      for (int k = 0; k < 5; ++k) ran_out += (tool.Tick(X_WH, rpm).status & kCoupledIterationsUsedUp) != 0;
      min_mJ = std::min(min_mJ, tool.invariants.lost_mJ());
    }
    tool.invariants.CheckBone();
  }
  // On a plane there are no bumps that could push the tool out, so no single tick may return energy.
  double min_tick_mJ = 0;
  for (const int iterations : {1, 2, 4}) {
    std::mt19937_64 random(static_cast<std::uint64_t>(iterations));
    CoupledParams params = DiscParams();
    params.max_iterations = iterations;
    params.coupling.stiffness_N_per_mm = 50;
    params.coupling.p_TC_mm = {0, 0, 40};
    WatchedTool tool(MakeBox({}, {40, 20, 4}, 0.2), params, DiscPose({}, {0, 0, 2 + kR + 0.1}));
    for (int i = 0; i < 400; ++i) {
      Pose X_WH = DiscPose({}, Vec3(0, 0, 2 + kR - 0.1) + 0.5 * DrawDirection(random));
      X_WH.R_AB = glm::normalize(X_WH.R_AB * glm::angleAxis(0.02, DrawDirection(random)));
      const CoupledOutput out = tool.Tick(X_WH, 0);
      const double lost = out.cut_mJ + out.friction_mJ + out.numerical_mJ;
      min_tick_mJ = std::min(min_tick_mJ, lost / (1e-3 + std::abs(out.hand_mJ)));
    }
  }
  // A step treats its rotation as small, so this fraction of the energy that it stores may be returned.
  verdict.AtLeast("minimum energy lost in a tick on a plane relative to the hand's work", min_tick_mJ, -1e-3);
  verdict.AtLeast("ticks in which 1 to 3 iterations were not enough", ran_out, 100);
  verdict.AtLeast("minimum energy dissipated since the start", min_mJ, -1e-6, "mJ");
}

TEST(HardCase06, RandomJumpsSatisfyTheInvariants) {
  Verdict verdict("holds");
  const int seeds = std::max(1, static_cast<int>(4 * Effort()));
  double largest_N = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(1000 + seed));
    const double rpm = seed % 2 == 0 ? 7500 : 0;
    CoupledParams params = DiscParams();
    params.spare_leaves = 20000;
    const Vec3 home(0, 0, 4 + kR - 1);
    WatchedTool tool(MakeBox({}, {12, 3, 8}, 0.2), params, DiscPose({}, {0, 0, 4 + kR + 1}));
    for (int i = 0; i < 150; ++i) {
      const Vec3 to = home + kJumps_mm[random() % 4] * DrawDirection(random);
      // The handle stays there for a while, like a hand whose position was measured wrongly.
      const int stay = 1 + static_cast<int>(random() % 6);
      for (int k = 0; k < stay; ++k) tool.Tick(DiscPose({}, to), rpm);
    }
    tool.invariants.CheckBone();
    largest_N = std::max(largest_N, tool.invariants.largest_force_N());
  }
  verdict.AtMost("largest force", largest_N, 40 * (1 + 1e-12), "N");
}

// ---- 7: jump and turn

TEST(HardCase07, DiscThatTurnsOnAPathSweepsHalfABall) {
  Verdict verdict("holds");
  DiscSaw small;
  small.diameter_mm = 6;
  small.teeth = 12;
  SimulationParams params;
  params.tool = small;
  const double R = 3;
  const double t = small.thickness_mm;
  // The volume is two opposite quarters of the ball, plus half the disc's thickness in front of the first position and
  // behind the last. Where these two join at the axis they are not counted twice. The corners of the thick disc extend
  // beyond the ball.
  const double expected = 2.0 / 3 * std::numbers::pi * R * R * R + std::numbers::pi * R * R * t - t * t * R +
                          std::numbers::pi * t * t * R / 4;
  double worst = 0;
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), glm::normalize(Vec3(1, 1, 0))}) {
    for (const Quat& R_WT : {Quat(1, 0, 0, 0), glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3)))}) {
      WatchedPath path(MakeBox({}, {7, 7, 7}, 0.1), params, {R_WT, Vec3(0)});
      EXPECT_EQ(path.Tick({R_WT * glm::angleAxis(std::numbers::pi / 2, axis), Vec3(0)}).status, kTickOk);
      path.invariants.CheckBone();
      worst = std::max(worst, std::abs(path.CalcRemoved() / expected - 1));
    }
  }
  // A disc that shrinks during the motion, as it would with interpolated matrices, would sweep a third less. The
  // remaining error is that of the grid.
  verdict.AtMost("error of the swept volume in a quarter turn", 100 * worst, 1, "%");
}

TEST(HardCase07, TurnDoesNotDependOnTheSignOfItsQuaternion) {
  Verdict verdict("holds");
  double max_N = 0, max_Nmm = 0;
  for (const double rpm : {0.0, 7500.0}) {
    const Pose X_start = DiscPose({}, {0, 0, 4 + kR + 0.3});
    const Bone bone = MakeBox({}, {16, 3, 8}, 0.2);
    WatchedTool plain(bone, DiscParams(), X_start);
    WatchedTool other(bone, DiscParams(), X_start);
    for (int i = 0; i < 300; ++i) {
      Pose X = DiscPose({}, {0, 0.002 * i, 4 + kR + 0.3 - 0.01 * i});
      X.R_AB = glm::normalize(X.R_AB * glm::angleAxis(0.001 * i, glm::normalize(Vec3(1, 2, 3))));
      const CoupledOutput a = plain.Tick(X, rpm);
      if (i % 3 == 0) X.R_AB = -X.R_AB;
      const CoupledOutput b = other.Tick(X, rpm);
      max_N = std::max(max_N, glm::length(a.f_H_W_N - b.f_H_W_N));
      max_Nmm = std::max(max_Nmm, glm::length(a.tau_H_W_Nmm - b.tau_H_W_Nmm));
    }
    EXPECT_GT(plain.invariants.largest_force_N(), 1);
  }
  // The bound covers rounding and the solver's residual of 1e-8.
  verdict.AtMost("force difference", max_N, 1e-6, "N");
  verdict.AtMost("torque difference", max_Nmm, 1e-5, "N mm");
}

TEST(HardCase07, JumpWithATurnSatisfiesTheInvariants) {
  Verdict verdict("holds");
  const int seeds = std::max(1, static_cast<int>(6 * Effort()));
  double max_voxels = 0;
  double deepest_mm = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(static_cast<std::uint64_t>(2000 + seed));
    const double rpm = seed % 2 == 0 ? 7500 : 0;
    const Bone bone = MakeBox({}, {12, 3, 8}, 0.2);
    CoupledParams params = DiscParams();
    params.spare_leaves = 20000;
    if (seed % 3 == 1) params.coupling.p_TC_mm = {0, 0, 40};
    Pose X_WH = DiscPose({}, {0, 0, 4 + kR + 0.5});
    WatchedTool tool(bone, params, X_WH);
    const Vec3 home = X_WH.p_AB - Vec3(0, 0, 2);
    for (int i = 0; i < 100; ++i) {
      X_WH.p_AB = home + kJumps_mm[random() % 3] * DrawDirection(random);
      X_WH.R_AB = glm::normalize(X_WH.R_AB * glm::angleAxis(std::numbers::pi / 2, DrawDirection(random)));
      const int stay = 1 + static_cast<int>(random() % 10);
      for (int k = 0; k < stay; ++k) {
        const Pose X = tool.X_WT;
        const CoupledOutput out = tool.Tick(X_WH, rpm);
        if (out.engaged_teeth == 0 && out.f_face_W_N == Vec3(0)) continue;
        // In contact, no point of the edge may move further than a substep looks ahead. A rotation about the spindle
        // does not displace the disc.
        const double tilt = std::acos(std::clamp(glm::dot(X.Vector({0, 0, 1}), out.X_WT.Vector({0, 0, 1})), -1.0, 1.0));
        const double moved_mm = std::max(glm::length(out.X_WT.p_AB - X.p_AB), tilt * kR);
        if (out.substeps <= 2) max_voxels = std::max(max_voxels, moved_mm / (0.2 * out.substeps));
      }
    }
    tool.invariants.CheckBone();
    if (rpm == 0) {
      EXPECT_EQ(tool.simulation.UpdateBone().CalcHash(), bone.CalcHash());
    }
    // Out of the bone the tool is free again at once.
    X_WH.p_AB = {0, 0, 60};
    CoupledOutput out;
    for (int i = 0; i < 200; ++i) out = tool.Tick(X_WH, rpm);
    if (rpm == 0) {
      EXPECT_EQ(out.f_H_W_N, Vec3(0));
      EXPECT_EQ(out.X_WT.p_AB, X_WH.p_AB);
    }
    deepest_mm = std::max(deepest_mm, tool.invariants.largest_force_N());
  }
  verdict.AtMost("largest force", deepest_mm, 40 * (1 + 1e-12), "N");
  verdict.Note("motion of the edge per substep", max_voxels, "voxels");
}

}  // namespace
}  // namespace kerf::test
