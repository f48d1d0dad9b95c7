// Cancellation of lengthy work.
#pragma once

#include <exception>

namespace kerf {

/// A callback that receives the progress of lengthy work may throw this. The work then ends soon, leaves nothing
/// unfinished behind and lets the exception pass. It is not an Error, because it needs no message, and so that it is
/// not mistaken for a fault of a file.
class Cancelled final : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

}  // namespace kerf
