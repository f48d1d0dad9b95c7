// Reading of a project's CT again from the file or folder from which its bone was made.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bone/import/volume.h"
#include "kerf/bone.h"

namespace kerf {

/// Reads the CT from which a bone was imported, as the import does. Throws Error with one sentence for TrMade() if it
/// is no longer there, cannot be read, or is not the one that the bone's notes state; lets Cancelled pass.
Volume ReadCtOf(const Bone& bone, const std::string& path, const std::function<void(double)>& progress);

/// Reads at most one CT at a time, in another thread.
class CtReader {
 public:
  /// A CT, or the reason for which there is none, a sentence for TrMade().
  struct Result {
    std::shared_ptr<const Volume> ct;
    std::string why_not;
  };

  ~CtReader() { Cancel(); }
  /// `path`: see ReadCtOf().
  void Begin(std::shared_ptr<const Bone> bone, const std::string& path);
  /// Ends the reading in progress; its work ends by itself.
  void Cancel();
  /// Returns the result once, when it is there.
  std::optional<Result> Take();
  /// Waits until no work is left, but not longer than `until`. Returns false if some is left.
  bool WaitUntil(std::chrono::steady_clock::time_point until) const;

 private:
  std::future<Result> reading_;
  std::shared_ptr<std::atomic<bool>> cancelled_;  // of the reading in progress
  std::vector<std::future<Result>> unused_;       // end by themselves
};

}  // namespace kerf
