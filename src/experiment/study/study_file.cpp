#include "experiment/study/study_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "base/core/nearest_name.h"
#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "base/toml/toml_document.h"
#include "experiment/study/settings.h"
#include "kerf/error.h"
#include "study_default_toml.h"

namespace kerf {
namespace {

using NodeKind = TomlNode::Kind;

constexpr std::size_t kMaxScenes = 100'000;
constexpr std::size_t kMaxValues = 1000;
constexpr std::size_t kMaxNameLength = 60;  // the names become parts of file names

std::string NearestOf(const std::string& name, const std::vector<std::string>& names) {
  std::string nearest = FindNearestName(name.substr(0, 100), names);
  for (const std::string& one : names) {
    if (one.starts_with(name + "_")) nearest = one;  // only the unit is missing
  }
  return nearest.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                         : fmt::format("the nearest is \"{}\"", nearest);
}

/// Reads a list of distinct words from `words`; empty if it is missing or invalid.
std::vector<std::string> ReadWords(TableReader& reader, const char* key, const char* what,
                                   const std::vector<std::string>& words, Faults& faults) {
  std::vector<std::string> read;
  const TomlNode* node = reader.Node(key);
  if (node == nullptr) return read;
  if (node->kind != NodeKind::kArray) {
    reader.Fault(key, fmt::format("{} must be a list of names of {}s: [\"{}\"]", key, what, words.front()));
    return read;
  }
  if (node->children.empty()) reader.Fault(key, fmt::format("{} is empty; omit it for all", key));
  for (const TomlNode& item : node->children) {
    if (item.kind != NodeKind::kText) {
      faults.Add(item.line, item.column, fmt::format("{} = {} must be the name of a {}", key, item.Show(), what));
    } else if (std::find(words.begin(), words.end(), item.text) == words.end()) {
      faults.Add(item.line, item.column,
                 fmt::format("there is no {} {}; {}", what, item.Show(), NearestOf(item.text, words)));
    } else if (std::find(read.begin(), read.end(), item.text) != read.end()) {
      faults.Add(item.line, item.column, fmt::format("{} is listed twice in {}", item.Show(), key));
    } else {
      read.push_back(item.text);
    }
  }
  return read;
}

std::vector<Holding> ReadHoldings(TableReader& reader, Faults& faults) {
  std::vector<Holding> holdings;
  for (const std::string& word : ReadWords(reader, "holdings", "holding", {"hand", "path"}, faults)) {
    holdings.push_back(word == "hand" ? Holding::kHand : Holding::kPath);
  }
  return holdings;
}

void ReadKnob(const TomlNode& table, const std::vector<std::string>& paths, StudySpec& spec, Faults& faults) {
  TableReader reader(table, "[[knob]]", faults);
  KnobSweep sweep;
  reader.Require("name");
  reader.Require("values");
  reader("name", sweep.knob, TextLimit{200}, "");
  sweep.paths = ReadWords(reader, "paths", "path", paths, faults);
  sweep.holdings = ReadHoldings(reader, faults);
  const TomlNode* values = reader.Node("values");
  reader.Finish();
  if (sweep.knob.empty()) return;
  std::vector<std::string> names;
  for (const Knob& knob : StudyKnobs()) names.push_back(knob.name);
  if (std::find(names.begin(), names.end(), sweep.knob) == names.end()) {
    return reader.Fault("name", fmt::format("there is no knob \"{}\"; {}", sweep.knob, NearestOf(sweep.knob, names)));
  }
  for (const KnobSweep& earlier : spec.knobs) {
    if (earlier.knob == sweep.knob)
      return reader.Fault("name", fmt::format("the knob \"{}\" is listed twice", sweep.knob));
  }
  if (values == nullptr) return;
  if (values->kind != NodeKind::kArray || values->children.empty() || values->children.size() > kMaxValues) {
    return reader.Fault("values", fmt::format("values must be a list of 1 to {} values of {}", kMaxValues, sweep.knob));
  }
  for (const TomlNode& item : values->children) {
    TomlNode one;  // read as if the table contained knob = value
    one.children.push_back(item);
    one.children.back().key = sweep.knob;
    StudySettings settings = spec.base;
    TableReader value(one, "values", faults);
    Describe(settings, value);
    const std::string text = ValueOf(settings, sweep.knob);
    if (std::find(sweep.values.begin(), sweep.values.end(), text) == sweep.values.end()) {
      sweep.values.push_back(text);
    } else if (faults.empty()) {  // not for an invalid value, which has left the base setting unchanged
      faults.Add(item.line, item.column, fmt::format("{} is listed twice in values", item.Show()));
    }
  }
  spec.knobs.push_back(std::move(sweep));
}

std::string FindNameFault(const std::string& name) {
  const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  });
  if (name.empty() || !plain || name.size() > kMaxNameLength) {
    return fmt::format("a name has 1 to {} letters, digits, '-' and '_'", kMaxNameLength);
  }
  return "";
}

void ReadScenes(TableReader& root, const std::string& file, const std::vector<std::string>& built_in, StudySpec& spec,
                Faults& faults) {
  std::set<std::string> names(built_in.begin(), built_in.end());
  for (const TomlNode* table : root.Tables("scene", kMaxScenes)) {
    TableReader reader(*table, "[[scene]]", faults);
    StudyScene scene;
    std::string where;
    reader.Require("name");
    reader.Require("file");
    reader("name", scene.name, TextLimit{200}, "");
    reader("file", where, TextLimit{4096}, "");
    if (reader.Has("name")) {
      if (const std::string fault = FindNameFault(scene.name); !fault.empty()) {
        reader.Fault("name", fault);
      } else if (!names.insert(scene.name).second) {
        reader.Fault("name", fmt::format("there is already a path \"{}\"", scene.name));
      }
    }
    if (reader.Has("file") && where.empty()) reader.Fault("file", "file is empty");
    reader.Finish();
    scene.file = (std::filesystem::absolute(file).parent_path() / where).lexically_normal().string();
    spec.scenes.push_back(std::move(scene));
  }
}

void ReadStudyTable(TableReader& root, const std::vector<std::string>& built_in,
                    const std::vector<std::string>& all_paths, StudySpec& spec, Faults& faults) {
  // A study file that lists scenes uses no built-in paths unless it lists them.
  if (spec.scenes.empty()) spec.paths = built_in;
  const TomlNode* table = root.Table("study");
  if (table == nullptr) return;
  TableReader reader(*table, "[study]", faults);
  if (const auto paths = ReadWords(reader, "paths", "path", built_in, faults); !paths.empty()) spec.paths = paths;
  if (const auto holdings = ReadHoldings(reader, faults); !holdings.empty()) spec.holdings = holdings;
  spec.cost_paths = ReadWords(reader, "cost_paths", "path", all_paths, faults);
  reader("ticks_per_case", spec.ticks_per_case, Range{1000, 1e8}, "");
  reader("ticks_of_defaults", spec.ticks_of_defaults, Range{1000, 1e8}, "");
  reader("reference_tolerance", spec.reference_tolerance, Range{1e-8, 0.1}, "");
  reader.Finish();
}

}  // namespace

StudySpec ParseStudy(const std::string& text, const std::string& file, const std::vector<std::string>& built_in) {
  const TomlNode document = ParseToml(text, file);
  Faults faults(file);
  TableReader root(document, "the study file", faults);
  StudySpec spec;
  spec.name = std::filesystem::path(file).stem().string();
  root("title", spec.title, TextLimit{200}, "");
  root.Table("study");  // determines the order in which messages list the keys
  if (const TomlNode* base = root.Table("base")) {
    TableReader reader(*base, "[base]", faults);
    Describe(spec.base, reader);
    reader.Finish();
    spec.names_law = reader.Has("law");
  }
  const std::vector<const TomlNode*> knobs = root.Tables("knob", StudyKnobs().size());
  ReadScenes(root, file, built_in, spec, faults);
  std::vector<std::string> all_paths = built_in;
  for (const StudyScene& scene : spec.scenes) all_paths.push_back(scene.name);
  for (const TomlNode* knob : knobs) ReadKnob(*knob, all_paths, spec, faults);
  ReadStudyTable(root, built_in, all_paths, spec, faults);
  root.Finish();
  faults.ThrowIfAny();
  return spec;
}

std::string DefaultStudyToml() {
  return kStudyDefaultToml;
}

}  // namespace kerf
