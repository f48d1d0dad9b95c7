// Properties of the cutter: the removal rule, exact volumes, no heap use, and bit-identical results everywhere.
#include "cut/removal/cutter.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

#include "base/core/heap_guard.h"
#include "cut/removal/carve.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"
#include "strokes.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using test::CutAll;
using test::Step;
using test::StrokeKind;

constexpr double kVoxel = 0.2;

/// Makes a block of two materials in a skewed pose.
Bone MakeLayeredBlock() {
  const Pose X_WB = test::BlockPoses(kVoxel)[5];
  const Vec3 size(7, 6, 6);
  SolidField solid;
  solid.value = [=](const Vec3& p) { return test::BoxDistance(X_WB.InversePoint(p), 0.5 * size); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [=](const Vec3& p) { return X_WB.InversePoint(p).z > 0.3 ? 24 : 32; };
  MaterialTable table = test::OneRegionTable(24);
  table.Add({32, "cancellous", Tissue::kCancellous, 1370, 0.3, true, "test"});
  const Box3 box{X_WB.p_AB - Vec3(6), X_WB.p_AB + Vec3(6)};
  return MakeBone(solid, box.Grown(1), {kVoxel, 0.3, {}}, table);
}

struct CutCase {
  const char* name;
  Tool tool;
  CutWith with;
  bool whole_voxels;
};

std::vector<CutCase> Cases() {
  DiscSaw thin;
  thin.diameter_mm = 12;
  DiscSaw thick;
  thick.diameter_mm = 8;
  thick.thickness_mm = 1;
  BallBurr ball;
  ball.diameter_mm = 3;
  FissureBur bur;
  bur.diameter_mm = 3;
  bur.length_mm = 5;
  bur.taper = 0.8;
  bur.point_angle_deg = 120;
  return {{"bur", bur, CutWith::kEdge, false},
          {"bur by whole voxels", bur, CutWith::kWholeTool, true},
          {"thin disc", thin, CutWith::kWholeTool, false},
          {"thick disc", thick, CutWith::kWholeTool, false},
          {"rim of a thick disc", thick, CutWith::kEdge, false},
          {"ball", ball, CutWith::kWholeTool, false},
          {"rim by whole voxels", thin, CutWith::kEdge, true},
          {"ball by whole voxels", ball, CutWith::kEdge, true}};
}

std::vector<Step> StepsOf(const CutCase& what, unsigned seed) {
  std::mt19937 random(seed);
  return test::DrawSteps(random, what.tool, StrokeKind::kFree, kVoxel, 4, 30);
}

struct Outcome {
  std::uint64_t hash = 0;
  double removed_mm3 = 0;
  std::vector<double> by_step;
};

Outcome CutCopy(const Bone& initial, const CutCase& what, const std::vector<Step>& steps) {
  Bone bone = initial;
  BoneField field(bone, 4096);
  Cutter cutter(field, what.tool, what.with, what.whole_voxels);
  Outcome outcome;
  for (const Step& step : steps) {
    if (step.lifted) cutter.Lift();
    outcome.by_step.push_back(cutter.Cut(step.X_from, step.X_to).removed_mm3);
  }
  outcome.removed_mm3 = std::accumulate(outcome.by_step.begin(), outcome.by_step.end(), 0.0);
  field.Settle();
  outcome.hash = bone.CalcHash();
  return outcome;
}

TEST(Cutter, IsTheSameBitForBitFromRunToRunAndAtEveryVectorWidth) {
  const Bone bone = MakeLayeredBlock();
  ASSERT_GE(VectorTargets().size(), 2u);
  for (const CutCase& what : Cases()) {
    const auto steps = StepsOf(what, 3);
    SetVectorTarget("");
    const Outcome best = CutCopy(bone, what, steps);
    EXPECT_GT(best.removed_mm3, 1) << what.name;
    EXPECT_NE(best.hash, bone.CalcHash());
    for (const std::string& target : VectorTargets()) {
      SetVectorTarget(target);
      EXPECT_EQ(VectorTarget(), target);
      const Outcome other = CutCopy(bone, what, steps);
      EXPECT_EQ(other.hash, best.hash) << what.name << ", " << target;
      EXPECT_EQ(other.by_step, best.by_step) << what.name << ", " << target;
    }
    SetVectorTarget("");
  }
}

TEST(Cutter, UnknownVectorInstructionsAreRefusedByName) {
  EXPECT_EQ(test::MessageOf([] { SetVectorTarget("mmx"); }).substr(0, 52),
            "this machine has no vector instructions \"mmx\"; it ha");
  EXPECT_EQ(VectorTarget(), VectorTargets()[0]);
}

TEST(Cutter, RepeatedMotionRemovesNothingMore) {
  for (const CutCase& what : Cases()) {
    Bone bone = MakeLayeredBlock();
    BoneField field(bone, 4096);
    const auto steps = StepsOf(what, 4);
    Cutter cutter(field, what.tool, what.with, what.whole_voxels);
    EXPECT_GT(CutAll(cutter, steps), 1) << what.name;
    const std::uint64_t hash = bone.CalcHash();
    EXPECT_EQ(CutAll(cutter, steps), 0) << what.name;
    Cutter another(field, what.tool, what.with, what.whole_voxels);
    EXPECT_EQ(CutAll(another, steps), 0) << what.name;
    EXPECT_EQ(bone.CalcHash(), hash);
  }
}

TEST(Cutter, OrderOfCutsDoesNotMatter) {
  const Bone bone = MakeLayeredBlock();
  for (const CutCase& what : Cases()) {
    auto first = StepsOf(what, 5);
    auto second = StepsOf(what, 6);
    auto ab = first;
    ab.insert(ab.end(), second.begin(), second.end());
    second.insert(second.end(), first.begin(), first.end());
    EXPECT_EQ(CutCopy(bone, what, ab).hash, CutCopy(bone, what, second).hash) << what.name;
  }
}

TEST(Cutter, BoneBeyondTheBandIsUntouched) {
  Bone initial = MakeLayeredBlock();
  const BoneField initial_field(initial, 1);
  for (const CutCase& what : Cases()) {
    Bone bone = initial;
    BoneField field(bone, 4096);
    Cutter cutter(field, what.tool, what.with, what.whole_voxels);
    const auto steps = StepsOf(what, 7);
    CutAll(cutter, steps);
    const std::optional<RoundSolid> solid = CalcRoundSolid(what.tool);
    const auto faces = solid.value_or(RoundSolid{}).CalcFaces();
    double nearest = 0;
    int changed = 0;
    for (int i = 0; i < 60 * 60 * 60; ++i) {
      const Vec3 p_vox = Vec3(i / 3600, i / 60 % 60, i % 60) - 30.0;
      if (field.Sample(p_vox) == initial_field.Sample(p_vox)) continue;
      const Vec3 p_W = kVoxel * p_vox;
      ++changed;
      double distance = 1e9;
      for (const Step& step : steps) {
        for (const Pose* X : {&step.X_from, &step.X_to}) {
          const Vec3 p_T = X->InversePoint(p_W);
          double of_bur = -1e9;
          if (const auto* disc = std::get_if<DiscSaw>(&what.tool)) {
            const double r = std::max(glm::length(glm::dvec2(p_T)) - disc->radius_mm(), 0.0);
            const double z = std::max(std::abs(p_T.z) - 0.5 * disc->thickness_mm, 0.0);
            distance = std::min(distance, std::sqrt(r * r + z * z));
          } else if (solid) {
            // The cutter's distance from a bur is that from the furthest of its faces.
            for (const RoundSolid::Face& face : faces) {
              of_bur = std::max(of_bur, face.CalcDistance(glm::length(glm::dvec2(p_T)), p_T.z));
            }
            distance = std::min(distance, of_bur);
          } else {
            distance = std::min(distance, glm::length(p_T) - CalcReach(what.tool));
          }
        }
      }
      nearest = std::max(nearest, distance);
    }
    // Between the ends of a step, which are half a voxel apart in the disc's plane and a quarter along the spindle, the
    // tool is nearer than at either end by less than the distance between them.
    EXPECT_LE(nearest, bone.band_mm() + 0.75 * kVoxel) << what.name;
    EXPECT_GT(changed, 100) << what.name;
  }
}

TEST(Cutter, RemovedByRegionIsExactlyWhatTheBoneHasLost) {
  const Bone initial = MakeLayeredBlock();
  const auto before = initial.CalcRegionVolumes();
  for (const CutCase& what : Cases()) {
    Bone bone = initial;
    BoneField field(bone, 4096);
    Cutter cutter(field, what.tool, what.with, what.whole_voxels);
    const auto steps = StepsOf(what, 8);
    // The removed volume is queried halfway and the bookkeeping is settled there, so that leaves are registered more
    // than once.
    const std::vector<Step> head(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
    const std::vector<Step> tail(steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    CutAll(cutter, head);
    cutter.CalcRemovedByRegion();
    field.Settle();
    CutAll(cutter, tail);
    const auto& removed = cutter.CalcRemovedByRegion();
    field.Settle();
    const auto after = bone.CalcRegionVolumes();
    for (const int region : {24, 32}) {
      const auto left = after.find(region);
      // The same cells are summed in a different order, so only rounding differs.
      EXPECT_NEAR(removed[static_cast<std::size_t>(region)] + (left == after.end() ? 0 : left->second),
                  before.at(region), 1e-9 * before.at(region))
          << what.name;
    }
    const double sum = std::accumulate(removed.begin(), removed.end(), 0.0);
    EXPECT_NEAR(sum + bone.CalcVolume(), initial.CalcVolume(), 1e-9 * initial.CalcVolume()) << what.name;
  }
}

TEST(Cutter, BoneLeftForLackOfLeavesIsRemovedAfterARefill) {
  const Bone initial = MakeLayeredBlock();
  for (const CutCase& what : Cases()) {
    const auto steps = StepsOf(what, 9);
    Bone plenty_bone = initial;
    BoneField plenty(plenty_bone, 4096);
    Cutter plenty_cutter(plenty, what.tool, what.with, what.whole_voxels);
    const double plenty_removed = CutAll(plenty_cutter, steps);
    Bone bone = initial;
    BoneField field(bone, 2);
    Cutter cutter(field, what.tool, what.with, what.whole_voxels);
    int refills = 0;
    double removed = 0;
    for (const Step& step : steps) {
      if (step.lifted) cutter.Lift();
      cutter.CalcRemovedByRegion();  // from here on, the old values of what is already cut have to be kept again
      for (;;) {
        const Cutter::Result result = cutter.Cut(step.X_from, step.X_to);
        removed += result.removed_mm3;
        if (!result.out_of_leaves) break;
        ++refills;
        field.Refill(2);
      }
    }
    EXPECT_GT(refills, 0) << what.name;
    const auto& by_region = cutter.CalcRemovedByRegion();
    field.Settle();
    EXPECT_NEAR(std::accumulate(by_region.begin(), by_region.end(), 0.0) + bone.CalcVolume(), initial.CalcVolume(),
                1e-9 * initial.CalcVolume());
    // If a rim starts inside solid bone, a repeated step removes other parts of the bone around its flats.
    if (what.with == CutWith::kEdge && std::holds_alternative<DiscSaw>(what.tool)) continue;
    // In a repeated step all cutting parts of the tool are tested, which means that the flats have moved less far
    // since they last cut.
    double worst = 0;
    for (int i = 0; i < 60 * 60 * 60; ++i) {
      const Vec3 p_vox = Vec3(i / 3600, i / 60 % 60, i % 60) - 30.0;
      worst = std::max(worst, std::abs(field.Sample(p_vox) - plenty.Sample(p_vox)));
    }
    // Even the smallest difference may decide whether a whole voxel is removed.
    EXPECT_LE(worst, what.whole_voxels ? kVoxel + 1e-6 : Cutter::kFlankTolerance * kVoxel + 1e-6) << what.name;
    EXPECT_NEAR(removed, plenty_removed, 0.01 * plenty_removed) << what.name;
  }
}

TEST(Cutter, CuttingUsesNoHeap) {
  for (const CutCase& what : Cases()) {
    Bone bone = MakeLayeredBlock();
    BoneField field(bone, 4096);
    Cutter cutter(field, what.tool, what.with, what.whole_voxels);
    const auto steps = StepsOf(what, 10);
    bool is_new_list = false;
    const HeapUseCounter heap_uses;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      const Step& step = steps[i];
      // From then on, the old values of what was cut are kept again.
      if (i % 8 == 7) cutter.CalcRemovedByRegion();
      const HeapGuard guard;
      const std::int64_t uses = heap_uses.count();
      if (step.lifted) cutter.Lift();
      EXPECT_FALSE(cutter.Cut(step.X_from, step.X_to).out_of_leaves);
      is_new_list = is_new_list || (cutter.effort().is_new_list && !step.lifted);
      EXPECT_EQ(heap_uses.count(), uses) << what.name;
    }
    EXPECT_TRUE(is_new_list) << what.name;
    EXPECT_LT(field.spare_leaves(), 4096);
  }
}

TEST(Cutter, PhiInBoneIsTheDistanceToTheSweptSpace) {
  // The tool moves around three corners in one plane, in pure bone: the distance to the union is the minimum over its
  // parts.
  Bone bone = test::MakeBox(Pose{}, {16, 16, 8}, kVoxel);
  BoneField field(bone, 4096);
  DiscSaw disc;
  disc.diameter_mm = 6;
  disc.thickness_mm = 0.45;
  Cutter cutter(field, disc, CutWith::kEdge);
  Pose X;
  X.R_AB = glm::angleAxis(0.4, glm::normalize(Vec3(1, 2, 0.3)));
  const std::vector<Vec3> corners_T = {{0, 14, 0}, {0, 2, 0}, {1.5, 0.5, 0}, {-1, 1, 0}};
  std::vector<Pose> poses;
  for (const Vec3& corner_T : corners_T) poses.push_back({X.R_AB, X.Vector(corner_T)});
  CutAll(cutter, test::MakeSteps(poses, disc, kVoxel));
  int checked = 0;
  for (int i = 0; i < 70 * 70 * 35; ++i) {
    const Vec3 p_vox = Vec3(i / 35 / 70, i / 35 % 70, i % 35) - Vec3(35, 35, 17);
    const Vec3 p_W = kVoxel * p_vox;
    const Vec3 p_T = X.InversePoint(p_W);
    double distance = 1e9;
    for (std::size_t n = 1; n < corners_T.size(); ++n) {
      const Vec3 segment = corners_T[n] - corners_T[n - 1];
      const Vec3 q(p_T.x - corners_T[n - 1].x, p_T.y - corners_T[n - 1].y, 0);
      const double t = std::clamp(glm::dot(q, segment) / glm::dot(segment, segment), 0.0, 1.0);
      const double radial = std::max(glm::length(q - t * segment) - 3, 0.0);
      distance = std::min(distance, std::hypot(radial, std::max(std::abs(p_T.z) - 0.225, 0.0)));
    }
    if (distance == 0 || distance > bone.band_mm()) continue;
    const double to_block = -test::BoxDistance(p_W, {8, 8, 4});
    if (to_block < bone.band_mm()) continue;
    // 3e-6 allows for float arithmetic at a radius of 3 mm, with the polygon's poses rotated back and forth.
    EXPECT_NEAR(field.Sample(p_vox), -distance, 3e-6);
    ++checked;
  }
  EXPECT_GT(checked, 5000);
}

TEST(Cutter, OnlyTheRimOfADiscCutsWithCutWithEdge) {
  Bone bone = test::MakeBox(Pose{}, {14, 14, 8}, kVoxel);
  BoneField field(bone, 4096);
  DiscSaw disc;
  disc.diameter_mm = 8;
  disc.thickness_mm = 0.4;
  Cutter cutter(field, disc, CutWith::kEdge);
  // The disc is pushed along its spindle into solid bone, so only a ring is removed.
  std::vector<Pose> poses;
  for (int i = 0; i <= 20; ++i) poses.push_back({Quat(1, 0, 0, 0), Vec3(0.03, 0.05, 0.04 * i)});
  CutAll(cutter, test::MakeSteps(poses, disc, kVoxel));
  int inside = 0;
  int rim = 0;
  for (int i = 0; i < 50 * 50; ++i) {
    const Vec3 p_vox(i / 50 - 25, i % 50 - 25, 2);
    const Vec3 p_W = kVoxel * p_vox;
    const double r = std::hypot(p_W.x - 0.03, p_W.y - 0.05);
    if (r < 4 - CalcToothSide(4, kVoxel) - 1e-5) {
      EXPECT_EQ(field.Sample(p_vox), -field.band_mm());  // pure bone
      ++inside;
    } else if (r < 4 - 0.2 * kVoxel && r > 4 - CalcToothSide(4, kVoxel) + 0.1 * kVoxel) {
      EXPECT_GT(field.Sample(p_vox), 0);
      ++rim;
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(rim, 100);
}

TEST(Cutter, WholeVoxelsAreEitherPresentOrAbsent) {
  Bone bone = test::MakeBox(Pose{}, {12, 12, 12}, kVoxel);
  BoneField field(bone, 4096);
  BallBurr ball;
  ball.diameter_mm = 4;
  Cutter cutter(field, ball, CutWith::kEdge, true);
  const std::vector<Pose> poses = {{Quat(1, 0, 0, 0), {0.03, 0.05, 0.02}}, {Quat(1, 0, 0, 0), {1.13, 0.35, -0.52}}};
  const double removed = CutAll(cutter, test::MakeSteps(poses, ball, kVoxel));
  int count = 0;
  for (int i = 0; i < 50 * 50 * 50; ++i) {
    const Vec3 p_vox = Vec3(i / 2500, i / 50 % 50, i % 50) - 25.0;
    const Vec3 segment = poses[1].p_AB - poses[0].p_AB;
    const Vec3 q = kVoxel * p_vox - poses[0].p_AB;
    const double t = std::clamp(glm::dot(q, segment) / glm::dot(segment, segment), 0.0, 1.0);
    const double distance = glm::length(q - t * segment) - 2;
    if (std::abs(distance) < 1e-5) continue;
    count += distance < 0 ? 1 : 0;
    const double steps = field.Sample(p_vox) / kVoxel;
    if (std::abs(distance) < bone.band_mm() - 1e-5) {
      EXPECT_EQ(distance<0, steps> 0);
      EXPECT_NEAR(steps - std::floor(steps), 0.5, 1e-6);
    }
  }
  EXPECT_NEAR(removed / (kVoxel * kVoxel * kVoxel), count, 1e-3);
}

TEST(Cutter, ABallRemovesItsCapsuleAtEverySpeedAndVoxelSize) {
  BallBurr ball;
  ball.diameter_mm = 6;
  const double length = 1.0;
  const double capsule =
      std::numbers::pi * 36 + std::numbers::pi * 9 * length;  // 4/3 pi 3^3 plus the cylinder along the motion
  std::vector<double> all;
  for (const double h : {0.1, 0.2, 0.3}) {
    const Bone block = test::MakeBox(Pose{}, {9, 9, 9}, h);
    for (const double speed : {1.0, 5.0, 10.0}) {
      Bone bone = block;
      BoneField field(bone, 4096);
      Cutter cutter(field, ball, CutWith::kEdge);
      const Vec3 motion = length * glm::normalize(Vec3(1, 0.4, -0.3));
      std::vector<Pose> poses;
      const int ticks = static_cast<int>(std::round(1000 * length / speed));
      for (int i = 0; i <= ticks; ++i) {
        poses.push_back({Quat(1, 0, 0, 0), Vec3(-0.4, -0.1, 0.2) + motion * (static_cast<double>(i) / ticks)});
      }
      const double by_occupancy = CutAll(cutter, test::MakeSteps(poses, ball, h));
      const auto& by_region = cutter.CalcRemovedByRegion();
      const double exact = std::accumulate(by_region.begin(), by_region.end(), 0.0);
      // The volume is within 2 % for any voxel size; by occupancy, it is within 1 %.
      EXPECT_NEAR(exact / capsule, 1, 0.02) << h;
      EXPECT_NEAR(by_occupancy / capsule, 1, 0.01) << h;
      all.push_back(exact);
    }
    // The speed affects only rounding, because the capsule is cut in more or fewer parts.
    EXPECT_NEAR(all[all.size() - 1], all[all.size() - 2], 1e-5 * capsule);
    EXPECT_NEAR(all[all.size() - 1], all[all.size() - 3], 1e-5 * capsule);
  }
}

/// Returns the volume of a bur, and its area projected along x.
struct BurMeasures {
  double volume_mm3, side_mm2;
};
BurMeasures MeasureBur(const FissureBur& bur) {
  const RoundSolid s = *CalcRoundSolid(bur);
  const double a = s.corner_radius_mm, b = s.top_radius_mm, side = s.top_z_mm - s.corner_z_mm;
  return {std::numbers::pi / 3 * (a * a * s.corner_z_mm + side * (a * a + a * b + b * b)),
          a * s.corner_z_mm + side * (a + b)};
}

TEST(Cutter, ABurRemovesItsGrooveAndItsHoleInEightPosesWithSecondOrder) {
  // A bur that is set down in bone and moves across its axis removes its volume and its side area times the way; along
  // its axis, a cylinder of its largest radius.
  FissureBur flat;
  flat.diameter_mm = 1.6;
  flat.length_mm = 4;
  FissureBur pointed = flat;
  pointed.taper = 0.7;
  pointed.point_angle_deg = 118;
  for (const FissureBur& bur : {flat, pointed}) {
    const BurMeasures exact = MeasureBur(bur);
    constexpr double kWay_mm = 2;
    double rms[2][2] = {};
    for (const int level : {0, 1}) {
      const double h = level == 0 ? 0.2 : 0.1;
      for (const Pose& X_WB : test::BlockPoses(h)) {
        const Bone block = test::MakeBox(X_WB, {7, 5, 10}, h);
        for (const bool across : {true, false}) {
          Bone bone = block;
          BoneField field(bone, 4096);
          Cutter cutter(field, bur, CutWith::kEdge);
          const Vec3 way_B = across ? Vec3(kWay_mm, 0, 0) : Vec3(0, 0, -kWay_mm);
          const Vec3 from_B = Vec3(0.03, 0.05, -1.9) - 0.5 * way_B;
          CutAll(cutter,
                 test::MakeSteps({{X_WB.R_AB, X_WB.Point(from_B)}, {X_WB.R_AB, X_WB.Point(from_B + way_B)}}, bur, h));
          const auto& by_region = cutter.CalcRemovedByRegion();
          const double removed = std::accumulate(by_region.begin(), by_region.end(), 0.0);
          const double swept = exact.volume_mm3 + kWay_mm * (across ? exact.side_mm2 : std::numbers::pi * 0.64);
          if (level == 1) {
            EXPECT_NEAR(removed / swept, 1, 0.01) << across;
          }
          rms[level][across] += (removed / swept - 1) * (removed / swept - 1) / 8;
        }
      }
    }
    // At half the voxel, the errors of the edges, which a grid rounds off, fall to a quarter; a third is asked.
    for (const bool across : {true, false}) EXPECT_LT(std::sqrt(rms[1][across]), std::sqrt(rms[0][across]) / 3);
  }
}

TEST(Cutter, ABurThatMovesAslantRemovesTheSweepOfItsRim) {
  // The sweep of a cylinder along a way at an angle to its axis is its volume and the way times its projected area.
  FissureBur bur;
  bur.diameter_mm = 2;
  bur.length_mm = 3;
  const Bone block = test::MakeBox(Pose{}, {8, 6, 9}, 0.1);
  for (const double degrees : {20.0, 45.0, 70.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Vec3 way(2 * std::sin(angle), 0, -2 * std::cos(angle));
    Bone bone = block;
    BoneField field(bone, 4096);
    Cutter cutter(field, bur, CutWith::kEdge);
    const Vec3 from = Vec3(0.01, 0.02, -1.5) - 0.5 * way;
    CutAll(cutter, test::MakeSteps({{Quat(1, 0, 0, 0), from}, {Quat(1, 0, 0, 0), from + way}}, bur, 0.1));
    const auto& by_region = cutter.CalcRemovedByRegion();
    const double removed = std::accumulate(by_region.begin(), by_region.end(), 0.0);
    const double swept = std::numbers::pi * 3 + 2 * (std::sin(angle) * 6 + std::cos(angle) * std::numbers::pi);
    EXPECT_NEAR(removed / swept, 1, 0.01) << degrees;
  }
}

TEST(Substeps, CountFollowsTheEdgesMotionAndTheDiscsSidewaysMotion) {
  const DiscSaw disc;  // 22 x 0.25 mm
  const BallBurr ball;
  const Pose a;
  const Pose forward{Quat(1, 0, 0, 0), {0.26, 0, 0}};
  const Pose along{Quat(1, 0, 0, 0), {0, 0, 0.26}};
  const Pose tilted{glm::angleAxis(0.01, Vec3(1, 0, 0)), Vec3(0)};
  EXPECT_EQ(CountSubsteps(a, a, disc, 0.1), 1);
  EXPECT_EQ(CountSubsteps(a, forward, disc, 0.1), 6);  // 0.26 / 0.05
  EXPECT_EQ(CountSubsteps(a, forward, ball, 0.1), 6);
  EXPECT_EQ(CountSubsteps(a, along, disc, 0.1), 11);  // 0.26 / 0.025
  EXPECT_EQ(CountSubsteps(a, along, disc, 1.0), 5);   // limited by the thinner disc: 0.26 / 0.0625
  EXPECT_EQ(CountSubsteps(a, tilted, disc, 0.1), 5);  // 0.11 mm at the rim / 0.025
  EXPECT_EQ(CountSubsteps(a, tilted, ball, 0.1), 1);
  const FissureBur bur;  // 1.6 x 8 mm
  EXPECT_EQ(CountSubsteps(a, forward, bur, 0.1), 6);
  EXPECT_EQ(CountSubsteps(a, along, bur, 0.1), 6);
  EXPECT_EQ(CountSubsteps(a, tilted, bur, 0.1), 4);  // 0.082 mm at the top / 0.025
  const Pose half = Interpolate(a, tilted, 0.5);
  EXPECT_NEAR(glm::angle(half.R_AB), 0.005, 1e-12);
}

}  // namespace
}  // namespace kerf
