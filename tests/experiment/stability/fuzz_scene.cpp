#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "experiment/stability/fuzz.h"
#include "support/solids.h"

namespace kerf::test {
namespace {

enum class BoneKind { kBlock, kTilted, kPlate, kLayers, kIslands, kInclusion, kFarOff, kMandible, kCount };

constexpr int kOuter = 24;
constexpr int kInner = 21;

MaterialTable MakeTable(double E_outer_MPa, double nu_outer, double E_inner_MPa, double nu_inner) {
  MaterialTable table;
  table.Add({kOuter, "outer", Tissue::kCortical, E_outer_MPa, nu_outer, true, "test"});
  table.Add({kInner, "inner", Tissue::kCancellous, E_inner_MPa, nu_inner, true, "test"});
  return table;
}

Bone MakeKind(BoneKind kind, double h) {
  const MaterialTable table = MakeTable(19300, 0.28, 500, 0.3);
  BlockParams block;
  block.size_mm = h * Vec3(48, 14, 24);
  block.layers = {{block.size_mm.z, kOuter}};
  block.voxel_mm = h;
  switch (kind) {
    case BoneKind::kBlock:
    case BoneKind::kCount:
      break;
    case BoneKind::kTilted:
      block.X_WB = {glm::angleAxis(0.6, glm::normalize(Vec3(1, 2, 3))), h * Vec3(0.3, 0.7, 0.1)};
      break;
    case BoneKind::kPlate:
      block.size_mm.z = 2 * h;
      break;
    case BoneKind::kLayers:
      block.layers = {{3 * h, kOuter}, {7 * h, kInner}, {h, kOuter}, {block.size_mm.z, kInner}};
      break;
    case BoneKind::kFarOff:
      block.X_WB.p_AB = kWorldReach_mm * Vec3(0.98, -0.98, 0.96);
      break;
    case BoneKind::kIslands: {
      // Balls slightly larger than a voxel, six voxels apart.
      SolidField field;
      field.value = [h](const Vec3& p) {
        const Vec3 q = p / (6 * h);
        const Vec3 n = glm::clamp(glm::round(q), Vec3(-3), Vec3(3));
        return 6 * h * glm::length(q - n) - 0.9 * h;
      };
      field.classify = ClassifyByDistance(field.value);
      field.region = [](const Vec3&) { return kOuter; };
      const Vec3 half(26 * h);
      return MakeBone(field, {-half, half}, {h, h, {}}, table);
    }
    case BoneKind::kInclusion: {
      const Vec3 half = 0.5 * block.size_mm;
      SolidField field;
      field.value = [half](const Vec3& p) { return BoxDistance(p, half); };
      field.classify = ClassifyByDistance(field.value);
      field.region = [h](const Vec3& p) { return glm::length(p - Vec3(0, 0, 8 * h)) < 2 * h ? kInner : kOuter; };
      const Box3 box{-half, half};
      return MakeBone(field, box.Grown(6 * h), {h, h, {}}, table);
    }
    case BoneKind::kMandible: {
      MandibleParams params;
      params.voxel_mm = 1;
      return MakeMandible(params, DefaultMandibleTable());
    }
  }
  return MakeBlock(block, table);
}

Tool MakeDiscOrBall(Dice& dice, double voxel_mm) {
  const double E_MPa = dice.One({1e3, 205000.0, 205000.0, 1.5e6});
  if (dice.OneIn(4)) {
    BallBurr ball;
    ball.diameter_mm = std::clamp(voxel_mm * dice.LogUniform(1, 40), 0.5, 20.0);
    ball.flutes = dice.One({1, 8, 30});
    ball.tooth_width_mm = dice.One({0.05, 0.5, 5.0});
    ball.E_MPa = E_MPa;
    return ball;
  }
  DiscSaw disc;
  disc.diameter_mm = std::clamp(voxel_mm * dice.LogUniform(4, 200), 1.0, 60.0);
  // The disc is much thinner than a voxel, of the default thickness, or thick.
  disc.thickness_mm = dice.One({0.02, 0.25, 0.25, 0.25, 1.0, 3.0});
  disc.teeth = dice.One({1, 8, 24, 24, 100});
  disc.E_MPa = E_MPa;
  disc.nu = dice.One({0.0, 0.28, 0.5});
  return disc;
}

/// Sets what all flat blades have. The pitch may be longer than the stroke, and the blade thinner than a voxel.
template <typename Blade>
void DrawBlade(Dice& dice, double voxel_mm, Blade& blade) {
  blade.width_mm = std::clamp(voxel_mm * dice.LogUniform(4, 60), 1.0, 15.0);
  blade.taper = dice.One({0.1, 0.6, 1.0});
  blade.thickness_mm = dice.One({0.02, 0.4, 0.4, 1.0, 3.0});
  blade.set_mm = dice.One({0.0, 0.05, 0.05, 1.0});
  blade.pitch_mm = dice.One({0.1, 1.0, 1.41, 20.0});
}

Tool MakeBurOrBlade(Dice& dice, double voxel_mm) {
  switch (dice.Below(5)) {
    case 0: {
      FissureBur bur;
      bur.diameter_mm = std::clamp(voxel_mm * dice.LogUniform(1, 40), 0.3, 20.0);
      bur.length_mm = std::clamp(bur.diameter_mm * dice.LogUniform(1.5, 10), 1.0, 60.0);
      bur.taper = dice.One({0.1, 0.8, 1.0});
      bur.point_angle_deg = dice.One({90.0, 120.0, 180.0});
      bur.flutes = dice.One({1, 6, 30});
      return bur;
    }
    case 1: {
      TwistDrill drill;
      drill.diameter_mm = std::clamp(voxel_mm * dice.LogUniform(1, 40), 0.3, 20.0);
      drill.length_mm = std::clamp(drill.diameter_mm * dice.LogUniform(1.5, 20), 1.0, 100.0);
      drill.point_angle_deg = dice.One({90.0, 118.0, 180.0});
      return drill;
    }
    case 2: {
      ReciprocatingBlade blade;
      DrawBlade(dice, voxel_mm, blade);
      blade.length_mm = std::clamp(voxel_mm * dice.LogUniform(15, 300), 3.0, 60.0);
      blade.stroke_mm = dice.One({0.05, 3.0, 3.0, 30.0});
      return blade;
    }
    case 3: {
      OscillatingBlade blade;
      DrawBlade(dice, voxel_mm, blade);
      blade.radius_mm = std::clamp(blade.width_mm * dice.LogUniform(1, 5), 8.0, 60.0);
      blade.width_mm = std::min(blade.width_mm, 1.1 * blade.radius_mm);
      blade.swing_deg = dice.One({0.1, 5.0, 5.0, 20.0});
      return blade;
    }
    default: {
      PiezoInsert insert;
      DrawBlade(dice, voxel_mm, insert);
      insert.length_mm = std::clamp(voxel_mm * dice.LogUniform(10, 100), 1.0, 30.0);
      insert.stroke_mm = dice.One({0.01, 0.12, 0.5});
      return insert;
    }
  }
}

}  // namespace

Bone MakeFuzzBone(Dice& dice, double& voxel_mm) {
  // The mandible is large and slow to construct, so it is used in one scene in a hundred.
  const auto kind =
      dice.OneIn(100) ? BoneKind::kMandible : static_cast<BoneKind>(dice.Below(static_cast<int>(BoneKind::kMandible)));
  voxel_mm = kind == BoneKind::kMandible ? 1 : dice.One({0.1, 0.2, 0.2, 0.4, 1.0, 2.0});
  static std::map<std::pair<BoneKind, double>, Bone> made;
  auto found = made.find({kind, voxel_mm});
  if (found == made.end()) found = made.emplace(std::pair(kind, voxel_mm), MakeKind(kind, voxel_mm)).first;
  Bone bone = found->second;
  const double E_MPa = dice.OneIn(2) ? 19300 : dice.LogUniform(1, 1e9);
  const double nu = dice.One({0.0, 0.28, 0.28, 0.499999, 0.5});
  if (kind == BoneKind::kMandible) {
    bone.set_materials(MakeUniformTable(bone.materials(), E_MPa, nu));
  } else {
    bone.set_materials(MakeTable(E_MPa, nu, dice.OneIn(2) ? 200000 : dice.LogUniform(1, 1e9), nu));
  }
  return bone;
}

FuzzScene MakeFuzzScene(Dice& dice, FuzzTools tools) {
  FuzzScene scene;
  scene.bone = MakeFuzzBone(dice, scene.voxel_mm);
  scene.box = scene.bone.CalcBounds();
  ComparedParams& p = scene.params;
  p.tool =
      tools == FuzzTools::kDiscsAndBalls ? MakeDiscOrBall(dice, scene.voxel_mm) : MakeBurOrBlade(dice, scene.voxel_mm);
  Validate(p.tool);
  const auto& laws = ForceLaws();
  p.law = ForceLaw(laws[static_cast<std::size_t>(dice.Below(static_cast<int>(laws.size())))]->name);
  CouplingParams& c = p.coupling;
  c.p_TC_mm = dice.One({Vec3(0), Vec3(0), CalcGrip(p.tool), Vec3(30, -20, 10), Vec3(1000, 0, 0)});
  c.stiffness_N_per_mm = dice.OneIn(3) ? dice.LogUniform(1e-3, 1e3) : dice.LogUniform(0.2, 5);
  c.torsion_Nmm_per_rad = dice.OneIn(3) ? dice.LogUniform(1, 1e7) : 5000;
  c.damping_Ns_per_mm = dice.One({0.0, 0.0, 0.002, 1.0});
  c.torsion_damping_Nmms = dice.One({0.0, 0.0, 5.0, 1e4});
  c.max_force_N = dice.One({0.1, 5.0, 40.0, 40.0, 1e4});
  c.max_torque_Nmm = dice.One({1.0, 4000.0, 4000.0, 1e6});
  SetEffect(p.effects, "kerf_friction", "coefficient", dice.One({0.0, 0.2, 0.2, 1.0, 2.0}));
  p.rim_samples_per_pitch = dice.One({1, 4, 8});
  p.max_iterations = dice.One({1, 2, 5, 40, 40});
  p.max_substeps = dice.One({1, 4, 16, 24, 24, 64});
  p.whole_voxel_removal = dice.OneIn(8);
  p.spare_leaves = dice.One({0, 1, 10, 200, 4096});
  p.slab_reading = dice.One({PaperReading::kCorrected, PaperReading::kAsComputed});
  // The tool starts next to the bone, half inside it, or anywhere around it.
  const double reach_mm = CalcReach(p.tool);
  const Vec3 direction = dice.Direction();
  scene.start.R_AB = dice.OneIn(2) ? Quat(1, 0, 0, 0) : dice.Rotation();
  scene.start.p_AB = scene.box.centre() + direction * (0.5 * scene.box.size() * Vec3(dice.Uniform(0, 1.2)) +
                                                       dice.Uniform(0, 1.2) * reach_mm);
  if (tools == FuzzTools::kBursAndBlades) c.blade_bends = dice.OneIn(2);
  return scene;
}

std::string ToText(const FuzzScene& scene) {
  const ComparedParams& p = scene.params;
  const CouplingParams& c = p.coupling;
  const Pose& X = scene.start;
  return fmt::format(
      "voxel {} mm, bone from {} {} {} to {} {} {} mm; {}, pitch {} mm, E {} MPa; law {}; "
      "coupling at {} {} {}, {} N/mm, {} N s/mm, {} N mm/rad, {} N mm s, {} N, {} N mm, bends {}; friction {}, {} "
      "samples, {} "
      "iterations, {} substeps, whole voxels {}, {} spare leaves; start {{{:a}, {:a}, {:a}, {:a}}}, {{{:a}, {:a}, "
      "{:a}}}",
      scene.voxel_mm, scene.box.lower.x, scene.box.lower.y, scene.box.lower.z, scene.box.upper.x, scene.box.upper.y,
      scene.box.upper.z, DescribeTool(p.tool), CalcTooth(p.tool).pitch_mm, CalcModulus(p.tool), p.law.name(),
      c.p_TC_mm.x, c.p_TC_mm.y, c.p_TC_mm.z, c.stiffness_N_per_mm, c.damping_Ns_per_mm, c.torsion_Nmm_per_rad,
      c.torsion_damping_Nmms, c.max_force_N, c.max_torque_Nmm, c.blade_bends,
      FindChoice(p.effects, "kerf_friction")->GetNumber("coefficient"), p.rim_samples_per_pitch, p.max_iterations,
      p.max_substeps, p.whole_voxel_removal, p.spare_leaves, X.R_AB.w, X.R_AB.x, X.R_AB.y, X.R_AB.z, X.p_AB.x, X.p_AB.y,
      X.p_AB.z);
}

}  // namespace kerf::test
