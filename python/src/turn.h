// Use of an object by one thread at a time.
#pragma once

#include <atomic>
#include <string>

#include "kerf/error.h"

namespace kerf::python {

/// Keeps two threads from using an object at once.
class Turn {
 public:
  /// `what`: the object, for the message. Throws kerf::Error if another thread uses it.
  Turn(std::atomic<bool>& busy, const char* what) : busy_(busy) {
    if (busy_.exchange(true)) throw Error(std::string("this ") + what + " is in use by another thread");
  }
  ~Turn() { busy_ = false; }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::atomic<bool>& busy_;
};

}  // namespace kerf::python
