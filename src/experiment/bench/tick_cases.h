// The cases of `kerf bench tick`.
#pragma once

#include <string>
#include <vector>

#include "experiment/bench/cut_case.h"

namespace kerf {

/// Names of all cases, in the order in which they run.
std::vector<std::string> NamesOfTickCases();

/// Throws Error for a name that no case has, naming the nearest.
void CheckTickCases(const std::vector<std::string>& names);

/// Runs the cases named, all when none is; what compares cases with each other is worked out from those that ran.
/// Throws Error as above, and for a core that is not there.
std::vector<BenchResult> RunTickCases(const std::vector<std::string>& names, const BenchOptions& options);

}  // namespace kerf
