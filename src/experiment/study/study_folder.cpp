#include "experiment/study/study_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>

#include "base/files/files.h"
#include "base/files/json_text.h"
#include "base/files/temporary.h"
#include "experiment/study/record_json.h"
#include "experiment/study/settings.h"
#include "kerf/error.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kSchema = 1;
constexpr std::size_t kMaxRecordBytes = std::size_t{16} << 20;
constexpr std::size_t kMaxDescriptionBytes = std::size_t{256} << 20;

/// Calls `read` with the file's JSON; the messages of errors include the file name.
template <typename Read>
auto ReadJson(const std::string& file, std::size_t max_bytes, Read&& read) {
  const std::string text = ReadTextFile(file, max_bytes);
  try {
    return read(text);
  } catch (const std::exception& e) {
    throw Error(fmt::format("{}: is damaged: {}", file, e.what()));
  }
}

void CheckSchema(const Json& json) {
  const int schema = json.at("schema");
  if (schema != kSchema) throw Error(fmt::format("its schema is {}; this program supports {}", schema, kSchema));
}

/// Returns the stored record without times and related data.
Json WithoutTimes(const WorkRecord& record) {
  Json json = Json::parse(FormatWorkRecord(record));
  for (const char* key : {"seconds", "commit", "cpu", "costs"}) json.erase(key);
  return json;
}

}  // namespace

std::string FormatWorkRecord(const WorkRecord& record) {
  Json json{{"schema", kSchema},
            {"id", record.id},
            {"work", ToString(record.work)},
            {"input", record.input},
            {"state", ToString(record.state)},
            {"why", record.why},
            {"path_title", record.path_title},
            {"force_hash", ShowHash(record.force_hash)},
            {"bone_hash", ShowHash(record.bone_hash)}};
  if (record.errors) json["errors"] = ToJson(*record.errors);
  if (record.costs) json["costs"] = ToJson(*record.costs);
  json["seconds"] = record.seconds;
  json["commit"] = record.commit;
  json["cpu"] = record.cpu;
  // An error message from a library need not be UTF-8.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

WorkRecord ParseWorkRecord(const std::string& text) {
  try {
    CheckJsonDepth(text, "it");
    const Json json = Json::parse(text);
    CheckSchema(json);
    WorkRecord record;
    record.id = json.at("id");
    const std::string work = json.at("work");
    if (work != "errors" && work != "costs") throw Error(fmt::format("\"{}\" is not a kind of work", work));
    record.work = work == "errors" ? CaseWork::kErrors : CaseWork::kCosts;
    record.input = json.at("input");
    record.state = StateFromString(json.at("state"));
    record.why = json.at("why");
    record.path_title = json.at("path_title");
    record.force_hash = HashFromText(json.at("force_hash"));
    record.bone_hash = HashFromText(json.at("bone_hash"));
    if (json.contains("errors")) record.errors = ErrorsFromJson(json.at("errors"));
    if (json.contains("costs")) record.costs = CostsFromJson(json.at("costs"));
    if (record.state == CaseState::kDone &&
        !(record.work == CaseWork::kErrors ? record.errors.has_value() : record.costs.has_value())) {
      throw Error("it contains no figures");
    }
    record.seconds = json.at("seconds");
    record.commit = json.at("commit");
    record.cpu = json.at("cpu");
    return record;
  } catch (const Json::exception& e) {
    throw Error(e.what());
  }
}

bool AgreeInAllButTimes(const WorkRecord& a, const WorkRecord& b) {
  WorkRecord x = a;
  WorkRecord y = b;
  // A record of an earlier version lacks this figure, which is not a contradiction.
  if (x.errors && y.errors && x.errors->impulse_signed.has_value() != y.errors->impulse_signed.has_value()) {
    x.errors->impulse_signed.reset();
    y.errors->impulse_signed.reset();
  }
  return WithoutTimes(x) == WithoutTimes(y);
}

bool StudyFolder::HasDescription() const {
  std::error_code ignored;
  return fs::exists(fs::path(path_) / "plan.json", ignored);
}

StudyDescription StudyFolder::ReadDescription() const {
  return ReadJson((fs::path(path_) / "plan.json").string(), kMaxDescriptionBytes, [](const std::string& text) {
    CheckJsonDepth(text, "it");
    const Json json = Json::parse(text);
    CheckSchema(json);
    StudyDescription d;
    d.spec = SpecFromJson(json.at("study"));
    if (HashOf(d.spec) != HashFromText(json.at("study_hash"))) throw Error("it was edited by hand");
    d.plan_hash = HashFromText(json.at("plan_hash"));
    if (!json.at("shard").is_null()) d.shard = ShardFromText(json.at("shard"));
    d.errors = json.at("errors");
    d.costs = json.at("costs");
    d.command = json.at("command");
    d.commit = json.at("commit");
    d.build = json.at("build");
    d.machine = MachineFromJson(json.at("machine"));
    return d;
  });
}

void StudyFolder::WriteDescription(const StudyDescription& d) const {
  Json json{{"schema", kSchema},
            {"study", SpecToJson(d.spec)},
            {"study_hash", ShowHash(HashOf(d.spec))},
            {"plan_hash", ShowHash(d.plan_hash)},
            {"shard", nullptr},
            {"errors", d.errors},
            {"costs", d.costs},
            {"command", d.command},
            {"commit", d.commit},
            {"build", d.build},
            {"machine", ToJson(d.machine)}};
  if (d.shard) json["shard"] = ToString(*d.shard);
  for (const char* name : {"cases", "references"}) MakeFolder((fs::path(path_) / name).string());
  WriteTextFile((fs::path(path_) / "plan.json").string(), json.dump(1) + "\n");
}

std::string StudyFolder::FileOf(const std::string& id, CaseWork work) const {
  return (fs::path(path_) / "cases" / fmt::format("{}.{}.json", id, ToString(work))).string();
}

std::optional<WorkRecord> StudyFolder::Read(const std::string& id, CaseWork work) const {
  const std::string file = FileOf(id, work);
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  return ReadJson(file, kMaxRecordBytes, [&](const std::string& text) {
    WorkRecord record = ParseWorkRecord(text);
    if (record.id != id || record.work != work) throw Error("it belongs to another case");
    return std::optional(std::move(record));
  });
}

void StudyFolder::Write(const WorkRecord& record, bool copy) const {
  const std::string file = FileOf(record.id, record.work);
  if (!copy) return WriteTextFile(file, FormatWorkRecord(record));
  try {
    Temporary temporary(file);
    std::ofstream out(temporary.path_to_write(), std::ios::binary | std::ios::trunc);
    out << FormatWorkRecord(record);
    out.close();
    if (!out) throw Error("it could not be written completely");
    temporary.RenameTo(file);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: can't be written: {}", file, e.what()));
  }
}

std::string StudyFolder::FileOfReference(const std::string& name) const {
  return (fs::path(path_) / "references" / (name + ".ref")).string();
}

std::optional<StoredReference> StudyFolder::ReadReference(const std::string& name) const {
  const std::string file = (fs::path(path_) / "references" / (name + ".json")).string();
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  return ReadJson(file, kMaxRecordBytes, [&](const std::string& text) {
    CheckJsonDepth(text, "it");
    const Json json = Json::parse(text);
    CheckSchema(json);
    StoredReference kept{json.at("name"), json.at("input"), json.at("why"), ReferenceFromJson(json.at("reference"))};
    if (kept.name != name) throw Error("it belongs to another reference");
    return std::optional(std::move(kept));
  });
}

void StudyFolder::WriteReference(const StoredReference& reference) const {
  const Json json{{"schema", kSchema},
                  {"name", reference.name},
                  {"input", reference.input},
                  {"why", reference.why},
                  {"reference", ToJson(reference.record)}};
  WriteTextFile((fs::path(path_) / "references" / (reference.name + ".json")).string(),
                json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::vector<std::string> StudyFolder::ListShards() const {
  std::vector<std::string> folders;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(path_, none)) {
    if (entry.path().filename().string().starts_with("shard-") && fs::exists(entry.path() / "plan.json", none)) {
      folders.push_back(entry.path().string());
    }
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

}  // namespace kerf
