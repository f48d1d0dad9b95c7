// Runs independent work items on all cores.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace kerf {

class WorkList {
 public:
  /// Adds an item. `cost`: its relative duration in any unit, for the progress. `stage`: name of the stage that the
  /// item belongs to.
  void Add(std::string stage, double cost, std::function<void()> work) {
    items_.push_back({std::move(stage), cost, std::move(work)});
  }
  /// Runs the items in the order of the list as far as possible. `threads`: 0 means one for each of the machine's
  /// cores. `progress` is called from this and other threads, one call at a time. Starts no further items once `stop`
  /// (optional) is true; items in progress are completed. Returns true if all were completed. Throws the first
  /// exception of an item after the others have ended.
  bool Run(int threads, const std::atomic<bool>* stop,
           const std::function<void(const std::string& stage, double fraction)>& progress);

 private:
  struct Item {
    std::string stage;
    double cost = 1;
    std::function<void()> work;
  };
  std::vector<Item> items_;
};

}  // namespace kerf
