// Whether what holds the saw, which the simulation does not know, is inside the bone.
#pragma once

#include <optional>
#include <vector>

#include "kerf/bone.h"
#include "kerf/tool.h"

namespace kerf {

/// Where the hub of a disc and the handpiece first were inside the bone while the saw cut; none: never.
struct HolderPlaces {
  std::optional<Vec3> hub_W{};
  std::optional<Vec3> handpiece_W{};
};

/// Detects that the hub of a disc or the handpiece is inside a bone. Either one counts as inside from half the bone's
/// band (see Bone::band_mm()) below the surface on, until it is out of the bone.
class HolderWatch {
 public:
  /// Forgets the places. Throws Error for an invalid tool.
  void SetTool(const Tool& tool);
  /// `X_WT`: pose of the tool. A call takes about 10 us.
  void Update(const Bone& bone, const Pose& X_WT);
  /// Keeps the places of what is in the bone now, in which the saw cuts.
  void NoteCut();
  bool hub_in_bone() const { return hub_.place_W.has_value(); }
  bool handpiece_in_bone() const { return handpiece_.place_W.has_value(); }
  const HolderPlaces& places() const { return places_; }

 private:
  struct Part {
    std::vector<Vec3> points_T;     // on its surface
    std::optional<Vec3> place_W{};  // one that is in the bone

    void Update(const Bone& bone, const Pose& X_WT);
  };
  Part hub_;
  Part handpiece_;
  HolderPlaces places_;
};

}  // namespace kerf
