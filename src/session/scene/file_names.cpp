#include "session/scene/file_names.h"

#include <fmt/format.h>

#include <filesystem>

namespace kerf {

std::string ResolveFileName(const std::string& name, const std::string& scene_file) {
  const std::filesystem::path folder = std::filesystem::absolute(scene_file).parent_path();
  return (folder / name).lexically_normal().string();
}

void ReadFileName(TableReader& reader, const char* key, std::string& file, const std::string& scene_file) {
  if (!reader.Has(key)) return;
  std::string name;
  reader(key, name, kFileNameLimit, "");
  if (!name.empty()) {
    file = ResolveFileName(name, scene_file);
  } else {
    reader.Fault(key, fmt::format("{} is empty", key));
  }
}

}  // namespace kerf
