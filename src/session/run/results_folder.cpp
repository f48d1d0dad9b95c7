#include "session/run/results_folder.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "base/files/files.h"

namespace kerf {

std::vector<std::string> ReadEarlierResults(const std::string& folder, const std::string& list) {
  std::vector<std::string> names;
  std::error_code failed;
  if (!std::filesystem::is_regular_file(folder + "/" + list, failed)) return names;
  const auto summary = nlohmann::json::parse(ReadTextFile(folder + "/" + list), nullptr, false);
  if (!summary.is_object() || !summary.contains("kerf") || !summary.contains("files")) return names;
  for (const auto& file : summary["files"]) {
    if (!file.is_string()) continue;
    const std::filesystem::path name(file.get<std::string>());
    const std::string extension = name.extension().string();
    constexpr std::string_view kResults[] = {".png", ".svg", ".stl", ".vdb", ".csv", ".wav", ".md"};
    const bool result = std::find(std::begin(kResults), std::end(kResults), extension) != std::end(kResults);
    if (result && name == name.filename()) names.push_back(name.string());
  }
  return names;
}

std::vector<std::string> ListPieceFiles(const std::string& folder, const std::vector<std::string>& inputs) {
  std::vector<std::string> files;
  const auto add = [&](const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    if (name.starts_with("piece_") && name.ends_with(".stl")) files.push_back(folder + "/" + name);
  };
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(folder, none)) add(file.path());
  for (const std::string& input : inputs) add(input);
  return files;
}

}  // namespace kerf
