// Progress of the construction of a bone by several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <thread>

namespace kerf {

/// Reports progress only from the thread that created it, even when other threads do the work.
class Progress {
 public:
  Progress(const std::function<void(double)>& report, double from, double to, std::size_t total)
      : report_(report), from_(from), to_(to), total_(std::max<std::size_t>(total, 1)) {}

  void Done(std::size_t count) {
    const std::size_t done = done_ += count;
    if (!report_ || std::this_thread::get_id() != owner_) return;
    report_(std::lerp(from_, to_, static_cast<double>(done) / static_cast<double>(total_)));  // at most to_
  }

 private:
  const std::function<void(double)>& report_;
  double from_;
  double to_;
  std::size_t total_;
  std::atomic<std::size_t> done_{0};
  std::thread::id owner_ = std::this_thread::get_id();
};

}  // namespace kerf
