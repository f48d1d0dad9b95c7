// The mandibular canal of the left half: a tube from the mandibular foramen to the mental foramen.
#pragma once

#include <vector>

#include "bone/models/mandible_body.h"
#include "bone/models/mandible_ramus.h"

namespace kerf {

class MandibleCanal {
 public:
  MandibleCanal(const MandibleLayout& layout, const MandibleBody& body, const MandibleRamus& ramus);

  /// Returns the distance to the tube's wall, negative inside. Beyond about 3 mm the value may be too small.
  double Distance(const Vec3& p_W) const;
  /// Returns the distance to the funnels at its two ends, which are removed from the bone. Here and below: if the
  /// distance exceeds `limit`, any value larger than `limit` may be returned.
  double OpeningDistance(const Vec3& p_W, double limit) const;
  /// Returns the distance to the tongue of bone in front of the mandibular foramen.
  double LingulaDistance(const Vec3& p_W, double limit) const { return tongue_.Distance(p_W, limit); }

  const Vec3& lingula() const { return lingula_; }
  const Vec3& mandibular_foramen() const { return path_.front(); }
  const Vec3& mental_foramen() const { return mental_foramen_; }
  const Vec3& first_molar() const { return first_molar_; }

 private:
  double radius_ = 1;
  std::vector<Vec3> path_;
  struct Chunk {
    Box3 box;
    std::size_t first = 0, last = 0;  // segments of the path
  };
  std::vector<Chunk> chunks_;
  RoundedCones mandibular_opening_, mental_opening_, tongue_;
  Vec3 lingula_{0}, mental_foramen_{0}, first_molar_{0};
};

}  // namespace kerf
