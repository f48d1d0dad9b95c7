// Whether what was asked of another thread is there, for whoever may not wait.
#pragma once

#include <chrono>
#include <future>

namespace kerf {

template <typename T>
bool IsReady(const std::future<T>& future) {
  return future.valid() && future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace kerf
