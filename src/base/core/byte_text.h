// Sizes in bytes as text for messages.
#pragma once

#include <string>
#include <utility>

namespace kerf {

/// Formats a required and an available size: "40.0 MB" and "2.1 MB", both in kB, MB or GB, depending on the larger.
/// Uses as many decimals as needed to make them differ, at most 9.
std::pair<std::string, std::string> FormatBytePair(double needed, double available);

}  // namespace kerf
