// Many pieces of work that don't need each other, on all cores.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace kerf {

class WorkList {
 public:
  /// `cost`: what it takes, in any unit; for the progress. `stage`: what it is part of.
  void Add(std::string stage, double cost, std::function<void()> work) {
    items_.push_back({std::move(stage), cost, std::move(work)});
  }
  /// In the order of the list as far as can be. `threads` 0: as many as the machine has. `progress` is called from this
  /// thread's and others' work, one call at a time. Ends early when `stop` (may be null) is true: what was begun is
  /// ended. True: all was done. Throws the first exception of a work, when the others have ended.
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
