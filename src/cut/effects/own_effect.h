// Effects that another program has added.
#pragma once

#include <memory>
#include <span>

#include "cut/effects/effect.h"
#include "kerf/own_effect.h"

namespace kerf {

/// Makes an effect that has `make_own`. Throws kerf::Error if its function returns null.
std::unique_ptr<Effect> MakeOwnEffect(const EffectInfo& info, std::span<const EffectValue> values,
                                      const EffectSetup& setup);

}  // namespace kerf
