// Hard cases 8 to 10: steps between materials, extremes of materials, and extremes of friction.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "experiment/stability/verdict.h"
#include "experiment/stability/watched.h"
#include "kerf/error.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf::test {
namespace {

MaterialTable TwoRegionTable(double E_1_MPa, double E_2_MPa) {
  MaterialTable table;
  table.Add({1, "first", Tissue::kCortical, E_1_MPa, 0.28, true, "test"});
  table.Add({2, "second", Tissue::kOther, E_2_MPa, 0.28, true, "test"});
  return table;
}

/// Returns a block with region 2 wherever `second` returns true.
Bone MakeTwoRegions(const Vec3& size, double voxel_mm, double E_1_MPa, double E_2_MPa,
                    const std::function<bool(const Vec3&)>& second) {
  Bone bone = MakeBox({}, size, voxel_mm);
  SetRegions(
      bone, [&](const Vec3& p) { return second(p) ? 2 : 1; }, voxel_mm);
  bone.set_materials(TwoRegionTable(E_1_MPa, E_2_MPa));
  return bone;
}

double CalcEStar(double E_MPa, double nu = 0.28) {
  return CalcReducedModulus(kSaw.E_MPa, kSaw.nu, E_MPa, nu);
}

/// Returns the largest step between two ticks, in just-noticeable differences (7 % of the larger force, or of 0.5 N if
/// both are smaller).
double CalcLargestStep(const std::vector<Vec3>& f_N) {
  double largest = 0;
  for (std::size_t i = 1; i < f_N.size(); ++i) {
    const double scale = 0.07 * std::max(std::max(glm::length(f_N[i]), glm::length(f_N[i - 1])), 0.5);
    largest = std::max(largest, glm::length(f_N[i] - f_N[i - 1]) / scale);
  }
  return largest;
}

// ---- 8: a step of material

/// Returns the sum of the thrusts along a kerf, with the border of the materials at x = 0 and the disc's centre at
/// `x_mm`.
double CalcSlotThrust(const ToothForce& force, double x_mm, double depth_mm, double bite_mm, double E_1, double E_2) {
  const double alpha = std::acos(1 - depth_mm / kR);
  constexpr int kIntervals = 4000;
  double sum = 0;
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = alpha * (i + 0.5) / kIntervals;
    const double E = x_mm + kR * std::sin(phi) < 0 ? E_1 : E_2;
    sum += force(bite_mm * std::sin(phi), Cortical(CalcEStar(E))) * kSaw.teeth / (2 * std::numbers::pi) * alpha /
           kIntervals;
  }
  return sum;
}

TEST(HardCase08, ForceAcrossAMaterialStepFollowsTheArcInEachMaterial) {
  Verdict verdict("holds");
  const double h = 0.2;
  const double border = 0.5 * h;  // between the last voxel of the first material and the first of the second
  const double depth = 3;
  const double feed = 10;
  double worst[2] = {};
  double worst_step = 0;
  double worst_rise = 0;
  for (const int samples : {8, 32})
    for (const double ratio : {10.0, 100.0}) {
      const Bone bone =
          MakeTwoRegions({24, 2, 8}, h, 19300, 19300 / ratio, [&](const Vec3& p) { return p.x > 0.5 * h; });
      const double z = 4 - depth + kR;
      SimulationParams params;
      params.law = ForceLaw("hertz_chip");
      params.rim_samples_per_pitch = samples;
      WatchedPath path(bone, params, DiscPose({}, {-14, 0, z}));
      for (double x = -14; x < -9; x += 0.1) path.Tick(DiscPose({}, {x, 0, z}));
      const ToothForce force = MakeToothForce(ForceLaw("hertz_chip"), Tool(kSaw));
      const double bite = feed / (kSaw.teeth * 125);
      const double full = CalcSlotThrust(force, -20, depth, bite, 19300, 19300 / ratio);
      double last = full, last_form = full;
      for (double x = -9; x < 0.5; x += 0.01) {
        const TickOutput out = path.Tick(DiscPose({}, {x, 0, z}));
        if (x < -8.5) {
          last = out.thrust_sum_N;
          continue;
        }
        const double form = CalcSlotThrust(force, x - border, depth, bite, 19300, 19300 / ratio);
        double& error = worst[samples == 8 ? 0 : 1];
        error = std::max(error, std::abs(out.thrust_sum_N - form) / full);
        worst_step = std::max(worst_step, (std::abs(out.thrust_sum_N - last) - std::abs(form - last_form)) / full);
        worst_rise = std::max(worst_rise, (out.thrust_sum_N - last) / full);
        last = out.thrust_sum_N;
        last_form = form;
      }
      path.invariants.CheckBone();
    }
  // Each point of the rim represents its part of the arc, 0.36 mm of 7.5 mm, which lies in one material or the other
  // (over the width of a region's voxel). Where the rim leaves the bone, that part counts 1.5 times. Four times as many
  // points give a smaller error.
  verdict.AtMost("error of the force across the border", 100 * worst[0], 5, "% of the force before it");
  verdict.AtMost("error of the force across the border, 32 points per pitch", 100 * worst[1], 3, "%");
  verdict.AtMost("force step in a tick in excess of the analytic step", 100 * worst_step, 1, "%");
  // The look-ahead is 0.04 mm, and a point of the rim approaches the border by at most 0.01 mm per tick.
  verdict.AtMost("rise of the force in a tick where it should fall", 100 * worst_rise, 0.35, "%");
}

TEST(HardCase08, HandHeldSawPassesFromCortexToCancellousBoneWithoutAStep) {
  Verdict verdict("holds");
  double largest = 0;
  double ratio_off = 0;
  for (const double ratio : {10.0, 100.0}) {
    // A plate of 2 mm lies on softer bone, and the hand moves down at 5 mm/s.
    const Bone bone = MakeTwoRegions({22, 2, 10}, 0.2, 19300, 19300 / ratio, [](const Vec3& p) { return p.z < 3; });
    WatchedTool tool(bone, DiscParams(), DiscPose({}, {0, 0, 5 + kR + 0.2}));
    std::vector<Vec3> f;
    for (int i = 0; i < 900; ++i) f.push_back(tool.Tick(DiscPose({}, {0, 0, 5 + kR + 0.2 - 0.005 * i})).f_H_W_N);
    largest = std::max(largest, CalcLargestStep(f));
    tool.invariants.CheckBone();
    // The saw is fed with a constant 5 N. Deep in the softer bone only the lower part of the arc contributes much.
    WatchedTool pushed(bone, DiscParams(), DiscPose({}, {0, 0, 5 + kR + 0.2}));
    double slow = 0, fast = 0;
    for (int i = 0; i < 6000 && pushed.X_WT.p_AB.z > 5 + kR - 4; ++i) {
      const double z = pushed.X_WT.p_AB.z;
      pushed.Push(DiscPose({}, {}).R_AB, {0, 0, -5});
      const double depth = 5 + kR - pushed.X_WT.p_AB.z;
      if (depth < 1.9) slow = z - pushed.X_WT.p_AB.z;
      fast = z - pushed.X_WT.p_AB.z;
    }
    // Compares the force from the arcs in both layers at that feed with the push.
    const double depth = 5 + kR - pushed.X_WT.p_AB.z;
    const ToothForce force = MakeToothForce(DiscParams().law, Tool(kSaw));
    double along = 0;
    const double alpha = std::acos(1 - depth / kR);
    for (int k = 0; k < 4000; ++k) {
      const double phi = alpha * ((k + 0.5) / 2000 - 1);
      // The border lies between the last voxel of the upper layer, at 3 mm, and the first of the lower, at 2.8 mm.
      const double E = pushed.X_WT.p_AB.z - kR * std::cos(phi) < 2.9 ? 19300 / ratio : 19300;
      along += force(fast * 1000 * std::cos(phi) / (kSaw.teeth * 125), Cortical(CalcEStar(E))) * std::cos(phi) *
               kSaw.teeth / (2 * std::numbers::pi) * alpha / 2000;
    }
    ratio_off = std::max(ratio_off, std::abs(along / 5 - 1));
    EXPECT_GT(fast, 0);
    EXPECT_GT(slow, 0);
    pushed.invariants.CheckBone();
  }
  verdict.AtMost("largest force step in a tick", largest, 1, "JND (7 %)");
  verdict.AtMost("error of the force computed from the feed, both layers", 100 * ratio_off, 4, "%");
}

TEST(HardCase08, ForceBumpOfAMetalGrainIsLimitedByItsSize) {
  Verdict verdict("holds");
  const double h = 0.2;
  double bump_N[4] = {};
  std::vector<double> plain_N;
  const int sizes[4] = {0, 1, 3, 5};  // voxels along an edge
  for (int n = 0; n < 4; ++n) {
    // The grain is a cube of `sizes[n]` voxels below the disc's lowest point, in its plane.
    const double half = 0.5 * h * (sizes[n] - 0.5);
    const Vec3 middle(0, 0, 2);
    const auto grain = [&](const Vec3& p) {
      const Vec3 q = glm::abs(p - middle);
      return std::max({q.x, q.y, q.z}) < half;
    };
    const Bone bone = MakeTwoRegions({22, 2, 8}, h, 19300, 200000, grain);
    WatchedPath path(bone, {.law = ForceLaw("hertz_chip")}, DiscPose({}, {0, 0, 4 + kR - 1}));
    double bump = 0;
    for (int i = 1; i <= 200; ++i) {
      const double thrust = path.Tick(DiscPose({}, {0, 0, 4 + kR - 1 - 0.01 * i})).thrust_sum_N;
      if (n == 0) plain_N.push_back(thrust);
      bump = std::max(bump, thrust - plain_N[static_cast<std::size_t>(i - 1)]);
    }
    path.invariants.CheckBone();
    bump_N[n] = bump;
  }
  // The bound is the grain's part of the arc (its length plus half a voxel on either side) times the increase of a
  // tooth's force with E*.
  const ToothForce force = MakeToothForce(ForceLaw("hertz_chip"), Tool(kSaw));
  const double bite = 10.0 / (kSaw.teeth * 125);
  const double tooth = force(bite, Cortical(CalcEStar(200000))) - force(bite, Cortical(CalcEStar(19300)));
  for (int n = 1; n < 4; ++n) {
    EXPECT_GT(bump_N[n], 0);
    EXPECT_LE(bump_N[n], (sizes[n] + 1) * h / kSaw.pitch_mm() * tooth * 1.05) << sizes[n];
    EXPECT_GE(bump_N[n], bump_N[n - 1]);
  }
  verdict.Note("force bump of a one-voxel grain", bump_N[1], "N");
  verdict.AtMost("force bump relative to the maximum for the grain's arc length",
                 bump_N[1] / (2 * h / kSaw.pitch_mm() * tooth), 1);

  // Coupled to a handle, the tool passes the grain without a step.
  const Bone bone = MakeTwoRegions({22, 2, 8}, h, 19300, 200000,
                                   [&](const Vec3& p) { return glm::length(p - Vec3(0, 0, 2)) < 0.5 * h; });
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = 4;
  WatchedTool tool(bone, params, DiscPose({}, {0, 0, 4 + kR + 0.2}));
  std::vector<Vec3> f;
  for (int i = 0; i < 1000; ++i) f.push_back(tool.Tick(DiscPose({}, {0, 0, 4 + kR + 0.2 - 0.005 * i})).f_H_W_N);
  tool.invariants.CheckBone();
  verdict.AtMost("largest force step in a hand", CalcLargestStep(f), 1, "JND (7 %)");
  EXPECT_LT(tool.X_WT.p_AB.z - kR, 2);  // the tool is through
}

// ---- 9: extremes of E and nu

TEST(HardCase09, InvalidMaterialIsRefusedWithAMessage) {
  Verdict verdict(
      "holds; E = 0 and E above 1e6 GPa are refused (in a file, E above 10 000 GPa as a mistaken unit), so F(E = 0) "
      "does not apply");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  int refused = 0;
  const auto expect_refused = [&](double E_MPa, double nu, const std::string& part) {
    try {
      MaterialTable table;
      table.Add({24, "test", Tissue::kCortical, E_MPa, nu, true, "test"});
      ADD_FAILURE() << "E = " << E_MPa << ", nu = " << nu << " was accepted";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
      ++refused;
    }
    MaterialTable table;
    table.Add({24, "test", Tissue::kCortical, 19300, 0.28, true, "test"});
    EXPECT_THROW(MakeUniformTable(table, E_MPa, nu), Error);
  };
  for (const double E : {0.0, -0.0, -1.0, nan, inf, -inf, 1.0001e9, 1e12}) expect_refused(E, 0.3, "region 24: E = ");
  for (const double nu : {-1e-12, 0.5 + 1e-12, 0.75, -1.0, nan, inf}) expect_refused(19300, nu, "region 24: nu = ");
  verdict.Equal("materials refused", refused, 14);
  // The same values are refused for the tool's own material.
  for (const double E : {0.0, -1.0, nan, inf}) {
    DiscSaw saw;
    saw.E_MPa = E;
    EXPECT_THROW(saw.Validate(), Error) << E;
  }
  for (const double nu : {-0.1, 0.51, nan}) {
    DiscSaw saw;
    saw.nu = nu;
    EXPECT_THROW(saw.Validate(), Error) << nu;
  }
}

/// Returns the thrust in the middle of a plunge at 4 mm/s.
double PlungeThrust(double E_MPa, double nu, const ForceLaw& law = ForceLaw("hertz_chip")) {
  static const Bone block = MakeBox({}, {22, 2, 8}, 0.2);
  Bone bone = block;
  bone.set_materials(OneRegionTable(24, E_MPa, nu));
  SimulationParams params;
  params.law = law;
  WatchedPath path(bone, params, DiscPose({}, {0, 0, 4 + kR - 3}));
  double sum = 0;
  for (int i = 1; i <= 50; ++i) sum += path.Tick(DiscPose({}, {0, 0, 4 + kR - 3 - 0.004 * i})).thrust_sum_N / 50;
  return sum;
}

TEST(HardCase09, ForceFollowsTheReducedModulusFromOneMegapascalUp) {
  Verdict verdict("holds");
  double worst = 0;
  double last = 0;
  const double reference = PlungeThrust(19300, 0.28);
  const ToothForce force = MakeToothForce(ForceLaw("hertz_chip"), Tool(kSaw));
  const double bite = 4.0 / (kSaw.teeth * 125);
  // The moduli range from 1e-3 to 1e6 GPa.
  for (const double E : {1.0, 10.0, 1e3, 19300.0, 2e5, 1e6, 1e7, 1e9}) {
    const double thrust = PlungeThrust(E, 0.28);
    EXPECT_GT(thrust, last);
    last = thrust;
    // The law is the same at another modulus, so the ratio is the same for all teeth.
    const double expected = force(bite, Cortical(CalcEStar(E))) / force(bite, Cortical(CalcEStar(19300)));
    worst = std::max(worst, std::abs(thrust / reference / expected - 1));
  }
  verdict.AtMost("error of the force ratio", worst, 1e-9);
  // Against rigid bone only the steel's own E* is left, so even at 1e6 GPa the force is no larger than that allows.
  EXPECT_NEAR(CalcEStar(1e9) / (kSaw.E_MPa / (1 - kSaw.nu * kSaw.nu)), 1, 1e-3);
  for (const ForceLawInfo* law : ForceLaws()) {
    const ToothForce f = MakeToothForce(ForceLaw(law->name), Tool(kSaw));
    for (const double E : {1e-3, 1.0, 1e9, 1e15}) {
      EXPECT_TRUE(std::isfinite(f(bite, Cortical(CalcEStar(E))))) << law->name;
      EXPECT_GE(f(bite, Cortical(CalcEStar(E))), 0) << law->name;
    }
  }
}

TEST(HardCase09, ForceIsContinuousInPoissonsRatioUpToOneHalf) {
  Verdict verdict("holds");
  double largest = 0;
  double last = PlungeThrust(19300, 0);
  double worst = 0;
  const ToothForce force = MakeToothForce(ForceLaw("hertz_chip"), Tool(kSaw));
  const double bite = 4.0 / (kSaw.teeth * 125);
  const double first = last;
  for (const double nu : {1e-12, 0.1, 0.25, 0.49, 0.499999, 0.5 - 1e-12, 0.5}) {
    const double thrust = PlungeThrust(19300, nu);
    EXPECT_TRUE(std::isfinite(thrust));
    if (nu > 0.4999995) largest = std::max(largest, std::abs(thrust / last - 1));
    last = thrust;
    worst = std::max(
        worst, std::abs(thrust / first /
                            (force(bite, Cortical(CalcEStar(19300, nu))) / force(bite, Cortical(CalcEStar(19300, 0)))) -
                        1));
  }
  // Near nu = 0.5, 1 / (1 - nu^2) rises by 1.3e-6 per millionth of nu.
  verdict.AtMost("change of the force from nu = 0.499999 to 0.5", largest, 2e-6);
  verdict.AtMost("error of the force ratio to nu = 0", worst, 1e-9);
}

TEST(HardCase09, AHandCutsAnyMaterialSteadily) {
  Verdict verdict("holds");
  double last_depth = INFINITY;
  double worst_noise = 0;
  for (const double E : {1.0, 1e3, 19300.0, 2e5, 1e7}) {
    for (const double nu : {0.0, 0.5}) {
      Bone bone = MakeBox({}, {22, 2, 8}, 0.2);
      bone.set_materials(OneRegionTable(24, E, nu));
      WatchedTool tool(bone, DiscParams(), DiscPose({}, {0, 0, 4 + kR + 0.05}));
      std::vector<Vec3> f;
      // The handle moves down by 3 mm at 10 mm/s and stays there.
      for (int i = 0; i < 600; ++i) {
        f.push_back(tool.Tick(DiscPose({}, {0, 0, 4 + kR + 0.05 - 0.01 * std::min(i, 300)})).f_H_W_N);
      }
      tool.invariants.CheckBone();
      worst_noise = std::max(worst_noise, CalcLargestStep(f));
      if (nu == 0) {
        const double depth = 4 + kR - tool.X_WT.p_AB.z;
        EXPECT_LE(depth, last_depth + 1e-9) << "E " << E;  // the harder the material, the smaller the depth
        last_depth = depth;
      }
    }
  }
  verdict.AtMost("largest force step", worst_noise, 1, "JND (7 %)");
}

// ---- 10: extremes of friction

/// A stopped saw pressed on a plane with 10 N, then pulled along its spindle.
struct Pull {
  std::vector<double> along_N;   // friction on the tool
  std::vector<double> moved_mm;  // distance that the tool has moved at its contact
};
Pull PullSideways(double mu, const std::vector<double>& handle_mm) {
  CoupledParams params = DiscParams();
  SetEffect(params.effects, "kerf_friction", "coefficient", mu);
  params.coupling.stiffness_N_per_mm = 2;
  WatchedTool tool(MakeBox({}, {24, 8, 4}, 0.2), params, DiscPose({}, {0, 0, 2 + kR + 0.1}));
  const auto down = [](double y) { return DiscPose({}, {0, y, 2 + kR - 5}); };
  for (int i = 0; i < 300; ++i) tool.Tick(down(0), 0);
  Pull pull;
  for (const double y : handle_mm) {
    const CoupledOutput out = tool.Tick(down(y), 0);
    pull.along_N.push_back(out.f_friction_W_N.y);
    // Measured at the lowest point of the edge, because above it the disc tilts towards the pull.
    pull.moved_mm.push_back(out.X_WT.Point({0, kR, 0}).y);
  }
  tool.invariants.CheckBone();
  return pull;
}

TEST(HardCase10, StoppedSawSticksUpToTheFrictionLimitAndNoFurther) {
  Verdict verdict("holds");
  std::vector<double> out_and_back;
  for (int i = 0; i < 2000; ++i) out_and_back.push_back(0.002 * (i < 1000 ? i : 2000 - i));  // 2 mm: 4 N
  double worst = 0;
  double stuck_mm = 0;
  for (const double mu : {0.0, 0.05, 0.2, 1.0, 2.0}) {
    const Pull pull = PullSideways(mu, out_and_back);
    double max_N = 0;
    for (const double f : pull.along_N) max_N = std::max(max_N, std::abs(f));
    const double limit = mu * 10;
    if (mu == 0) {
      EXPECT_EQ(max_N, 0);
      // Without friction the tool is at the handle.
      EXPECT_NEAR(pull.moved_mm[999], out_and_back[999], 0.02);
    } else if (limit < 3) {
      worst = std::max(worst, std::abs(max_N / limit - 1));
      EXPECT_LT(pull.along_N[990], 0);  // against the motion, also on the way back
      EXPECT_GT(pull.along_N[1990], 0);
    } else {
      // The tool sticks, except for a creep of less than 0.02 mm/s.
      stuck_mm = std::max(stuck_mm, std::abs(pull.moved_mm[999]));
    }
  }
  verdict.AtMost("error of the sliding force, mu 0.05 and 0.2", 100 * worst, 3, "%");
  verdict.AtMost("creep in a second at mu = 1 and 2", stuck_mm, 0.01, "mm");
}

TEST(HardCase10, FrictionDoesNotChatterAtRestOrThroughZeroSpeed) {
  Verdict verdict("holds");
  double max_step = 0;
  double rest_N = 0;
  for (const double mu : {0.2, 1.0, 2.0}) {
    // The handle moves back and forth by 0.5 mm at up to 3 mm/s, then rests.
    std::vector<double> handle_mm;
    for (int i = 0; i < 2000; ++i) handle_mm.push_back(0.5 * std::sin(0.006 * i));
    handle_mm.resize(2600, handle_mm.back());
    const Pull pull = PullSideways(mu, handle_mm);
    for (std::size_t i = 1; i < handle_mm.size(); ++i) {
      const double step = std::abs(pull.along_N[i] - pull.along_N[i - 1]);
      const double drawn = std::abs(handle_mm[i] - handle_mm[i - 1]) * 2;
      if (i > 10) max_step = std::max(max_step, step / std::max(drawn, 1e-3));
      if (i > 2300) rest_N = std::max(rest_N, step);
    }
  }
  // The coupling's stiffness limits the change of friction: within a tick the force changes by at most K dx.
  verdict.AtMost("change of friction in a tick relative to the change of the spring force", max_step, 1.5);
  verdict.AtMost("change of friction in a tick at rest", 1000 * rest_N, 0.1, "mN");
}

TEST(HardCase10, BuriedSawRisesOnlyByTheEnergyLostToFriction) {
  Verdict verdict("holds");
  // The tool is created 0.3 mm deep in the bone, with the spindle stopped, and is pressed down with 4 N. It does not
  // rise, because that would create energy. When it is dragged sideways, friction dissipates energy, and the same
  // amount may lift the tool, at 2 mm/s.
  const Pose X_start = DiscPose({}, {0, 0, 2 + kR - 0.3});
  WatchedTool tool(MakeBox({}, {24, 8, 4}, 0.2), DiscParams(), X_start);
  const auto to = [&](double y) { return tool.Tick(DiscPose({}, {0, y, 2 + kR - 4.3}), 0); };
  double fastest = 0;
  const auto lowest = [&] { return tool.X_WT.Point({0, kR, 0}).z - 2; };
  for (int i = 0; i < 300; ++i) to(0);
  const double before = lowest();
  double last = before;
  for (int i = 0; i < 1000; ++i) {
    to(0.003 * std::min(i, 700));
    fastest = std::max(fastest, (lowest() - last) * 1000);
    last = lowest();
  }
  tool.invariants.CheckBone();
  verdict.AtMost("height before dragging", before, -0.25, "mm");
  verdict.AtLeast("height after dragging", last, -0.1, "mm");
  verdict.AtMost("fastest rise", fastest, 2.1, "mm/s");
  verdict.AtLeast("total energy dissipated", tool.invariants.lost_mJ(), 0, "mJ");
}

TEST(HardCase10, FrictionOfATurningSawInItsKerfIsBoundedAndOpposesTheSlip) {
  Verdict verdict("holds");
  const Bone bone = MakeBox({}, {26, 4, 10}, 0.2);
  double largest_N = 0;
  double drag_N[4] = {};
  const double mus[4] = {0, 0.2, 1, 2};
  // A handle of 1 N/mm lets the friction drag the saw along the kerf by 2 to 4 mm. From a coefficient of 1 on, the drag
  // then wanders between 2 and 6 N.
  constexpr double kStiffness_N_per_mm = 5;
  constexpr double kPush_mm = 0.3;
  for (int n = 0; n < 4; ++n) {
    CoupledParams params = DiscParams();
    params.coupling.stiffness_N_per_mm = kStiffness_N_per_mm;
    SetEffect(params.effects, "kerf_friction", "coefficient", mus[n]);
    WatchedTool tool(bone, params, DiscPose({}, {0, 0, 5 + kR + 0.1}));
    for (int i = 0; i < 1500; ++i) tool.Tick(DiscPose({}, {0, 0, 5 + kR + 0.1 - 0.006 * std::min(i, 1000)}));
    // The tool is pushed against a wall of the kerf with 1.5 N.
    CoupledOutput out;
    for (int i = 0; i < 1000; ++i) {
      out = tool.Tick(DiscPose({}, {0, kPush_mm * std::min(i / 500.0, 1.0), 5 + kR - 5.9}));
      // Friction is at most its coefficient times the force of the walls.
      EXPECT_LE(glm::length(out.f_friction_W_N), mus[n] * 8 + 1e-9);
    }
    drag_N[n] = out.f_friction_W_N.x;
    if (mus[n] == 0) {
      EXPECT_EQ(out.f_friction_W_N, Vec3(0));
      EXPECT_EQ(tool.invariants.spindle_mJ(), 0);
    }
    // The tool is pushed against the other wall, which pushes in the opposite direction.
    const double wall_N = out.f_face_W_N.y;
    EXPECT_LT(wall_N, -1);
    for (int i = 0; i < 1000; ++i) out = tool.Tick(DiscPose({}, {0, kPush_mm * (1 - i / 500.0), 5 + kR - 5.9}));
    EXPECT_NEAR(out.f_face_W_N.y, -wall_N, 0.1);
    for (int i = 0; i < 1000; ++i) out = tool.Tick(DiscPose({}, {0, kPush_mm * (i / 500.0 - 1), 5 + kR - 5.9}));
    // With the spindle reversed, the drag is reversed too.
    for (int i = 0; i < 300; ++i) out = tool.Tick(DiscPose({}, {0, kPush_mm, 5 + kR - 5.9}), -7500);
    if (mus[n] > 0) {
      EXPECT_LT(out.f_friction_W_N.x, -0.2 * drag_N[n]);
    }
    largest_N = std::max(largest_N, tool.invariants.largest_force_N());
    tool.invariants.CheckBone();
  }
  // The spindle is along +y: below its centre, at the walls, the disc moves towards -x. Friction pulls the tool in the
  // opposite direction, more strongly with a higher coefficient.
  for (int n = 1; n < 4; ++n) EXPECT_GT(drag_N[n], drag_N[n - 1]);
  verdict.Note("drag at mu = 0.2", std::abs(drag_N[1]), "N");
  verdict.AtMost("largest force, mu 0 to 2", largest_N, 20, "N");
}

}  // namespace
}  // namespace kerf::test
