// The list of effects.
#pragma once

#include "kerf/effects.h"

// One line per effect: the function in the effect's file that describes it. Effects are called in this order; an effect
// must follow the effects that it needs.
// clang-format off
#define KERF_EFFECTS(EFFECT) \
  EFFECT(KerfFriction)       \
  EFFECT(TangentialForce)    \
  EFFECT(Spindle)            \
  EFFECT(Guide)              \
  EFFECT(Handpiece)          \
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
