// Hard case 18: a time step that is zero, tiny, too long, negative or not a number, in every part that has a time step.
#include <limits>

#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "kerf/slab.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::InKerf;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNegligibleTimeSteps[] = {0.0, -0.0, std::numeric_limits<double>::denorm_min(), 1e-9, 0.99e-6};
constexpr double kInvalidTimeSteps[] = {-1e-9, -0.001, -1.0, 1.01, 1e300, kInf, -kInf, kNan};

void ExpectSame(const CoupledOutput& a, const CoupledOutput& b) {
  EXPECT_EQ(a.X_WT.p_AB, b.X_WT.p_AB);
  EXPECT_EQ(a.X_WT.R_AB, b.X_WT.R_AB);
  EXPECT_EQ(a.f_H_W_N, b.f_H_W_N);
  EXPECT_EQ(a.tau_H_W_Nmm, b.tau_H_W_Nmm);
  EXPECT_EQ(a.f_cut_W_N, b.f_cut_W_N);
  EXPECT_EQ(a.f_face_W_N, b.f_face_W_N);
  EXPECT_EQ(a.f_friction_W_N, b.f_friction_W_N);
  EXPECT_EQ(a.thrust_sum_N, b.thrust_sum_N);
  EXPECT_EQ(a.engaged_teeth, b.engaged_teeth);
}

TEST(HardCase18, ZeroTimeStepRepeatsTheForceAndDoesNothingElse) {
  test::Verdict verdict(
      "holds: a time step below 1 us repeats the last force and does nothing else; an invalid one is refused");
  const Bone bone = test::MakeBox(Pose{}, {26, 2, 8}, 0.2);
  const Pose start = DiscPose(Pose{}, {0, 0, 4 + kR + 0.1});
  CoupledParams params = DiscParams();
  params.coupling.damping_Ns_per_mm = 0.002;
  CoupledSimulation simulation(bone, params, start);
  CoupledSimulation twin(bone, params, start);  // never receives such a time step
  test::Invariants watch(twin, start);
  int checked = 0;
  for (int i = 1; i <= 900; ++i) {
    CoupledInput in = test::Handle(DiscPose(Pose{}, {0.001 * i, 0.0005 * i, 4 + kR + 0.1 - 0.005 * i}));
    in.v_H_W_mm_per_s = Vec3(1, 0.5, -5);
    if (i > 600) in.rpm = 0;
    const CoupledOutput out = simulation.Tick(in);
    const CoupledOutput same = twin.Tick(in);
    watch.Tick(in, same);
    ExpectSame(out, same);
    if (i % 50 != 0) continue;
    simulation.ClearChanged();
    for (const double dt_s : kNegligibleTimeSteps) {
      CoupledInput none = in;
      none.dt_s = dt_s;
      none.X_WH.p_AB += Vec3(0, 0, checked % 2 == 0 ? -3 : 0);  // any position of the handle
      none.rpm = checked % 3 == 0 ? 0 : in.rpm;
      const CoupledOutput held = simulation.Tick(none);
      EXPECT_EQ(held.status, kCoupledNoTime);
      ExpectSame(held, out);
      for (const double energy_mJ : {held.hand_mJ, held.spindle_mJ, held.stored_mJ, held.cut_mJ, held.friction_mJ,
                                     held.damping_mJ, held.numerical_mJ, held.removed_mm3}) {
        EXPECT_EQ(energy_mJ, 0);
      }
      EXPECT_EQ(simulation.changed_count(), 0);
      ++checked;
    }
    // An invalid time step gives no force and leaves the state unchanged.
    for (const double dt_s : kInvalidTimeSteps) {
      CoupledInput none = in;
      none.dt_s = dt_s;
      const CoupledOutput refused = simulation.Tick(none);
      EXPECT_EQ(refused.status, kCoupledBadPose) << dt_s;
      EXPECT_EQ(refused.f_H_W_N, Vec3(0)) << dt_s;
      EXPECT_EQ(refused.X_WT.p_AB, out.X_WT.p_AB) << dt_s;
      none.dt_s = 0;
      EXPECT_EQ(simulation.Tick(none).f_H_W_N, Vec3(0)) << "there is no previous force to repeat";
      EXPECT_EQ(simulation.changed_count(), 0);
    }
  }
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), twin.UpdateBone().CalcHash());
  EXPECT_NE(simulation.UpdateBone().CalcHash(), bone.CalcHash());
  watch.CheckBone();
  verdict.Note("ticks below 1 us that repeated the last force bit for bit", checked);
}

TEST(HardCase18, AfterSetDownOrBeforeTheFirstTickThereIsNoForceToKeep) {
  InKerf kerf(Pose{}, {26, 2, 8}, 0.4, 2, DiscParams());
  kerf.Hold(10, {0, 0, -3});
  ASSERT_GT(kerf.out.f_H_W_N.z, 0.5);
  const Pose up = DiscPose(Pose{}, {0, 0, 20});
  ASSERT_TRUE(kerf.simulation.SetDown(up));
  CoupledInput none = test::Handle(kerf.X_WH);
  none.dt_s = 0;
  CoupledOutput out = kerf.simulation.Tick(none);
  EXPECT_EQ(out.f_H_W_N, Vec3(0));
  EXPECT_EQ(out.X_WT.p_AB, up.p_AB);
  CoupledSimulation fresh(test::MakeBox(Pose{}, {6, 2, 4}, 0.4), DiscParams(), up);
  out = fresh.Tick(none);
  EXPECT_EQ(out.f_H_W_N, Vec3(0));
  EXPECT_EQ(out.X_WT.p_AB, up.p_AB);
}

TEST(HardCase18, TickOfAWholeSecondStaysBounded) {
  test::Verdict verdict("holds: a tick moves the tool by at most max_substeps substeps");
  double max_motion_mm = 0;
  double max_mm3 = 0;
  for (const double dt_s : {1e-6, 1e-4, 0.01, 0.1, 1.0}) {
    for (const double rpm : {7500.0, 0.0}) {
      InKerf kerf(Pose{}, {26, 2, 20}, 0.2, 3, DiscParams());
      for (int i = 0; i < 40; ++i) {
        const Vec3 was = kerf.Place();
        kerf.To(kerf.OffsetPose({i % 2 == 0 ? 4.0 : -4.0, 1, -30}, 0.01), rpm, dt_s);
        max_motion_mm = std::max(max_motion_mm, glm::length(kerf.Place() - was));
        max_mm3 = std::max(max_mm3, kerf.out.removed_mm3);
      }
      kerf.invariants.CheckBone();
    }
  }
  const int max_substeps = DiscParams().max_substeps;
  verdict.AtMost("motion of the tool in a tick", max_motion_mm, max_substeps * 0.5 * 0.2 * (1 + 1e-9), "mm");
  // The bound uses the disc's projection along the motion: its diameter times its thickness, plus a margin for the
  // occupancy of a voxel.
  verdict.AtMost("volume removed in a tick", max_mm3, max_substeps * 0.5 * 0.2 * 22 * (0.25 + 0.2), "mm^3");
}

TEST(HardCase18, ZeroTimeStepOnAPathAndInTheSlabRepeatsTheForce) {
  test::Verdict verdict("holds");
  const Bone bone = test::MakeBox(Pose{}, {20, 2, 6}, 0.4);
  Simulation simulation(bone, {}, DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
  Simulation twin(bone, {}, DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
  SlabParams slab_params;
  slab_params.direction_W = Vec3(0, 0, -1);
  slab_params.friction_coefficient = 0.3;
  slab_params.normal_force_N = 2;
  SlabProfile profile;
  profile.layers.push_back({0, 24, 19300, 0.28});
  profile.end_mm = 10;
  profile.entry_mm = -3;
  SlabSimulation slab(profile, slab_params, DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
  SlabSimulation slab_twin(profile, slab_params, DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
  double min_N = 1e9;
  for (int i = 1; i <= 300; ++i) {
    const TickInput in{DiscPose(Pose{}, {0, 0, 3 + kR + 0.1 - 0.005 * i}), 0.001, 7500};
    const TickOutput out = simulation.Tick(in);
    const TickOutput slab_out = slab.Tick(in);
    EXPECT_EQ(twin.Tick(in).f_T_W_N, out.f_T_W_N);
    EXPECT_EQ(slab_twin.Tick(in).f_T_W_N, slab_out.f_T_W_N);
    if (i % 30 != 0) continue;
    min_N = std::min({min_N, glm::length(out.f_T_W_N), glm::length(slab_out.f_T_W_N)});
    for (const double dt_s : kNegligibleTimeSteps) {
      TickInput none = in;
      none.dt_s = dt_s;
      none.X_WT.p_AB.z -= 1;
      const TickOutput held = simulation.Tick(none);
      EXPECT_EQ(held.status, kTickNoTime);
      EXPECT_EQ(held.f_T_W_N, out.f_T_W_N);
      EXPECT_EQ(held.tau_TG_W_Nmm, out.tau_TG_W_Nmm);
      EXPECT_EQ(held.removed_mm3, 0);
      const TickOutput slab_held = slab.Tick(none);
      EXPECT_EQ(slab_held.status, kTickNoTime);
      EXPECT_EQ(slab_held.f_T_W_N, slab_out.f_T_W_N);
      EXPECT_EQ(slab.state().deepest_mm, slab_twin.state().deepest_mm);
    }
    for (const double dt_s : {-1e-9, -0.001, kInf, -kInf, kNan}) {
      TickInput none = in;
      none.dt_s = dt_s;
      for (const TickOutput& refused : {simulation.Tick(none), slab.Tick(none)}) {
        EXPECT_EQ(refused.status, kTickBadPose) << dt_s;
        EXPECT_EQ(refused.f_T_W_N, Vec3(0)) << dt_s;
      }
    }
  }
  verdict.AtLeast("smallest force that was held", min_N, 0.05, "N");
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), twin.UpdateBone().CalcHash());
}

TEST(HardCase18, DeviceKeepsItsForceForAZeroTimeStepAndLosesItForAnInvalidOne) {
  test::Verdict verdict(
      "holds: force, ramp and velocity are held; an invalid time step gives zero force and a new ramp");
  test::HeldSawOptions options;
  options.damping_Ns_per_mm = 0.001;
  test::HeldSaw saw(options);
  test::HeldSaw twin(options);
  for (test::HeldSaw* s : {&saw, &twin}) {
    IntentionStep push;
    push.seconds = 20;
    push.X_WH = s->start;
    push.push_W_N = Vec3(0, 0, -5);
    push.yield_s = 0.5;
    s->device.SetScript(IntentionScript(s->start, {push}));
  }
  for (int i = 1; i <= 2000; ++i) {
    const HapticTick out = saw.Step();
    const HapticTick same = twin.Step();
    EXPECT_EQ(out.force.f_H_W_N, same.force.f_H_W_N);
    EXPECT_EQ(out.v_H_W_mm_per_s, same.v_H_W_mm_per_s);
    if (i % 100 != 50) continue;
    for (int n = 0; n < 3; ++n) {
      const HapticTick held = saw.Step(7500, 0);
      EXPECT_EQ(held.faults, kHapticOk);
      EXPECT_EQ(held.force.f_H_W_N, out.force.f_H_W_N);
      EXPECT_EQ(held.force.ramp, out.force.ramp);
      EXPECT_EQ(held.v_H_W_mm_per_s, out.v_H_W_mm_per_s);
      EXPECT_EQ(saw.device.force_N(), twin.device.force_N());
    }
  }
  const HapticTick last = saw.Step();
  ASSERT_GT(last.force.f_H_W_N.z, 4);
  for (const double dt_s : {-0.001, kNan, -kInf, kInf}) {
    const HapticTick refused = saw.Step(7500, dt_s);
    EXPECT_NE(refused.faults & kHapticBadForce, 0u) << dt_s;
    EXPECT_EQ(refused.force.f_H_W_N, Vec3(0)) << dt_s;
    EXPECT_EQ(saw.device.force_N(), Vec3(0)) << dt_s;
  }
  const HapticTick next = saw.Step();
  EXPECT_EQ(next.faults, kHapticOk);
  verdict.AtMost("force in the first tick of the new ramp", next.force.f_H_W_N.z, 0.001 * last.force.f_H_W_N.z, "N");
}

}  // namespace
}  // namespace kerf
