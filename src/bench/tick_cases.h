// The cases of `kerf bench tick`.
#pragma once

#include <string>
#include <vector>

#include "bench/cut_case.h"

namespace kerf {

/// Names of all cases, in the order in which they run.
std::vector<std::string> NamesOfTickCases();

/// Runs the cases named, all when none is; what compares cases with each other is worked out from those that ran.
/// Throws Error for an unknown name, naming the nearest.
std::vector<BenchResult> RunTickCases(const std::vector<std::string>& names, const BenchOptions& options);

}  // namespace kerf
