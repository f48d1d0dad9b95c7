// Thrust and cutting force of the laws that state both, in the complete simulation, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "cut/effects/plan.h"
#include "cut/effects/tangential_force.h"
#include "cut/path_sim/internals.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "support/cuts.h"
#include "support/message_of.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Stroke;

constexpr double kTeeth_per_s = 24 * 125.0;
constexpr double kCutFeed_mm_per_s = 12;  // a bite of 4 um: the arc has bites on both sides of the crossover at 2 um

/// The defaults of two_component, for each mm of width: N, bite in mm.
double ComponentThrust(double bite) {
  return 9.66 * std::min(1.0, bite / 0.002) + 468 * bite;
}
double ComponentCutting(double bite) {
  return 6.83 * std::min(1.0, bite / 0.002) + 166 * bite;
}

/// Sums over the engaged teeth, N.
struct ComponentForm {
  double thrust = 0, cutting = 0;
  Vec3 f{0};  // of thrust and, if asked for, cutting force, on the tool
};

/// Integrates over the arc of a 22 mm disc that moves along -z (plunge) or +x (slot) with its lowest point `depth`
/// below the surface; the midpoint rule is accurate to 1e-8. `factor(e, t)`: factor on both forces at a place with the
/// outward direction e and the teeth's motion t. The spindle is along -y in the world (DiscPose), so that the teeth
/// move along t = (-y) x e for rpm > 0.
ComponentForm CalcComponentForm(double depth, bool plunge,
                                const std::function<double(const Vec3&, const Vec3&)>& factor, bool with_cutting) {
  const double alpha = std::acos(1 - depth / kR);
  const double from = plunge ? -alpha : 0;
  constexpr int kIntervals = 100000;
  ComponentForm form;
  const Vec3 axis_W = DiscPose(Pose{}, {0, 0, 0}).Vector({0, 0, 1});
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = from + (alpha - from) * (i + 0.5) / kIntervals;
    const double bite = kCutFeed_mm_per_s / kTeeth_per_s * (plunge ? std::cos(phi) : std::sin(phi));
    const Vec3 e(std::sin(phi), 0, -std::cos(phi));
    const Vec3 t = glm::cross(axis_W, e);
    const double teeth = 24 / (2 * std::numbers::pi) * (alpha - from) / kIntervals;
    const double k = teeth * kSaw.thickness_mm * factor(e, t);
    form.thrust += k * ComponentThrust(bite);
    form.cutting += k * ComponentCutting(bite);
    form.f -= k * ComponentThrust(bite) * e;
    if (with_cutting) form.f -= k * ComponentCutting(bite) * t;
  }
  return form;
}

/// A cut at constant feed, and its last tick.
struct ComponentCut {
  explicit ComponentCut(const Bone& bone, bool plunge, double depth, bool with_cutting,
                        const char* law = "two_component")
      : simulation(bone, Params(with_cutting, law), DiscPose(Pose{}, Start(plunge, depth))) {
    const Vec3 end(0, 0, 4 - depth + kR);
    const Vec3 before = plunge ? end + Vec3(0, 0, 0.24) : end - Vec3(0.4, 0, 0);
    Stroke(simulation, Pose{}, Start(plunge, depth), before, 100);
    out = Stroke(simulation, Pose{}, before, end, kCutFeed_mm_per_s).back();
  }
  static SimulationParams Params(bool with_cutting, const char* law) {
    SimulationParams params;
    params.law = ForceLaw(law);
    params.effects.clear();
    if (with_cutting) params.effects.emplace_back("tangential_force");
    return params;
  }
  static Vec3 Start(bool plunge, double depth) {
    return plunge ? Vec3(0, 0, 4 + kR + 0.5) : Vec3(-24, 0, 4 - depth + kR);
  }
  Simulation simulation;
  TickOutput out;
};

Bone ComponentBlock() {
  return test::MakeBox(Pose{}, {24, 1.5, 8}, 0.1);
}
double One(const Vec3&, const Vec3&) {
  return 1;
}

// 1 %: the engaged arc of a surface sampled every 0.1 mm (docs/physics.md), as for the other laws. In a plunge the
// depth of the last tick is the one at its start, 0.012 mm less.
TEST(ComponentForces, SlotAndPlungeAreWithinOnePercent) {
  for (const bool plunge : {false, true}) {
    const double depth = 3.3;
    ComponentCut cut(ComponentBlock(), plunge, depth, true);
    const ComponentForm form = CalcComponentForm(depth - (plunge ? 0.012 : 0), plunge, One, true);
    const char* const what = plunge ? "plunge" : "slot";
    EXPECT_NEAR(cut.out.thrust_sum_N / form.thrust, 1, 0.01) << what;
    EXPECT_NEAR(cut.out.cutting_sum_N / form.cutting, 1, 0.01) << what;
    EXPECT_NEAR(glm::length(cut.out.f_T_W_N - form.f) / glm::length(form.f), 0, 0.01) << what;
    // Power: the teeth move at 125 turns per second on a circle of radius R.
    const double rim_mm_per_s = 2 * std::numbers::pi * kR * 125;
    EXPECT_NEAR(cut.out.cutting_W / (1e-3 * form.cutting * rim_mm_per_s), 1, 0.01) << what;
    // Torque and power of the effect are those of the law's cutting force.
    const auto& figures = TangentialForceEffect::In(EffectsOf(cut.simulation)).figures();
    EXPECT_NEAR(figures.torque_Nmm / (form.cutting * kR), 1, 0.01) << what;
    EXPECT_NEAR(figures.power_W / cut.out.cutting_W, 1, 0.01) << what;
    std::printf("%s: thrust %.4f, cutting force %.4f of the closed form\n", what, cut.out.thrust_sum_N / form.thrust,
                cut.out.cutting_sum_N / form.cutting);
  }
}

TEST(ComponentForces, EachTissueHasItsOwnFactor) {
  const ComponentForm form = CalcComponentForm(3.3, false, One, false);
  for (const auto& [tissue, factor] : {std::pair{Tissue::kCancellous, 0.25}, std::pair{Tissue::kTooth, 1.0},
                                       std::pair{Tissue::kCanal, 0.0}, std::pair{Tissue::kOther, 1.0}}) {
    Bone bone = ComponentBlock();
    MaterialTable table;
    table.Add({24, "bone", tissue, 19300, 0.28, true, "test"});
    bone.set_materials(table);
    const ComponentCut cut(bone, false, 3.3, false);
    EXPECT_NEAR(cut.out.thrust_sum_N, factor * form.thrust, 0.01 * form.thrust);
    EXPECT_NEAR(cut.out.cutting_sum_N, factor * form.cutting, 0.01 * form.cutting);
    EXPECT_EQ(cut.out.thrust_sum_N == 0, factor == 0);
  }
}

// The factors 0.75, 1.25 and 1 times the squared cosines of the osteons with the motion, the thrust and the edge.
TEST(ComponentForces, FollowTheDirectionOfTheOsteons) {
  for (const Vec3 direction : {Vec3(1, 0, 0), Vec3(0, 0, -2), Vec3(0, 1, 0), Vec3(1, 2, -3)}) {
    const Vec3 d = glm::normalize(direction);
    Bone bone = ComponentBlock();
    MaterialTable table = bone.materials();
    table.SetOsteonDirection(direction);
    bone.set_materials(table);
    const ComponentCut cut(bone, false, 3.3, false);
    const ComponentForm form = CalcComponentForm(
        3.3, false,
        [&](const Vec3& e, const Vec3& t) {
          return 0.75 * glm::dot(d, t) * glm::dot(d, t) + 1.25 * glm::dot(d, e) * glm::dot(d, e) + d.y * d.y;
        },
        false);
    EXPECT_NEAR(cut.out.thrust_sum_N / form.thrust, 1, 0.01);
    EXPECT_NEAR(cut.out.cutting_sum_N / form.cutting, 1, 0.01);
    EXPECT_NEAR(glm::length(cut.out.f_T_W_N - form.f) / glm::length(form.f), 0, 0.01);
  }
}

// Spindle, heat and vibration follow from both components: with a cutting force of 0.625 times the thrust at any bite,
// two_component must give what edge_plus_chip gives with a ratio of 1.6.
TEST(ComponentForces, EffectsFollowFromBothComponents) {
  const char* const kEffects[] = {"tangential_force", "spindle", "heat", "tooth_vibration"};
  const auto run = [&](ForceLaw law, bool by_ratio) {
    SimulationParams params;
    params.law = std::move(law);
    params.effects.clear();
    for (const char* name : kEffects) params.effects.emplace_back(name);
    if (by_ratio) {
      SetEffect(params.effects, "tangential_force", "ratio", 1.6);
      SetEffect(params.effects, "tooth_vibration", "tangential_share", 0.625);
    }
    SetEffect(params.effects, "tooth_vibration", "max_N", 100.0);
    Simulation simulation(ComponentBlock(), params, DiscPose(Pose{}, {0, 0, 4 + kR + 0.2}));
    const TickOutput out =
        Stroke(simulation, Pose{}, {0, 0, 4 + kR + 0.2}, {0, 0, 4 + kR - 2}, kCutFeed_mm_per_s).back();
    std::vector<double> values(EffectsOf(simulation).channel_count());
    EffectsOf(simulation).Report(values);
    for (const double f : {out.f_T_W_N.x, out.f_T_W_N.y, out.f_T_W_N.z, out.tau_TG_W_Nmm.y}) values.push_back(f);
    return values;
  };
  ForceLaw component("two_component");
  component.Set("crossover_share", 0);
  component.Set("cutting_edge_N_per_mm", 0.625 * 9.66);
  component.Set("cutting_chip_N_per_mm2", 0.625 * 468);
  ForceLaw ratio("edge_plus_chip");
  ratio.Set("edge_N_per_mm", 9.66);
  ratio.Set("chip_N_per_mm2", 468);
  ratio.Set("reference_E_star_MPa", CalcReducedModulus(kSaw.E_MPa, kSaw.nu, 19300, 0.28));
  const std::vector<double> by_law = run(component, false);
  const std::vector<double> by_ratio = run(ratio, true);
  ASSERT_EQ(by_law.size(), by_ratio.size());
  int above_0 = 0;
  for (std::size_t i = 0; i < by_law.size(); ++i) {
    // Rounding, accumulated over some hundred ticks in the temperatures.
    EXPECT_NEAR(by_law[i], by_ratio[i], 1e-9 * std::abs(by_ratio[i]) + 1e-12) << i;
    above_0 += std::abs(by_law[i]) > 1e-3 ? 1 : 0;
  }
  EXPECT_GT(above_0, 12);
}

TEST(ComponentForces, ALawWithoutCuttingForceReportsNone) {
  const ComponentCut cut(ComponentBlock(), false, 3.3, true, "hertz_chip");
  EXPECT_GT(cut.out.thrust_sum_N, 1);
  EXPECT_EQ(cut.out.cutting_sum_N, 0);
  EXPECT_EQ(cut.out.cutting_W, 0);
}

TEST(ComponentForces, TableWithoutATissueIsRefused) {
  SimulationParams params;
  params.law = ForceLaw("tabulated");
  params.law.SetTable(std::make_shared<const ForceTable>(
      ParseForceTable("tissue,bite_um,thrust_N_per_mm,cutting_N_per_mm,source\ncancellous,1,1,1,test\n"
                      "cancellous,2,2,2,test\n",
                      "t.csv")));
  EXPECT_EQ(test::MessageOf([&] {
              Simulation(ComponentBlock(), params, DiscPose(Pose{}, {0, 0, 30}));
            }),
            "the table of the force law tabulated has no rows for cortical (region 24)");
}

}  // namespace
}  // namespace kerf
