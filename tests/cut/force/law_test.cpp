// Properties of every law in the list, so that a new law is tested from the start: exact factors when an input is
// doubled, the same force in other units, and no force without a bite.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include "cut/force/measured.h"
#include "kerf/force.h"
#include "kerf/material.h"
#include "support/saw.h"
#include "support/tooth_cut.h"
#include "test_paths.h"

namespace kerf {
namespace {

constexpr double kBites_mm[] = {1e-6, 1e-4, 1e-3, 2.5e-3, 2e-2};
constexpr double kEStar[] = {10, 500, 19140};
/// A force consists of a few products and one or two roots; exact factors change it by at most ten rounding errors.
constexpr double kRounding = 10 * 2.3e-16;

/// Expected factors of each law as functions of the bite, written independently of the library's formulas.
struct Factors {
  std::function<double(double h_mm)> bite_doubled;
  std::function<double(double h_mm)> teeth_doubled;  // factor of the sum over twice as many teeth at the same feed,
                                                     // each with half the bite
};
/// Thrust of two_component per mm of width: Ket = 9.66, Kct = 468; the edge term fades below a quarter of 8 um.
double CalcTwoComponent(double h) {
  return 9.66 * std::min(1.0, h / 0.002) + 468 * h;
}
/// Thrust of tabulated: 10.6 at 2.5 um and 14.58 at 10 um, linear; from 0 below.
double CalcTable(double h) {
  return h < 0.0025 ? 10.6 * h / 0.0025 : 10.6 + 3.98 * (h - 0.0025) / 0.0075;
}
const std::map<std::string, Factors> kFactors{
    // h^(3/2)
    {"hertz_chip", {[](double) { return 2 * std::sqrt(2.0); }, [](double) { return 1 / std::sqrt(2.0); }}},
    // independent of the bite; (pitch)^3
    {"hertz_constant_bite", {[](double) { return 1.0; }, [](double) { return 2.0 / 8; }}},
    // Ke + Kc h, Ke = 9.28, Kc = 530
    {"edge_plus_chip",
     {[](double h) { return (9.28 + 530 * 2 * h) / (9.28 + 530 * h); },
      [](double h) { return 2 * (9.28 + 530 * h / 2) / (9.28 + 530 * h); }}},
    {"two_component",
     {[](double h) { return CalcTwoComponent(2 * h) / CalcTwoComponent(h); },
      [](double h) { return 2 * CalcTwoComponent(h / 2) / CalcTwoComponent(h); }}},
    {"tabulated",
     {[](double h) { return CalcTable(2 * h) / CalcTable(h); },
      [](double h) { return 2 * CalcTable(h / 2) / CalcTable(h); }}},
};
/// The laws whose force is proportional to E*; the other ones do not read the moduli.
const std::set<std::string> kByModulus{"hertz_chip", "hertz_constant_bite", "edge_plus_chip"};

const Factors& FactorsOf(const ForceLawInfo& law) {
  const auto found = kFactors.find(law.name);
  if (found == kFactors.end()) {
    throw std::runtime_error(std::string("add the closed-form factors of ") + law.name + " to kFactors");
  }
  return found->second;
}

/// Converts a value to SI from the unit at the end of its key.
double ToSI(const std::string& key, double value) {
  const auto ends = [&](const std::string& unit) {
    return key.size() >= unit.size() && key.substr(key.size() - unit.size()) == unit;
  };
  if (ends("_N_per_mm2")) return 1e6 * value;
  if (ends("_N_per_mm")) return 1e3 * value;
  if (ends("_MPa")) return 1e6 * value;
  if (ends("_mm")) return 1e-3 * value;
  // A ratio has no unit; any other unit must be added above before it can be checked.
  if (!ends("_share_of_pitch") && !ends("_share") && !ends("_factor") && !ends("_exponent") && key != "scale")
    throw std::runtime_error("no SI factor for the unit of " + key);
  return value;
}

TEST(EveryLaw, DoubledModuliDoubleTheForceOrAreNotRead) {
  for (const ForceLawInfo* info : ForceLaws()) {
    const ToothForce force = MakeToothForce(ForceLaw(info->name), kSaw);
    DiscSaw stiffer = kSaw;
    stiffer.E_MPa = 2 * kSaw.E_MPa;
    const ToothForce force_stiffer = MakeToothForce(ForceLaw(info->name), stiffer);
    for (const double h : kBites_mm) {
      for (const double E : {100.0, 19300.0}) {
        const double once = force(h, Cortical(CalcReducedModulus(kSaw.E_MPa, kSaw.nu, E, 0.28)));
        const double twice = force_stiffer(h, Cortical(CalcReducedModulus(stiffer.E_MPa, stiffer.nu, 2 * E, 0.28)));
        EXPECT_NEAR(twice / once, kByModulus.count(info->name) != 0 ? 2 : 1, 2 * kRounding)
            << info->name << " at " << h << " mm";
      }
    }
  }
}

TEST(EveryLaw, DoubledBiteGivesTheLawsOwnFactor) {
  for (const ForceLawInfo* info : ForceLaws()) {
    const ToothForce force = MakeToothForce(ForceLaw(info->name), kSaw);
    for (const double h : kBites_mm) {
      const double factor = FactorsOf(*info).bite_doubled(h);
      EXPECT_NEAR(force(2 * h, Cortical(19140)) / force(h, Cortical(19140)), factor, factor * kRounding)
          << info->name << " at " << h;
    }
  }
}

TEST(EveryLaw, DoubledTeethAtTheSameFeedGiveTheLawsOwnFactor) {
  DiscSaw finer = kSaw;
  finer.teeth = 2 * kSaw.teeth;
  for (const ForceLawInfo* info : ForceLaws()) {
    const ToothForce coarse = MakeToothForce(ForceLaw(info->name), kSaw);
    const ToothForce fine = MakeToothForce(ForceLaw(info->name), finer);
    for (const double h : kBites_mm) {
      const double factor = FactorsOf(*info).teeth_doubled(h);
      EXPECT_NEAR(2 * fine(0.5 * h, Cortical(19140)) / coarse(h, Cortical(19140)), factor, factor * kRounding)
          << info->name << " at " << h;
    }
  }
}

TEST(EveryLaw, MetresAndPascalsGiveTheSameNewtons) {
  DiscSaw si = kSaw;
  si.diameter_mm = 1e-3 * kSaw.diameter_mm;  // metres from here on, despite the names of the fields
  si.thickness_mm = 1e-3 * kSaw.thickness_mm;
  si.edge_radius_um = 1e-3 * kSaw.edge_radius_um;
  si.E_MPa = 1e6 * kSaw.E_MPa;
  for (const ForceLawInfo* info : ForceLaws()) {
    const ForceLaw law(info->name);
    LawValues values = law.values();
    for (std::size_t i = 0; i < info->parameters.size(); ++i) values[i] = ToSI(info->parameters[i].key, values[i]);
    std::shared_ptr<ForceTable> table;
    if (law.table() != nullptr) {
      table = std::make_shared<ForceTable>();
      for (ForceLawRow row : law.table()->ListRows()) {
        row.bite_um *= 1e-3;
        row.thrust_N_per_mm *= 1e3;
        row.cutting_N_per_mm *= 1e3;
        table->Add(row);
      }
    }
    const ToothForce in_mm = info->make(law.values(), CalcTooth(kSaw), law.table());
    const ToothForce in_m = info->make(values, CalcTooth(si), table);
    for (const double h : kBites_mm) {
      for (const double E : kEStar) {
        const double newton = in_mm(h, Cortical(E));
        if (in_mm.HasCutting()) {
          const double cutting = in_mm.Cutting(h, Cortical(E));
          EXPECT_NEAR(in_m.Cutting(1e-3 * h, Cortical(1e6 * E)), cutting, cutting * kRounding) << info->name;
        }
        EXPECT_NEAR(in_m(1e-3 * h, Cortical(1e6 * E)), newton, newton * kRounding)
            << info->name << " at " << h << " mm";
      }
    }
  }
}

TEST(EveryLaw, GivesNoForceWithoutABite) {
  for (const ForceLawInfo* info : ForceLaws()) {
    const ToothForce force = MakeToothForce(ForceLaw(info->name), kSaw);
    for (const double bite : {0.0, -0.0, -1e-12, -1e-3, -1e300, std::nan("")}) {
      EXPECT_EQ(force(bite, Cortical(19140)), 0) << info->name << " at " << bite;
    }
  }
}

TEST(EveryLaw, NeverPullsAndGrowsWithBiteAndModulus) {
  for (const ForceLawInfo* info : ForceLaws()) {
    const ToothForce force = MakeToothForce(ForceLaw(info->name), kSaw);
    double before = 0;
    for (double h = 1e-7; h < 0.1; h *= 1.1) {
      const double now = force(h, Cortical(19140));
      EXPECT_GT(now, 0) << info->name;
      // The constant law must not decrease even by one bit, because it does not use the bite.
      EXPECT_GE(now, before) << info->name << " at " << h << " mm";
      if (kByModulus.count(info->name) != 0) {
        EXPECT_GT(force(h, Cortical(19141)), now) << info->name;
      }
      before = now;
    }
  }
}

// The rules of ToothForce, for random cuts: any mixture of tissues and direction, and bites of up to 1 m.
TEST(EveryLaw, KeepsTheRules) {
  std::mt19937_64 random(20261125);
  std::uniform_real_distribution<double> uniform;
  for (const ForceLawInfo* info : ForceLaws()) {
    const ToothForce force = MakeToothForce(ForceLaw(info->name), kSaw);
    EXPECT_EQ(force.HasCutting(), info->has_cutting) << info->name;
    for (int n = 0; n < 2000; ++n) {
      ToothCut cut{.E_star_MPa = 1e5 * uniform(random), .E_MPa = 1e5 * uniform(random)};
      double sum = 0;
      for (double& fraction : cut.tissue) sum += fraction = uniform(random);
      for (double& fraction : cut.tissue) fraction /= sum;
      cut.speed_mm_per_s = 1e4 * uniform(random);
      const double along = uniform(random), into = uniform(random) * (1 - along);
      if (n % 3 != 0) cut.osteon = {along, into, 1 - along - into};
      const double bite = std::pow(10.0, -7 + 10 * uniform(random));
      const double thrust = force(bite, cut);
      EXPECT_TRUE(std::isfinite(thrust) && thrust >= 0) << info->name << " at " << bite;
      // The last bits of an interpolation may fall.
      EXPECT_GE(force(bite * (1 + uniform(random)), cut), thrust * (1 - kRounding)) << info->name << " at " << bite;
      EXPECT_EQ(force(bite, cut), thrust);
      EXPECT_EQ(force(bite, ToothCut{}), 0) << info->name;
      EXPECT_EQ(force.jumps, force.thrust(force, 0, cut) > 0) << info->name;
      if (!force.HasCutting()) continue;
      const double cutting = force.Cutting(bite, cut);
      EXPECT_TRUE(std::isfinite(cutting) && cutting >= 0) << info->name << " at " << bite;
      EXPECT_EQ(force.Cutting(bite, ToothCut{}), 0) << info->name;
      EXPECT_GE(thrust, cutting * force.least_thrust_per_cutting * (1 - kRounding)) << info->name << " at " << bite;
    }
  }
}

TEST(EveryLaw, IsFullyDescribed) {
  std::ifstream file(std::string(KERF_SOURCE_DIR) + "/docs/physics.md");
  std::stringstream physics;
  physics << file.rdbuf();
  std::map<std::string, int> names;
  for (const ForceLawInfo* info : ForceLaws()) {
    ++names[info->name];
    EXPECT_NE(physics.str().find(std::string("| `") + info->name + "`"), std::string::npos)
        << "docs/physics.md has no row for " << info->name;
    EXPECT_FALSE(std::string(info->summary).empty());
    EXPECT_FALSE(std::string(info->source).empty());
    // The documentation uses the same text as the program.
    for (const std::string& phrase :
         {DescribeAccuracy(ForceLaw(info->name), DiscSaw{}), DescribeBlades(ForceLaw(info->name), DiscSaw{}),
          std::string(FindCaveat(*info).good_for)}) {
      EXPECT_FALSE(phrase.empty()) << info->name;
      EXPECT_NE(physics.str().find(phrase), std::string::npos) << "docs/physics.md does not say: " << phrase;
    }
    EXPECT_LE(info->parameters.size(), LawValues{}.size());
    EXPECT_TRUE(IsNowhereMeasured(info->validity) || info->validity.from_mm < info->validity.to_mm) << info->name;
    // A limit must state what is wrong beyond it, but for the bite where measurements begin: every force says that.
    const bool has_lower = info->validity.from_mm > 0 && info->validity.from_mm != kMinMeasuredBite_mm;
    EXPECT_EQ(has_lower, !std::string(info->validity.below).empty()) << info->name;
    EXPECT_EQ(std::isfinite(info->validity.to_mm), !std::string(info->validity.beyond).empty()) << info->name;
    for (const LawParameter& p : info->parameters) {
      EXPECT_GE(p.default_value, p.lower) << p.key;
      EXPECT_LE(p.default_value, p.upper) << p.key;
      EXPECT_FALSE(std::string(p.meaning).empty()) << p.key;
      if (!p.has_interval()) continue;
      EXPECT_GE(p.interval_lower, p.lower) << p.key;
      EXPECT_LE(p.interval_upper, p.upper) << p.key;
      EXPECT_LE(p.interval_lower, p.default_value) << p.key;
      EXPECT_GE(p.interval_upper, p.default_value) << p.key;
      EXPECT_FALSE(std::string(p.interval_basis).empty()) << p.key;
    }
  }
  for (const auto& [name, count] : names) EXPECT_EQ(count, 1) << name;
  EXPECT_STREQ(ForceLaw().name(), "two_component");
}

}  // namespace
}  // namespace kerf
