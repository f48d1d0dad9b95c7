// Reporting of bad input: one exception type, whose message is one clear sentence. In ticks: own_effect.h.
#pragma once

#include <stdexcept>
#include <string>

namespace kerf {

/// Input or environment that kerf cannot work with. what() is a sentence for the user, without a trailing newline.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace kerf
