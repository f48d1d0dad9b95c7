// The list of force laws.
#pragma once

#include "kerf/force.h"

// One line per law: the function in the law's file that describes it. The first law is the default.
#define KERF_FORCE_LAWS(LAW) \
  LAW(TwoComponent)          \
  LAW(HertzChip)             \
  LAW(HertzConstantBite)     \
  LAW(EdgePlusChip)          \
  LAW(Tabulated)

namespace kerf {

#define KERF_DECLARE_LAW(function) const ForceLawInfo& function();
KERF_FORCE_LAWS(KERF_DECLARE_LAW)
#undef KERF_DECLARE_LAW

/// Returns the first fault of a law, as RegisterForceLaw() checks it, as a sentence without the law's name; empty:
/// none.
std::string FindLawFault(const ForceLawInfo& info);

/// Returns true for a law that RegisterForceLaw() has added.
bool IsOwnLaw(const ForceLaw& law);

/// Returns true if the law has a table without rows for some tissue.
bool LacksTissue(const ForceLaw& law);

/// Returns the table that comes with kerf.
const std::shared_ptr<const ForceTable>& DefaultForceTable();

}  // namespace kerf
