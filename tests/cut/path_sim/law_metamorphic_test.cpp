// The exact factors of every law in the complete simulation, for every tick of a plunge into a block of one region.
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "kerf/simulation.h"
#include "support/cuts.h"

namespace kerf {
namespace {

using test::DiscPose;

/// Parameters of one run.
struct Setting {
  ForceLaw law;
  double E_bone_MPa = 19300;
  double E_saw_MPa = 205000;
  int teeth = 24;
  int rim_samples_per_pitch = 8;
  double dt_s = 0.001;
  double rpm = 7500;
};

/// Plunges 1.5 mm into a block in a skewed pose, 0.01 mm per tick: `dt_s` determines the feed rate, so that runs at
/// other feed rates cut the same bone.
std::vector<TickOutput> Plunge(const Setting& setting) {
  const Pose X_WB = test::BlockPoses(0.2)[5];
  Bone bone = test::MakeBox(X_WB, {8, 1.6, 3}, 0.2);
  bone.set_materials(test::OneRegionTable(24, setting.E_bone_MPa, 0.28));
  SimulationParams params;
  params.law = setting.law;
  DiscSaw saw;
  saw.teeth = setting.teeth;
  saw.E_MPa = setting.E_saw_MPa;
  params.tool = saw;
  params.rim_samples_per_pitch = setting.rim_samples_per_pitch;
  const double top = 1.5 + saw.radius_mm() + 0.1;
  Simulation simulation(bone, params, DiscPose(X_WB, {0, 0, top}));
  std::vector<TickOutput> ticks;
  for (int i = 1; i <= 160; ++i) {
    ticks.push_back(simulation.Tick({DiscPose(X_WB, {0, 0, top - 0.01 * i}), setting.dt_s, setting.rpm}));
  }
  return ticks;
}

/// Expects that each tick's force and thrust are `factor` times those of `base`, and that the bone and the teeth are
/// the same.
void ExpectFactor(const std::vector<TickOutput>& changed, const std::vector<TickOutput>& base, double factor,
                  const std::string& what) {
  ASSERT_EQ(changed.size(), base.size());
  // The force is a sum over some hundred samples of the rim, each rounded once or twice.
  const double tolerance = 1e-13;
  int loaded = 0;
  for (std::size_t i = 0; i < base.size(); ++i) {
    EXPECT_EQ(changed[i].removed_mm3, base[i].removed_mm3) << what;
    const double thrust = factor * base[i].thrust_sum_N;
    ASSERT_NEAR(changed[i].thrust_sum_N, thrust, tolerance * thrust) << what << ", tick " << i;
    const Vec3 force = factor * base[i].f_T_W_N;
    ASSERT_NEAR(glm::length(changed[i].f_T_W_N - force), 0, tolerance * thrust) << what << ", tick " << i;
    loaded += thrust > 0 ? 1 : 0;
  }
  EXPECT_GT(loaded, 100) << what;
}

/// Returns p a + q b, tick by tick.
std::vector<TickOutput> Combine(double p, const std::vector<TickOutput>& a, double q,
                                const std::vector<TickOutput>& b) {
  std::vector<TickOutput> sum = a;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum[i].f_T_W_N = p * a[i].f_T_W_N + q * b[i].f_T_W_N;
    sum[i].thrust_sum_N = p * a[i].thrust_sum_N + q * b[i].thrust_sum_N;
  }
  return sum;
}

/// Factors of a power law; laws of a different form have their own test below.
struct Power {
  double bite_doubled;
  double teeth_doubled;
};
const std::map<std::string, Power> kPowers{{"hertz_chip", {2 * std::sqrt(2.0), 1 / std::sqrt(2.0)}},
                                           {"hertz_constant_bite", {1, 0.25}}};

TEST(LawMetamorphic, DoubledModuliDoubleTheForceOfLawsThatReadThem) {
  for (const ForceLawInfo* info : ForceLaws()) {
    Setting setting{ForceLaw(info->name)};
    const std::vector<TickOutput> base = Plunge(setting);
    setting.E_bone_MPa *= 2;
    setting.E_saw_MPa *= 2;
    const bool reads_moduli = !info->has_cutting;
    ExpectFactor(Plunge(setting), base, reads_moduli ? 2 : 1, info->name);
  }
}

TEST(LawMetamorphic, DoubledBiteAndDoubledTeethGiveThePowerLawsFactors) {
  for (const auto& [name, power] : kPowers) {
    const Setting setting{ForceLaw(name)};
    const std::vector<TickOutput> base = Plunge(setting);
    Setting faster = setting;  // the same poses in half the time
    faster.dt_s /= 2;
    ExpectFactor(Plunge(faster), base, power.bite_doubled, name + ", feed doubled");
    Setting slower_spindle = setting;
    slower_spindle.rpm /= 2;
    ExpectFactor(Plunge(slower_spindle), base, power.bite_doubled, name + ", rpm halved");
    Setting finer = setting;  // with the same samples of the rim
    finer.teeth *= 2;
    finer.rim_samples_per_pitch /= 2;
    ExpectFactor(Plunge(finer), base, power.teeth_doubled, name + ", teeth doubled");
  }
}

/// Checks that a law is the sum of two terms, of which each is left if the other's parameter is 0: one that does not
/// depend on the bite, and one in proportion to it.
void ExpectTwoTerms(const ForceLaw& law, const char* edge_key, const char* chip_key) {
  Setting whole{law};
  Setting edge = whole;
  edge.law.Set(chip_key, 0);
  Setting chip = whole;
  chip.law.Set(edge_key, 0);
  const std::vector<TickOutput> edge_part = Plunge(edge);
  const std::vector<TickOutput> chip_part = Plunge(chip);
  ExpectFactor(Plunge(whole), Combine(1, edge_part, 1, chip_part), 1, "whole");
  Setting faster = whole;
  faster.dt_s /= 2;
  ExpectFactor(Plunge(faster), Combine(1, edge_part, 2, chip_part), 1, "bite doubled");
  // Twice as many teeth with half the bite have twice the edge force and the same chip force in total.
  Setting finer = whole;
  finer.teeth *= 2;
  finer.rim_samples_per_pitch /= 2;
  ExpectFactor(Plunge(finer), Combine(2, edge_part, 1, chip_part), 1, "teeth doubled");
}

TEST(LawMetamorphic, EdgePlusChipIsTheSumOfItsTwoTerms) {
  ExpectTwoTerms(ForceLaw("edge_plus_chip"), "edge_N_per_mm", "chip_N_per_mm2");
}

TEST(LawMetamorphic, TwoComponentWithoutCrossoverIsTheSumOfItsTwoTerms) {
  ForceLaw law("two_component");
  law.Set("crossover_share", 0);
  ExpectTwoTerms(law, "thrust_edge_N_per_mm", "thrust_chip_N_per_mm2");
}

// A table with rows at 2 and 10 um is two_component with its crossover at 2 um: 9.66 + 468 h beyond, linear below.
TEST(LawMetamorphic, TableOfTwoComponentGivesItsForces) {
  const Setting component{ForceLaw("two_component")};
  Setting table{ForceLaw("tabulated")};
  table.law.SetTable(
      std::make_shared<const ForceTable>(ParseForceTable("tissue,bite_um,thrust_N_per_mm,cutting_N_per_mm,source\n"
                                                         "cortical,2,10.596,7.162,test\ncortical,10,14.34,8.49,test\n",
                                                         "t.csv")));
  const std::vector<TickOutput> base = Plunge(component);
  const std::vector<TickOutput> same = Plunge(table);
  ExpectFactor(same, base, 1, "table");
  // The forces of a tick are sums over some hundred samples of the rim.
  for (std::size_t i = 0; i < base.size(); ++i) {
    EXPECT_NEAR(same[i].cutting_sum_N, base[i].cutting_sum_N, 1e-12 * base[i].cutting_sum_N);
  }
}

TEST(LawMetamorphic, EveryLawHasItsFactorsTested) {
  for (const ForceLawInfo* info : ForceLaws()) {
    EXPECT_TRUE(kPowers.count(info->name) != 0 || std::string(info->name) == "edge_plus_chip" || info->has_cutting)
        << "add the factors of " << info->name;
  }
}

}  // namespace
}  // namespace kerf
