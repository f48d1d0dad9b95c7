// Saving of bones in the background.
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Writes bones to files in a thread of its own, one after the other. Each is written under a temporary name and then
/// renamed, so that a file with the final name is always complete.
class BoneSaver {
 public:
  BoneSaver();
  /// Writes what is still to be written.
  ~BoneSaver();
  BoneSaver(const BoneSaver&) = delete;
  BoneSaver& operator=(const BoneSaver&) = delete;

  /// Keeps the bone until it is written.
  void Save(std::shared_ptr<const Bone> bone, const std::string& path);
  /// Returns a sentence for each bone that could not be written since the last call. Finish() tries them again.
  std::vector<std::string> TakeFailures();
  /// Returns the bones that are not saved yet, or could not be, by path.
  std::map<std::string, std::shared_ptr<const Bone>> ListUnsaved();
  /// Waits until all bones are written, and tries again to write those that could not be. Returns a sentence for
  /// each that still can't be written.
  std::vector<std::string> Finish();

 private:
  struct Job {
    std::shared_ptr<const Bone> bone;
    std::string path;
  };
  void Run();

  std::mutex mutex_;  // protects everything below
  std::condition_variable changed_;
  std::deque<Job> jobs_;  // the first is being written if `writing_`
  std::vector<Job> failed_;
  std::vector<std::string> failures_;
  bool writing_ = false;
  Job written_;  // that is being written
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace kerf
