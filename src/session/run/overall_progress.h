// Progress of a run as one fraction of all its stages, which never decreases.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "session/run/loop_options.h"
#include "session/scene/scene.h"

namespace kerf {

/// A stage that a run reports to its progress function, and how long it is expected to take. Only the ratios matter.
struct ExpectedStage {
  std::string name;
  double seconds = 0;
  bool may_end_early = false;  // the user may end it
};

/// Return the stages of `kerf run`, in either mode, and of `kerf loop`. `results`: with those after the cut, in which
/// the results are written.
std::vector<ExpectedStage> ListRunStages(const Scene& scene, bool results);
std::vector<ExpectedStage> ListLoopStages(const Scene& scene, const LoopOptions& options, bool results);

/// Computes the completed fraction of a run from that of its current stage.
class OverallProgress {
 public:
  explicit OverallProgress(std::vector<ExpectedStage> stages) : stages_(std::move(stages)) {}
  /// Returns the completed fraction of all stages, 0 to 1, if `fraction` of `stage` is completed: at least what was
  /// returned before. A stage that is not in the list changes nothing. Of a stage that was ended early, only what was
  /// completed counts.
  double Advance(const std::string& stage, double fraction);

 private:
  std::vector<ExpectedStage> stages_;
  std::size_t now_ = 0;  // index of the current stage
  double fraction_ = 0;  // completed, of that stage
  double completed_ = 0;
};

}  // namespace kerf
