// Structures: the distance against brute force, the warning at the margin, and reported breaches against the actual
// cut.
#include "cut/effects/structures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "cut/tool/shape.h"
#include "kerf/coupled.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "support/message_of.h"
#include "support/solids.h"

namespace kerf {
namespace {

Quat Turned(std::mt19937_64& random) {
  std::normal_distribution<double> n;
  return glm::normalize(Quat(n(random), n(random), n(random), n(random)));
}

/// Returns the smallest distance between any box and a fine grid of points on the tool's surface, or 0 if the centre of
/// a box is in the tool; a box's nearest point is found by clamping. A stroke is tried at many displacements.
double BruteForce(const std::vector<Box3>& boxes, const Tool& tool, const Pose& X) {
  const std::vector<Vec3> surface = SampleToolSurface(tool, 0.2);
  const double stroke_mm = CalcStroke(tool);
  const int places = 1 + static_cast<int>(std::ceil(stroke_mm / 0.2));
  std::vector<Vec3> slides;
  for (int i = 0; i < places; ++i)
    slides.push_back({0, places > 1 ? stroke_mm * (1.0 * i / (places - 1) - 0.5) : 0, 0});
  std::vector<Vec3> points;
  for (const Vec3& slide : slides) {
    for (const Vec3& p : surface) points.push_back(X.Point(p + slide));
  }
  double smallest = 1e300;
  for (const Box3& box : boxes) {
    const Vec3 c_T = X.InversePoint(box.centre());
    for (const Vec3& slide : slides) {
      if (FindNearestOfTool(tool, c_T - slide) == c_T - slide) return 0;
    }
    for (const Vec3& p : points) {
      const Vec3 q = glm::clamp(p, box.lower, box.upper);
      smallest = std::min(smallest, glm::length(p - q));
    }
  }
  return smallest;
}

class StructureDistanceOf : public testing::TestWithParam<Tool> {};

TEST_P(StructureDistanceOf, MatchesBruteForceFromAnyPose) {
  const Tool& saw = GetParam();
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> at(-12, 12);
  double largest = 0;
  for (int world = 0; world < 6; ++world) {
    // As many voxels as a canal has, either in a curved row or scattered.
    std::vector<Box3> boxes;
    for (int i = 0; i < 60; ++i) {
      const double t = 0.1 * i;
      const Vec3 c =
          world < 4 ? Vec3(3 * t - 9, 2 * std::sin(t), 0.3 * t * world) : Vec3(at(random), at(random), at(random));
      boxes.push_back({c - Vec3(0.15), c + Vec3(0.15)});
    }
    StructureDistance distance(boxes, saw);
    for (int i = 0; i < 12; ++i) {
      const Pose X{Turned(random), {at(random), at(random), at(random)}};
      const double found = distance.Find(X, 30).distance_mm;
      const double expected = BruteForce(boxes, saw, X);
      // The grid of points, 0.2 mm apart, overestimates small distances by up to 0.14 mm. The search must be accurate
      // to 0.02 mm or a tenth; it is much better than that.
      EXPECT_LE(found, expected + 0.02) << world << " " << i;
      EXPECT_GE(found, expected - 0.15) << world << " " << i;
      largest = std::max(largest, found - expected);
      // A new search, without earlier results, finds the same distance within the required accuracy.
      EXPECT_NEAR(StructureDistance(boxes, saw).Find(X, 30).distance_mm, found, 0.02);
    }
  }
  RecordProperty("largest_above_brute_force_um", std::to_string(1000 * largest));
}

INSTANTIATE_TEST_SUITE_P(Tools, StructureDistanceOf,
                         testing::Values(Tool(DiscSaw{}), Tool(FissureBur{.diameter_mm = 2.1, .length_mm = 8}),
                                         Tool(FissureBur{.diameter_mm = 6, .length_mm = 4, .point_angle_deg = 120}),
                                         Tool(FissureBur{.diameter_mm = 1, .length_mm = 30, .taper = 0.5}),
                                         Tool(ReciprocatingBlade{.length_mm = 14, .taper = 0.6, .set_mm = 0})));

TEST(StructureDistance, SearchForAMovingToolMatchesAFreshSearch) {
  const DiscSaw saw;
  std::vector<Box3> boxes;
  for (int i = 0; i < 300; ++i) {
    const Vec3 c(0.1 * i - 15, 1.5 * std::sin(0.05 * i), -14);
    boxes.push_back({c - Vec3(0.1), c + Vec3(0.1)});
  }
  StructureDistance moving(boxes, saw);
  double max_queries = 0;
  for (int i = 0; i < 2000; ++i) {
    Pose X{Quat(std::cos(0.0002 * i), std::sin(0.0002 * i), 0, 0), {0.002 * i - 2, 0, -0.0015 * i}};
    X.R_AB = glm::normalize(X.R_AB * Quat(std::sqrt(0.5), std::sqrt(0.5), 0, 0));
    const double found = moving.Find(X, 20).distance_mm;
    max_queries = std::max(max_queries, static_cast<double>(moving.queries()));
    if (i % 20 != 0) continue;
    EXPECT_NEAR(found, StructureDistance(boxes, saw).Find(X, 20).distance_mm, 0.02) << i;
  }
  EXPECT_LT(max_queries, 400);
}

// A tool of realistic thickness moves down onto and into a rough sheet, so that many patches are near many boxes. With
// few queries per call the distance is accurate to 0.1 mm, including contact.
TEST(StructureDistance, FollowsAToolWithFewQueries) {
  constexpr std::size_t kMax = 48;
  std::vector<Box3> boxes;
  for (int x = -60; x <= 60; ++x) {
    for (int y = -20; y <= 20; ++y) {
      const Vec3 c(0.2 * x, 0.2 * y, -12 + 0.2 * ((x * 7 + y * 3) % 2));
      boxes.push_back({c - Vec3(0.1), c + Vec3(0.1)});
    }
  }
  for (const double thickness_mm : {0.25, 3.0}) {
    DiscSaw saw;
    saw.thickness_mm = thickness_mm;
    StructureDistance moving(boxes, saw);
    const Quat upright(std::sqrt(0.5), std::sqrt(0.5), 0, 0);  // its axis along y
    for (int i = 0; i < 400; ++i) {
      const Pose X{upright, {0.001 * i, 0, 3 - 0.01 * i}};
      const double found = moving.Find(X, 20, kMax).distance_mm;
      EXPECT_LE(moving.queries(), kMax + 13);  // the limit may be exceeded by the queries of one patch
      if (i % 40 != 0) continue;
      EXPECT_NEAR(found, StructureDistance(boxes, saw).Find(X, 20).distance_mm, 0.1) << i;
    }
  }
}

TEST(StructureDistance, BallDistanceIsThatOfItsCentreMinusItsRadius) {
  const BallBurr ball;
  StructureDistance distance({{{-1, -1, -1}, {1, 1, 1}}}, ball);
  EXPECT_DOUBLE_EQ(distance.Find({{1, 0, 0, 0}, {9, 0, 0}}, 20).distance_mm, 9 - 1 - 3);
  EXPECT_DOUBLE_EQ(distance.Find({{1, 0, 0, 0}, {3.9, 0, 0}}, 20).distance_mm, 0);
  EXPECT_EQ(distance.Find({{1, 0, 0, 0}, {90, 0, 0}}, 20).distance_mm, 20);
}

/// A block of 20 x 8 x 16 mm with a square canal of 2 x 2 mm along x, from z = -1 to 1.
Bone MakeBlockWithCanal(double h) {
  SolidField field;
  const Vec3 half(10, 4, 8);
  field.value = [=](const Vec3& p) { return test::BoxDistance(p, half); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p) { return std::abs(p.y) < 1 && std::abs(p.z) < 1 ? 7 : 24; };
  MaterialTable table = test::OneRegionTable();
  table.Add({7, "nerve", Tissue::kCanal, 1000, 0.3, true, "test"});
  return MakeBone(field, Box3{-half, half}.Grown(6 * h), {h, h, {}}, table);
}

const Pose kStructuresAcross{Quat(std::sqrt(0.5), 0, std::sqrt(0.5), 0), Vec3(0)};  // spindle along x

TEST(Structures, WarnsAtItsMarginAndReportsTheBreach) {
  const double h = 0.1;  // the kerf is 2.5 voxels wide
  SimulationParams params;
  SetEffect(params.effects, "structures", "warn_mm", 2);
  const Bone bone = MakeBlockWithCanal(h);
  const double start_mm = 8 + 11 + 0.5;
  const auto at = [&](double z) {
    Pose X = kStructuresAcross;
    X.p_AB = {0.03, 0, z};
    return X;
  };
  Simulation simulation(bone, params, at(start_mm));
  const double before_mm3 = simulation.UpdateBone().CalcRegionVolumes().at(7);
  const auto& effect = dynamic_cast<const StructuresEffect&>(*EffectsOf(simulation).Find("structures"));
  std::array<double, 5> figures{};
  double warned_mm = -1, breached_mm = -100;
  const double step_mm = 0.004;
  for (double z = start_mm; z > 10; z -= step_mm) {
    simulation.Tick({at(z)});
    EffectsOf(simulation).Report(figures);
    const double gap_mm = z - 11 - 1;  // between the rim and the canal's top
    // The distance may be too large by the offset of the voxels' faces (half a voxel) plus the search's error, and too
    // small by the same amount plus the tool's motion since the last search.
    EXPECT_NEAR(figures[0], std::max(0.0, gap_mm), 0.51 * h + 0.02 + 0.01 * std::max(0.0, gap_mm)) << z;
    if (figures[1] > 0 && warned_mm < 0) warned_mm = gap_mm;
    if (figures[2] > 0 && breached_mm == -100) breached_mm = gap_mm;
  }
  EXPECT_NEAR(warned_mm, 2, 0.51 * h + 0.05);
  // Teeth are tested a twentieth of a voxel ahead, and a point has the label of the nearest voxel.
  EXPECT_NEAR(breached_mm, 0, h);
  ASSERT_GE(effect.events().size(), 2u);
  EXPECT_EQ(effect.events()[0].kind, StructureEvent::Kind::kNear);
  EXPECT_EQ(effect.events()[1].kind, StructureEvent::Kind::kBreach);
  EXPECT_NEAR(effect.events()[0].p_W_mm.z, 1, 0.51 * h);
  const double cut_mm3 = before_mm3 - simulation.UpdateBone().CalcRegionVolumes().at(7);
  EXPECT_GT(cut_mm3, 0.8);
  // The reported volume is each tick's volume times the fraction of its teeth in the canal; it differs from the exact
  // loss because the rim's arc in the canal lies slightly to the side of the deepest point, at which the tick removes
  // most.
  EXPECT_NEAR(figures[2], cut_mm3, 0.1 * cut_mm3);
  // The cut passes through a canal 2 mm wide: no tooth in it is further from other bone than half that width.
  EXPECT_NEAR(figures[3], 1, h);
  EXPECT_GT(figures[4], 0);
}

EffectFile MakeTube(const Vec3& a, const Vec3& b) {
  EffectFile file;
  file.place = "s.toml:3:1: ";
  file.name = "canal.mrk.json";
  file.curves.push_back({{a, b}, true});
  return file;
}

EffectFile MakeBoxSurface(const Vec3& half) {
  EffectFile file;
  file.place = "s.toml:4:1: ";
  file.name = "canal.stl";
  for (int i = 0; i < 8; ++i) {
    file.mesh.points.push_back(half * Vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1));
  }
  file.mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                         {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return file;
}

EffectChoice ChooseTube(const EffectFile& tube, double radius_mm) {
  EffectChoice choice("structures");
  choice.Set("tissues", std::string("none")).Set("radius_mm", radius_mm).SetFile("markups", tube);
  return choice;
}

TEST(Structures, OnlyObserves) {
  const auto cut = [](bool watched) {
    CoupledParams params;
    if (watched) {
      EffectChoice choice("structures");
      choice.SetFile("surface", MakeBoxSurface({12, 1, 2}));
      choice.Set("radius_mm", 0.8).SetFile("markups", MakeTube({-9, 2, 4}, {9, 2, 4}));
      params.effects.push_back(choice);
    }
    Pose X = kStructuresAcross;
    X.p_AB = {0, 0, 19.2};
    CoupledSimulation simulation(MakeBlockWithCanal(0.4), params, X);
    Vec3 sum(0);
    for (int i = 0; i < 2500; ++i) {
      X.p_AB.z = 19.2 - 0.004 * i;
      sum += simulation.Tick({.X_WH = X}).f_H_W_N;
    }
    return std::pair(sum, simulation.UpdateBone().CalcHash());
  };
  const auto with = cut(true);
  const auto without = cut(false);
  EXPECT_EQ(with.first, without.first);
  EXPECT_EQ(with.second, without.second);
}

TEST(Structures, BoneWithoutStructuresIsRefused) {
  SimulationParams params;
  params.effects.emplace_back("structures");
  EXPECT_THROW(Simulation(test::MakeBox(Pose{}, {4, 4, 4}, 0.4), params, kStructuresAcross), Error);
}

TEST(Structures, TubeDistanceIsThatOfItsAxisMinusItsRadius) {
  const double h = 0.2, radius_mm = 1.3;
  const Bone bone = test::MakeBox(Pose{}, {10, 4, 8}, h);
  const DiscSaw saw;
  struct Case {
    Vec3 a, b;
    Pose X;
    double axis_mm;  // distance from the disc to the tube's axis, closed form
  };
  const double rim_mm = saw.radius_mm(), half_mm = 0.5 * saw.thickness_mm;
  const Pose flat{Quat(1, 0, 0, 0), {0, 0, 13}};
  const Pose upright{kStructuresAcross.R_AB, {0, 0, 19}};
  const std::vector<Case> cases{
      // The flat above a tube parallel to it, and above a tube that leaves the bone.
      {{-6, 0, 2}, {6, 0, 2}, flat, 13 - half_mm - 2},
      {{-30, 1, 2}, {30, 1, 2}, flat, 13 - half_mm - 2},
      // The rim above a tube that runs across the disc, and above one that runs along it.
      {{-7, 0, 1}, {7, 0, 1}, upright, 19 - rim_mm - 1},
      {{0, -3, 1}, {0, 3, 1}, upright, 19 - rim_mm - 1},
      // The rim next to a tube's round end: distance from the disc's nearest corner.
      {{3, 0, -7}, {3, 0, 3}, upright, std::hypot(3 - half_mm, 19 - rim_mm - 3)},
      // A slanted tube under the flat: its upper end is nearest.
      {{-3, -2, -5}, {3, 2, 4}, flat, 13 - half_mm - 4},
  };
  for (const Case& c : cases) {
    SimulationParams params;
    params.tool = saw;
    params.effects.push_back(ChooseTube(MakeTube(c.a, c.b), radius_mm));
    Simulation simulation(bone, params, c.X);
    simulation.Tick({c.X});
    const auto& effect = dynamic_cast<const StructuresEffect&>(*EffectsOf(simulation).Find("structures"));
    // A voxel whose centre is just inside the tube extends at most half its diagonal out of it, and a voxel whose
    // centre is just outside leaves as much of the tube uncovered. The tolerance is therefore 0.87 voxels plus the
    // error of the search.
    EXPECT_NEAR(effect.distance_mm(), c.axis_mm - radius_mm, 0.87 * h + 0.02) << c.a.x << " " << c.a.y << " " << c.a.z;
    // The tube's volume is pi r^2 l + 4/3 pi r^3. A circle of 6.5 voxels radius about a voxel's centre contains 137
    // centres: 3.2 % too many.
    const double length_mm = glm::length(c.b - c.a);
    const double volume_mm3 = std::numbers::pi * radius_mm * radius_mm * (length_mm + 4 * radius_mm / 3);
    EXPECT_NEAR(effect.voxels().CalcVolume(), volume_mm3, 0.04 * volume_mm3);
  }
}

/// What the effect reports on a cut down through the block's canal, and the volume that the canal's region has lost.
struct CanalCut {
  std::vector<double> distance_mm;
  std::array<double, 5> figures{};
  double lost_mm3 = 0;
};
CanalCut CutThroughCanal(const EffectChoice& choice) {
  SimulationParams params;
  params.effects.push_back(choice);
  const auto at = [](double z) { return Pose{kStructuresAcross.R_AB, {0.03, 0, z}}; };
  Simulation simulation(MakeBlockWithCanal(0.1), params, at(19.5));
  const double before_mm3 = simulation.UpdateBone().CalcRegionVolumes().at(7);
  CanalCut cut;
  for (double z = 19.5; z > 10; z -= 0.01) {
    simulation.Tick({at(z)});
    EffectsOf(simulation).Report(cut.figures);
    cut.distance_mm.push_back(cut.figures[0]);
  }
  cut.lost_mm3 = before_mm3 - simulation.UpdateBone().CalcRegionVolumes().at(7);
  return cut;
}

TEST(Structures, CanalByRegionAndBySurfaceGivesTheSameReport) {
  const double h = 0.1;
  const CanalCut by_region = CutThroughCanal(EffectChoice("structures"));
  EffectChoice choice("structures");
  // The outer faces of the canal's voxels, slightly displaced.
  choice.Set("tissues", std::string("none")).SetFile("surface", MakeBoxSurface({10.3, 0.97, 0.93}));
  const CanalCut by_surface = CutThroughCanal(choice);
  ASSERT_EQ(by_region.distance_mm.size(), by_surface.distance_mm.size());
  for (std::size_t i = 0; i < by_region.distance_mm.size(); ++i) {
    EXPECT_NEAR(by_surface.distance_mm[i], by_region.distance_mm[i], h) << i;
  }
  EXPECT_GT(by_region.lost_mm3, 0.8);
  EXPECT_EQ(by_region.lost_mm3, by_surface.lost_mm3);
  // This is the accuracy of the breach's volume that docs/effects.md states.
  EXPECT_NEAR(by_surface.figures[2], by_surface.lost_mm3, 0.1 * by_surface.lost_mm3);
  EXPECT_NEAR(by_surface.figures[2], by_region.figures[2], 0.1 * by_region.figures[2]);
  EXPECT_NEAR(by_surface.figures[3], by_region.figures[3], h);
  EXPECT_NEAR(by_surface.figures[4], by_region.figures[4], 0.1 * by_region.figures[4]);
}

TEST(StructureVoxels, FillAClosedSurfaceInAnyOrientation) {
  // Lines along z cross a torus's surface up to four times.
  const double major = 6, minor = 2, h = 0.13;
  const Vec3 middle(0.031, -0.017, 0.4);
  EffectFile file;
  constexpr int kAround = 120, kAcrossIt = 60;
  const Quat tilt = glm::normalize(Quat(1, 0.6, 0.2, -0.1));
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcrossIt; ++j) {
      const double a = 2 * std::numbers::pi * i / kAround, b = 2 * std::numbers::pi * j / kAcrossIt;
      const double r = major + minor * std::cos(b);
      file.mesh.points.push_back(tilt * Vec3(r * std::cos(a), r * std::sin(a), minor * std::sin(b)) + middle);
    }
  }
  const auto index = [](int i, int j) { return static_cast<std::uint32_t>((i % kAround) * kAcrossIt + j % kAcrossIt); };
  for (int i = 0; i < kAround; ++i) {
    for (int j = 0; j < kAcrossIt; ++j) {
      file.mesh.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
      file.mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
    }
  }
  ASSERT_EQ(CountOpenEdges(file.mesh), 0u);
  StructureVoxels voxels(h), turned(h);
  voxels.AddSurface(file.mesh);
  for (auto& triangle : file.mesh.triangles) std::swap(triangle[0], triangle[1]);
  turned.AddSurface(file.mesh);
  voxels.Finish();
  turned.Finish();
  const double volume_mm3 = std::abs(CalcEnclosedVolume(file.mesh));
  EXPECT_NEAR(voxels.CalcVolume(), volume_mm3, 0.005 * volume_mm3);
  EXPECT_EQ(voxels.CalcVolume(), turned.CalcVolume());
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> at(-9, 9);
  int inside = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 p(at(random), at(random), at(random));
    const Vec3 q = glm::conjugate(tilt) * (p - middle);
    const double distance = std::hypot(std::hypot(q.x, q.y) - major, q.z) - minor;
    // 0.87 voxels is half a voxel's diagonal; 0.02 mm is the depth of the facets below the torus.
    if (std::abs(distance) < 0.87 * h + 0.02) continue;
    EXPECT_EQ(voxels.Contains(p), distance < 0) << p.x << " " << p.y << " " << p.z;
    EXPECT_EQ(voxels.Contains(p), turned.Contains(p));
    inside += distance < 0;
  }
  EXPECT_GT(inside, 500);
  // The faces enclose exactly the voxels.
  EXPECT_NEAR(CalcEnclosedVolume(voxels.MakeSurface()), voxels.CalcVolume(), 1e-6);
}

TEST(Structures, UnusableFilesAreRefused) {
  const auto refusal = [](const EffectChoice& choice) -> std::string {
    SimulationParams params;
    params.effects.push_back(choice);
    return test::MessageOf([&] { Simulation(MakeBlockWithCanal(0.4), params, kStructuresAcross); });
  };
  using ::testing::HasSubstr;
  EXPECT_EQ(refusal(ChooseTube(MakeTube({-5, 0, 2}, {5, 0, 2}), 0.5)), "");
  EXPECT_THAT(refusal(ChooseTube(MakeTube({-5, 0, 90}, {5, 0, 90}), 0.5)),
              HasSubstr("s.toml:3:1: canal.mrk.json: lies 82 mm away from the bone"));
  EXPECT_THAT(refusal(ChooseTube(MakeTube({-5, 0, 2}, {5, 0, 2}), 0.3)),
              HasSubstr("radius_mm = 0.3 is less than a voxel of the bone's regions, 0.4 mm"));
  EXPECT_THAT(refusal(ChooseTube(MakeTube({-5, 0, 2}, {5, 1e9, 2}), 0.5)), HasSubstr("extends beyond 1 km"));
  EXPECT_THAT(refusal(ChooseTube(MakeTube({-5, 0, 2}, {9e5, 9e5, 2}), 0.5)), HasSubstr("is too large for the voxels"));
  EffectChoice small("structures");
  small.SetFile("surface", MakeBoxSurface({0.01, 0.01, 0.01}));
  EXPECT_EQ(refusal(small), "");  // it contains the centre of the middle voxel
  EffectFile off = MakeBoxSurface(Vec3(0.01));
  for (Vec3& p : off.mesh.points) p += Vec3(0.2);
  small.SetFile("surface", off);
  EXPECT_THAT(refusal(small), HasSubstr("s.toml:4:1: canal.stl: is too small for the bone's regions"));
  EffectChoice nothing("structures");
  nothing.Set("tissues", std::string("none"));
  EXPECT_THAT(refusal(nothing), HasSubstr("tissues is \"none\", and neither surface nor markups is set"));
  EXPECT_THAT(refusal(ChooseTube(MakeTube({-5, 0, 2}, {5, 0, 2}), 0)), HasSubstr("markups needs radius_mm"));
  EffectChoice radius("structures");
  radius.Set("radius_mm", 1.0);
  EXPECT_THAT(refusal(radius), HasSubstr("radius_mm is not used"));
}

TEST(StructureVoxels, AreThoseOfTheRegionAndTheShellIsTheirNeighbours) {
  const double h = 0.5;
  const Bone bone = MakeBlockWithCanal(h);
  std::array<bool, 256> wanted{};
  wanted[7] = true;
  StructureVoxels voxels(h);
  voxels.AddRegions(bone, wanted);
  voxels.Finish();
  // Labels extend beyond the bone's faces where the canal comes out; air is not part of the structure.
  const auto is_canal = [&](const Vec3& p) { return bone.RegionAt(p) == 7 && bone.SignedDistance(p) < 0; };
  double volume_mm3 = 0;
  for (const Box3& box : voxels.MakeBoxes()) {
    const Vec3 size = box.size();
    volume_mm3 += size.x * size.y * size.z;
    // Tests the centres, voxel by voxel.
    for (double z = box.lower.z + 0.5 * h; z < box.upper.z; z += h) {
      EXPECT_TRUE(is_canal({box.centre().x, box.centre().y, z}));
    }
  }
  long count = 0;
  for (double x = -12; x <= 12; x += h) {
    for (double y = -6; y <= 6; y += h) {
      for (double z = -10; z <= 10; z += h) count += is_canal({x, y, z}) ? 1 : 0;
    }
  }
  EXPECT_GT(count, 100);
  EXPECT_NEAR(volume_mm3, static_cast<double>(count) * h * h * h, 1e-6);
  for (Box3 box : voxels.MakeShell()) {
    // The first voxel represents the whole run of voxels.
    box.upper.z = box.lower.z + h;
    EXPECT_FALSE(is_canal(box.centre()));
    bool beside = false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double offset : {-h, h}) {
        Vec3 p = box.centre();
        p[axis] += offset;
        beside = beside || is_canal(p);
      }
    }
    EXPECT_TRUE(beside);
  }
}

}  // namespace
}  // namespace kerf
