// How bad input is reported: one exception type with one clear sentence, thrown outside the tick only.
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
