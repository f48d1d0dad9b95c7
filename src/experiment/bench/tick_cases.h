// The cases of `kerf bench tick`.
#pragma once

#include <string>
#include <vector>

#include "experiment/bench/cut_case.h"

namespace kerf {

/// Returns the names of all cases, in the order in which they run.
std::vector<std::string> NamesOfTickCases();

/// Throws Error for a name without a case; the message names the most similar one.
void CheckTickCases(const std::vector<std::string>& names);

/// Runs the named cases, or all if `names` is empty. Comparisons between cases are computed from those that ran. Throws
/// Error as CheckTickCases() does, and if the core does not exist.
std::vector<BenchResult> RunTickCases(const std::vector<std::string>& names, const BenchOptions& options);

}  // namespace kerf
