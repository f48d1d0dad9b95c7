// The effects on a blade with a stroke, on a path: forces, power, heat, speed of the motor and lines compared with
// closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/effects/chips.h"
#include "cut/effects/guide.h"
#include "cut/effects/heat/heat.h"
#include "cut/effects/plan.h"
#include "cut/effects/sound/sound.h"
#include "cut/effects/spindle/spindle.h"
#include "cut/effects/tangential_force.h"
#include "cut/effects/tooth_vibration.h"
#include "cut/hand_sim/hands.h"
#include "cut/hand_sim/internals.h"
#include "cut/tool/drive.h"
#include "cut/tool/edge_down.h"
#include "kerf/simulation.h"
#include "support/solids.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kSawingFeed = 2;  // mm/s
constexpr double kSawnLength = 6;  // mm of bone along the edge

/// Blade whose ends stay outside of the block at all times.
ReciprocatingBlade SawingBlade() {
  ReciprocatingBlade blade;
  blade.length_mm = 12;
  return blade;
}

/// Pose of the blade: edge along +x, feed along -z, blade in the plane y = 0.
Pose SawingPose(double z_mm) {
  return {CalcEdgeDown(), {0, 0, z_mm}};
}

/// A blade that is fed into a block, with and without effects.
class SawCut {
 public:
  SawCut(double strokes_a_minute, const EffectChoices& effects, const ForceLaw& law = ForceLaw("edge_plus_chip"),
         const Tool& blade = SawingBlade())
      : drive(blade),
        rpm_(strokes_a_minute),
        simulation(MakeBlock(), Params(blade, law, effects), SawingPose(z_)),
        plain_(MakeBlock(), Params(blade, law, {}), SawingPose(z_)) {}

  void Tick() {
    z_ -= kSawingFeed * 1e-3;
    step = drive.CalcStep(phase_rad, rpm_, 1e-3, 1e-3);
    phase_rad = Drive::Advance(phase_rad, rpm_, 1e-3);
    const HeapGuard guard;
    out = simulation.Tick({SawingPose(z_), 1e-3, rpm_});
    f_added_W = out.f_T_W_N - plain_.Tick({SawingPose(z_), 1e-3, rpm_}).f_T_W_N;
  }
  void Run(int ticks) {
    for (int i = 0; i < ticks; ++i) Tick();
  }
  /// Returns the mean thrust over the way of the teeth in the tick.
  double ForceForWork() const { return 1e3 * out.thrust_W / step.speed_mm_per_s; }
  Pose X_WT() const { return SawingPose(z_); }
  const TangentialForceEffect::Figures& figures() const {
    return TangentialForceEffect::In(EffectsOf(simulation)).figures();
  }
  template <typename T>
  const T& Get(const char* name) const {
    return dynamic_cast<const T&>(*EffectsOf(simulation).Find(name));
  }

  Drive drive;
  double phase_rad = 0;  // at the end of the tick
  DriveStep step;        // of the tick
  TickOutput out;
  Vec3 f_added_W{0};

 private:
  static Bone MakeBlock() {
    Bone bone = test::MakeBox({}, {kSawnLength, 3, 5}, 0.1);
    bone.set_materials(test::OneRegionTable(24, 19300, 0.28));
    return bone;
  }
  static SimulationParams Params(const Tool& blade, const ForceLaw& law, const EffectChoices& effects) {
    SimulationParams params;
    params.tool = blade;
    params.law = law;
    params.effects = effects;
    return params;
  }
  double z_ = 2.5;
  double rpm_;

 public:
  Simulation simulation;

 private:
  Simulation plain_;
};

/// Law with a force that does not depend on the bite.
ForceLaw ConstantForce() {
  ForceLaw law("edge_plus_chip");
  law.Set("chip_N_per_mm2", 0);
  return law;
}

EffectChoices Tangential(double ratio = 1.6) {
  EffectChoices effects;
  SetEffect(effects, "tangential_force", "ratio", ratio);
  return effects;
}

TEST(StrokeEffects, CuttingForceActsAgainstTheStrokeAndHasNoImpulse) {
  SawCut cut(1200, Tangential());  // a period of 50 ticks
  cut.Run(150);
  double impulse = 0, sum = 0, peak_N = 0, most_N = 0;
  for (int i = 0; i < 50; ++i) {
    cut.Tick();
    const double force_N = cut.ForceForWork() / 1.6;
    EXPECT_NEAR(cut.f_added_W.x, -force_N * cut.step.velocity_mm_per_s / cut.step.speed_mm_per_s, 1e-4 * force_N) << i;
    EXPECT_NEAR(std::hypot(cut.f_added_W.y, cut.f_added_W.z), 0, 1e-9);
    EXPECT_NEAR(cut.figures().sum_N, force_N, 1e-9 * force_N);
    EXPECT_NEAR(cut.figures().power_W, 1e-3 * force_N * cut.step.speed_mm_per_s, 1e-4 * cut.figures().power_W);
    impulse += cut.f_added_W.x;
    sum += std::abs(cut.f_added_W.x);
    peak_N = std::max(peak_N, std::abs(cut.f_added_W.x));
    if (std::abs(cut.step.velocity_mm_per_s) > 0.999 * cut.step.speed_mm_per_s) most_N = std::max(most_N, force_N);
  }
  EXPECT_GT(most_N, 0.1);
  EXPECT_NEAR(peak_N / most_N, 1, 1e-4);
  EXPECT_NEAR(impulse / sum, 0, 0.01);  // the strokes differ by what the grid finds at the ends of the block
}

TEST(StrokeEffects, MeanPowerIsTheIntegralOfForceTimesSpeed) {
  SawCut cut(300, Tangential());  // a period of 200 ticks
  cut.Run(400);
  double mean_W = 0, teeth = 0;
  for (int i = 0; i < 200; ++i) {
    cut.Tick();
    mean_W += cut.figures().power_W / 200;
    teeth += cut.out.engaged_teeth / 200;
  }
  const ReciprocatingBlade blade = SawingBlade();
  const ToothForce law = MakeToothForce(ForceLaw("edge_plus_chip"), blade);
  const ToothCut bone = Cortical(CalcReducedModulus(blade.E_MPa, blade.nu, 19300, 0.28));
  const double rad_per_s = kFullTurn * 5;
  double integral_W = 0;
  constexpr int kParts = 4000;
  for (int i = 0; i < kParts; ++i) {
    const double phase = kFullTurn * i / kParts, part = kFullTurn / kParts;
    const double since_s = cut.drive.CalcMeanSincePassed(phase, part) / rad_per_s;
    integral_W += 1e-3 * teeth * law(kSawingFeed * since_s, bone) / 1.6 * cut.drive.CalcWay(phase, part) * 5;
  }
  EXPECT_NEAR(mean_W / integral_W, 1, 0.01);
}

TEST(StrokeEffects, MeanOverPeriodsPushesNeitherWayAndTakesTheWholePower) {
  SawCut cut(60000, Tangential());  // a period of 1 ms
  cut.Run(100);
  const double force_N = cut.ForceForWork() / 1.6;
  ASSERT_GT(force_N, 0.01);
  EXPECT_NEAR(cut.f_added_W.x, 0, 1e-12);
  EXPECT_NEAR(cut.figures().power_W, 1e-3 * force_N * 2 * 3 * 1000, 1e-9);
  EXPECT_NEAR(cut.figures().torque_Nmm, force_N * 3 / std::numbers::pi, 1e-9);
}

TEST(StrokeEffects, HeatReceivesItsFractionOfThePower) {
  EffectChoices effects = Tangential();
  SetEffect(effects, "heat", "share_into_bone", 0.2);
  SetEffect(effects, "heat", "voxel_mm", 0.4);
  for (const double strokes_a_minute : {1200.0, 60000.0}) {
    SawCut cut(strokes_a_minute, effects);
    double work_mJ = 0;
    for (int i = 0; i < 600; ++i) {
      cut.Tick();
      work_mJ += cut.out.thrust_W / 1.6 + 1e-3 * cut.out.thrust_sum_N * kSawingFeed;
    }
    const HeatBalance b = cut.Get<HeatEffect>("heat").CalcBalance();
    ASSERT_GT(work_mJ, 100);
    EXPECT_NEAR(b.put_in, 0.2 * work_mJ, 1e-6 * work_mJ);
    EXPECT_NEAR(b.CalcRest(), 0, 1e-6 * b.put_in);
    EXPECT_EQ(b.no_room, 0);
    EXPECT_LT(b.chips, 0.2 * b.put_in);
    EXPECT_GT(cut.Get<HeatEffect>("heat").figures().peak_C, 40);
  }
}

TEST(StrokeEffects, SpindleSlowsDownByTheClosedFormAtConstantLoad) {
  // With a force that does not depend on the bite the mean torque on the crank is F stroke / pi.
  EffectChoices effects = Tangential();
  SetEffect(effects, "spindle", "stall_torque_Nmm", 60.0);
  for (const double strokes_a_minute : {12000.0, 60000.0}) {
    SawCut cut(strokes_a_minute, effects, ConstantForce());
    cut.Run(500);
    double torque_Nmm = 0, w = 0, load_Nmm = 0;
    const SpindleEffect& spindle = cut.Get<SpindleEffect>("spindle");
    for (int i = 0; i < 500; ++i) {
      cut.Tick();
      torque_Nmm += cut.out.thrust_sum_N / 1.6 * 3 / std::numbers::pi / 500;
      load_Nmm += spindle.load_Nmm() / 500;
      w += spindle.rpm() * std::numbers::pi / 30 / 500;
    }
    ASSERT_GT(torque_Nmm, 3);
    EXPECT_NEAR(load_Nmm / torque_Nmm, 1, 0.02);
    const Motor& m = spindle.motor();
    const double set = strokes_a_minute * std::numbers::pi / 30;
    const double expected =
        (m.stall_torque_Nmm - m.friction_Nmm - torque_Nmm) / (m.stall_torque_Nmm / set + m.viscous_Nmms);
    EXPECT_LT(w, 0.95 * set);
    EXPECT_NEAR(w / expected, 1, 0.01);
  }
}

TEST(StrokeEffects, OverloadedStrokeStallsInAHandAndStartsAgainWhenRelieved) {
  CoupledParams params;
  params.tool = SawingBlade();
  params.law = ForceLaw("hertz_chip");
  params.effects = Tangential();
  SetEffect(params.effects, "spindle", "stall_torque_Nmm", 12.0);  // 7 N mm above its friction
  params.coupling.max_force_N = 50;
  params.coupling.stiffness_N_per_mm = 10;
  CoupledSimulation simulation(test::MakeBox({}, {kSawnLength, 3, 5}, 0.2), params, SawingPose(2.7));
  const SpindleEffect& spindle =
      dynamic_cast<const SpindleEffect&>(*EffectsOf(std::as_const(simulation)).Find("spindle"));
  const auto press = [&](double force_N, int ticks) {
    CoupledOutput out;
    for (int i = 0; i < ticks; ++i) out = simulation.Tick(test::Handle(SawingPose(2.5 - 0.1 * force_N), 6000));
    return out;
  };
  press(-2, 300);  // in the air
  EXPECT_GT(spindle.rpm(), 2000);
  EXPECT_EQ(press(30, 500).removed_mm3, 0);
  EXPECT_TRUE(spindle.stalled());
  press(1, 500);
  EXPECT_FALSE(spindle.stalled());
  EXPECT_GT(spindle.rpm(), 2000);
}

TEST(StrokeEffects, AHandFollowsASlowStrokeOnly) {
  CoupledParams params;
  params.tool = SawingBlade();
  params.effects = Tangential();
  for (const double strokes_a_minute : {300.0, 15000.0}) {
    CoupledSimulation simulation(test::MakeBox({}, {kSawnLength, 3, 5}, 0.2), params, SawingPose(2.7));
    const auto& figures = TangentialForceEffect::In(EffectsOf(std::as_const(simulation))).figures();
    double aside_mm = 0, power_W = 0, force_N = 0;
    for (int i = 0; i < 1000; ++i) {
      const double z_mm = std::max(-2.5, 2.7 - 0.02 * i);
      const CoupledOutput out = simulation.Tick(test::Handle(SawingPose(z_mm), strokes_a_minute));
      if (i < 600) continue;
      aside_mm = std::max(aside_mm, std::abs(out.X_WT.p_AB.x));
      power_W += figures.power_W / 400;
      force_N += figures.sum_N / 400;
    }
    EXPECT_GT(force_N, 0.1);
    if (strokes_a_minute < 1200) {
      EXPECT_GT(aside_mm, 0.3);
    } else {
      EXPECT_LT(aside_mm, 0.01);
      EXPECT_NEAR(power_W / (1e-3 * force_N * 2 * 3 * 250), 1, 0.1);
    }
  }
}

// A blade that is pressed against a wall of its kerf, while the hand moves along the edge at v. Coulomb's law gives the
// mean force mu N <sign(v + v_stroke)> = mu N (2 / pi) asin(v / v_peak), which is below 1 % of mu N here; the two ways
// at the mean speed give 0.
TEST(StrokeEffects, FrictionOfAFastStrokeMovesNoHand) {
  constexpr double kCoefficient = 0.3, kAlong_mm_per_s = 4, kPress_mm = 0.4;
  CoupledParams params;
  params.tool = SawingBlade();
  params.coupling.stiffness_N_per_mm = 20;
  SetEffect(params.effects, "kerf_friction", "coefficient", kCoefficient);
  for (const double strokes_a_minute : {2400.0, 15000.0, 60000.0}) {
    SCOPED_TRACE(strokes_a_minute);
    CoupledSimulation simulation(test::MakeBox({}, {kSawnLength, 3, 5}, 0.2), params, SawingPose(2.7));
    Pose X_WH = SawingPose(2.7);
    const auto tick = [&](const Vec3& move_mm, double rpm) {
      X_WH.p_AB += move_mm;
      return simulation.Tick(test::Handle(X_WH, rpm));
    };
    for (int i = 0; i < 800; ++i) tick({0, 0, i < 500 ? -0.008 : 0}, 60000);
    for (int i = 0; i < 300; ++i) tick({0, i < 100 ? 0.01 * kPress_mm : 0, 0}, strokes_a_minute);
    constexpr int kMeasured = 300;  // whole periods
    double along_N = 0, across_N = 0, away_mm = 0;
    for (int i = 0; i < kMeasured; ++i) {
      const CoupledOutput out = tick({1e-3 * kAlong_mm_per_s, 0, 0}, strokes_a_minute);
      along_N -= out.f_friction_W_N.x / kMeasured;
      across_N += std::abs(out.f_face_W_N.y) / kMeasured;
      away_mm = std::max(away_mm, std::abs(out.X_WT.p_AB.x - X_WH.p_AB.x));
    }
    const double most_N = kCoefficient * across_N;
    ASSERT_GT(most_N, 0.1);
    const double peak_mm_per_s = 0.5 * ReciprocatingBlade{}.stroke_mm * strokes_a_minute * kFullTurn / 60;
    EXPECT_NEAR(along_N / most_N, 2 / std::numbers::pi * std::asin(kAlong_mm_per_s / peak_mm_per_s), 0.01);
    EXPECT_LT(away_mm, 0.01);
  }
}

TEST(StrokeEffects, PassingTeethGiveLinesOfTheDisplacementOverThePitch) {
  // With the same force F on every tooth within w of the middle of the edge, the number of teeth varies with the
  // displacement s. Its Fourier series has the terms 2 F / (pi m) sin(2 pi m w / pitch) cos(2 pi m s / pitch).
  ReciprocatingBlade blade = SawingBlade();
  blade.pitch_mm = kSawnLength / 4.5;
  EffectChoices effects;
  SetEffect(effects, "tooth_vibration", "max_N", 100.0);
  SetEffect(effects, "tooth_vibration", "set_share", 0.0);
  const auto check = [&](double strokes_a_minute, bool felt) {
    SawCut cut(strokes_a_minute, effects, ConstantForce(), blade);
    cut.Run(200);
    double largest_N = 0;
    for (int i = 0; i < 1000; ++i) {
      cut.Tick();
      const double tooth_N = cut.out.thrust_sum_N / cut.out.engaged_teeth;
      const double s_mm = cut.drive.CalcDisplacement(cut.phase_rad);
      const double w_mm = 0.5 * cut.out.engaged_teeth * blade.pitch_mm;
      double line_N = 0;
      for (const int m : {1, 2}) {
        line_N += 2 * tooth_N / (std::numbers::pi * m) * std::sin(kFullTurn * m * w_mm / blade.pitch_mm) *
                  std::cos(kFullTurn * m * s_mm / blade.pitch_mm);
      }
      const auto& vibration = cut.Get<ToothVibrationEffect>("tooth_vibration");
      const Vec3 whole_T = vibration.Sample(0);
      ASSERT_NEAR(whole_T.x, -line_N, 0.06 * tooth_N) << i;  // the amplitudes lag, and the grid finds the ends roughly
      ASSERT_NEAR(whole_T.y, 0.625 * whole_T.x * (std::cos(cut.phase_rad) < 0 ? -1 : 1), 1e-9);
      if (felt) {
        ASSERT_NEAR(cut.f_added_W.z, -whole_T.x, 1e-9);
        ASSERT_NEAR(cut.f_added_W.x, whole_T.y, 1e-9);
      } else {
        ASSERT_EQ(cut.f_added_W, Vec3(0));
      }
      largest_N = std::max(largest_N, std::abs(whole_T.x) / tooth_N);
    }
    EXPECT_GT(largest_N, 0.5);
  };
  check(60, true);  // at most 7 teeth a second pass
  // Its period is below two ticks: nothing of it enters the force of a tick, but Sample() has it.
  check(45000, false);
}

TEST(StrokeEffects, TheSoundHasLinesAtTheStrokeAndAtThePassingTeeth) {
  EffectChoices effects = Tangential();
  SetEffect(effects, "sound", "noise_level", 0.0);
  SawCut cut(6000, effects);
  cut.Run(200);
  const EffectPlan& plan = EffectsOf(std::as_const(cut.simulation));
  const ToneReader reader(plan);
  EXPECT_NEAR(reader.teeth(), 2 * 3 / 1.41, 1e-12);
  Tone tone(reader.tone(), reader.teeth());
  std::vector<double> channels(plan.channel_count());
  std::vector<float> samples;
  double mean_W = 0;
  for (int i = 0; i < 600; ++i) {
    cut.Tick();
    plan.Report(channels);
    tone.Render(reader.Read(1e-3, channels), samples);
    mean_W += static_cast<double>(reader.Read(1e-3, channels).load_W) / 600;
  }
  EXPECT_GT(mean_W, 0);
  samples.erase(samples.begin(), samples.begin() + 4800);
  const auto line = [&](double hz) {
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double t = (static_cast<double>(i) + 0.5) / static_cast<double>(samples.size());
      sum += (1 - std::cos(kFullTurn * t)) * static_cast<double>(samples[i]) *
             std::polar(1.0, -kFullTurn * hz * static_cast<double>(i) / 48000);
    }
    return std::abs(sum) / static_cast<double>(samples.size());
  };
  for (const double hz : {100.0, 100 * 2 * 3 / 1.41}) {
    EXPECT_GT(line(hz), 5 * line(hz + 30)) << hz;
    EXPECT_GT(line(hz), 5 * line(hz - 30)) << hz;
  }
}

TEST(StrokeEffects, ChipsFlyAlongTheStroke) {
  EffectChoices effects;
  SetEffect(effects, "chips", "spread", 0.0);
  SetEffect(effects, "chips", "drag", 0.0);
  SetEffect(effects, "chips", "size_mm", 0.05);
  SetEffect(effects, "chips", "gravity_m_per_s2", Vec3(0));
  for (const double strokes_a_minute : {1200.0, 60000.0}) {
    SawCut cut(strokes_a_minute, effects);
    const ChipsEffect& chips = cut.Get<ChipsEffect>("chips");
    double removed_mm3 = 0;
    int forwards = 0, backwards = 0;
    std::size_t seen = 0;
    for (int i = 0; i < 300; ++i) {
      cut.Tick();
      removed_mm3 += cut.out.removed_mm3;
      for (std::size_t n = seen; n < chips.pool().size(); ++n) {
        const ChipPool::Chip chip = chips.pool().CalcChip(n);
        EXPECT_NEAR(std::abs(chip.v_F_mm_per_s.x), cut.step.speed_mm_per_s, 1e-3 * cut.step.speed_mm_per_s);
        EXPECT_NEAR(std::hypot(chip.v_F_mm_per_s.y, chip.v_F_mm_per_s.z), 0, 1e-9);
        const double from_x = chip.p_F_mm.x + chips.p_WF_mm().x - chip.age_s * chip.v_F_mm_per_s.x;
        EXPECT_LT(std::abs(from_x), 0.5 * kSawnLength + 0.1);
        (chip.v_F_mm_per_s.x > 0 ? forwards : backwards) += 1;
      }
      seen = chips.pool().size();
    }
    EXPECT_NEAR(chips.thrown_mm3() + chips.dropped_mm3() + chips.waiting_mm3(), removed_mm3, 1e-9);
    EXPECT_GT(forwards, 100);
    EXPECT_NEAR(static_cast<double>(forwards) / backwards, 1, 0.25);
  }
}

TEST(StrokeEffects, ChipsOfAnArcFlyAlongIt) {
  EffectChoices effects;
  SetEffect(effects, "chips", "spread", 0.0);
  SetEffect(effects, "chips", "drag", 0.0);
  SetEffect(effects, "chips", "size_mm", 0.05);
  SetEffect(effects, "chips", "gravity_m_per_s2", Vec3(0));
  const OscillatingBlade blade;
  SawCut cut(1200, effects, ForceLaw("edge_plus_chip"), blade);
  const ChipsEffect& chips = cut.Get<ChipsEffect>("chips");
  std::size_t seen = 0;
  for (int i = 0; i < 200; ++i) {
    cut.Tick();
    const Vec3 axis_W = cut.X_WT().Point({-blade.radius_mm, 0, 0});
    for (std::size_t n = seen; n < chips.pool().size(); ++n) {
      const ChipPool::Chip chip = chips.pool().CalcChip(n);
      const double speed = cut.step.speed_mm_per_s;
      Vec3 arm_W = chip.p_F_mm + chips.p_WF_mm() - chip.age_s * chip.v_F_mm_per_s - axis_W;
      arm_W.y = 0;                                              // the swing axis is parallel to y of W
      EXPECT_NEAR(glm::length(arm_W), blade.radius_mm, 0.005);  // the blade advances by 0.002 mm in a tick
      EXPECT_NEAR(glm::length(chip.v_F_mm_per_s), speed, 1e-5 * speed);
      EXPECT_NEAR(glm::dot(arm_W, chip.v_F_mm_per_s), 0, 1e-3 * speed);
    }
    seen = chips.pool().size();
  }
  EXPECT_GT(seen, 100u);
}

TEST(StrokeEffects, GuideMeasuresTheDepthOfAnArcOverItsSwing) {
  const OscillatingBlade blade;
  const double reach_rad = std::asin(0.5 * blade.width_mm / blade.radius_mm) + 0.5 * blade.swing_deg * kFullTurn / 360;
  for (const double tilt_deg : {-20.0, -11.5, 0.0, 6.0, 11.5, 20.0}) {  // the arc ends at 10.4 degrees
    const double tilt_rad = tilt_deg * kFullTurn / 360;
    CoupledParams params;
    params.tool = blade;
    EffectChoice guide("guide");
    guide.Set("point_mm", Vec3(0, 0, 40)).Set("normal", Vec3(0, 0, 1));
    guide.Set("depth_direction", Vec3(std::cos(tilt_rad), std::sin(tilt_rad), 0)).Set("depth_mm", 30.0);
    params.effects.push_back(guide);
    const Pose start{{1, 0, 0, 0}, {0, 0, 40}};
    CoupledSimulation simulation(test::MakeBox({}, {4, 4, 4}, 0.4), params, start);
    test::PushingHand hand(simulation, start);
    hand.Push(Vec3(0), 15000);
    std::vector<double> channels(EffectsOf(simulation).channel_count());
    EffectsOf(simulation).Report(channels);
    const double past_rad = std::max(0.0, std::abs(tilt_rad) - reach_rad);
    EXPECT_NEAR(channels[2], blade.radius_mm * (std::cos(past_rad) - std::cos(tilt_rad)), 1e-6) << tilt_deg;
  }
}

TEST(StrokeEffects, GuideStopsTheTipAtTheEndOfTheStroke) {
  // In air, with the tip down: the edge is 12 mm long, and the stroke adds half of 3 mm.
  CoupledParams params;
  params.tool = SawingBlade();
  EffectChoice guide("guide");
  guide.Set("point_mm", Vec3(0, 0, 40)).Set("normal", Vec3(0, 1, 0)).Set("depth_direction", Vec3(0, 0, -1));
  guide.Set("depth_mm", 10.0).Set("stiffness_N_per_mm", 100.0).Set("max_force_N", 1000.0);
  params.effects.push_back(guide);
  // y of T is down: x_T = x, z_T = y.
  const Pose start{glm::quat_cast(glm::dmat3(Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(0, 1, 0))), {0, 0, 40}};
  CoupledSimulation simulation(test::MakeBox({}, {4, 4, 4}, 0.4), params, start);
  test::PushingHand hand(simulation, start);
  CoupledOutput out;
  for (int i = 0; i < 400; ++i) out = hand.Push({0, 0, -3}, 15000);
  EXPECT_NEAR(out.X_WT.p_AB.z - 7.5, 30 - 0.03, 0.002);
  std::vector<double> channels(EffectsOf(simulation).channel_count());
  EffectsOf(simulation).Report(channels);
  EXPECT_NEAR(channels[2], 10.03, 0.002);
  EXPECT_NEAR(channels[3], 3, 0.02);
  // Across the plane the four corners of the blade hold it.
  for (int i = 0; i < 400; ++i) out = hand.Push({0, 3, 0}, 15000);
  EffectsOf(simulation).Report(channels);
  EXPECT_NEAR(channels[3], 3, 0.05);
  EXPECT_LT(channels[0], 0.5 + 4 * 3 / 100.0);
}

}  // namespace
}  // namespace kerf
