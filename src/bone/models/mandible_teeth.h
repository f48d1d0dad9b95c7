// The lower teeth of the left half: crowns by tooth type on the dental arch, and roots in the bone.
#pragma once

#include <vector>

#include "bone/models/mandible_layout.h"
#include "bone/models/teeth_mask.h"

namespace kerf {

class MandibleTeeth {
 public:
  explicit MandibleTeeth(const MandibleLayout& layout);

  /// Returns the distance to crowns and roots of a set of teeth. If it exceeds `limit`, any value larger than `limit`
  /// may be returned.
  double Distance(const Vec3& p_W, double limit, TeethMask teeth = kAllTeeth) const;
  /// Returns the distance to the roots and the thin layer of bone around them. This layer forms the ridges that cover
  /// the roots on the alveolar process.
  double SocketDistance(const Vec3& p_W, double limit, TeethMask teeth = kAllTeeth) const;
  /// Returns the teeth whose Distance() or SocketDistance() may be at most `limit` at a point within a ball.
  TeethMask FindNear(const Vec3& centre_W, double radius_mm, double limit) const;
  TeethMask FindNearSockets(const Vec3& centre_W, double radius_mm, double limit) const;
  /// Contains all roots with their layer of bone.
  const Box3& root_box() const { return root_box_; }

 private:
  enum class Kind { kIncisor, kCanine, kPremolar, kMolar };
  struct Tooth {
    Kind kind = Kind::kIncisor;
    Vec3 neck{0};                                     // middle of the crown's base
    Vec3 along{1, 0, 0}, out{0, -1, 0}, up{0, 0, 1};  // distal, facial, occlusal
    double width = 0, depth = 0, height = 0;          // of the crown: along the arch, across it, above the neck
    std::vector<RoundedCone<Vec3>> roots;
    Box3 box, root_box;  // contain the tooth, and its roots with the bone around them
  };
  /// If the distance exceeds `limit`, any value larger than `limit` may be returned.
  static double CrownDistance(const Tooth& tooth, const Vec3& local, double limit);

  template <typename BoxOf>
  TeethMask FindBoxes(const Vec3& centre_W, double reach_mm, BoxOf&& box_of) const;

  std::vector<Tooth> teeth_;
  Box3 box_, root_box_;
};

}  // namespace kerf
