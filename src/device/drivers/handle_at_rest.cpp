#include "device/drivers/handle_at_rest.h"

namespace kerf {

bool HandleAtRest::Update(const ServoSample& sample) {
  const Vec3& p = sample.sample.X_DH.p_AB;
  const bool unseen = sample.at_s - seen_s_ > kUnseen_s;
  seen_s_ = sample.at_s;
  if (unseen || glm::length(p) > reach_mm_ || glm::length(p - place_D_mm_) > kStill_mm) {
    place_D_mm_ = p;
    since_s_ = sample.at_s;
  }
  return sample.at_s - since_s_ > kStill_s;
}

}  // namespace kerf
