// Section [force] of a scene: the force law, its parameters and its table.
#pragma once

#include <string>

#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "kerf/force.h"

namespace kerf {

/// File with the table of the law.
struct ForceTableFile {
  std::string file;   // absolute path; empty: none
  std::string place;  // prefix of messages about it: "scene.toml:12:1: "
};

/// Reads [force]. The file of a table is returned, to be read by ReadForceTableFile().
ForceTableFile ReadForce(TableReader& root, ForceLaw& law, const std::string& scene_file, Faults& faults);
/// Sets the law's table, if there is a file. Throws kerf::Error with the place of the key.
void ReadForceTableFile(const ForceTableFile& file, ForceLaw& law);
/// Rejects the keys with which effects convert a thrust to a cutting force, if the law states the cutting force.
void RefuseCuttingRatios(const TomlNode& document, const ForceLaw& law, Faults& faults);

}  // namespace kerf
