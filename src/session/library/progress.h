// Progress that can be cancelled by what is called with it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/core/cancelled.h"
#include "kerf/error.h"
#include "kerf/scene.h"
#include "session/run/overall_progress.h"

namespace kerf {

/// Returns a function that throws Cancelled if `progress` returns false; an empty one for an empty one.
inline std::function<void(double)> ThrowIfCancelled(const ShowProgress& progress) {
  if (!progress) return {};
  return [&progress](double fraction) {
    if (!progress(fraction)) throw Cancelled();
  };
}

/// Shows the progress of a run over all its stages.
class ShownStages {
 public:
  /// `progress` must outlive this object.
  ShownStages(std::vector<ExpectedStage> stages, const ShowProgress& progress)
      : overall_(std::move(stages)), progress_(progress) {}
  /// Returns false if the work is to be cancelled.
  bool Show(const std::string& stage, double fraction) {
    return !progress_ || progress_(overall_.Advance(stage, fraction));
  }
  /// Returns the progress function of a stage. It throws Cancelled, and this object must outlive it.
  std::function<void(double)> Stage(const std::string& name) {
    return [this, name](double fraction) {
      if (!Show(name, fraction)) throw Cancelled();
    };
  }
  /// Shows that all is completed.
  void End() const {
    if (progress_) progress_(1);
  }

 private:
  OverallProgress overall_;
  const ShowProgress& progress_;
};

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
