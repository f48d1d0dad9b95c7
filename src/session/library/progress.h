// Progress that can be cancelled by what is called with it.
#pragma once

#include <functional>

#include "base/core/cancelled.h"
#include "kerf/error.h"
#include "kerf/scene.h"

namespace kerf {

/// Returns a function that throws Cancelled if `progress` returns false; an empty one for an empty one.
inline std::function<void(double)> ThrowIfCancelled(const ShowProgress& progress) {
  if (!progress) return {};
  return [&progress](double fraction) {
    if (!progress(fraction)) throw Cancelled();
  };
}

/// Calls `work`, and throws kerf::Error if it was cancelled.
template <typename Work>
auto OrCancelled(Work&& work) {
  try {
    return work();
  } catch (const Cancelled&) {
    throw Error("the work was cancelled");
  }
}

}  // namespace kerf
