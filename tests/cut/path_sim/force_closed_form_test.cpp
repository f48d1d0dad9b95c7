// Engaged teeth and force on homogeneous and layered blocks, compared with closed forms.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "kerf/simulation.h"
#include "support/cuts.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscPose;
using test::Stroke;

/// A region of the paper's Table 1.
struct PaperRegion {
  int id;
  double E_MPa;
  double nu;
};
constexpr PaperRegion kPaperRegions[] = {{24, 19300, 0.28}, {21, 20500, 0.25}, {13, 19300, 0.25}, {6, 17300, 0.38}};
constexpr double kPaperDepths[] = {1.1, 2.2, 3.3, 4.4, 5.5, 6.6};

Bone BlockOf(const PaperRegion& region, const Pose& X_WB, const Vec3& size, double voxel_mm) {
  Bone bone = test::MakeBox(X_WB, size, voxel_mm);
  bone.set_materials(test::OneRegionTable(24, region.E_MPa, region.nu));  // the region grid has region 24 everywhere
  return bone;
}

/// Closed form for a kerf: the rim is engaged from its lowest point to where it leaves the surface.
struct SlotForm {
  double teeth;
  double thrust_N;  // sum of the tooth forces
  double along_N;   // against the feed
  double up_N;      // out of the bone
};

/// Integrates over the engaged arc by the midpoint rule with 1e5 intervals, accurate to 1e-9.
SlotForm CalcSlotForm(const ForceLaw& law, double E_star_MPa, double depth_mm, double feed_mm_per_s, double rpm) {
  const ToothForce force = MakeToothForce(law, kSaw);
  const double alpha = std::acos(1 - depth_mm / kR);
  const double bite = feed_mm_per_s / (kSaw.teeth * rpm / 60);
  SlotForm form{alpha * kR / kSaw.pitch_mm(), 0, 0, 0};
  constexpr int kIntervals = 100000;
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = alpha * (i + 0.5) / kIntervals;  // from the lowest point towards the feed
    const double f =
        force(bite * std::sin(phi), Cortical(E_star_MPa)) * kSaw.teeth / (2 * std::numbers::pi) * alpha / kIntervals;
    form.thrust_N += f;
    form.along_N += f * std::sin(phi);
    form.up_N += f * std::cos(phi);
  }
  return form;
}

/// Returns a tooth force, computed independently of the library with Hertz's formula, in mm, N and MPa.
double HertzByHand(const ForceLaw& law, double E_star, double bite) {
  const double R = 11;
  if (std::string_view(law.name()) == "hertz_chip") return 4.0 / 3.0 * E_star * std::sqrt(R) * std::pow(bite, 1.5);
  // (a / K)^3 with the paper's K^3 = 3 d1 / (8 E*), a = 1 % of the pitch.
  const double a = 0.01 * std::numbers::pi * 22 / 24;
  return std::pow(a, 3) / (3 * 22 / (8 * E_star));
}

/// Returns means over the middle of a kerf, where depth and bite are constant.
SlotForm MeasureSlot(const Bone& block, const Pose& X_WB, const ForceLaw& law, double top, double depth, double feed) {
  SimulationParams params;
  params.law = law;
  const double z = top - depth + kR;
  const Vec3 from(-12, 0, z);
  Simulation simulation(block, params, DiscPose(X_WB, from));
  Stroke(simulation, X_WB, from, {-2, 0, z}, 100);  // approach to the measured part
  const std::vector<TickOutput> ticks = Stroke(simulation, X_WB, {-2, 0, z}, {-1.6, 0, z}, feed);
  SlotForm mean{0, 0, 0, 0};
  const double n = static_cast<double>(ticks.size()) / 2;
  for (std::size_t i = ticks.size() / 2; i < ticks.size(); ++i) {
    mean.teeth += ticks[i].engaged_teeth / n;
    mean.thrust_N += ticks[i].thrust_sum_N / n;
    mean.along_N -= glm::dot(ticks[i].f_T_W_N, X_WB.Vector({1, 0, 0})) / n;
    mean.up_N += glm::dot(ticks[i].f_T_W_N, X_WB.Vector({0, 0, 1})) / n;
  }
  return mean;
}

TEST(ForceClosedForm, SlotForceAndTeethAreWithinOnePercentForThePapersRegionsAndDepths) {
  const Vec3 size(22, 1.5, 8);
  const double feed = 4;
  double worst_teeth = 0;
  double worst_force = 0;
  const Pose X_WB = BlockPoses(0.1)[5];
  const Bone block = test::MakeBox(X_WB, size, 0.1);
  for (const char* name : {"hertz_chip", "hertz_constant_bite"}) {
    const ForceLaw law(name);
    for (const PaperRegion& region : kPaperRegions) {
      Bone bone = block;
      bone.set_materials(test::OneRegionTable(24, region.E_MPa, region.nu));
      const double E_star = CalcReducedModulus(kSaw.E_MPa, kSaw.nu, region.E_MPa, region.nu);
      for (const double depth : kPaperDepths) {
        const SlotForm expected = CalcSlotForm(law, E_star, depth, feed, 7500);
        const SlotForm measured = MeasureSlot(bone, X_WB, law, 4, depth, feed);
        EXPECT_NEAR(measured.teeth / expected.teeth, 1, 0.01) << "depth " << depth;
        EXPECT_NEAR(measured.thrust_N / expected.thrust_N, 1, 0.01) << "depth " << depth;
        EXPECT_NEAR(measured.along_N / expected.along_N, 1, 0.01) << "depth " << depth;
        EXPECT_NEAR(measured.up_N / expected.up_N, 1, 0.01) << "depth " << depth;
        worst_teeth = std::max(worst_teeth, std::abs(measured.teeth / expected.teeth - 1));
        worst_force = std::max(worst_force, std::abs(measured.thrust_N / expected.thrust_N - 1));
      }
    }
  }
  std::printf("worst: engaged teeth %.3f %%, thrust %.3f %%\n", 100 * worst_teeth, 100 * worst_force);
}

TEST(ForceClosedForm, ForceDoesNotDependOnThePoseInTheGrid) {
  const double E_star = CalcReducedModulus(kSaw.E_MPa, kSaw.nu, 19300, 0.28);
  const SlotForm expected = CalcSlotForm({}, E_star, 3.3, 4, 7500);
  for (const Pose& X_WB : BlockPoses(0.1)) {
    const Bone bone = BlockOf(kPaperRegions[0], X_WB, {20, 1.5, 5}, 0.1);
    const SlotForm measured = MeasureSlot(bone, X_WB, {}, 2.5, 3.3, 4);
    EXPECT_NEAR(measured.teeth / expected.teeth, 1, 0.01);
    EXPECT_NEAR(measured.thrust_N / expected.thrust_N, 1, 0.01);
  }
}

TEST(ForceClosedForm, PlungeEngagesTheWholeBuriedArc) {
  const Bone bone = test::MakeBox(Pose{}, {20, 1.5, 6}, 0.1);
  Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 3 + kR + 0.5}));
  Stroke(simulation, Pose{}, {0, 0, 3 + kR + 0.5}, {0, 0, 3 + kR - 3}, 100);
  const std::vector<TickOutput> ticks = Stroke(simulation, Pose{}, {0, 0, kR}, {0, 0, kR - 0.02}, 4);
  const TickOutput& out = ticks.back();
  const double alpha = std::acos(1 - 3.02 / kR);
  EXPECT_NEAR(out.engaged_teeth, 2 * alpha * kR / kSaw.pitch_mm(), 0.01 * out.engaged_teeth);
  // By mirror symmetry there is no force along x; along the spindle's axis there is never a force.
  EXPECT_NEAR(out.f_T_W_N.x, 0, 1e-3 * out.f_T_W_N.z);
  EXPECT_NEAR(out.f_T_W_N.y, 0, 1e-9);
  EXPECT_GT(out.f_T_W_N.z, 0);
}

TEST(ForceClosedForm, ToothForceIsHertz) {
  for (const char* name : {"hertz_chip", "hertz_constant_bite"}) {
    const ForceLaw law(name);
    for (const double bite : {1e-4, 1e-3, 2.5e-3}) {
      for (const double E_star : {500.0, 19000.0}) {
        EXPECT_NEAR(MakeToothForce(law, kSaw)(bite, Cortical(E_star)) / HertzByHand(law, E_star, bite), 1, 1e-12);
      }
    }
  }
}

TEST(ForceClosedForm, LayeredPlateGivesEachLayersForceAndTheStepBetweenThem) {
  // The saw is much larger than the plate is long, so the whole length of the plate is cut at nearly the same depth.
  const Vec3 size(10, 1, 6);
  SolidField field;
  field.value = [=](const Vec3& p) { return test::BoxDistance(p, 0.5 * size); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p) { return p.z > 1 ? 24 : p.z > -1 ? 32 : 6; };
  MaterialTable table = test::OneRegionTable(24, 19300, 0.28);
  table.Add({32, "cancellous", Tissue::kCancellous, 500, 0.3, true, "test"});
  table.Add({6, "lower", Tissue::kCortical, 17300, 0.38, true, "test"});
  const Bone bone = MakeBone(field, Box3{Vec3(-6, -1.5, -4), Vec3(6, 1.5, 4)}, {0.1, 0.1, {}}, table);

  SimulationParams params;
  DiscSaw saw;
  saw.diameter_mm = 200;
  saw.teeth = 200;
  params.tool = saw;
  params.law = ForceLaw("hertz_chip");
  params.law.Set("contact_radius_mm", 11);
  const double R = saw.radius_mm();
  Simulation simulation(bone, params, DiscPose(Pose{}, {0, 0, 3.5 + R}));
  const double feed = 5;
  const std::vector<TickOutput> ticks = Stroke(simulation, Pose{}, {0, 0, 3.5 + R}, {0, 0, -3 + R}, feed);
  const double sag = R - std::sqrt(R * R - 25);  // 0.125 mm: height of the rim's ends above its middle
  const double bite = feed / (saw.teeth * 7500 / 60.0);
  const double arc_teeth = 2 * std::asin(5 / R) * R / saw.pitch_mm();
  int checked = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double lowest =
        3.5 - feed * 0.001 * static_cast<double>(i);  // height of the rim in the plate's frame at the tick's start
    const double highest = lowest + sag;
    for (const auto& [id, top, bottom] :
         {std::tuple{24, 3.0, 1.0}, std::tuple{32, 1.0, -1.0}, std::tuple{6, -1.0, -3.0}}) {
      // Look-ahead and interpolation blur a border by 1.5 voxels; breakthrough begins three voxels before the end.
      if (!(highest < top - 0.15 && lowest > bottom + (id == 6 ? 0.3 : 0.15))) continue;
      const Region& region = table.At(id);
      const double E_star = CalcReducedModulus(kSaw.E_MPa, kSaw.nu, region.E_MPa, region.nu);
      EXPECT_NEAR(ticks[i].mean_E_MPa, region.E_MPa, 1e-6 * region.E_MPa);
      // At each end of the plate, its edge is rounded at this voxel size, which shortens the kerf's floor by up to 0.07
      // mm: 1.4 % for both ends, plus a little due to the look-ahead along the floor.
      EXPECT_NEAR(ticks[i].thrust_sum_N / (arc_teeth * HertzByHand(params.law, E_star, bite)), 1, 0.016);
      ++checked;
    }
  }
  EXPECT_GT(checked, 800);
  // The step of E occurs at the right place: half of the arc is past a border when the rim's mean height equals the
  // border's.
  const double mean_sag = sag / 3;
  for (const auto& [border, E_above, E_below] : {std::tuple{1.0, 19300.0, 500.0}, std::tuple{-1.0, 500.0, 17300.0}}) {
    const auto middle = [&, up = E_above, down = E_below](const TickOutput& t) {
      return (t.mean_E_MPa - 0.5 * (up + down)) * (down - up) > 0;  // past the middle of the step
    };
    std::size_t i = 0;
    while (i < ticks.size() && 3.5 - feed * 0.001 * static_cast<double>(i) + mean_sag > border + 0.5) ++i;
    while (i < ticks.size() && !middle(ticks[i])) ++i;
    ASSERT_LT(i, ticks.size());
    const double height = 3.5 - feed * 0.001 * static_cast<double>(i) + mean_sag;
    EXPECT_NEAR(height, border, 0.1);  // one voxel
  }
}

TEST(ForceClosedForm, ForceIsContinuousOnEntryAndBetweenTicks) {
  // The force does not jump: when the disc enters a face at 1 mm/s, no tick changes the force by more than 5 % of the
  // final force.
  const Bone bone = test::MakeBox(Pose{}, {10, 1.5, 4}, 0.1);
  Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 2 + kR + 0.1}));
  const auto ticks = Stroke(simulation, Pose{}, {0, 0, 2 + kR + 0.1}, {0, 0, 2 + kR - 0.5}, 1);
  const double last = ticks.back().f_T_W_N.z;
  ASSERT_GT(last, 0);
  EXPECT_EQ(ticks.front().f_T_W_N, Vec3(0));  // exactly zero in air
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    EXPECT_LE(std::abs(ticks[i].f_T_W_N.z - ticks[i - 1].f_T_W_N.z), 0.05 * last);
  }
}

TEST(ForceClosedForm, RimFindsAPlateBetweenTwoOfItsSamples) {
  // With 8 samples per pitch the rim is sampled every 0.36 mm, with one sample at its lowest point: a plate 0.2 mm wide
  // is placed between two of them.
  Pose X_WB;
  X_WB.p_AB = {0.18, 0, 0};
  const Bone bone = test::MakeBox(X_WB, {0.2, 1.5, 4}, 0.05);
  Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 2 + kR + 0.2}));
  const auto ticks = Stroke(simulation, Pose{}, {0, 0, 2 + kR + 0.2}, {0, 0, kR}, 4);
  const TickOutput& out = ticks.back();
  ASSERT_GT(out.removed_mm3, 0);
  // Each free edge of the kerf's floor is rounded by up to 0.7 voxels, 0.035 mm: at least 0.13 of 0.2 mm are engaged.
  EXPECT_GT(out.engaged_teeth, 0.13 / kSaw.pitch_mm());
  EXPECT_LT(out.engaged_teeth, 0.23 / kSaw.pitch_mm());
}

TEST(ForceClosedForm, TorqueIsTheForcesMomentAboutTheGrip) {
  const Pose X_WB = BlockPoses(0.2)[5];
  const Bone bone = test::MakeBox(X_WB, {20, 2, 6}, 0.2);
  SimulationParams params;
  DiscSaw saw;
  saw.p_TG_mm = {3, -4, 80};
  params.tool = saw;
  Simulation simulation(bone, params, DiscPose(X_WB, {-12, 0, 12}));
  const auto ticks = Stroke(simulation, X_WB, {-12, 0, 12}, {0, 0, 12}, 50);
  const TickOutput& out = ticks.back();
  ASSERT_GT(out.engaged_teeth, 0.5);
  const Pose X_WT = DiscPose(X_WB, {0, 0, 12});
  const Vec3 arm_W = X_WT.p_AB - X_WT.Point(saw.p_TG_mm);  // from the grip to the disc's centre
  const Vec3 expected = glm::cross(arm_W, out.f_T_W_N);
  EXPECT_NEAR(glm::length(out.tau_TG_W_Nmm - expected), 0, 1e-9 * glm::length(expected));
}

TEST(Simulation, BadPoseChangesNothingAndGivesNoForce) {
  const Bone bone = test::MakeBox(Pose{}, {20, 2, 6}, 0.2);
  Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 3 + kR}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  TickInput bad;
  bad.X_WT = DiscPose(Pose{}, {0, 0, kR});
  bad.X_WT.p_AB.x = nan;
  for (int i = 0; i < 4; ++i) {
    TickInput in = bad;
    if (i > 0) in.X_WT = DiscPose(Pose{}, {0, 0, kR});
    if (i == 1) in.X_WT.R_AB.w = 2;
    if (i == 2) in.dt_s = -0.001;
    if (i == 3) in.rpm = nan;
    const TickOutput out = simulation.Tick(in);
    EXPECT_EQ(out.status, kTickBadPose);
    EXPECT_EQ(out.f_T_W_N, Vec3(0));
    EXPECT_EQ(out.removed_mm3, 0);
  }
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), bone.CalcHash());
  // The next valid pose is reached from the last valid one.
  EXPECT_GT(simulation.Tick({DiscPose(Pose{}, {0, 0, 2 + kR}), 0.001, 7500}).removed_mm3, 0);
}

TEST(Simulation, StoppedSpindleDoesNotCut) {
  const Bone bone = test::MakeBox(Pose{}, {20, 2, 6}, 0.2);
  // A spindle below kMinRpm counts as stopped.
  for (const double rpm : {0.0, 0.999, -0.5, 1e-300, 5e-324}) {
    Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 3 + kR}));
    const TickOutput out = simulation.Tick({DiscPose(Pose{}, {0, 0, 2 + kR}), 0.001, rpm});
    EXPECT_EQ(out.status, kTickSpindleStopped) << rpm;
    EXPECT_EQ(out.removed_mm3, 0) << rpm;
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), bone.CalcHash()) << rpm;
  }
}

TEST(Simulation, SameCallsGiveTheSameBits) {
  const Pose X_WB = BlockPoses(0.2)[6];
  const Bone bone = test::MakeBox(X_WB, {8, 2, 6}, 0.2);
  std::uint64_t hash[2];
  std::vector<TickOutput> outs[2];
  for (int run = 0; run < 2; ++run) {
    Simulation simulation(bone, {}, DiscPose(X_WB, {-12, 0, 12}));
    outs[run] = Stroke(simulation, X_WB, {-12, 0, 12}, {0, 0, 11}, 30);
    hash[run] = simulation.UpdateBone().CalcHash();
  }
  EXPECT_EQ(hash[0], hash[1]);
  for (std::size_t i = 0; i < outs[0].size(); ++i) {
    EXPECT_EQ(outs[0][i].f_T_W_N, outs[1][i].f_T_W_N);
    EXPECT_EQ(outs[0][i].removed_mm3, outs[1][i].removed_mm3);
  }
}

}  // namespace
}  // namespace kerf
