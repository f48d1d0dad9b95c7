// Non-blocking test of whether the result of another thread is available.
#pragma once

#include <chrono>
#include <future>

namespace kerf {

template <typename T>
bool IsReady(const std::future<T>& future) {
  return future.valid() && future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace kerf
