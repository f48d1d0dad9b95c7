#include "session/run/work_list.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <thread>

namespace kerf {

bool WorkList::Run(int threads, const std::atomic<bool>* stop,
                   const std::function<void(const std::string& stage, double fraction)>& progress) {
  double whole = 0;
  for (const Item& item : items_) whole += item.cost;
  std::mutex mutex;  // protects all variables below
  std::size_t next = 0;
  std::size_t ended = 0;
  double done = 0;
  std::exception_ptr failure;
  const auto work = [&] {
    for (;;) {
      const Item* item = nullptr;
      {
        const std::lock_guard lock(mutex);
        if (next >= items_.size() || failure || (stop != nullptr && stop->load())) return;
        item = &items_[next++];
        if (progress) progress(item->stage, whole > 0 ? done / whole : 0);
      }
      std::exception_ptr thrown;
      try {
        item->work();
      } catch (...) {
        thrown = std::current_exception();
      }
      const std::lock_guard lock(mutex);
      if (thrown && !failure) failure = thrown;
      ++ended;
      done += item->cost;
      if (progress) progress(item->stage, whole > 0 ? done / whole : 1);
    }
  };
  if (threads <= 0) threads = static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  threads = std::min(threads, static_cast<int>(items_.size()));
  std::vector<std::jthread> others;  // also joined if `progress` throws
  for (int i = 1; i < threads; ++i) others.emplace_back(work);
  work();
  others.clear();
  if (failure) std::rethrow_exception(failure);
  return ended == items_.size();
}

}  // namespace kerf
