// The list of effects.
#pragma once

#include "kerf/effects.h"

// A line for each effect: the function in its file that describes it. The order is that in which a tick calls them: who
// needs another stands after it.
// clang-format off
#define KERF_EFFECTS(EFFECT) \
  EFFECT(KerfFriction)       \
  EFFECT(TangentialForce)    \
  EFFECT(Spindle)            \
  EFFECT(Guide)              \
  EFFECT(ToothVibration)     \
  EFFECT(Heat)               \
  EFFECT(Structures)         \
  EFFECT(Fragments)          \
  EFFECT(Chips)              \
  EFFECT(Sound)
// clang-format on

namespace kerf {

#define KERF_DECLARE_EFFECT(function) const EffectInfo& function();
KERF_EFFECTS(KERF_DECLARE_EFFECT)
#undef KERF_DECLARE_EFFECT

}  // namespace kerf
