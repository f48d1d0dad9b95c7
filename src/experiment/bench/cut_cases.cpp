#include "experiment/bench/cut_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "cut/tool/edge_down.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

// ---- poses of tools in the cut's frame B ----------------------------------------------------------------------------

/// Returns the pose of a disc with its spindle along y and its centre at p_B.
Pose HoldDisc(const Vec3& p_B) {
  return {glm::angleAxis(-0.5 * std::numbers::pi, Vec3(1, 0, 0)), p_B};
}
/// Returns the pose of a blade with its edge along x, which faces down.
Pose HoldBlade(const Vec3& p_B) {
  return {CalcEdgeDown(), p_B};
}
/// Returns the pose of an upright burr, bur or drill.
Pose HoldUpright(const Vec3& p_B) {
  return {Quat(1, 0, 0, 0), p_B};
}

}  // namespace

void UseBlock(const Vec3& size_mm, double voxel_mm, CutCase& cut) {
  BlockParams block;
  block.size_mm = size_mm;
  block.X_WB = cut.X_WB;
  block.voxel_mm = voxel_mm;
  cut.make_bone = [block] { return MakeBlock(block, DefaultMandibleTable()); };
}

CutCase MakeDiscCut(double voxel_mm) {
  CutCase cut;
  cut.name = fmt::format("disc-{}", voxel_mm);
  cut.title = fmt::format("disc 22 x 0.25 mm, 8 mm deep, tilted, 5 mm/s, {} mm voxels", voxel_mm);
  cut.tool = DiscSaw{};
  cut.X_WB = {glm::angleAxis(0.5, glm::normalize(Vec3(1, 2, 0.5))), {0.3, -0.1, 0.2}};
  UseBlock({46, 4, 12}, voxel_mm, cut);
  cut.X_BT_start = HoldDisc({-34.5, 0, 3});
  cut.warm_up_mm = 14;
  cut.measured_mm = 26;
  cut.baseline = BenchBaseline::kOpenVdb;
  // The cube contains parts of one wall of the kerf and of its floor.
  cut.dense_offset_B = {0, 0.1, -10.8};
  cut.dense_edge_mm = 28 * voxel_mm;
  cut.spare_leaves = voxel_mm < 0.08 ? 16384 : 4096;
  return cut;
}

EffectChoices ListEffectsOf(const CutCase& cut) {
  EffectChoices effects;
  for (const EffectInfo* info : Effects()) {
    EffectChoice choice(info->name);
    const auto set = [&](const char* key, const EffectValue& value) {
      choice.values()[info->FindParameter(key)] = value;
    };
    if (choice.name() == std::string("guide")) {
      set("point_mm", cut.X_WB.p_AB);
      set("normal", cut.X_WB.Vector({0, 1, 0}));
      set("depth_direction", cut.X_WB.Vector({0, 0, -1}));
    }
    if (choice.name() == std::string("spindle")) set("stall_torque_Nmm", 1e5);
    effects.push_back(std::move(choice));
  }
  return effects;
}

CutCase MakeEffectsCut() {
  CutCase cut = MakeDiscCut(0.1);
  cut.name = "disc-0.1-effects";
  cut.title = "the first cut with all effects";
  cut.effects = ListEffectsOf(cut);
  cut.flat_top = false;  // the pull of the teeth moves the tool a little
  cut.baseline = BenchBaseline::kNone;
  cut.dense_edge_mm = 0;
  return cut;
}

CutCase MakeHandCut() {
  CutCase cut = MakeDiscCut(0.1);
  cut.name = "disc-0.1-hand";
  cut.title = "the same with a trembling hand, through a coupling of 4 N/mm";
  // There is no closed form, because the tool lags behind the handle and the thrust lifts it slightly.
  cut.by_hand = true;
  cut.flat_top = false;
  cut.baseline = BenchBaseline::kNone;
  cut.dense_edge_mm = 0;
  return cut;
}

CutCase MakeBuriedCut() {
  CutCase cut = MakeDiscCut(0.1);
  cut.name = "disc-0.1-buried";
  cut.title = "the same disc, fully buried, starting inside the bone";
  UseBlock({46, 4, 24}, 0.1, cut);
  cut.X_BT_start = HoldDisc({-11.5, 0, -12});
  cut.flat_top = false;  // the rear of the rim cuts too, since the disc was placed inside the bone
  cut.warm_up_mm = 1;
  cut.measured_mm = 20;
  cut.baseline = BenchBaseline::kNone;
  cut.dense_edge_mm = 0;
  cut.spare_leaves = 16384;
  return cut;
}

CutCase MakeThickDiscCut() {
  CutCase cut = MakeDiscCut(0.2);
  cut.name = "thick-disc-0.2";
  cut.title = "disc r = 10 mm, 1 mm thick, 5 mm deep, 10 mm/s, 0.2 mm voxels";
  cut.tool = DiscSaw{.diameter_mm = 20, .thickness_mm = 1};
  cut.feed_mm_per_s = 10;
  cut.X_BT_start = HoldDisc({-34, 0, 5});
  cut.warm_up_mm = 14;
  cut.baseline = BenchBaseline::kNone;
  cut.dense_offset_B = {0, 0.5, -9.8};
  return cut;
}

CutCase MakeBallCut(double voxel_mm, double feed_mm_per_s, bool whole) {
  CutCase cut;
  cut.name = fmt::format("ball-{}", voxel_mm) + (feed_mm_per_s == 10 ? "" : fmt::format("-{}mm/s", feed_mm_per_s));
  cut.title = fmt::format("ball r = 3 mm, 2 mm deep, {} mm/s, {} mm voxels{}", feed_mm_per_s, voxel_mm,
                          whole ? ", 256^3" : fmt::format(" (r = {:.0f} voxels)", 3 / voxel_mm));
  cut.tool = BallBurr{.diameter_mm = 6};
  cut.rpm = -30000;
  cut.feed_mm_per_s = feed_mm_per_s;
  BlockParams block;
  block.size_mm = whole ? Vec3(250 * voxel_mm) : Vec3(50, 10, 7);
  block.voxel_mm = voxel_mm;
  // The array of 256^3 includes the three voxels of the band on each side.
  if (whole) cut.X_WB.p_AB = voxel_mm * Vec3(127.5, 127.5, 252.5);
  block.X_WB = cut.X_WB;
  cut.make_bone = [block] { return MakeBlock(block, DefaultMandibleTable()); };
  cut.X_BT_start = HoldUpright({-29, 0, 1});
  cut.warm_up_mm = 7;
  cut.measured_mm = feed_mm_per_s < 2 ? 5 : 25;
  if (whole && feed_mm_per_s == 10) {
    cut.baseline = BenchBaseline::kDense;
    cut.dense_all = true;
  } else {
    cut.dense_offset_B = {0, 0, -2.5};
    cut.dense_edge_mm = 28 * voxel_mm;
  }
  return cut;
}

CutCase MakeBurCut(double voxel_mm) {
  CutCase cut;
  cut.name = fmt::format("bur-{}", voxel_mm);
  cut.title = fmt::format("bur 2.1 x 8 mm, point 120 degrees, 4 mm deep, 5 mm/s, {} mm voxels", voxel_mm);
  cut.tool = FissureBur{.diameter_mm = 2.1, .length_mm = 8, .point_angle_deg = 120};
  cut.rpm = -30000;
  cut.X_WB = MakeDiscCut(voxel_mm).X_WB;
  UseBlock({36, 8, 8}, voxel_mm, cut);
  cut.X_BT_start = HoldUpright({-20, 0, -4});
  cut.warm_up_mm = 6;
  cut.measured_mm = 26;
  cut.baseline = BenchBaseline::kOpenVdb;
  // The cube contains parts of one wall of the groove and of its floor.
  cut.dense_offset_B = {0, 0.5, 0.4};
  cut.dense_edge_mm = 28 * voxel_mm;
  return cut;
}

CutCase MakeDrillCut(double voxel_mm) {
  CutCase cut;
  cut.name = fmt::format("drill-{}", voxel_mm);
  cut.title = fmt::format("drill 2 mm, point 118 degrees, along its axis, 2 mm/s, {} mm voxels", voxel_mm);
  const TwistDrill drill{.diameter_mm = 2};
  cut.tool = drill;
  cut.rpm = -1000;
  cut.feed_mm_per_s = 2;
  cut.X_WB = MakeDiscCut(voxel_mm).X_WB;
  UseBlock({8, 8, 16}, voxel_mm, cut);
  cut.X_BT_start = HoldUpright({0, 0, 0.5});
  cut.direction_B = {0, 0, -1};
  cut.warm_up_mm = 3;
  cut.measured_mm = 10;
  cut.section_mm2 = std::numbers::pi * drill.radius_mm() * drill.radius_mm();
  cut.baseline = BenchBaseline::kOpenVdb;
  return cut;
}

CutCase MakeSawnCut(const Tool& blade, double rpm, double bar_mm, double voxel_mm) {
  CutCase cut;
  cut.name = fmt::format("{}-{}", GetShape(blade), voxel_mm);
  cut.title = fmt::format("{} through a bar {:g} mm wide, {:g} double strokes a minute, 5 mm/s, {} mm voxels",
                          DescribeToolBriefly(blade), bar_mm, rpm, voxel_mm);
  cut.tool = blade;
  cut.rpm = rpm;
  cut.X_WB = MakeDiscCut(voxel_mm).X_WB;
  UseBlock({bar_mm, 4, 40}, voxel_mm, cut);
  cut.X_BT_start = HoldBlade({0, 0, 1});
  cut.direction_B = {0, 0, -1};
  cut.warm_up_mm = 8;
  cut.measured_mm = 26;
  cut.section_mm2 = bar_mm * CalcCutWidth(blade);
  cut.baseline = BenchBaseline::kOpenVdb;
  return cut;
}

CutCase MakeMandibleCut(bool whole) {
  MandibleParams params;
  const MandibleShape shape(params);
  const MandibleLandmarks& marks = shape.landmarks();
  CutCase cut;
  cut.name = whole ? "mandible" : "mandible-block";
  cut.title = fmt::format("disc 22 x 0.25 mm up through the body of {}, 5 mm/s, {} mm voxels",
                          whole ? "a whole mandible" : "a mandible cropped to a block", params.voxel_mm);
  cut.tool = DiscSaw{};
  // x points up, y along the body, and z outwards.
  const Vec3 up(0, 0, 1);
  const Vec3 out = glm::normalize(marks.first_molar_out - glm::dot(marks.first_molar_out, up) * up);
  cut.X_WB = {glm::normalize(glm::quat_cast(glm::dmat3(up, glm::cross(out, up), out))), marks.first_molar};
  cut.X_BT_start = HoldDisc({-params.canal_to_base_mm - 0.5 * params.canal_diameter_mm - 12.5, 0, 0});
  cut.warm_up_mm = 6;
  cut.measured_mm = 20;
  cut.flat_top = false;
  if (whole) {
    cut.make_bone = [params] { return MakeMandible(params, DefaultMandibleTable()); };
  } else {
    cut.make_bone = [params, middle = marks.first_molar] {
      const MandibleShape parent(params);
      const auto box = [middle](const Vec3& p_W) {
        const Vec3 q = glm::abs(p_W - middle) - Vec3(16);
        return glm::length(glm::max(q, Vec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
      };
      SolidField solid;
      solid.value = [&](const Vec3& p_W) { return std::max(parent.Value(p_W), box(p_W)); };
      solid.classify = [&](const Vec3& p_W, double radius_mm) {
        if (box(p_W) > radius_mm) return BlockClass::kOutside;
        const BlockClass of_parent = parent.Classify(p_W, radius_mm);
        if (of_parent == BlockClass::kInside && box(p_W) > -radius_mm) return BlockClass::kMixed;
        return of_parent;
      };
      solid.region = [&](const Vec3& p_W) { return parent.RegionAt(p_W); };
      solid.is_distance = false;
      return MakeBone(solid, Box3{middle - 18.0, middle + 18.0}, {params.voxel_mm, params.voxel_mm, {}},
                      DefaultMandibleTable());
    };
  }
  return cut;
}

}  // namespace kerf
