// The heat grid against solutions of Pennes' equation: point and line source, perfusion, dose, bounds and balance.
#include "cut/effects/heat/heat_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "base/core/heap_guard.h"
#include "cut/removal/carve.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// A bone and its heat grid, with functions that take points in the world frame.
class Heated {
 public:
  Heated(Bone the_bone, const HeatGridParams& params) : bone(std::move(the_bone)), field(bone), grid(params, field) {}

  double Rise(const Vec3& p_W) const { return grid.CalcTemperature(p_W - field.p_WF_mm()) - grid.params().body_C; }
  bool Put(const Vec3& p_W, double mJ) { return grid.Put(p_W - field.p_WF_mm(), p_W - field.p_WF_mm(), mJ); }
  void AdvanceFrames(int count) {
    for (int i = 0; i < count; ++i) grid.Advance(grid.frame_s(), {});
  }

  Bone bone;
  BoneField field;
  HeatGrid grid;
};

HeatGridParams OnlyConduction(double spacing_mm) {
  HeatGridParams params;
  params.spacing_mm = spacing_mm;
  params.max_MB = 64;
  params.perfusion_mL_per_min_kg = 0;
  params.air_W_per_m2K = 0;
  params.water_mg_per_mm3 = 0;
  params.longest_frame_s = 10;
  return params;
}

double CalcCapacity(const HeatGridParams& p) {  // mJ / (mm3 K)
  return 1e-6 * p.density_kg_per_m3 * p.heat_capacity_J_per_kgK;
}
double CalcAlpha(const HeatGridParams& p) {  // mm2 / s
  return p.conductivity_W_per_mK / CalcCapacity(p);
}

/// Returns the relative error over all points together.
double CalcError(const Heated& heated, const std::vector<Vec3>& points,
                 const std::function<double(const Vec3&)>& exact) {
  double error = 0, size = 0;
  for (const Vec3& p : points) {
    error += std::pow(heated.Rise(p) - exact(p), 2);
    size += std::pow(exact(p), 2);
  }
  return std::sqrt(error / size);
}

void ExpectBalance(const HeatGrid& grid, double fraction) {
  const HeatBalance b = grid.CalcBalance();
  EXPECT_NEAR(b.CalcRest(), 0, fraction * b.put_in);
}

// T = E / (rho c (4 pi alpha t)^(3/2)) exp(-r^2 / (4 alpha t)), Carslaw and Jaeger 1959, 10.2.
TEST(HeatGrid, HeatOfAPointMatchesTheClosedFormToSecondOrder) {
  const Vec3 source(0);  // a node of all three grids, like the points
  const std::vector<Vec3> points{source,      {0.6, 0, -0.6},   {-0.6, 1.2, 0},  {1.2, -1.2, 0.6},
                                 {0, 0, 1.8}, {-1.8, 0.6, 1.2}, {0.6, -0.6, 0.6}};
  std::vector<double> errors;
  for (const double spacing : {0.6, 0.3, 0.15}) {
    const HeatGridParams params = OnlyConduction(spacing);
    Heated heated(test::MakeBox(Pose{}, Vec3(15), 0.5), params);
    const double E = 1e5;  // enough to open all blocks that matter
    ASSERT_TRUE(heated.Put(source, E));
    // 256 frames at a spacing of 0.15 mm; the total time is the same for each spacing.
    const int frames = static_cast<int>(std::lround(256 * std::pow(0.15 / spacing, 2)));
    heated.AdvanceFrames(frames);
    const double t = frames * heated.grid.frame_s();
    const double alpha = CalcAlpha(params);
    errors.push_back(CalcError(heated, points, [&](const Vec3& p) {
      return E / (CalcCapacity(params) * std::pow(4 * std::numbers::pi * alpha * t, 1.5)) *
             std::exp(-glm::dot(p - source, p - source) / (4 * alpha * t));
    }));
    ExpectBalance(heated.grid, 1e-6);
  }
  EXPECT_LT(errors.back(), 0.01);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.8) << errors[0] << " " << errors[1];
  EXPECT_GT(std::log2(errors[1] / errors[2]), 1.8) << errors[1] << " " << errors[2];
}

// T = q / (4 pi k r) erfc(r / sqrt(4 alpha t)), Carslaw and Jaeger 10.4.
TEST(HeatGrid, SteadyPointSourceMatchesTheClosedFormToSecondOrder) {
  const Vec3 source(0);
  const std::vector<Vec3> points{{1.2, 0, -0.6}, {-0.6, 1.2, 0}, {1.2, -1.2, 0.6}, {0, 0, 1.8}, {-1.8, 0.6, 1.2}};
  std::vector<double> errors;
  for (const double spacing : {0.6, 0.3, 0.15}) {
    const HeatGridParams params = OnlyConduction(spacing);
    Heated heated(test::MakeBox(Pose{}, Vec3(15), 0.5), params);
    const double q = 1e4;  // mW
    const int frames = static_cast<int>(std::lround(256 * std::pow(0.15 / spacing, 2)));
    const double frame_s = heated.grid.frame_s();
    // Heat that is added at the start of a frame represents half a frame before and half a frame after, so the first
    // addition is half as large.
    for (int i = 0; i < frames; ++i) {
      ASSERT_TRUE(heated.Put(source, q * frame_s * (i == 0 ? 0.5 : 1)));
      heated.AdvanceFrames(1);
    }
    const double t = frames * frame_s;
    const double alpha = CalcAlpha(params);
    errors.push_back(CalcError(heated, points, [&](const Vec3& p) {
      const double r = glm::length(p - source);
      return q / (4 * std::numbers::pi * params.conductivity_W_per_mK * r) * std::erfc(r / std::sqrt(4 * alpha * t));
    }));
  }
  EXPECT_LT(errors.back(), 0.01);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.8) << errors[0] << " " << errors[1];
  EXPECT_GT(std::log2(errors[1] / errors[2]), 1.8) << errors[1] << " " << errors[2];
}

// A line source through a plate with insulated faces: T = q' / (4 pi k) E1(r^2 / (4 alpha t)), Carslaw and Jaeger 10.4.
TEST(HeatGrid, LineSourceThroughAPlateMatchesTheClosedForm) {
  const double spacing = 0.2;
  const HeatGridParams params = OnlyConduction(spacing);
  // The plate extends from -5.5 to 5.5 cells, so its faces are midway between nodes.
  Heated heated(test::MakeBox(Pose{}, {18, 18, 11 * spacing}, 0.1), params);
  const double q_per_mm = 50;  // mW / mm
  const double frame_s = heated.grid.frame_s();
  const int frames = 150;
  for (int i = 0; i < frames; ++i) {
    for (int k = -5; k <= 5; ++k) {
      ASSERT_TRUE(heated.Put({0.05, 0.03, k * spacing}, q_per_mm * spacing * frame_s * (i == 0 ? 0.5 : 1)));
    }
    heated.AdvanceFrames(1);
  }
  const double t = frames * frame_s;
  const std::vector<Vec3> points{{0.8, 0.3, -0.9}, {-0.3, 1.1, 0.2}, {1.3, -1.2, 0.9}, {-1.5, 0.4, 0}, {2.1, 1, 0.4}};
  const double error = CalcError(heated, points, [&](const Vec3& p) {
    const double r2 = std::pow(p.x - 0.05, 2) + std::pow(p.y - 0.03, 2);
    return -q_per_mm / (4 * std::numbers::pi * params.conductivity_W_per_mK) *
           std::expint(-r2 / (4 * CalcAlpha(params) * t));
  });
  EXPECT_LT(error, 0.01);
  ExpectBalance(heated.grid, 1e-6);
}

TEST(HeatGrid, BloodCarriesHeatOffExponentially) {
  HeatGridParams params = OnlyConduction(0.5);
  params.perfusion_mL_per_min_kg = 500;
  Heated heated(test::MakeBox(Pose{}, Vec3(12), 0.5), params);
  ASSERT_TRUE(heated.Put(Vec3(0), 2e5));  // enough to open all blocks that matter
  // 500e-6 m3 of blood per minute and kilogram of bone, with 1908 kg/m3 for bone and 3.8e6 J/(m3 K) for blood.
  const double rate_per_s = 500e-6 / 60 * 1908 * 3.8e6 / (1908 * 1313);
  heated.AdvanceFrames(200);
  const double t = 200 * heated.grid.frame_s();
  ASSERT_GT(rate_per_s * t, 0.5);
  EXPECT_NEAR(heated.grid.CalcBalance().stored / (2e5 * std::exp(-rate_per_s * t)), 1,
              2e-5);  // rounding of 200 frames
  ExpectBalance(heated.grid, 1e-6);
}

// A single cell of bone keeps its temperature; 1 min at 47 C, for example, is a dose of 16 min.
TEST(HeatGrid, DoseAtConstantTemperatureMatchesTheClosedForm) {
  struct Held {
    double C, seconds, cem43_min;
  };
  for (const Held& held : {Held{47, 60, 16}, Held{50, 30, 64}, Held{53, 60, 1024}, Held{43, 60, 1}, Held{42, 60, 0.25},
                           Held{39.001, 120, 2 * std::pow(4, 39.001 - 43)}, Held{38.9, 60, 0}}) {
    HeatGridParams params = OnlyConduction(0.4);
    params.longest_frame_s = 0.1;
    Heated heated(test::MakeBox(Pose{}, Vec3(0.4), 0.05), params);
    ASSERT_TRUE(heated.Put(Vec3(0), (held.C - 37) * CalcCapacity(params) * std::pow(0.4, 3)));
    heated.AdvanceFrames(static_cast<int>(std::lround(held.seconds / heated.grid.frame_s())));
    const HeatFigures& f = heated.grid.figures();
    EXPECT_NEAR(f.peak_C, held.C, 1e-5);
    EXPECT_NEAR(f.cem43_min, held.cem43_min, 2e-4 * held.cem43_min) << held.C;  // rounding of 600 sums in float
    EXPECT_NEAR(heated.grid.CalcDose(-heated.field.p_WF_mm()), held.cem43_min, 2e-4 * held.cem43_min);
    const bool hot = held.C >= 50;
    if (held.C == 47) continue;  // at the limit, except for rounding
    EXPECT_NEAR(f.above_47_s, hot ? held.seconds : 0, 1e-2);
    EXPECT_NEAR(f.past_47_mm3, hot && held.seconds >= 60 ? 0.064 : 0, 1e-6);
    EXPECT_NEAR(f.past_dose_mm3, hot ? 0.064 : 0, 1e-6);
  }
}

// For any heat input and any tick lengths: once heating has ended, nothing becomes hotter than the hottest node was,
// and nothing becomes colder than both the coolant and the body.
TEST(HeatGrid, NoNewExtremesForAnyTick) {
  for (const double dt_s : {0.001, 0.004, 0.03, 0.1, 0.333, 1.0}) {
    for (const double conductivity : {0.1, 0.32, 5.0}) {
      SCOPED_TRACE(testing::Message() << dt_s << " s, " << conductivity << " W/mK");
      std::mt19937 random(17);
      std::uniform_real_distribution<double> at(-3, 3);
      HeatGridParams params;
      params.conductivity_W_per_mK = conductivity;
      params.irrigation_W_per_m2K = 1e5;
      params.air_W_per_m2K = 100;
      // The block is skewed, so that its surface cuts the cells in all ways.
      Heated heated(
          test::MakeBox(Pose{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), Vec3(0.1)}, Vec3(7, 7, 3), 0.2),
          params);
      for (int i = 0; i < 300; ++i) heated.Put({at(random), at(random), at(random)}, 40);
      const HeatWet wet{-heated.field.p_WF_mm(), {0, 0, 1}, 2, 1};
      const int ticks = static_cast<int>(std::max(3.0, 1.5 / dt_s));
      double hottest_C = std::numeric_limits<double>::infinity();
      bool settled = false;
      for (int i = 0; i < ticks; ++i) {
        heated.grid.Advance(dt_s, wet);
        double high = -1e9, low = 1e9;
        heated.grid.ForEachNode([&](const HeatNode& node) {
          high = std::max(high, node.C);
          low = std::min(low, node.C);
        });
        // The upper limit is checked from the frame after the one that received the last heat.
        EXPECT_LE(high, settled ? hottest_C + 1e-4 : 1e6);
        EXPECT_GE(low, params.coolant_C - 1e-4);
        settled = heated.grid.frames() > 0 && heated.grid.CalcBalance().waiting == 0;
        if (settled) hottest_C = high;
      }
      ExpectBalance(heated.grid, 1e-5);
      EXPECT_GT(heated.grid.CalcBalance().irrigation, 0);
      EXPECT_GT(heated.grid.CalcBalance().air, 0);
    }
  }
}

// Heat leaves through a bare face against the resistances of the coolant film (1 / h) and of half a cell in series.
TEST(HeatGrid, CoolantRemovesHeatByNewtonsLaw) {
  HeatGridParams params = OnlyConduction(0.4);
  params.longest_frame_s = 0.002;
  params.irrigation_W_per_m2K = 2000;
  Heated heated(test::MakeBox(Pose{}, {12.4, 12.4, 12.4}, 0.2), params);
  // A whole layer at the lower face is heated uniformly: the flow is one-dimensional until the edges have an influence.
  const double U = 1e-3 / (1 / 2000.0 + 0.0002 / 0.32);
  const HeatWet wet{Vec3(0, 0, -6) - heated.field.p_WF_mm(), {0, 0, 1}, 0.61, 1};
  // Nodes are at multiples of 0.4 mm: the lowest ones, at -6 mm, have their whole lower face bare.
  for (int i = -8; i <= 8; ++i) {
    for (int k = -8; k <= 8; ++k) {
      for (int z = -15; z <= -8; ++z) ASSERT_TRUE(heated.Put({0.4 * i, 0.4 * k, 0.4 * z}, 4));
    }
  }
  heated.grid.Advance(0.0001, wet);
  heated.AdvanceFrames(1);
  const double before = heated.grid.CalcBalance().irrigation;
  const double rise = heated.Rise({0, 0, -6});
  heated.grid.Advance(heated.grid.frame_s(), wet);
  // The nine nodes within 0.61 mm of the axis are in the wet cylinder, each with 0.16 mm2 of face.
  const double expected_mW = 9 * 0.16 * U * (rise + 37 - params.coolant_C);
  EXPECT_NEAR((heated.grid.CalcBalance().irrigation - before) / heated.grid.frame_s() / expected_mW, 1, 0.02);
}

// A single cell is heated to 100 C, its water boils off, and the bone is heated further; no more water boils off than
// there is.
TEST(HeatGrid, WaterBoilsOffAt100CUntilItIsGone) {
  HeatGridParams params = OnlyConduction(0.4);
  params.water_mg_per_mm3 = 0.1;
  Heated heated(test::MakeBox(Pose{}, Vec3(0.4), 0.05), params);
  const double cell_mm3 = std::pow(0.4, 3);
  const double to_100_mJ = 63 * CalcCapacity(params) * cell_mm3;
  const double water_mJ = 0.1 * 2257 * cell_mm3;
  struct Put {
    double mJ, rise_K, steam_mJ;
  };
  for (const Put& put : {Put{0.5 * to_100_mJ, 31.5, 0}, Put{0.5 * to_100_mJ + 0.3 * water_mJ, 63, 0.3 * water_mJ},
                         Put{0.7 * water_mJ, 63, water_mJ}, Put{to_100_mJ, 126, water_mJ}}) {
    ASSERT_TRUE(heated.Put(Vec3(0), put.mJ));
    heated.AdvanceFrames(2);
    EXPECT_NEAR(heated.Rise(Vec3(0)), put.rise_K, 1e-4);  // rounding of floats
    EXPECT_NEAR(heated.grid.CalcBalance().steam, put.steam_mJ, 1e-6 * water_mJ);
  }
  ExpectBalance(heated.grid, 1e-6);
}

// Coolant chills bone near warm bone; this is accounted for separately, and discarded when nothing is warm.
TEST(HeatGrid, ChilledBoneIsCountedSeparatelyAndOpensNoBlocks) {
  HeatGridParams params;
  params.irrigation_W_per_m2K = 2000;
  Heated heated(test::MakeBox(Pose{}, {24, 24, 6}, 0.2), params);
  params.irrigation_W_per_m2K = 0;
  Heated dry(test::MakeBox(Pose{}, {24, 24, 6}, 0.2), params);
  ASSERT_TRUE(heated.Put({0, 0, 2.8}, 5));
  ASSERT_TRUE(dry.Put({0, 0, 2.8}, 5));
  const HeatWet wet{Vec3(0, 0, 3) - heated.field.p_WF_mm(), {0, 0, 1}, 12, 1};
  bool chilled = false;
  for (int i = 0; i < 4000 && heated.grid.awake(); ++i) {
    heated.grid.Advance(0.05, wet);
    dry.grid.Advance(0.05, {});
    const HeatBalance b = heated.grid.CalcBalance();
    chilled = chilled || b.chilled > 1;
    EXPECT_GE(b.stored, 0);
    EXPECT_GE(b.chilled, 0);
    EXPECT_NEAR(b.CalcRest(), 0, 1e-5 * (b.put_in + b.irrigation));
  }
  EXPECT_TRUE(chilled);
  EXPECT_FALSE(heated.grid.awake());
  EXPECT_EQ(heated.grid.CalcBalance().chilled, 0);
  // Chilling opens no blocks.
  EXPECT_LE(heated.grid.block_count(), dry.grid.block_count());
}

// The bone is tilted, half of it is under coolant, and it is hot enough for steam and dose, so that every kernel is
// used.
TEST(HeatGrid, IsTheSameBitForBitAtEveryVectorWidth) {
  ASSERT_GE(VectorTargets().size(), 2U);
  const auto run = [] {
    Pose tilted;
    tilted.R_AB = glm::angleAxis(0.4, glm::normalize(Vec3(1, 2, 3)));
    HeatGridParams params;
    params.spacing_mm = 0.25;
    params.irrigation_W_per_m2K = 2000;  // on half of the upper face
    Heated heated(test::MakeBox(tilted, Vec3(4, 5, 3), 0.25), params);
    const HeatWet wet{Vec3(0, 0, 1.5) - heated.field.p_WF_mm(), {1, 0, 0}, 1.5, 1};
    for (int i = 0; i < 300; ++i) {
      EXPECT_TRUE(heated.Put(Vec3(0.4, 0.004 * i, 0.9), 15));
      heated.grid.Advance(0.01, wet);
    }
    std::vector<double> all;
    heated.grid.ForEachNode([&](const HeatNode& node) {
      for (const double value : {node.fraction, node.C, node.above_47_s, node.cem43_min}) all.push_back(value);
    });
    const HeatBalance b = heated.grid.CalcBalance();
    EXPECT_GT(std::min({b.stored, b.perfusion, b.irrigation, b.air, b.steam}), 0);
    all.insert(all.end(), {b.stored, b.perfusion, b.irrigation, b.air, b.steam});
    all.push_back(heated.grid.figures().cem43_min);
    EXPECT_GT(all.back(), 0);
    return all;
  };
  const std::vector<double> best = run();
  for (const std::string& target : VectorTargets()) {
    SetVectorTarget(target);
    EXPECT_EQ(run(), best) << target;
  }
  SetVectorTarget("");
}

TEST(HeatGrid, FullPoolIsReportedAndTheHeatBalanceCloses) {
  HeatGridParams params = OnlyConduction(0.2);
  params.max_MB = 0.1;  // about 8 blocks
  Heated heated(test::MakeBox(Pose{}, Vec3(20), 0.5), params);
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(heated.Put({0.4 * (i - 20), 0.1, 0.1}, 50));
  for (int i = 0; i < 300; ++i) heated.grid.Advance(0.01, {});
  EXPECT_TRUE(heated.grid.figures().full);
  EXPECT_EQ(heated.grid.block_count(), heated.grid.block_capacity());
  EXPECT_GT(heated.grid.CalcBalance().no_room, 0);
  EXPECT_GT(heated.grid.CalcBalance().stored, 0);
  EXPECT_TRUE(std::isfinite(heated.grid.figures().peak_C));
  ExpectBalance(heated.grid, 1e-6);
}

TEST(HeatGrid, SleepsWhenColdAndDoesNotAllocate) {
  HeatGridParams params;
  params.perfusion_mL_per_min_kg = 1000;
  Heated heated(test::MakeBox(Pose{}, Vec3(9), 0.3), params);
  EXPECT_FALSE(heated.grid.awake());
  {
    const HeapGuard guard;
    for (int i = 0; i < 100; ++i) {
      heated.Put({0.02 * i, 0, 0}, 3);
      heated.grid.Advance(0.001, {});
    }
    EXPECT_TRUE(heated.grid.awake());
    for (int i = 0; i < 4000 && heated.grid.awake(); ++i) heated.grid.Advance(0.5, {});
  }
  EXPECT_FALSE(heated.grid.awake());
  EXPECT_LT(heated.grid.figures().hottest_C, 37.1);
  EXPECT_GT(heated.grid.figures().peak_C, 40);
  ExpectBalance(heated.grid, 1e-5);
}

TEST(HeatGrid, InvalidHeatIsRejected) {
  Heated heated(test::MakeBox(Pose{}, Vec3(5), 0.3), {});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(heated.Put(Vec3(0), nan));
  EXPECT_FALSE(heated.Put(Vec3(0), -1));
  EXPECT_FALSE(heated.Put(Vec3(0), std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(heated.Put(Vec3(nan), 1));
  EXPECT_FALSE(heated.grid.awake());
  // Heat far from all bone is counted as carried away by chips.
  EXPECT_TRUE(heated.Put(Vec3(100), 1));
  heated.AdvanceFrames(2);
  EXPECT_EQ(heated.grid.CalcBalance().chips, 1);
  EXPECT_FALSE(heated.grid.awake());
}

}  // namespace
}  // namespace kerf
