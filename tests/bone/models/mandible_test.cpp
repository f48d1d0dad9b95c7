#include "bone/models/mandible.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "bone/material/atlas.h"
#include "bone/material/region_table.h"
#include "bone/models/mandible_measures.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using namespace test;

constexpr double kVoxel_mm = 0.4;

/// The default bone, made once for all tests.
const Bone& DefaultBone() {
  static const Bone bone = [] {
    MandibleParams params;
    params.voxel_mm = kVoxel_mm;
    return MakeMandible(params, DefaultMandibleTable());
  }();
  return bone;
}

const MandibleShape& DefaultShape() {
  static const MandibleShape shape{MandibleParams{}};
  return shape;
}

/// Returns the bone of the voxel grid without the crowns; roots count as bone, because they fill it.
Field BoneOfGrid() {
  return [](const Vec3& p) {
    const double f = DefaultBone().SignedDistance(p);
    if (f >= 0) return f;
    return DefaultBone().RegionAt(p) == kToothRegion && DefaultShape().BoneValue(p) > 0 ? 1.0 : f;
  };
}

Field BoneOfShape(const MandibleShape& shape) {
  return [&shape](const Vec3& p) { return shape.BoneValue(p); };
}

TEST(Mandible, DefaultBoneHasAnatomicalDimensions) {
  const MandibleParams params;
  const MandibleLandmarks& l = DefaultShape().landmarks();
  const Field bone = BoneOfGrid();
  // Lengths on the grid are accurate to half a voxel at each end, and the side view to its step of 0.4 mm; the
  // tolerance is 0.8 mm unless stated otherwise.
  const double lingula_height = params.lingula_from_below * params.ramus_height_mm;
  const MandibleMeasures m = MeasureSide(SideView(bone), lingula_height);
  EXPECT_NEAR(m.gonial_angle_deg, 124.8, 2.0);  // from two points of a curved edge, 25 mm apart, each to half a step
  EXPECT_NEAR(m.ramus_height, 44.8, 1.0);
  EXPECT_NEAR(m.ramus_width, 31.3, 1.0);
  EXPECT_NEAR(m.coronoid_height, 59, 1.0);
  EXPECT_NEAR(m.condyle_height, 54, 1.0);

  EXPECT_NEAR(MeasureHeight(bone, {0, 6, 0}, {0, -1, 0}), 30, 1.2);  // the chin's tubercles protrude below
  EXPECT_NEAR(MeasureHeight(bone, l.mental_foramen, l.mental_foramen_out), 26.6, 0.8);
  EXPECT_NEAR(MeasureHeight(bone, l.first_molar, l.first_molar_out), 28.5, 0.8);
  const double to_buccal = WalkOut(bone, l.first_molar, l.first_molar_out);
  const double to_lingual = WalkOut(bone, l.first_molar, -l.first_molar_out);
  EXPECT_NEAR(to_buccal, 6.6 + 1.4, 0.5);
  EXPECT_NEAR(to_lingual, 4.1 + 1.4, 0.5);
  EXPECT_NEAR(to_buccal + to_lingual, 13.5, 0.6);
  EXPECT_NEAR(WalkOut(bone, l.first_molar, {0, 0, -1}), 8.8 + 1.4, 0.6);

  EXPECT_NEAR(2 * MeasureReach(bone, [](const Vec3& p) { return p.z < -12 && p.y > 50; }), 97, 1.0);
  EXPECT_NEAR(2 * MeasureReach(bone, [](const Vec3& p) { return p.z > 20; }), 118, 1.0);
  // The mental foramen is 25.2 to 25.9 mm from the midline.
  EXPECT_NEAR(l.mental_foramen.x, 25.5, 1.5);
}

TEST(Mandible, LingulaIsWhereTheParametersPlaceIt) {
  const MandibleShape& shape = DefaultShape();
  const MandibleParams params;
  const MandibleLandmarks& l = shape.landmarks();
  // The inner face of the ramus is sampled as a height field over (u from the back edge, height). A plane is fitted to
  // it, and the lingula is the point that protrudes most from this plane.
  const Vec3 up{0, l.base_line.z, -l.base_line.y};
  const Vec3 forward{0, -l.back_edge.z, l.back_edge.y};
  struct Sample {
    double u, h, x;
  };
  std::vector<Sample> samples;
  for (double u = 9; u <= 25; u += 0.25) {
    for (double h = 22; h <= 36; h += 0.25) {
      // The point in the side view with this u and height.
      const double along_edge = (h - u * glm::dot(forward, up)) / glm::dot(l.back_edge, up);
      Vec3 p = l.gonion + u * forward + along_edge * l.back_edge;
      double x = 25;
      while (x < 60 && shape.BoneValue({x, p.y, p.z}) > 0) x += 0.05;
      samples.push_back({u, h, x});
    }
  }
  glm::dvec3 mean{0};
  for (const Sample& s : samples) mean += glm::dvec3{s.u, s.h, s.x};
  mean /= static_cast<double>(samples.size());
  double uu = 0, hh = 0, uh = 0, ux = 0, hx = 0;
  for (const Sample& s : samples) {
    const double u = s.u - mean.x, h = s.h - mean.y, x = s.x - mean.z;
    uu += u * u, hh += h * h, uh += u * h, ux += u * x, hx += h * x;
  }
  const double det = uu * hh - uh * uh;
  const double a = (ux * hh - hx * uh) / det, b = (hx * uu - ux * uh) / det;
  Sample tip{};
  double best = 0;
  for (const Sample& s : samples) {
    const double out = mean.z + a * (s.u - mean.x) + b * (s.h - mean.y) - s.x;
    if (out > best) best = out, tip = s;
  }
  EXPECT_GT(best, 1.0);  // this is a tongue, not just a ripple
  // The tongue is 4 mm long and rounded.
  EXPECT_NEAR(tip.u / params.ramus_width_mm, 0.53, 0.05);
  EXPECT_NEAR(tip.h / params.ramus_height_mm, 0.65, 0.05);
}

TEST(Mandible, EachParameterChangesItsDimensionByTheSameAmount) {
  struct Case {
    const char* name;
    double MandibleParams::*parameter;
    double change;
    std::function<double(const MandibleShape&, const MandibleParams&)> measure;
    double tolerance;
  };
  const auto side = [](double MandibleMeasures::*value) {
    return [value](const MandibleShape& shape, const MandibleParams& p) {
      return MeasureSide(SideView(BoneOfShape(shape)), p.lingula_from_below * p.ramus_height_mm).*value;
    };
  };
  const auto molar = [](const Vec3& sign, bool canal_wall) {
    return [sign, canal_wall](const MandibleShape& shape, const MandibleParams& p) {
      const MandibleLandmarks& l = shape.landmarks();
      const Vec3 direction = sign.x * l.first_molar_out + Vec3{0, 0, sign.z};
      return WalkOut(BoneOfShape(shape), l.first_molar, direction) - (canal_wall ? 0.5 * p.canal_diameter_mm : 0);
    };
  };
  // The side view is accurate to its step of 0.4 mm at each end of a difference. A lower body meets the plate of the
  // ramus earlier, and their junction adds up to 0.5 mm below the first molar.
  const Case cases[] = {
      {"symphysis_height", &MandibleParams::symphysis_height_mm, 3,
       [](const MandibleShape& s, const MandibleParams&) {
         return MeasureHeight(BoneOfShape(s), {0, 6, 0}, {0, -1, 0});
       },
       0.3},
      {"mental_foramen_height", &MandibleParams::mental_foramen_height_mm, 3,
       [](const MandibleShape& s, const MandibleParams&) {
         return MeasureHeight(BoneOfShape(s), s.landmarks().mental_foramen, s.landmarks().mental_foramen_out);
       },
       0.3},
      {"first_molar_height", &MandibleParams::first_molar_height_mm, -3,
       [](const MandibleShape& s, const MandibleParams&) {
         return MeasureHeight(BoneOfShape(s), s.landmarks().first_molar, s.landmarks().first_molar_out);
       },
       0.5},
      {"first_molar_width", &MandibleParams::first_molar_width_mm, 2,
       [&](const MandibleShape& s, const MandibleParams& p) {
         return molar({1, 0, 0}, false)(s, p) + molar({-1, 0, 0}, false)(s, p);
       },
       0.3},
      {"ramus_height", &MandibleParams::ramus_height_mm, 4, side(&MandibleMeasures::ramus_height), 0.8},
      {"ramus_width", &MandibleParams::ramus_width_mm, 4, side(&MandibleMeasures::ramus_width), 0.8},
      {"gonial_angle", &MandibleParams::gonial_angle_deg, -8, side(&MandibleMeasures::gonial_angle_deg), 2},
      {"coronoid_height", &MandibleParams::coronoid_height_mm, 5, side(&MandibleMeasures::coronoid_height), 0.8},
      {"condyle_height", &MandibleParams::condyle_height_mm, 6, side(&MandibleMeasures::condyle_height), 0.8},
      {"bigonial", &MandibleParams::bigonial_mm, 8,
       [](const MandibleShape& s, const MandibleParams&) {
         return 2 * MeasureReach(BoneOfShape(s), [](const Vec3& p) { return p.z < -12 && p.y > 50; });
       },
       1.5},
      {"bicondylar", &MandibleParams::bicondylar_mm, 8,
       [](const MandibleShape& s, const MandibleParams&) {
         return 2 * MeasureReach(BoneOfShape(s), [](const Vec3& p) { return p.z > 24; });
       },
       0.5},
      {"canal_to_buccal", &MandibleParams::canal_to_buccal_mm, 1, molar({1, 0, 0}, true), 0.2},
      {"canal_to_base", &MandibleParams::canal_to_base_mm, 2, molar({0, 0, -1}, true), 0.2},
  };
  for (const Case& c : cases) {
    MandibleParams changed;
    changed.*c.parameter += c.change;
    const MandibleShape shape(changed);
    EXPECT_NEAR(c.measure(shape, changed) - c.measure(DefaultShape(), MandibleParams{}), c.change, c.tolerance)
        << c.name;
  }
}

TEST(Mandible, IsOnePieceWithAnyNumberOfTeeth) {
  for (const int teeth : {0, 14, 16}) {
    MandibleParams params;
    params.teeth = teeth;
    params.voxel_mm = 0.6;
    const Pieces pieces = SplitPieces(teeth == 14 ? DefaultBone() : MakeMandible(params, DefaultMandibleTable()));
    EXPECT_EQ(pieces.pieces.size(), 1u) << teeth;
    EXPECT_EQ(pieces.dust_count, 0u) << teeth;
  }
}

TEST(Mandible, HasThePlausibleVolumeAndBox) {
  // Whole mandibles have 42 cm3 (Visible Human, 7 teeth) or 57.6 cm3 (dynjaw); larger ones reach about 80 cm3.
  EXPECT_GT(DefaultBone().CalcVolume(), 45e3);
  EXPECT_LT(DefaultBone().CalcVolume(), 80e3);
  const Vec3 size = DefaultBone().CalcBounds().size();
  // The Visible Human's mandible measures 120 x 88 x 82 mm, and dynjaw's 118 x 87 x 77 mm.
  EXPECT_NEAR(size.x, 119, 3);
  EXPECT_NEAR(size.y, 88, 5);
  EXPECT_NEAR(size.z, 79, 5);
}

TEST(Mandible, EveryRegionOccursAndTheirVolumesAddUp) {
  const std::map<int, double> volumes = DefaultBone().CalcRegionVolumes();
  double sum = 0;
  for (const auto& [id, volume] : volumes) sum += volume;
  EXPECT_NEAR(sum, DefaultBone().CalcVolume(), 1e-6 * sum);
  for (int id = 1; id <= kCanalRegion; ++id)
    EXPECT_GT(volumes.count(id) ? volumes.at(id) : 0, 10) << "region " << id << " in mm3";
  EXPECT_LT(volumes.count(0) ? volumes.at(0) : 0, 1) << "mm3 of bone without a material";
  // Only about half of the bone is cancellous, because the walls are thick.
  EXPECT_GT(volumes.at(kCancellousRegion), 0.2 * sum);
  EXPECT_LT(volumes.at(kCancellousRegion), 0.6 * sum);
}

TEST(Mandible, BuccalCortexAtTheFirstMolarPassesThePapersRegionsInTheirBands) {
  const MandibleShape& shape = DefaultShape();
  const MandibleLandmarks& l = shape.landmarks();
  const Field bone = BoneOfShape(shape);
  for (const double side : {1.0, -1.0}) {
    for (const double face : {1.0, -1.0}) {
      double base = 1e9, crest = -1e9;
      std::vector<std::pair<int, double>> bands;
      for (double z = 5; z > -45; z -= 0.05) {
        // The outermost point of the bone at this height, slightly inside.
        double n = face * 14;
        while (face * n > -14 && bone(Vec3{l.first_molar.x, l.first_molar.y, z} + n * l.first_molar_out) > -0.3)
          n -= face * 0.1;
        if (face * n <= -14) continue;
        const Vec3 p = Vec3{l.first_molar.x, l.first_molar.y, z} + n * l.first_molar_out;
        base = std::min(base, z), crest = std::max(crest, z);
        const int region = shape.RegionAt({side * p.x, p.y, p.z});
        if (region > 31) continue;  // a root is visible through the thin crest
        if (bands.empty() || bands.back().first != region) bands.emplace_back(region, z);
      }
      std::vector<int> order;
      for (const auto& [region, z] : bands) order.push_back(region);
      ASSERT_EQ(order, (std::vector<int>{24, 21, 13, 6})) << side << " " << face;
      for (std::size_t i = 1; i < 4; ++i) {
        // The atlas computes the crest and the base from points 2 mm apart, so they may be off by 1 mm of about 28 mm.
        EXPECT_NEAR((crest - bands[i].second) / (crest - base), MandibleAtlas::kBodyBands[i], 0.06) << i;
      }
    }
  }
}

TEST(Mandible, CortexIsAsThickAsStated) {
  const MandibleShape& shape = DefaultShape();
  const MandibleLandmarks& l = shape.landmarks();
  const Field bone = BoneOfShape(shape);
  const auto region = [&](const Vec3& p) { return shape.RegionAt(p); };
  const auto cortex = [&](const Vec3& inside, const Vec3& outward) {
    return MeasureCortex(bone, region, inside, outward);
  };
  const Vec3 at = l.first_molar;
  // Measured along a ray that meets the surface slightly obliquely; the field is a distance to within a few percent.
  EXPECT_NEAR(cortex(at, l.first_molar_out), 2.2, 0.25);
  EXPECT_NEAR(cortex(at, -l.first_molar_out), 2.0, 0.25);
  EXPECT_NEAR(cortex({0, 7, -24}, {0, -1, 0}), 3.7, 0.4);
  EXPECT_GT(cortex(at, {0, 0, -1}), 2.5);  // the cortex is thickest along the lower border
  const Vec3 behind = l.mandibular_foramen + Vec3{2.5, 4, 4};
  EXPECT_NEAR(cortex(behind, {1, 0, 0}), 1.4, 0.25);
  MandibleParams thick;
  thick.cortex_buccal_mm += 0.8;
  const MandibleShape other(thick);
  EXPECT_NEAR(MeasureCortex(
                  BoneOfShape(other), [&](const Vec3& p) { return other.RegionAt(p); }, at, l.first_molar_out) -
                  cortex(at, l.first_molar_out),
              0.8, 0.2);
}

TEST(Mandible, TheCanalIsATubeOfItsDiameterInsideTheBone) {
  const MandibleShape& shape = DefaultShape();
  const MandibleLandmarks& l = shape.landmarks();
  // The canal's cross-section is measured by regions; horizontally, the canal is cut at a right angle.
  double width = 0, height = 0;
  for (double s = -3; s <= 3; s += 0.01) {
    width += shape.RegionAt(l.first_molar + s * l.first_molar_out) == kCanalRegion ? 0.01 : 0;
    height += shape.RegionAt(l.first_molar + Vec3{0, 0, s}) == kCanalRegion ? 0.01 : 0;
  }
  EXPECT_NEAR(width, 2.8, 0.15);
  EXPECT_NEAR(height, 2.8, 0.15);
  // The canal is inside the bone everywhere except at its two openings.
  std::mt19937 random(2);
  std::uniform_real_distribution<double> x(10, 60), y(5, 80), z(-40, 20);
  int inside = 0;
  for (int n = 0; n < 400000; ++n) {
    const Vec3 p{x(random), y(random), z(random)};
    if (shape.CanalValue(p) > 0) continue;
    ++inside;
    if (glm::distance(p, l.mental_foramen) < 4 || glm::distance(p, l.mandibular_foramen) < 5) continue;
    EXPECT_LT(shape.BoneValue(p), -0.4) << p.x << " " << p.y << " " << p.z;
    EXPECT_GT(shape.ToothValue(p), 0) << p.x << " " << p.y << " " << p.z;
  }
  // The canal's volume is that of a tube about 65 mm long.
  const double volume = inside / 400000.0 * 50 * 75 * 60;
  EXPECT_NEAR(volume, std::numbers::pi * 1.4 * 1.4 * 65, 0.2 * std::numbers::pi * 1.4 * 1.4 * 65);
}

TEST(Mandible, LeftAndRightMirrorEachOther) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> x(0, 62), y(-5, 95), z(-45, 42);
  for (int n = 0; n < 20000; ++n) {
    const Vec3 p{x(random), y(random), z(random)};
    const Vec3 q{-p.x, p.y, p.z};
    EXPECT_EQ(DefaultShape().Value(p), DefaultShape().Value(q));
    // The distance is computed by sweeps in an order that is not mirror-symmetric.
    EXPECT_NEAR(DefaultBone().SignedDistance(p), DefaultBone().SignedDistance(q), 0.05 * kVoxel_mm);
  }
  const double left = DefaultBone().CalcBounds().upper.x;
  EXPECT_NEAR(left, -DefaultBone().CalcBounds().lower.x, 0.05 * kVoxel_mm);
}

void ExpectBallsReported(const MandibleShape& shape) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> x(-70, 70), y(-15, 105), z(-55, 55), size(0.3, 9);
  std::normal_distribution<double> normal;
  int reported = 0;
  for (int n = 0; n < 25000; ++n) {
    const Vec3 centre{x(random), y(random), z(random)};
    const double f = shape.Value(centre);
    // Every other radius is the largest with which the block can be classified; there an error is most likely.
    const double radius = n % 2 ? size(random) : std::max(0.2, (std::abs(f) - 0.16) / 1.21);
    const BlockClass said = shape.Classify(centre, radius);
    if (said == BlockClass::kMixed || radius > 25) continue;
    ++reported;
    for (int k = 0; k < 60; ++k) {
      const Vec3 direction = glm::normalize(Vec3{normal(random), normal(random), normal(random)});
      const double value = shape.Value(centre + radius * (k % 3 ? 1.0 : 0.6) * direction);
      if (said == BlockClass::kOutside) {
        ASSERT_GT(value, 0) << centre.x << " " << centre.y << " " << centre.z << " r " << radius;
      } else {
        ASSERT_LT(value, 0) << centre.x << " " << centre.y << " " << centre.z << " r " << radius;
      }
    }
  }
  EXPECT_GT(reported, 3000);
}

/// Neighbouring sections are as different as possible.
MandibleParams UnevenParams() {
  MandibleParams uneven;
  uneven.symphysis_height_mm = 36;
  uneven.mental_foramen_height_mm = 22;
  uneven.first_molar_height_mm = 34;
  uneven.first_molar_width_mm = 16;
  uneven.ramus_width_mm = 25;
  uneven.bigonial_mm = 108;
  uneven.teeth = 16;
  return uneven;
}

TEST(Mandible, ClassificationOfBallsIsCorrect) {
  ExpectBallsReported(DefaultShape());
  ExpectBallsReported(MandibleShape(UnevenParams()));
}

/// Returns random points near the bone.
std::vector<Vec3> DrawPoints(const MandibleShape& shape, std::size_t count, std::mt19937_64& random) {
  std::vector<Vec3> points;
  std::uniform_real_distribution<double> unit(0, 1);
  const Box3 box = shape.bounds();
  while (points.size() < count) {
    const Vec3 p = box.lower + Vec3(unit(random), unit(random), unit(random)) * box.size();
    if (std::abs(shape.Value(p)) < 6) points.push_back(p);
  }
  return points;
}

TEST(Mandible, PartsNearABallGiveTheSameValuesInIt) {
  for (const MandibleParams& params : {MandibleParams(), UnevenParams()}) {
    const MandibleShape shape(params);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> unit(0, 1);
    std::normal_distribution<double> normal;
    int pruned = 0;
    for (const Vec3& centre : DrawPoints(shape, 3000, random)) {
      const double radius = 0.1 + 2.4 * unit(random);
      const MandibleParts parts = shape.FindParts(centre, radius);
      pruned += parts.oblique_line && parts.openings && parts.lingula ? 0 : 1;
      for (int k = 0; k < 20; ++k) {
        const Vec3 direction = glm::normalize(Vec3{normal(random), normal(random), normal(random)});
        const Vec3 p = centre + radius * std::cbrt(unit(random)) * direction;
        ASSERT_EQ(shape.Value(p, parts), shape.Value(p)) << p.x << " " << p.y << " " << p.z << " r " << radius;
        const double part = 0.6 * radius;
        ASSERT_EQ(shape.Classify(p, part, parts), shape.Classify(p, part)) << p.x << " " << p.y << " " << p.z;
      }
    }
    EXPECT_GT(pruned, 500);  // otherwise this tests nothing
  }
}

TEST(Mandible, RegionsOfALeafAreThoseOfItsPoints) {
  // The cortex changes as fast as it can where it is thick at the chin and thin behind, or the reverse, in a low body.
  MandibleParams thick_chin;
  thick_chin.symphysis_height_mm = 24;
  thick_chin.mental_foramen_height_mm = 21;
  thick_chin.cortex_front_mm = 5;
  thick_chin.cortex_buccal_mm = thick_chin.cortex_lingual_mm = 1;
  MandibleParams thin_chin = thick_chin;
  thin_chin.cortex_front_mm = 1.5;
  thin_chin.cortex_buccal_mm = thin_chin.cortex_lingual_mm = 4;
  for (const MandibleParams& params : {MandibleParams(), UnevenParams(), thick_chin, thin_chin}) {
    const MandibleShape shape(params);
    std::mt19937_64 random(8);
    std::array<int, 256> count{};
    bool fine = false;
    for (const Vec3& p : DrawPoints(shape, 150, random)) {
      fine = !fine;
      const double voxel_mm = fine ? 0.2 : 0.37;
      LeafPlace leaf{{}, voxel_mm};
      for (int axis = 0; axis < 3; ++axis) {
        leaf.first[static_cast<std::size_t>(axis)] = 8 * static_cast<int>(std::floor(p[axis] / (8 * voxel_mm)));
      }
      WantedVoxels wanted;
      for (std::size_t n = 0; n < wanted.size(); ++n) wanted[n] = random() % 4 != 0;
      constexpr int kUntouched = 1000;
      LeafRegions ids;
      ids.fill(kUntouched);
      shape.SetRegions(leaf, wanted, ids);
      for (int n = 0; n < kLeafVoxels; ++n) {
        const auto at = static_cast<std::size_t>(n);
        if (!wanted[at]) {
          ASSERT_EQ(ids[at], kUntouched);
          continue;
        }
        const Vec3 voxel = leaf.CalcPosition(n);
        const int region = ids[at] == kRegionByPlace ? shape.CortexRegionAt(voxel) : ids[at];
        ASSERT_EQ(region, shape.RegionAt(voxel)) << voxel.x << " " << voxel.y << " " << voxel.z;
        ++count[static_cast<std::size_t>(region)];
      }
    }
    EXPECT_GT(count[kToothRegion], 1000);
    EXPECT_GT(count[kCancellousRegion], 1000);
    EXPECT_GT(count[kCanalRegion], 0);
  }
}

TEST(Mandible, IsDeterministic) {
  MandibleParams params;
  params.voxel_mm = 0.8;
  const std::uint64_t first = MakeMandible(params, DefaultMandibleTable()).CalcHash();
  EXPECT_EQ(MakeMandible(params, DefaultMandibleTable()).CalcHash(), first);
  params.first_molar_width_mm += 0.5;
  EXPECT_NE(MakeMandible(params, DefaultMandibleTable()).CalcHash(), first);
}

TEST(Mandible, EachParameterAcceptsTheEndsOfItsRangeAndRefusesValuesBeyond) {
  const auto message = [](const MandibleParams& p) -> std::string {
    return test::MessageOf(
        [&] {
          MandibleShape shape(p);
          // There is bone around the canal for all parameters.
          EXPECT_LT(shape.BoneValue(shape.landmarks().first_molar), 0);
        },
        "accepted");
  };
  const MandibleParams defaults;
  MandibleParams p;
  std::vector<std::string> keys;
  Describe(p, [&](const char* key, auto&, Range, const char*) { keys.push_back(key); });
  EXPECT_GE(keys.size(), 25u);
  for (const std::string& key : keys) {
    for (int end = 0; end < 4; ++end) {
      MandibleParams changed = defaults;
      Range range{0, 0};
      Describe(changed, [&](const char* k, auto& value, Range r, const char*) {
        if (key != k) return;
        range = r;
        const double v = end == 0 ? r.lower : end == 1 ? r.upper : end == 2 ? r.lower - 1 : r.upper + 1;
        value = static_cast<std::decay_t<decltype(value)>>(v);
      });
      if (key == "voxel_mm" && end < 2) continue;
      const std::string said = message(changed);
      if (end >= 2) {
        EXPECT_THAT(said, testing::HasSubstr("mandible: " + key)) << key;
        EXPECT_THAT(said, testing::HasSubstr("valid range")) << key;
      } else if (said != "accepted") {
        // The two parameters contradict each other, which is reported.
        EXPECT_THAT(said, testing::AnyOf(testing::HasSubstr("the notch"), testing::HasSubstr("lingual side"))) << key;
      }
    }
  }
  p = {};
  p.teeth = 7;
  EXPECT_EQ(message(p), "mandible: teeth = 7 is not 0, 14 or 16");
  p = {};
  p.ramus_width_mm = std::nan("");
  EXPECT_EQ(message(p), "mandible: ramus_width_mm = nan is not a finite number; valid range 24 to 38 mm");
  MaterialTable table;
  table.Add({1, "a", Tissue::kCortical, 1e4, 0.3, true, "s"});
  EXPECT_THAT([&] { MakeMandible({}, table); }, testing::ThrowsMessage<Error>(testing::HasSubstr("has no region 2;")));
}

}  // namespace
}  // namespace kerf
