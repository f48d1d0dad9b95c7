// Numbers of bytes in messages.
#pragma once

#include <string>
#include <utility>

namespace kerf {

/// What is needed and what there is of it: "40.0 MB" and "2.1 MB", in kB, MB or GB by the larger, with as many digits
/// as it takes for them to differ, where they do.
std::pair<std::string, std::string> FormatBytePair(double needed, double there);

}  // namespace kerf
