// A CT as a function of the place.
#pragma once

#include <memory>
#include <utility>

#include "bone/import/hu_sampler.h"
#include "view/live/slice_view.h"

namespace kerf {

/// Returns the CT's numbers, and air outside the scan; an empty function if `ct` is null.
inline CtSource MakeCtSource(std::shared_ptr<const Volume> ct) {
  if (!ct) return nullptr;
  constexpr double kAir_HU = -1024;
  const glm::dmat3 turn = glm::inverse(ct->axes_W);
  const auto sampler = std::make_shared<const HuSampler>(*ct);
  return [ct = std::move(ct), sampler, turn](const Vec3& p_W) {
    const Vec3 p_V = turn * (p_W - ct->origin_W) / ct->spacing_mm;
    for (int a = 0; a < 3; ++a) {
      if (p_V[a] < -0.5 || p_V[a] > ct->size[a] - 0.5) return kAir_HU;
    }
    return sampler->At(p_W);
  };
}

}  // namespace kerf
