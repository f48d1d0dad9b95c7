#include "experiment/validation/measured_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/files/files.h"
#include "kerf/error.h"
#include "measured_sets_toml.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxSetBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxSets = 1000;

std::map<std::string, MeasuredSet> MapOfBuiltInSets() {
  std::map<std::string, MeasuredSet> sets;
  for (const MeasuredSetFile& file : kMeasuredSetFiles) {
    sets[file.name] = ParseMeasuredSet(file.toml, fmt::format("volumes/measured/{}.toml", file.name), file.name);
  }
  return sets;
}

std::vector<MeasuredSet> ListOf(const std::map<std::string, MeasuredSet>& sets) {
  std::vector<MeasuredSet> list;
  for (const auto& [name, set] : sets) list.push_back(set);
  return list;
}

/// Returns the paths of all .toml files in a folder, in order.
std::vector<std::filesystem::path> ListTomlFiles(const std::string& folder) {
  std::error_code fault;
  std::filesystem::directory_iterator files(folder, fault);
  if (fault) throw Error(fmt::format("cannot read the folder {}: {}", folder, fault.message()));
  std::vector<std::filesystem::path> paths;
  for (; files != std::filesystem::directory_iterator(); files.increment(fault)) {
    if (files->path().extension() == ".toml") paths.push_back(files->path());
  }
  if (fault) throw Error(fmt::format("cannot read the folder {}: {}", folder, fault.message()));
  if (paths.empty()) throw Error(fmt::format("the folder {} has no file with the extension .toml", folder));
  if (paths.size() > kMaxSets) {
    throw Error(
        fmt::format("the folder {} has {} .toml files; at most {} are allowed", folder, paths.size(), kMaxSets));
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

std::vector<MeasuredSet> BuiltInSets() {
  return ListOf(MapOfBuiltInSets());
}

std::vector<MeasuredSet> ReadSets(const std::string& folder) {
  std::map<std::string, MeasuredSet> sets = MapOfBuiltInSets();
  for (const std::filesystem::path& path : ListTomlFiles(folder)) {
    const std::string name = path.stem().string();
    sets[name] = ParseMeasuredSet(ReadTextFile(path.string(), kMaxSetBytes), path.string(), name);
  }
  return ListOf(sets);
}

}  // namespace kerf
