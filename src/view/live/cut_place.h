// Where the tool cuts, for the picture. Pure.
#pragma once

#include <optional>

#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// Estimates the place of contact from the force on the tool: the point of the rim (disc) or of the surface (ball) that
/// the force pushes away from the bone. Of a straight edge with a stroke, it is the middle of the part that lies in
/// `uncut`, the bone before any cut, or else of the whole edge. Returns nullopt for a force below 0.02 N, or one along
/// the spindle of a disc. `uncut`: may be null.
std::optional<Vec3> EstimateContact(const Tool& tool, const Pose& X_WT, const Vec3& f_T_W_N,
                                    const Bone* uncut = nullptr);

/// Follows the place of contact smoothly. It keeps the last place for a while, so that what depends on it does not
/// flicker when the tool leaves the bone for a moment.
class CutPlace {
 public:
  static constexpr double kHold_s = 0.6;

  /// `f_T_W_N`: force on the tool; `dt_s`: time since the last call; `uncut`: as for EstimateContact().
  void Update(const Tool& tool, const Pose& X_WT, const Vec3& f_T_W_N, double dt_s, const Bone* uncut = nullptr);
  void Clear() { *this = {}; }
  /// Unset if the tool has not touched bone for kHold_s.
  std::optional<Vec3> p_W() const { return p_W_; }

 private:
  std::optional<Vec3> p_T_;  // tool frame
  std::optional<Vec3> p_W_;
  double since_s_ = 0;
};

}  // namespace kerf
