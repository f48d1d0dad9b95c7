// The solid of the generic mandible (kerf/models.h).
#pragma once

#include <memory>

#include "bone/grid/build.h"
#include "bone/models/teeth_mask.h"
#include "kerf/models.h"

namespace kerf {

/// Named points of the left half, world frame; for the right half, x has the opposite sign.
struct MandibleLandmarks {
  Vec3 menton{0};              // point where the base line touches the chin, midline
  Vec3 gonion{0};              // intersection of base line and back edge of the ramus, side view
  Vec3 base_line{0};           // unit, from gonion forward, in the y-z plane
  Vec3 back_edge{0};           // unit, from gonion up along the back edge of the ramus, in the y-z plane
  Vec3 first_molar{0};         // canal centre below the first molar's mesial root
  Vec3 first_molar_out{0};     // unit, buccal, horizontal
  Vec3 mental_foramen_out{0};  // unit, buccal, horizontal
  Vec3 mental_foramen{0};      // centre of the canal's outer end
  Vec3 mandibular_foramen{0};
  Vec3 lingula{0};
  Vec3 condyle{0};  // centre
};

/// The parts of the mandible that affect its values within a ball: by default all.
struct MandibleParts {
  bool oblique_line = true, chin = true, openings = true, lingula = true;
  TeethMask sockets = kAllTeeth, teeth = kAllTeeth;
};

/// The solid described by functions of a world point. Immutable, thread-safe. `parts`: those of FindParts() for a ball
/// that contains the point, for the same value, bit for bit, in less time.
class MandibleShape {
 public:
  /// Throws kerf::Error that names the first parameter out of range.
  explicit MandibleShape(const MandibleParams& params);
  ~MandibleShape();

  /// Values for bone and teeth together, or for one of them, mm: zero on the surface, negative inside, and
  /// approximately a distance near the surface.
  double Value(const Vec3& p_W, const MandibleParts& parts = {}) const;
  double BoneValue(const Vec3& p_W) const;   // without crowns
  double ToothValue(const Vec3& p_W) const;  // crowns and roots, including the parts inside the bone
  double CanalValue(const Vec3& p_W) const;  // signed distance to the canal's wall
  BlockClass Classify(const Vec3& centre_W, double radius_mm, const MandibleParts& parts = {}) const;
  int RegionAt(const Vec3& p_W) const;
  int CortexRegionAt(const Vec3& p_W) const;  // if the point is in the cortex
  /// Sets the regions of a leaf to those of RegionAt(), or to kRegionByPlace in the cortex; see SolidField.
  void SetRegions(const LeafPlace& leaf, const WantedVoxels& wanted, LeafRegions& ids) const;
  MandibleParts FindParts(const Vec3& centre_W, double radius_mm) const;

  const MandibleLandmarks& landmarks() const;
  Box3 bounds() const;  // contains the surface with some margin

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

/// Throws kerf::Error if the table lacks a region of the generic mandible.
void CheckMandibleRegions(const MaterialTable& materials);
/// Notes in the bone how it was made: the generator and its parameters.
void DescribeMandible(const MandibleParams& params, Bone& bone);

}  // namespace kerf
