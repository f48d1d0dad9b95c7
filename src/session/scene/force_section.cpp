#include "session/scene/force_section.h"

#include <fmt/format.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/files/files.h"
#include "cut/force/density.h"
#include "kerf/error.h"
#include "session/scene/file_names.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxTableBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxRows = 1000;

/// Reads the rows [[force.row]].
void ReadRows(TableReader& force, ForceLaw& law, Faults& faults) {
  const std::vector<const TomlNode*> nodes = force.Tables("row", kMaxRows);
  if (nodes.empty()) return;
  ForceTable table;
  for (const TomlNode* node : nodes) {
    TableReader reader(*node, "[[force.row]]", faults);
    ForceLawRow row;
    Describe(row, [&](const char* key, auto&&... rest) {
      reader.Require(key);
      reader(key, rest...);
    });
    reader.Finish();
    if (!faults.empty()) continue;
    try {
      table.Add(row);
    } catch (const Error& e) {
      faults.Add(node->line, node->column, e.what());
    }
  }
  if (!faults.empty()) return;
  try {
    table.CheckComplete();
    law.SetTable(std::make_shared<const ForceTable>(std::move(table)));
  } catch (const Error& e) {
    force.Fault("row", e.what());
  }
}

}  // namespace

ForceTableFile ReadForce(TableReader& root, ForceLaw& law, const std::string& scene_file, Faults& faults) {
  const TomlNode* table = root.Table("force");
  if (table == nullptr) return {};
  TableReader reader(*table, "[force]", faults);
  Describe(law, reader);
  const TomlNode* word = table->Find("law");
  if (word != nullptr && word->text != law.name()) return {};  // the law is unknown, so its keys are unknown too
  ForceTableFile file;
  if (law.info().has_table) {
    ReadFileName(reader, "file", file.file, scene_file);
    if (!file.file.empty()) file.place = table->PlaceOf("file", scene_file) + ": ";
    ReadRows(reader, law, faults);
    if (reader.Has("file") && reader.Has("row")) {
      reader.Fault("row", "[force] has both file and row; keep one of them");
    }
  }
  // A key of another law would have no effect, so it is rejected.
  for (const char* key : {"file", "row"}) {
    if (!reader.Has(key) || law.info().has_table) continue;
    reader.Node(key);  // known, so that Finish() does not report it again
    reader.Fault(key, fmt::format("{} is not used: the law {} reads no table; remove it", key, law.name()));
  }
  std::map<std::string_view, std::string> owners;  // other laws with a key
  for (const ForceLawInfo* other : ForceLaws()) {
    for (const LawParameter& parameter : other->parameters) {
      if (!reader.Has(parameter.key) || reader.Known(parameter.key)) continue;
      std::string& names = owners[parameter.key];
      names += (names.empty() ? "" : " and ") + std::string(other->name);
    }
  }
  for (const auto& [key, names] : owners) {
    const std::string name(key);
    reader.Fault(name.c_str(),
                 fmt::format("{} is not used: it belongs to {}, and the law is {}; remove it", key, names, law.name()));
  }
  for (const LawParameter* parameter : {&kModulusExponent, &kDensityReferenceE}) {
    if (!reader.Has(parameter->key) || !reader.Known(parameter->key) || law.Get("density_exponent") > 0) continue;
    if (law.Get(parameter->key) == parameter->default_value) continue;  // as a scene that kerf wrote
    reader.Fault(parameter->key, fmt::format("{} is not used without density_exponent; remove it", parameter->key));
  }
  reader.Finish();
  return file;
}

void ReadForceTableFile(const ForceTableFile& file, ForceLaw& law) {
  if (file.file.empty()) return;
  try {
    law.SetTable(
        std::make_shared<const ForceTable>(ParseForceTable(ReadTextFile(file.file, kMaxTableBytes), file.file)));
  } catch (const Error& e) {
    throw Error(file.place + e.what());
  }
}

void RefuseCuttingRatios(const TomlNode& document, const ForceLaw& law, Faults& faults) {
  const TomlNode* effects = document.Find("effects");
  if (effects == nullptr || !law.info().has_cutting) return;
  for (const auto& [effect, key] : kCuttingRatioKeys) {
    const TomlNode* table = effects->Find(std::string(effect));
    const TomlNode* at = table != nullptr ? table->Find(std::string(key)) : nullptr;
    if (at == nullptr) continue;
    faults.Add(at->line, at->column,
               fmt::format("{} is not used: the law {} states the cutting force; remove it", key, law.name()));
  }
}

}  // namespace kerf
