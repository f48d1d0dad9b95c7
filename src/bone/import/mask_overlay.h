// Where a mask and the CT agree and where the mask overrides the CT, for pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bone/import/import.h"

namespace kerf {

/// Returns 1 for the voxels inside the mask by more than the reach where the CT shows neither bone nor a cavity.
/// `solid`: 1 for bone and cavities.
std::vector<std::uint8_t> FindAdded(const Isolation& isolation, const std::vector<std::uint8_t>& solid, double iso_hu);

/// An import's use of a mask, by position.
class MaskOverlay {
 public:
  enum class What { kNothing, kKept, kAdded, kCutOff, kGivenAway };

  /// Isolates the bone as Import() does with `options`, which have a mask. `ct`: along the patient's axes. Throws
  /// kerf::Error as Isolate() does.
  MaskOverlay(const Volume& ct, const ImportOptions& options);

  What At(const Vec3& p_W) const;
  /// Returns whether a point is in the mask's wanted bone.
  bool IsInMask(const Vec3& p_W) const;
  double added_mm3() const { return added_mm3_; }
  double cut_off_mm3() const { return cut_off_mm3_; }
  double given_away_mm3() const { return given_away_mm3_; }
  double reach_mm() const { return isolation_.mask->reach_mm; }

 private:
  std::optional<std::size_t> FindVoxel(const Vec3& p_W) const;

  Isolation isolation_;
  std::vector<std::uint8_t> added_;
  double added_mm3_ = 0;
  double cut_off_mm3_ = 0;
  double given_away_mm3_ = 0;
};

}  // namespace kerf
