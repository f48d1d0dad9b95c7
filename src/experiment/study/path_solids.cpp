// Bones as exact solids for a study.
#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

#include "bone/grid/ct_modulus.h"
#include "bone/grid/set_leaf.h"
#include "experiment/study/paths.h"

namespace kerf {
namespace {

constexpr double kMinRegionVoxel_mm = 0.2;  // as in MakeMandible() and in an import

/// Intersects `whole` with the part. Far from the bone, the distance to the part's faces need not be exact.
std::function<double(const Vec3&)> CutOut(std::function<double(const Vec3&)> whole,
                                          const std::optional<BonePart>& part) {
  if (!part) return whole;
  return [whole = std::move(whole), part = *part](const Vec3& p_W) {
    const double to_box = part.Distance(p_W);
    return to_box > 1 ? to_box : std::max(whole(p_W), to_box);
  };
}

/// Returns the bone maker of a path. `classify` classifies parts of the whole bone. The solid's function is not an
/// exact distance, so the distances are computed on the grid.
std::function<Bone(double, int)> MakeMaker(const StudyPath& path, const std::optional<BonePart>& part,
                                           std::function<BlockClass(const Vec3&, double)> classify,
                                           std::function<int(const Vec3&)> region) {
  return RememberLast([solid = path.solid, materials = path.materials, bounds = path.bounds_W, part,
                       classify = std::move(classify), region = std::move(region)](double voxel_mm, int band_voxels) {
    SolidField field;
    field.value = solid.distance_mm;
    field.classify = [&](const Vec3& p_W, double radius_mm) {
      const double to_box = part ? part->Distance(p_W) : -2 * radius_mm;
      if (to_box > radius_mm) return BlockClass::kOutside;
      const BlockClass whole = classify(p_W, radius_mm);
      return whole == BlockClass::kInside && to_box > -radius_mm ? BlockClass::kMixed : whole;
    };
    field.region = region;
    field.is_distance = false;
    BuildOptions options;
    options.voxel_mm = voxel_mm;
    options.region_voxel_mm = std::max(voxel_mm, kMinRegionVoxel_mm);
    options.band_voxels = band_voxels;
    return MakeBone(field, bounds.Grown((band_voxels + 2) * voxel_mm), options, materials);
  });
}

}  // namespace

double BonePart::Distance(const Vec3& p_W) const {
  const Vec3 q = glm::abs(X_WB.InversePoint(p_W) - box_B.centre()) - 0.5 * box_B.size();
  return glm::length(glm::max(q, Vec3(0))) + std::min(std::max({q.x, q.y, q.z}), 0.0);
}

Box3 BonePart::CalcBounds() const {
  Box3 bounds_W;
  for (int corner = 0; corner < 8; ++corner) {
    bounds_W.Include(X_WB.Point({(corner & 1 ? box_B.upper : box_B.lower).x, (corner & 2 ? box_B.upper : box_B.lower).y,
                                 (corner & 4 ? box_B.upper : box_B.lower).z}));
  }
  return bounds_W;
}

void SetBlock(StudyPath& path, const BlockParams& block, const BlockGaps& gaps) {
  const auto distance = [block, shape = gaps.shape](const Vec3& p_W) {
    const double to_block = CalcBlockDistance(block, p_W);
    return shape ? std::max(to_block, shape(p_W)) : to_block;
  };
  const auto cut = [distance, was_cut = gaps.was_cut](const Vec3& p_W) {
    return was_cut ? std::max(distance(p_W), was_cut(p_W)) : distance(p_W);
  };
  const auto region = [block](const Vec3& p_W) { return CalcBlockRegion(block, p_W); };
  path.solid = MakeSolid(cut, region, path.materials);
  const BonePart all{block.X_WB,
                     {{-0.5 * block.size_mm.x, -0.5 * block.size_mm.y, -block.size_mm.z},
                      {0.5 * block.size_mm.x, 0.5 * block.size_mm.y, 0}}};
  path.bounds_W = all.CalcBounds();
  path.make_bone = RememberLast([distance, region, was_cut = gaps.was_cut, bounds = path.bounds_W,
                                 materials = path.materials](double voxel_mm, int band_voxels) {
    // The bone is made as in MakeBlock().
    SolidField field;
    field.value = distance;
    field.classify = ClassifyByDistance(distance);
    field.region = region;
    BuildOptions options;
    options.voxel_mm = voxel_mm;
    options.region_voxel_mm = voxel_mm;
    options.band_voxels = band_voxels;
    Bone bone = MakeBone(field, bounds.Grown((band_voxels + 2) * voxel_mm), options, materials);
    if (was_cut) CutAway(bone, bounds, was_cut);
    return bone;
  });
}

void SetMandible(StudyPath& path, const std::shared_ptr<const MandibleShape>& shape,
                 const std::optional<BonePart>& part) {
  path.bounds_W = part ? part->CalcBounds() : shape->bounds();
  const auto region = [shape](const Vec3& p_W) { return shape->RegionAt(p_W); };
  path.solid = MakeSolid(CutOut([shape](const Vec3& p_W) { return shape->Value(p_W); }, part), region, path.materials);
  path.make_bone = MakeMaker(
      path, part, [shape](const Vec3& p_W, double radius_mm) { return shape->Classify(p_W, radius_mm); }, region);
}

void SetImported(StudyPath& path, Bone imported, const std::optional<BonePart>& part, const std::optional<CtLaw>& law) {
  path.bounds_W = part ? part->CalcBounds() : imported.CalcBounds();
  path.materials = imported.materials();
  const auto truth = std::make_shared<const Bone>(std::move(imported));
  const auto region = [truth](const Vec3& p_W) { return truth->RegionAt(p_W); };
  path.solid =
      MakeSolid(CutOut([truth](const Vec3& p_W) { return truth->SignedDistance(p_W); }, part), region, path.materials);
  // Beyond its band, the imported bone has only the sign of the distance, so a ball is known to be inside or outside
  // only if its radius is at most that of the band.
  const double band_mm = 0.99 * truth->band_mm();
  path.make_bone = MakeMaker(
      path, part,
      [truth, band_mm](const Vec3& p_W, double radius_mm) {
        const double d = truth->SignedDistance(p_W);
        if (radius_mm > band_mm || std::abs(d) <= radius_mm) return BlockClass::kMixed;
        return d > 0 ? BlockClass::kOutside : BlockClass::kInside;
      },
      region);
  if (!law || !truth->has_hu()) return;
  // Cancellous bone takes E from the CT. The exact solid must return this E at every point, whatever the neighbouring
  // tissue.
  auto by_ct = std::make_shared<Bone>(*truth);
  UseCtModulus(*by_ct, *law, true);
  path.ct_solid = path.solid;
  path.ct_solid.material = [by_region = path.solid.material, by_ct, materials = path.materials](const Vec3& p_W) {
    ExactSolid::Material material = by_region(p_W);
    if (material.region == 0 || materials.At(material.region).tissue != Tissue::kCancellous) return material;
    if (const double E_MPa = by_ct->ModulusAt(p_W); E_MPa > 0) material.E_MPa = E_MPa;
    return material;
  };
  path.use_ct = [truth, law = *law](Bone& bone) {
    CopyHu(bone, *truth);
    UseCtModulus(bone, law, false);
  };
}

}  // namespace kerf
