// Hard case 17: no tooth, one tooth, many teeth, and a disc whose teeth are all in the air while its flats touch bone.
#include <numbers>

#include "cut/force/laws.h"
#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "kerf/error.h"
#include "kerf/force.h"
#include "support/message_of.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::InKerf;
using test::Sawing;

TEST(HardCase17, ASawWithoutTeethIsRefusedAtSetUp) {
  test::Verdict verdict("holds: 0 teeth are refused, 1 to 1000 work");
  for (const int teeth : {0, -1, 1001}) {
    CoupledParams params = DiscParams();
    DiscSaw saw;
    saw.teeth = teeth;
    params.tool = saw;
    EXPECT_EQ(
        test::MessageOf([&] {
          CoupledSimulation simulation(test::MakeBox(Pose{}, {6, 2, 4}, 0.4), params, DiscPose(Pose{}, {0, 0, 30}));
        }),
        fmt::format("teeth = {} {}; valid range 1 to 1000", teeth, teeth < 1 ? "is below 1" : "is above 1000"));
    EXPECT_THROW(Simulation(test::MakeBox(Pose{}, {6, 2, 4}, 0.4), {saw, {}, {}, 8}, DiscPose(Pose{}, {0, 0, 30})),
                 Error);
  }
}

TEST(HardCase17, ThrustDependsOnTheNumberOfTeethByTheForceLaw) {
  test::Verdict verdict("holds: the thrust on each engaged tooth follows the force law at the bite of that tooth");
  const Bone bone = test::MakeBox(Pose{}, {26, 2, 8}, 0.2);
  const double E_star = CalcReducedModulus(DiscSaw().E_MPa, DiscSaw().nu, 19300, 0.28);
  double max_off = 0;
  for (const int teeth : {1, 2, 24, 64, 1000}) {
    CoupledParams params = DiscParams();
    DiscSaw disc;
    disc.teeth = teeth;
    params.tool = disc;
    params.coupling.stiffness_N_per_mm = 1000;  // the tool follows the handle
    params.coupling.max_force_N = 1e4;
    Sawing saw(bone, params, DiscPose(Pose{}, {0, 0, 4 + kR + 0.1}));
    saw.Move(DiscPose(Pose{}, {0, 0, 4 + kR - 2}), 420, 7500);  // 5 mm/s
    const double z = saw.out.X_WT.p_AB.z;
    saw.Move(DiscPose(Pose{}, {0, 0, 4 + kR - 2.005}), 1, 7500);
    const double feed = (z - saw.out.X_WT.p_AB.z) / 0.001;
    EXPECT_NEAR(feed, 5, 0.5) << teeth;
    const ToothForce force = MakeToothForce(params.law, params.tool);
    // Over the arc of half angle alpha that is engaged at the start of the tick, a tooth has a bite of v cos(phi) / f.
    const double alpha = std::acos(1 - (4 + kR - z) / kR);
    double thrust_N = 0;
    for (int k = 0; k < 2000; ++k) {
      const double phi = alpha * ((k + 0.5) / 1000 - 1);
      thrust_N += force(feed * std::cos(phi) / (teeth * 7500 / 60.0), Cortical(E_star)) * teeth /
                  (2 * std::numbers::pi) * alpha / 1000;
    }
    max_off = std::max(max_off, std::abs(saw.out.thrust_sum_N / thrust_N - 1));
    EXPECT_NEAR(saw.out.engaged_teeth, teeth * alpha / std::numbers::pi, 0.02 * teeth * alpha / std::numbers::pi)
        << teeth;
    saw.invariants.CheckBone();
  }
  // The look-ahead lengthens the engaged arc by up to 1 % at this depth.
  verdict.AtMost("deviation from the closed form, 1 to 1000 teeth", max_off, 0.02);
}

/// Returns a plate across z, thinner than the disc's depth, with a slot as wide as the disc and longer than its chord.
/// The whole rim is in the air: above, below or in the slot.
Bone SlottedPlate(double voxel_mm) {
  const auto slot = [](const Vec3& p) {
    const double wide = test::BoxDistance(p - Vec3(p.x > 0 ? 11 : -11, 0, 0), {3, 2, 10});  // around the rim
    return std::min(wide, test::BoxDistance(p, {14, 0.125, 10}));
  };
  SolidField field;
  field.value = [=](const Vec3& p) { return std::max(test::BoxDistance(p, {18, 4, 1}), -slot(p)); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  return MakeBone(field, Box3{{-18, -4, -1}, {18, 4, 1}}.Grown(6 * voxel_mm), {voxel_mm, voxel_mm, {}},
                  test::OneRegionTable());
}

TEST(HardCase17, WithAllTeethInTheAirTheFlatsStillRub) {
  test::Verdict verdict("holds");
  const Bone bone = SlottedPlate(0.1);
  double smallest = 1e9;
  double largest = 0;
  for (const double side : {1.0, -1.0}) {
    for (const double rpm : {7500.0, -7500.0, 0.0}) {
      CoupledParams params = DiscParams();
      params.coupling.p_TC_mm = {0, 5, 0};  // the plate is 5 mm below the disc's centre
      SetEffect(params.effects, "kerf_friction", "coefficient", 0.2);
      const Pose start = DiscPose(Pose{}, {0, 0, 5});
      Sawing saw(bone, params, start);
      Pose X = start;
      X.p_AB.y += 5 * side;
      saw.Move(X, 200, rpm);
      // With the spindle stopped there is friction only while the saw moves along.
      if (rpm == 0) X.p_AB.x += 2;
      saw.Move(X, 400, rpm);
      const double N = glm::length(saw.out.f_face_W_N);
      const double rubs_N = glm::length(saw.out.f_friction_W_N);
      EXPECT_EQ(saw.out.engaged_teeth, 0);
      EXPECT_EQ(saw.out.f_cut_W_N, Vec3(0));
      EXPECT_EQ(saw.invariants.removed_mm3(), 0);
      EXPECT_NEAR(N, 5, 0.1);
      // With forward rotation, the flats below the centre slip backwards along the slot, and friction pulls the saw
      // forwards.
      if (rpm != 0) {
        EXPECT_GT(saw.out.f_friction_W_N.x * rpm, 0);
      }
      smallest = std::min(smallest, rubs_N / N);
      largest = std::max(largest, rubs_N / N);
    }
  }
  EXPECT_EQ(bone.CalcHash(), SlottedPlate(0.1).CalcHash());
  verdict.AtLeast("minimum friction / normal force", smallest, 0.1);
  verdict.AtMost("maximum friction / normal force", largest, 0.2 * (1 + 1e-6));
}

}  // namespace
}  // namespace kerf
