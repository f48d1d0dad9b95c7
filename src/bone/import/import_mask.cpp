// Import of a bone from a mask alone, without its CT.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <utility>

#include "bone/grid/build.h"
#include "bone/import/import_steps.h"
#include "bone/import/mandible_likeness.h"
#include "bone/import/patient_frame.h"
#include "kerf/error.h"
#include "kerf/label_map.h"

namespace kerf {
namespace {

// Returns the part of the mask with wanted bone, metal and lesions, with a margin of one voxel.
Volume CropMask(const BoneMask& of, const std::vector<std::uint8_t>& wanted) {
  const Volume& mask = of.tissue;
  std::array<int, 3> lower = mask.size, upper = {0, 0, 0};
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(mask.size[2]); ++k) {
    for (int j = 0; j < mask.size[1]; ++j) {
      for (int i = 0; i < mask.size[0]; ++i, ++v) {
        if (wanted[v] == 0 && !IsMetal(of.At(v)) && !IsLesion(of.At(v))) continue;
        const std::array<int, 3> at = {i, j, static_cast<int>(k)};
        for (std::size_t a = 0; a < 3; ++a) {
          lower[a] = std::min(lower[a], at[a] - 1);
          upper[a] = std::max(upper[a], at[a] + 1);
        }
      }
    }
  }
  return Crop(mask, lower, upper);
}

// Samples a mask whose axes are not at right angles, such as one of a tilted gantry, at the nearest voxels of a lattice
// whose axes are. Leaves another one as it is.
Volume Straighten(Volume mask) {
  const glm::dmat3& axes = mask.axes_W;
  const double shear = std::max({std::abs(glm::dot(axes[0], axes[1])), std::abs(glm::dot(axes[0], axes[2])),
                                 std::abs(glm::dot(axes[1], axes[2]))});
  if (shear <= 1e-3 && glm::determinant(axes) > 0) return mask;
  Volume straight = mask;
  straight.axes_W[1] = glm::normalize(axes[1] - glm::dot(axes[0], axes[1]) * axes[0]);
  straight.axes_W[2] = glm::cross(axes[0], straight.axes_W[1]);
  for (int a = 0; a < 3; ++a) straight.spacing_mm[a] *= glm::dot(axes[a], straight.axes_W[a]);
  Box3 box_V;
  for (int c = 0; c < 8; ++c) {
    const auto last = [&](std::size_t a) { return (c >> a & 1) * (mask.size[a] - 1); };
    box_V.Include(straight.VoxelFromWorld(mask.WorldFromVoxel({last(0), last(1), last(2)})));
  }
  straight.origin_W = straight.WorldFromVoxel(box_V.lower);
  for (std::size_t a = 0; a < 3; ++a)
    straight.size[a] = static_cast<int>(std::lround(box_V.size()[static_cast<int>(a)])) + 1;
  straight.hu.assign(straight.count(), 0);
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(straight.size[2]); ++k) {
    for (int j = 0; j < straight.size[1]; ++j) {
      for (int i = 0; i < straight.size[0]; ++i, ++v) {
        const Vec3 p_V = glm::round(mask.VoxelFromWorld(straight.WorldFromVoxel({i, j, static_cast<double>(k)})));
        const std::array<int, 3> at = {static_cast<int>(p_V.x), static_cast<int>(p_V.y), static_cast<int>(p_V.z)};
        if (mask.Contains(at)) straight.hu[v] = mask.hu[mask.Index(at[0], at[1], at[2])];
      }
    }
  }
  straight.warnings.emplace_back(
      "the axes of the mask are not at right angles: it was sampled on a lattice whose axes are, which moves its "
      "surface by up to half a voxel");
  return straight;
}

// Adds the metal and the lesions that touch the wanted bone.
void AddJoined(const BoneMask& mask, std::vector<std::uint8_t>& solid) {
  const Components parts = FindComponents(
      mask.tissue, [&](std::size_t v) { return solid[v] != 0 || IsMetal(mask.At(v)) || IsLesion(mask.At(v)); });
  std::vector<bool> wanted(parts.list.size(), false);
  for (std::size_t v = 0; v < solid.size(); ++v) {
    if (solid[v] != 0) wanted[static_cast<std::size_t>(parts.labels[v] - 1)] = true;
  }
  for (std::size_t v = 0; v < solid.size(); ++v) {
    if (parts.labels[v] > 0 && wanted[static_cast<std::size_t>(parts.labels[v] - 1)]) solid[v] = 1;
  }
}

}  // namespace

ImportResult ImportMask(const ImportOptions& options) {
  if (options.keep_hu) throw Error("a mask without a CT has no CT numbers to keep");
  if (!options.isolate.keep_W.empty() || !options.isolate.drop_W.empty())
    throw Error("points to keep or to drop select bone in a CT, and there is none");
  ImportResult result;
  ImportReport& report = result.report;
  report.kind = "mask";
  Stages stages(report);
  BoneMask mask{Straighten(StoreAlongPatient(options.isolate.mask->tissue)), options.isolate.mask->how};
  report.input_hash = CalcHash(mask.tissue);
  report.warnings = mask.tissue.warnings;
  report.isolation = mask.how;
  const auto find_wanted = [&mask] {
    std::vector<std::uint8_t> wanted(mask.tissue.count());
    for (std::size_t v = 0; v < wanted.size(); ++v) wanted[v] = IsWanted(mask.At(v)) ? 1 : 0;
    return wanted;
  };
  std::vector<std::uint8_t> solid = find_wanted();
  if (std::find(solid.begin(), solid.end(), 1) == solid.end()) throw Error("the mask contains no wanted bone");
  Volume cropped = CropMask(mask, solid);
  const Volume whole = std::exchange(mask.tissue, std::move(cropped));
  for (std::int16_t& tissue : mask.tissue.hu) tissue = std::max(tissue, std::int16_t{0});  // beyond the mask
  solid = find_wanted();
  AddJoined(mask, solid);
  const Volume& lattice = mask.tissue;
  const Pose X_WL{glm::normalize(glm::quat_cast(lattice.axes_W)), lattice.origin_W};
  const Vec3 first_V = whole.VoxelFromWorld(lattice.origin_W);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const bool at_edge = first_V[axis] < -0.5 || first_V[axis] + lattice.size[a] > whole.size[a] + 0.5;
    report.cut_by_scan |= at_edge && !options.isolate.mask->cropped;
  }
  report.mask.used = true;
  report.mask.wanted_mm3 = static_cast<double>(std::count(solid.begin(), solid.end(), 1)) * lattice.CalcVoxelVolume();
  report.input_mm3 = report.mask.wanted_mm3;
  report.warnings.push_back(fmt::format(
      "made without a CT: the surface is that of the segmentation, with voxels of {:.4g} x {:.4g} x {:.4g} "
      "mm, the cortex is {:.4g} mm thick everywhere, marrow and cavities are not known, and there are no CT numbers",
      lattice.spacing_mm.x, lattice.spacing_mm.y, lattice.spacing_mm.z, options.mesh_shell_mm));
  stages.Done("read");

  const Components parts = FindComponents(lattice, [&solid](std::size_t v) { return solid[v] != 0; });
  const MandibleLikeness likeness = CheckMandibleLikeness(lattice, parts.labels, 1, parts.list.front());
  report.mandible = likeness.is_mandible;
  report.shape_objection = Describe(likeness, lattice.frame);
  TissueOptions tissue_options = options.tissue;
  tissue_options.shell_mm = options.mesh_shell_mm;
  tissue_options.up_W = likeness.up_W;
  const MaskSamples samples = SampleMask(mask, lattice, CalcDefaultReach(mask));
  Volume without_hu = lattice;
  without_hu.hu.clear();
  const TissueMap tissue(without_hu, solid, solid, nullptr, report.mandible, tissue_options, &samples);
  report.tooth_mm3 = tissue.tooth_mm3();
  stages.Done("tissues");
  if (options.progress) options.progress(0.1);

  const LabelMap labels{.size = lattice.size, .spacing_mm = lattice.spacing_mm, .X_WL = X_WL, .labels = solid};
  result.bone = MakeBoneFromLabels(labels, {{1, TissueMap::kPlainCortexRegion}}, options.voxel_mm,
                                   ChooseTable(options, report.mandible));
  if (options.progress) options.progress(0.6);
  SetRegions(
      result.bone, [&tissue](const Vec3& p_W) { return tissue.RegionAt(p_W); },
      std::max(options.voxel_mm, kRegionVoxel_mm), Part(options.progress, 0.6, 0.8));
  stages.Done("level set");
  DropDust(result.bone, false, report);
  Finish(options, result.bone, report);
  stages.Done("measure");
  return result;
}

}  // namespace kerf
