// The sets of measurements that are part of the program, and those of a folder.
#pragma once

#include <string>
#include <vector>

#include "experiment/validation/measured_set.h"

namespace kerf {

/// Returns the sets of volumes/measured, ordered by name.
std::vector<MeasuredSet> BuiltInSets();

/// Returns the built-in sets and those of all files NAME.toml in `folder`, ordered by name. A set replaces the built-in
/// one of the same name. Throws Error if the folder cannot be read or has no such file, or a file is faulty.
std::vector<MeasuredSet> ReadSets(const std::string& folder);

}  // namespace kerf
