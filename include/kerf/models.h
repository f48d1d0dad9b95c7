// Bones that are made from numbers: blocks and plates with layers of material, for experiments with a known answer, and
// the generic mandible, which is parametric, implicit and mirror-symmetric.
//
// Frame of the mandible: LPS as in a CT with the head upright, mm: x to the patient's left, y to the back, z up. Its
// origin is the point between the edges of the two lower central incisors; the occlusal plane is z = 0. Lower teeth,
// crest and body have negative z.
#pragma once

#include <functional>
#include <vector>

#include "kerf/bone.h"
#include "kerf/describe.h"
#include "kerf/material.h"

namespace kerf {

/// One layer of a block; layers are listed from the top face (+z) down.
struct MaterialLayer {
  double thickness_mm = 0;
  int region = 24;
};

/// A box with edges along the axes of its frame B. The origin is at the centre of its top face, z points up (out of the
/// bone).
struct BlockParams {
  Vec3 size_mm{40, 20, 20};
  Pose X_WB;                          // pose of the block in the world
  std::vector<MaterialLayer> layers;  // empty: region 24 throughout; the last layer fills the rest
  double voxel_mm = 0.1;
};

template <typename V>
void Describe(MaterialLayer& p, V&& visit) {
  visit("thickness_mm", p.thickness_mm, Range{0.001, 1000}, "thickness of the layer; the last layer fills the rest");
  visit("region", p.region, kRegionRange, "region of the layer in the table of materials");
}

template <typename V>
void Describe(BlockParams& p, V&& visit) {
  visit("size_x_mm", p.size_mm.x, Range{0.1, 1000}, "length of the block along its x axis");
  visit("size_y_mm", p.size_mm.y, Range{0.1, 1000}, "length of the block along its y axis");
  visit("size_z_mm", p.size_mm.z, Range{0.1, 1000}, "height of the block, along its z axis");
  visit("voxel_mm", p.voxel_mm, kVoxelRange_mm, "edge of a voxel");
  visit("top_mm", p.X_WB.p_AB, kCoordinateRange_mm, "middle of the block's top face (+z), world frame");
  visit("rotation", p.X_WB.R_AB, "rotation from the block's frame to the world frame: unit quaternion [w, x, y, z]");
}

/// Returns a plate of the body of the mandible laid flat: a cortical plate of 2.2 mm, cancellous bone, and a cortical
/// plate of 2.0 mm (buccal and lingual plates at the first molar, CT of 20 dry mandibles), 13.5 mm in total.
BlockParams MakePlateParams();

/// Makes a block or a plate. `progress`: as in MakeMandible(). Throws kerf::Error if a parameter is out of range, the
/// pose is not valid, a layer has an unknown region or lies entirely below the block, or if the block would be too
/// large.
Bone MakeBlock(const BlockParams& params, const MaterialTable& materials = DefaultMandibleTable(),
               const std::function<void(double)>& progress = {});

/// Dimensions, mm and degrees. docs/mandible.md gives their meaning on the bone and the anatomical values.
struct MandibleParams {
  double symphysis_height_mm = 30;
  double mental_foramen_height_mm = 26.6;
  double first_molar_height_mm = 28.5;
  double first_molar_width_mm = 13.5;

  double ramus_height_mm = 44.8;
  double ramus_width_mm = 31.3;
  double ramus_thickness_mm = 7.6;
  double gonial_angle_deg = 124.8;
  double coronoid_height_mm = 59;
  double condyle_height_mm = 54;
  double bigonial_mm = 97;
  double bicondylar_mm = 118;
  double condyle_width_mm = 19.5;
  double condyle_depth_mm = 9;

  double lingula_from_back = 0.53;
  double lingula_from_below = 0.65;
  double canal_diameter_mm = 2.8;
  double canal_to_buccal_mm = 6.6;
  double canal_to_base_mm = 8.8;
  double foramen_diameter_mm = 3.1;
  double foramen_to_base_mm = 12.3;

  double cortex_front_mm = 3.7;
  double cortex_buccal_mm = 2.2;
  double cortex_lingual_mm = 2.0;
  double cortex_back_mm = 1.4;

  int teeth = 14;
  double voxel_mm = 0.1;
};

template <typename V>
void Describe(MandibleParams& p, V&& visit) {
  visit("symphysis_height_mm", p.symphysis_height_mm, Range{24, 38},
        "height of the body in the midline, crest to lower border");
  visit("mental_foramen_height_mm", p.mental_foramen_height_mm, Range{21, 33},
        "height of the body at the mental foramen");
  visit("first_molar_height_mm", p.first_molar_height_mm, Range{22, 35}, "height of the body at the first molar");
  visit("first_molar_width_mm", p.first_molar_width_mm, Range{10.5, 17},
        "width of the body at the first molar, at the canal's height");
  visit("ramus_height_mm", p.ramus_height_mm, Range{38, 54}, "lowest point of the notch above the base line");
  visit("ramus_width_mm", p.ramus_width_mm, Range{24, 38},
        "width of the ramus at the lingula, perpendicular to its back edge");
  visit("ramus_thickness_mm", p.ramus_thickness_mm, Range{6, 10}, "thickness of the ramus behind the lingula");
  visit("gonial_angle_deg", p.gonial_angle_deg, Range{110, 138},
        "angle between the base line and the back edge of the ramus");
  visit("coronoid_height_mm", p.coronoid_height_mm, Range{48, 68.5}, "tip of the coronoid process above the base line");
  visit("condyle_height_mm", p.condyle_height_mm, Range{46, 68.6}, "top of the condyle above the base line");
  visit("bigonial_mm", p.bigonial_mm, Range{84, 112},
        "breadth between the outer faces at the angles, up to 10 mm above the base line");
  visit("bicondylar_mm", p.bicondylar_mm, Range{104, 134}, "breadth between the outer poles of the condyles");
  visit("condyle_width_mm", p.condyle_width_mm, Range{15, 24}, "length of the condyle's long, nearly transverse axis");
  visit("condyle_depth_mm", p.condyle_depth_mm, Range{7, 12}, "length of the condyle's short axis, front to back");
  visit("lingula_from_back", p.lingula_from_back, Range{0.4, 0.65},
        "lingula: distance from the back edge / ramus width");
  visit("lingula_from_below", p.lingula_from_below, Range{0.5, 0.75},
        "lingula: height above the base line / ramus height");
  visit("canal_diameter_mm", p.canal_diameter_mm, Range{1.5, 4}, "diameter of the mandibular canal");
  visit("canal_to_buccal_mm", p.canal_to_buccal_mm, Range{3, 9},
        "bone on the buccal side of the canal at the first molar");
  visit("canal_to_base_mm", p.canal_to_base_mm, Range{5, 13}, "bone below the canal at the first molar");
  visit("foramen_diameter_mm", p.foramen_diameter_mm, Range{2, 5}, "height of the mental foramen");
  visit("foramen_to_base_mm", p.foramen_to_base_mm, Range{8, 17}, "mental foramen's lower edge above the lower border");
  visit("cortex_front_mm", p.cortex_front_mm, Range{1.5, 5}, "thickness of the cortex at the symphysis, facial");
  visit("cortex_buccal_mm", p.cortex_buccal_mm, Range{1, 4}, "thickness of the buccal plate at the first molar");
  visit("cortex_lingual_mm", p.cortex_lingual_mm, Range{1, 4}, "thickness of the lingual plate at the first molar");
  visit("cortex_back_mm", p.cortex_back_mm, Range{0.8, 3}, "thickness of the cortex at the ramus and condyle");
  visit("teeth", p.teeth, Range{0, 16}, "number of teeth; valid are 0, 14 (no third molars) and 16");
  visit("voxel_mm", p.voxel_mm, kVoxelRange_mm, "edge of a voxel");
}

/// Makes the generic mandible. `progress`, which is optional, is called with values from 0 to 1, from one thread; what
/// it throws ends the work. The voxels of the region grid have an edge of voxel_mm, but at least 0.2 mm. Throws
/// kerf::Error if a parameter is out of range or `materials` lacks one of the regions 1 to 34.
Bone MakeMandible(const MandibleParams& params, const MaterialTable& materials = DefaultMandibleTable(),
                  const std::function<void(double)>& progress = {});

}  // namespace kerf
