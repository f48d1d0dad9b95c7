// Tests of the checker: it accepts the simulation's results and detects each kind of fault.
#include "experiment/stability/invariants.h"

#include <gtest/gtest.h>

#include <functional>

#include "bone/grid/set_leaf.h"
#include "cut/hand_sim/hands.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf::test {
namespace {

/// A cut into a small block. Its ticks are recorded and then checked again with a fault.
struct Cut {
  Cut() : X_start(DiscPose({}, {0, 0, 3 + kR + 0.5})) {
    const Bone bone = MakeBox({}, {10, 3, 6}, 0.2);
    CoupledSimulation simulation(bone, DiscParams(), X_start);
    for (int i = 0; i < 300; ++i) {
      ins.push_back(Handle(DiscPose({}, {0.002 * i, 0, 3 + kR + 0.5 - 0.01 * i})));
      outs.push_back(simulation.Tick(ins.back()));
    }
  }
  Pose X_start;
  std::vector<CoupledInput> ins;
  std::vector<CoupledOutput> outs;
};

/// Returns the violations after `change` has been applied to the outputs.
std::map<std::string, std::string> FindViolations(const std::function<void(std::vector<CoupledOutput>&)>& change) {
  static const Cut cut;
  CoupledSimulation simulation(MakeBox({}, {10, 3, 6}, 0.2), DiscParams(), cut.X_start);
  Invariants invariants(simulation, cut.X_start, {.watch_bone = false, .report = false});
  std::vector<CoupledOutput> outs = cut.outs;
  change(outs);
  for (std::size_t i = 0; i < outs.size(); ++i) invariants.Tick(cut.ins[i], outs[i]);
  return invariants.violations();
}

TEST(Invariants, HoldInAnUnmodifiedCut) {
  EXPECT_TRUE(FindViolations([](auto&) {}).empty());
}

TEST(Invariants, EachDetectsItsFault) {
  const double nan = std::nan("");
  struct Fault {
    const char* invariant;
    std::function<void(std::vector<CoupledOutput>&)> change;
  };
  const Fault faults[] = {
      {"I1", [&](auto& o) { o[250].f_H_W_N.y = nan; }},
      {"I1", [&](auto& o) { o[250].numerical_mJ = INFINITY; }},
      {"I1", [&](auto& o) { o[250].X_WT.R_AB.w = 2; }},
      {"I2", [](auto& o) { o[250].f_H_W_N *= 40.001 / glm::length(o[250].f_H_W_N); }},
      {"I2",
       [](auto& o) {
         o[250].tau_H_W_Nmm = {4001, 0, 0};
       }},
      {"I2", [](auto& o) { o[250].substeps = 25; }},
      {"I2", [](auto& o) { o[250].mean_bite_mm = -1e-9; }},
      {"I2", [](auto& o) { o[250].f_cut_W_N *= 1.5; }},
      {"I3", [](auto& o) { o[5].f_H_W_N.z = 1e-300; }},
      {"I3", [](auto& o) { o[5].X_WT.p_AB.z += 1e-9; }},
      {"I3", [](auto& o) { o[5].removed_mm3 = 1e-12; }},
      {"I5", [](auto& o) { o[250].removed_mm3 = -1e-12; }},
      {"I15", [](auto& o) { o[250].numerical_mJ += 1e-5; }},
      {"I15", [](auto& o) { o[250].cut_mJ *= -1; }},
      {"I15", [](auto& o) { o[250].hand_mJ *= 1.01; }},
      // All dissipated energy of the ticks is returned.
      {"I15",
       [](auto& o) {
         o[250].numerical_mJ -= 10;
         o[250].spindle_mJ = 0;
         o[250].stored_mJ += 10;
       }},
      {"I7", [](auto& o) { o[250].X_WT.p_AB.x += 0.11; }},
      {"I7", [](auto& o) { o[250].X_WT.p_AB.y += 0.06; }},
      {"I7", [](auto& o) { o[250].X_WT.R_AB = o[250].X_WT.R_AB * glm::angleAxis(0.006, Vec3(1, 0, 0)); }},
      {"I17", [](auto& o) { o[250].f_H_W_N *= 1.01; }},
      {"I17", [](auto& o) { o[250].f_H_W_N *= -1; }},
      {"I17", [](auto& o) { o[250].X_WT = o[249].X_WT; }},  // a stale pose
      {"I17", [](auto& o) { o[250].f_cut_W_N *= 0.99; }},
      {"I17", [](auto& o) { o[250].tau_H_W_Nmm.x += 1; }},
  };
  for (std::size_t i = 0; i < std::size(faults); ++i) {
    const auto violations = FindViolations(faults[i].change);
    EXPECT_TRUE(violations.contains(faults[i].invariant)) << i;
    for (const auto& [invariant, text] : violations) EXPECT_NE(text.find("tick "), std::string::npos);
  }
}

// The coupling has a damper, as for every device. The only valid force is the sum of the spring's and of the damper's
// at the given speed.
TEST(Invariants, DampersForceMustMatchItsSpeed) {
  CoupledParams params = DiscParams();
  params.coupling.damping_Ns_per_mm = 0.002;
  const Pose X_start = DiscPose({}, {0, 0, 3 + kR + 0.5});
  for (const double added_N : {0.0, 1e-6, 0.01, 1.0}) {
    CoupledSimulation simulation(MakeBox({}, {10, 3, 6}, 0.2), params, X_start);
    Invariants invariants(simulation, X_start, {.watch_bone = false, .report = false});
    int damped = 0;
    for (int i = 0; i < 300; ++i) {
      CoupledInput in = Handle(DiscPose({}, {0.002 * i, 0, 3 + kR + 0.5 - 0.01 * i}));
      in.v_H_W_mm_per_s = {2, 0, -10};
      CoupledOutput out = simulation.Tick(in);
      const double spring_N = params.coupling.stiffness_N_per_mm * glm::length(out.X_WT.p_AB - in.X_WH.p_AB);
      damped += std::abs(glm::length(out.f_H_W_N) - spring_N) > 1e-4 ? 1 : 0;
      if (i == 250) {
        ASSERT_EQ(out.substeps, 1);
        out.f_H_W_N.x += added_N;
      }
      invariants.Tick(in, out);
    }
    EXPECT_GT(damped, 100);
    EXPECT_EQ(invariants.violations().contains("I17"), added_N > 0) << added_N;
    if (added_N == 0) {
      EXPECT_TRUE(invariants.ok()) << invariants.violations().begin()->second;
    }
  }
}

TEST(Invariants, AFailureNamesTheTickAndTheFigureOnce) {
  const auto violations = FindViolations([](auto& o) {
    for (int i = 250; i < 260; ++i) o[static_cast<std::size_t>(i)].removed_mm3 = -0.5;
  });
  ASSERT_EQ(violations.size(), 1u);
  EXPECT_EQ(violations.at("I5"), "I5 in tick 251: -0.5 mm^3 removed");
}

/// Cuts and jumps, with checks of the bone in between and at the end.
void CutAndJump(CoupledSimulation& simulation, Invariants& invariants) {
  const auto tick = [&](const Vec3& p, double rpm = 7500) {
    const CoupledInput in = Handle(DiscPose({}, p), rpm);
    invariants.Tick(in, simulation.Tick(in));
  };
  for (int i = 0; i < 300; ++i) tick({0.002 * i, 0, 3 + kR + 0.3 - 0.01 * i});
  invariants.CheckBone();
  for (int i = 0; i < 50; ++i) tick({0.1 * i, 0.02 * i, kR}, i < 30 ? -7500 : 0);
  for (int i = 0; i < 5; ++i) tick({0, 0, 20});
  for (int i = 0; i < 100; ++i) tick({2, 1, 3});
  const Pose X = DiscPose({}, {0, -0.7, 3 + kR - 1});
  simulation.SetDown(X);
  invariants.SetDown(X);
  for (int i = 0; i < 100; ++i) tick({0, -0.7, 3 + kR - 1 - 0.01 * i});
}

TEST(Invariants, HoldOverCutsAndJumps) {
  const Pose X_start = DiscPose({}, {0, 0, 3 + kR + 0.3});
  CoupledSimulation simulation(MakeBox({}, {10, 3, 6}, 0.2), DiscParams(), X_start);
  Invariants invariants(simulation, X_start);
  CutAndJump(simulation, invariants);
  invariants.CheckBone();
  EXPECT_GT(invariants.removed_mm3(), 3);
}

/// Returns the violations for the bone of a cut after `change` has been applied to it.
std::vector<std::string> WatchWith(const std::function<void(Bone&)>& change, double removed_times = 1,
                                   const Vec3& reported_off = Vec3(0)) {
  const Pose X_start = DiscPose({}, {0, 0, 3 + kR + 0.3});
  const Bone before = MakeBox({}, {10, 3, 6}, 0.2);
  CoupledSimulation simulation(before, DiscParams(), X_start);
  BoneWatch watch(before, kSaw, CutWith::kEdge);
  Pose X = X_start;
  double removed = 0;
  for (int i = 0; i < 300; ++i) {
    const CoupledOutput out = simulation.Tick(Handle(DiscPose({}, {0.002 * i, 0, 3 + kR + 0.3 - 0.01 * i})));
    Pose reported = out.X_WT;
    reported.p_AB += reported_off;
    watch.Move(X, reported, 0, out.substeps > 0);
    X = reported;
    removed += out.removed_mm3;
  }
  double exact = 0;
  for (const double v : simulation.CalcRemovedByRegion()) exact += v;
  Bone bone = std::move(simulation).TakeBone();
  change(bone);
  return watch.Check(bone, {removed * removed_times, exact * removed_times});
}

bool Contains(const std::vector<std::string>& found, const std::string& invariant) {
  for (const std::string& text : found) {
    if (text.rfind(invariant, 0) == 0) return true;
  }
  return false;
}

void AddAt(Bone& bone, const LeafIndex& leaf, float value) {
  BoneField field(bone, 8);
  const BoneField::CutValues values = field.Write(leaf);
  ASSERT_NE(values.cut, nullptr);
  values.phi[0] += value;
  field.Settle();
}

TEST(BoneWatch, DetectsEachKindOfFault) {
  EXPECT_TRUE(WatchWith([](Bone&) {}).empty());
  // The first voxel is at (-1.6, 0, 0), at least 0.3 mm below the kerf's floor; the other one is far from the tool.
  EXPECT_TRUE(Contains(WatchWith([](Bone& b) { AddAt(b, {-1, 0, 0}, -0.01f); }), "I5"));
  EXPECT_TRUE(Contains(WatchWith([](Bone& b) { AddAt(b, {-3, 0, 0}, 0.01f); }), "I6"));
  EXPECT_TRUE(Contains(WatchWith([](Bone&) {}, 1.001), "I4"));
  EXPECT_TRUE(Contains(WatchWith([](Bone&) {}, 0.999), "I4"));
  // The tool's real position differed by a tenth of a voxel from the reported one.
  EXPECT_TRUE(Contains(WatchWith([](Bone&) {}, 1, {0, 0.02, 0}), "I6"));
  EXPECT_TRUE(Contains(WatchWith([](Bone&) {}, 1, {0, 0.02, 0}), "I7"));
  EXPECT_TRUE(Contains(WatchWith([](Bone&) {}, 1, {0, 0, -0.02}), "I7"));
  EXPECT_TRUE(Contains(WatchWith([](Bone&) {}, 1, {0, 0, 0.02}), "I6"));
}

TEST(Invariants, HoldOnADevice) {
  HeldSawOptions options;
  options.profile = FindDeviceProfile("omega_6");
  HeldSaw held(options);
  Invariants invariants(held.simulation, held.start);
  invariants.WatchDevice(options.profile, options.force_map);
  Intention intention{.X_WH = held.start};
  for (int i = 0; i < 1500; ++i) {
    intention.X_WH.p_AB.z -= i < 1000 ? 0.004 : -0.004;
    held.device.SetIntention(intention);
    DeviceFaults faults;
    faults.not_a_number = i % 400 == 399;
    faults.read_fails = i == 700;
    held.device.SetFaults(faults);
    invariants.Step(held.Step(7500, 0.001, i == 900));
  }
  invariants.CheckBone();
  EXPECT_GT(invariants.removed_mm3(), 1);
}

TEST(Invariants, DetectFaultsOfADevice) {
  HeldSawOptions options;
  options.profile = FindDeviceProfile("omega_6");
  HeldSaw held(options);
  Intention intention{.X_WH = held.start};
  std::vector<HapticTick> outs;
  for (int i = 0; i < 1200; ++i) {
    intention.X_WH.p_AB.z -= 0.004;
    held.device.SetIntention(intention);
    outs.push_back(held.Step(7500, 0.001, i == 1100));
  }
  ASSERT_GT(glm::length(outs[1000].force.f_H_W_N), 0.1);
  const double peak = options.profile.peak_force_N;
  struct Fault {
    const char* invariant;
    std::function<void()> change;
  };
  const std::vector<HapticTick> as_it_was = outs;
  Vec3& f = outs[1000].force.f_H_W_N;
  const Fault faults[] = {
      {"", [&] {}},
      {"I1", [&] { f.x = std::nan(""); }},
      {"I2",
       [&] {
         f = {0, 0, std::nextafter(peak, 100)};
       }},
      {"I2", [&] { f *= -1; }},
      {"I2", [&] { f *= 1.01; }},
      {"I2", [&] { f *= 0.99; }},
      {"I2", [&] { f.x += 0.01; }},
      {"I2",
       [&] {
         outs[1000].force.tau_H_W_Nmm = {1e4, 0, 0};
       }},
      {"I3", [&] { outs[1100].force.f_H_W_N = outs[1099].force.f_H_W_N; }},
  };
  for (const Fault& fault : faults) {
    outs = as_it_was;
    fault.change();
    HeldSaw other(options);
    Invariants invariants(other.simulation, other.start, {.watch_bone = false, .report = false});
    invariants.WatchDevice(options.profile, options.force_map);
    for (const HapticTick& out : outs) invariants.Step(out);
    if (*fault.invariant) {
      EXPECT_TRUE(invariants.violations().contains(fault.invariant)) << &fault - faults;
    } else {
      EXPECT_TRUE(invariants.ok());
    }
  }
}

TEST(PathInvariants, HoldAndDetectFaults) {
  for (int fault = 0; fault < 9; ++fault) {
    const Pose X_start = DiscPose({}, {-9, 0, 3 + kR - 2});
    SimulationParams params;
    Simulation simulation(MakeBox({}, {10, 3, 6}, 0.2), params, X_start);
    PathInvariants invariants(simulation, params, X_start, false);
    for (int i = 0; i < 200; ++i) {
      TickInput in;
      in.X_WT = DiscPose({}, {-9 + 0.05 * i, 0, 3 + kR - 2});
      if (i > 190) in.X_WT = DiscPose({}, {0, 0, 20});
      if (i == 150 && fault == 0) in.X_WT = DiscPose({}, {0, 10, 3});
      TickOutput out = simulation.Tick(in);
      if (i == 100) {
        if (fault == 1) out.f_T_W_N.x = std::nan("");
        if (fault == 2) out.f_T_W_N *= 2;
        if (fault == 3) out.removed_mm3 = -1e-9;
        if (fault == 4) out.f_T_W_N *= -0.5;
        if (fault == 5) out.removed_mm3 *= 1.1;
      }
      if (fault == 6 && i == 195) out.f_T_W_N.x = out.thrust_sum_N = 1e-9;
      if (fault == 7 && i == 100) in.X_WT.p_AB.y += 0.05;
      if (fault == 8 && i == 100) in.X_WT.p_AB.z -= 0.05;
      invariants.Tick(in, out);
    }
    invariants.CheckBone();
    const char* expected[] = {"", "I1", "I2", "I5", "I15", "I4", "I3", "I7", "I7"};
    if (fault == 0) {
      for (const auto& [invariant, text] : invariants.violations()) ADD_FAILURE() << text;
    } else {
      EXPECT_TRUE(invariants.violations().contains(expected[fault])) << fault;
    }
  }
}

}  // namespace
}  // namespace kerf::test
