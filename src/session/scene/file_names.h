// Names of files in a scene.
#pragma once

#include <string>

#include "base/toml/table_reader.h"

namespace kerf {

inline constexpr TextLimit kFileNameLimit{4096};

/// Returns the absolute path of a file that a scene names relative to its own folder.
std::string ResolveFileName(const std::string& name, const std::string& scene_file);
/// Sets `file` to the absolute path that the key names, if the key is present. Records a fault if the name is empty.
void ReadFileName(TableReader& reader, const char* key, std::string& file, const std::string& scene_file);

}  // namespace kerf
