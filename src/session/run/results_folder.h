// A folder of results that a run writes into, perhaps for the second time.
#pragma once

#include <string>
#include <vector>

namespace kerf {

/// What an earlier run wrote into the folder, as the `list` there has it: plain names of files of results only.
std::vector<std::string> ReadEarlierResults(const std::string& folder, const std::string& list = "summary.json");
/// Removes those of `earlier` that are not among `written`.
void RemoveStaleResults(const std::string& folder, const std::vector<std::string>& earlier,
                        const std::vector<std::string>& written);

}  // namespace kerf
