// The force with a modulus that is uniform or derived from CT numbers, compared with the force with the same constants
// in the region table.
#include <gtest/gtest.h>

#include "bone/grid/ct_modulus.h"
#include "kerf/simulation.h"
#include "support/cuts.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Stroke;

/// Makes a plate of 12 x 1.5 x 6 mm: cortical bone (24) above z = 0, cancellous bone (32) below.
Bone MakePlate(double E_24_MPa, double E_32_MPa, double nu_24 = 0.28, double nu_32 = 0.30) {
  SolidField field;
  field.value = [](const Vec3& p) { return test::BoxDistance(p, Vec3(6, 0.75, 3)); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p) { return p.z > 0 ? 24 : 32; };
  MaterialTable table = test::OneRegionTable(24, E_24_MPa, nu_24);
  table.Add({32, "cancellous", Tissue::kCancellous, E_32_MPa, nu_32, true, "test"});
  return MakeBone(field, Box3{Vec3(-7, -2, -4), Vec3(7, 2, 4)}, {0.1, 0.1, {}}, table);
}

std::vector<TickOutput> Plunge(const Bone& bone) {
  const double R = kSaw.radius_mm();
  Simulation simulation(bone, {.law = ForceLaw("hertz_chip")}, DiscPose(Pose{}, {0, 0, 3.1 + R}));
  return Stroke(simulation, Pose{}, {0, 0, 3.1 + R}, {0, 0, -2.5 + R}, 20);
}

/// Returns the law E = a HU MPa, expressed by means of rho = HU / 1200, for 12 to 30000 HU.
CtLaw LinearLaw(double a = 1) {
  CtLaw law;
  law.name = "linear";
  law.density = "qct";
  law.calibration = {{0, 0}, {30000, 25}};
  law.bands = {{0.01, 25, 0, 1200 * a, 1}};
  law.source = "test";
  return law;
}

TEST(UniformForce, IsBitIdenticalToThatOfAOneRegionBlock) {
  Bone uniform = MakePlate(19300, 1370);
  uniform.OverrideMaterials(MakeUniformTable(uniform.materials(), 17000, 0.31));
  const auto a = Plunge(uniform);
  const auto b = Plunge(MakePlate(17000, 17000, 0.31, 0.31));
  const auto regions = Plunge(MakePlate(19300, 1370));
  ASSERT_EQ(a.size(), b.size());
  double difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].f_T_W_N, b[i].f_T_W_N);
    EXPECT_EQ(a[i].mean_E_MPa, b[i].mean_E_MPa);
    EXPECT_EQ(a[i].removed_mm3, regions[i].removed_mm3);  // removal does not depend on the material
    difference = std::max(difference, glm::length(a[i].f_T_W_N - regions[i].f_T_W_N));
  }
  EXPECT_GT(difference, 0.1);  // and it differs from the force of the regions
}

TEST(CtForce, ConstantCtNumbersGiveTheForceOfTheSameTableConstants) {
  Bone ct = MakePlate(19300, 5);  // the table's 5 MPa must have no influence
  SetHu(
      ct, [](const Vec3&) { return 1500.0; }, 0.37);
  UseCtModulus(ct, LinearLaw(), false);
  const auto a = Plunge(ct);
  const auto b = Plunge(MakePlate(19300, 1500));
  ASSERT_EQ(a.size(), b.size());
  double peak = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double size = glm::length(b[i].f_T_W_N);
    peak = std::max(peak, size);
    // The grid stores seven digits of E.
    EXPECT_NEAR(glm::length(a[i].f_T_W_N - b[i].f_T_W_N), 0, 1e-6 * size + 1e-12);
    EXPECT_NEAR(a[i].mean_E_MPa, b[i].mean_E_MPa, 1e-6 * b[i].mean_E_MPa);
    EXPECT_EQ(a[i].removed_mm3, b[i].removed_mm3);
    EXPECT_EQ(a[i].main_region, b[i].main_region);
  }
  EXPECT_GT(peak, 1);
}

TEST(CtForce, DoubledCoefficientScalesItWithTheReducedModulus) {
  // The chip law is proportional to E*, which for steel on bone grows by less than a factor of two.
  const double E = 3000;
  const double ratio =
      CalcReducedModulus(kSaw.E_MPa, kSaw.nu, 2 * E, 0.3) / CalcReducedModulus(kSaw.E_MPa, kSaw.nu, E, 0.3);
  EXPECT_GT(ratio, 1.9);
  EXPECT_LT(ratio, 2);
  Bone once = MakePlate(5, 5, 0.3, 0.3);
  SetHu(
      once, [E](const Vec3&) { return E; }, 0.5);
  Bone twice = once;
  UseCtModulus(once, LinearLaw(1), true);
  UseCtModulus(twice, LinearLaw(2), true);
  const auto a = Plunge(once);
  const auto b = Plunge(twice);
  double peak = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(b[i].thrust_sum_N, ratio * a[i].thrust_sum_N, 1e-6 * b[i].thrust_sum_N + 1e-12);
    peak = std::max(peak, a[i].thrust_sum_N);
  }
  EXPECT_GT(peak, 0.5);
}

TEST(CtForce, RampGivesTheForceOfTheModulusAtTheTeeth) {
  // E falls from 3000 MPa at the top to 1000 MPa at the bottom. A large disc cuts the plate's whole length at nearly
  // the same depth, so the mean E over the teeth is the ramp's value at that depth.
  Bone bone = MakePlate(5, 5, 0.3, 0.3);
  SetHu(
      bone, [](const Vec3& p) { return 2000 + 1000 * p.z / 3; }, 0.5);
  UseCtModulus(bone, LinearLaw(), true);
  SimulationParams params;
  DiscSaw saw;
  saw.diameter_mm = 200;
  saw.teeth = 200;
  params.tool = saw;
  const double R = saw.radius_mm();
  Simulation simulation(bone, params, DiscPose(Pose{}, {0, 0, 3.5 + R}));
  const auto ticks = Stroke(simulation, Pose{}, {0, 0, 3.5 + R}, {0, 0, -2.5 + R}, 10);
  const double sag = (R - std::sqrt(R * R - 36)) / 3;  // mean height of the arc above its lowest point
  int checked = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double z = 3.5 - 0.01 * static_cast<double>(i) + sag;
    if (z > 2.5 || z < -2) continue;
    // The look-ahead is 0.025 mm deeper and the tool moves 0.01 mm in a tick, which makes 12 MPa; the kerf's rounded
    // ends have little weight.
    EXPECT_NEAR(ticks[i].mean_E_MPa, 2000 + 1000 * z / 3, 20);
    ++checked;
  }
  EXPECT_GT(checked, 400);
}

TEST(CtForce, DensityOfTheCtScalesTheForceOfALawByDensity) {
  // HU -> density -> E -> density: bone of twice the reference's density by its CT numbers has 2^n times the force that
  // bone with the reference's E in the region table has.
  CtLaw morgan = LinearLaw();
  morgan.bands = {{0.01, 25, 0, 15490, 1.93}};
  const double rho = 0.2;
  for (const char* name : {"edge_plus_chip", "two_component"}) {
    for (const double n : {1.0, 2.0}) {
      SimulationParams params;
      params.law = ForceLaw(name);
      params.law.Set("density_exponent", n);
      params.law.Set("reference_E_MPa", CalcModulus(morgan, rho));
      const auto plunge = [&](const Bone& bone) {
        const double R = kSaw.radius_mm();
        Simulation simulation(bone, params, DiscPose(Pose{}, {0, 0, 3.1 + R}));
        return Stroke(simulation, Pose{}, {0, 0, 3.1 + R}, {0, 0, -2.5 + R}, 20);
      };
      Bone ct = MakePlate(5, 5);  // the table's 5 MPa must have no influence
      SetHu(
          ct, [&](const Vec3&) { return 1200 * 2 * rho; }, 0.37);
      UseCtModulus(ct, morgan, true);
      const auto twice = plunge(ct);
      const auto once = plunge(MakePlate(CalcModulus(morgan, rho), CalcModulus(morgan, rho)));
      double peak = 0;
      for (std::size_t i = 0; i < once.size(); ++i) {
        peak = std::max(peak, once[i].thrust_sum_N);
        // The grid stores seven digits of E.
        EXPECT_NEAR(twice[i].thrust_sum_N, std::pow(2, n) * once[i].thrust_sum_N, 1e-6 * once[i].thrust_sum_N + 1e-12);
      }
      EXPECT_GT(peak, 1) << name;
    }
  }
}

}  // namespace
}  // namespace kerf
