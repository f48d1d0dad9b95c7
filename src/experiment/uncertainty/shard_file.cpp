#include "experiment/uncertainty/shard_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "base/files/files.h"
#include "base/files/json_text.h"
#include "base/table/table_json.h"
#include "kerf/error.h"
#include "kerf/version.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kSamplesSchema = 1;
constexpr std::size_t kMaxSamplesBytes = std::size_t{4} << 30;

ordered_json SampleJson(const UncertainSample& s) {
  return {{"sample", s.number},   {"fractions", s.fractions},         {"peak_N", s.peak_N},   {"mean_N", s.mean_N},
          {"work_mJ", s.work_mJ}, {"cutting_J", OrNull(s.cutting_J)}, {"force_N", s.force_N}, {"thrust_N", s.thrust_N}};
}

UncertainSample SampleFromJson(const nlohmann::json& json, std::size_t fractions, std::size_t rows) {
  UncertainSample s;
  s.number = GetInt(json.at("sample"));
  s.fractions = json.at("fractions").get<std::vector<double>>();
  s.peak_N = json.at("peak_N");
  s.mean_N = json.at("mean_N");
  s.work_mJ = json.at("work_mJ");
  if (!json.at("cutting_J").is_null()) s.cutting_J = json.at("cutting_J").get<double>();
  s.force_N = json.at("force_N").get<std::vector<double>>();
  s.thrust_N = json.at("thrust_N").get<std::vector<double>>();
  if (s.fractions.size() != fractions || s.force_N.size() != rows || s.thrust_N.size() != rows) {
    throw Error("the lists of a sample have wrong lengths");
  }
  return s;
}

ordered_json DrawingToJson(const Drawing& drawing) {
  ordered_json json = {{"drawn", ordered_json::array()}, {"fixed", ordered_json::array()}};
  for (const DrawnQuantity& q : drawing.drawn) {
    json["drawn"].push_back({{"name", q.name},
                             {"lower", q.lower},
                             {"upper", q.upper},
                             {"nominal", OrNull(q.nominal)},
                             {"basis", q.basis},
                             {"regions", q.regions},
                             {"stream", q.stream}});
  }
  for (const FixedQuantity& q : drawing.fixed) json["fixed"].push_back({{"name", q.name}, {"why", q.why}});
  return json;
}

Drawing DrawingFromJson(const nlohmann::json& json) {
  Drawing drawing;
  for (const nlohmann::json& q : json.at("drawn")) {
    DrawnQuantity& to = drawing.drawn.emplace_back();
    to.name = q.at("name");
    to.lower = q.at("lower");
    to.upper = q.at("upper");
    if (!q.at("nominal").is_null()) to.nominal = q.at("nominal").get<double>();
    to.basis = q.at("basis");
    to.regions = q.at("regions").get<std::vector<int>>();
    to.stream = q.at("stream");
  }
  for (const nlohmann::json& q : json.at("fixed")) drawing.fixed.push_back({q.at("name"), q.at("why")});
  return drawing;
}

std::uint64_t ParseHash(const std::string& text) {
  std::uint64_t hash = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), hash, 16);
  if (code != std::errc() || end != text.data() + text.size()) throw Error("a hash is not a hexadecimal number");
  return hash;
}

UncertainHead HeadFromJson(const nlohmann::json& json) {
  UncertainHead head;
  head.scene = json.at("scene");
  head.title = json.at("title");
  head.law = json.at("law");
  head.scene_sha256 = json.at("scene_sha256");
  head.bone_hash = ParseHash(json.at("bone_hash"));
  head.samples = GetInt(json.at("samples"));
  head.seed = json.at("seed");
  head.drawing = DrawingFromJson(json.at("quantities"));
  head.row_ticks = GetInt(json.at("row_ticks"));
  head.rate_hz = json.at("rate_hz");
  const nlohmann::json& rows = json.at("rows");
  head.rows.time_s = rows.at("time_s").get<std::vector<double>>();
  head.rows.segment = rows.at("segment").get<std::vector<std::size_t>>();
  head.rows.travel_mm = rows.at("travel_mm").get<std::vector<double>>();
  const std::size_t count = head.rows.time_s.size();
  if (head.rows.segment.size() != count || head.rows.travel_mm.size() != count) {
    throw Error("the lists of the rows differ in length");
  }
  head.nominal = SampleFromJson(json.at("nominal"), 0, count);
  return head;
}

/// Returns the files of the shards in a folder, sorted.
std::vector<std::string> ListSampleFiles(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const fs::path file = entry.path() / kSamplesFile;
    if (entry.path().filename().string().starts_with("shard-") && fs::exists(file, none)) {
      files.push_back(file.string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Throws kerf::Error if the head is not of this scene with these parameters.
void CheckBelongs(const UncertainHead& head, const std::string& file, const Scene& scene,
                  const UncertainParams& params) {
  if (head.scene_sha256 != HashScene(scene)) {
    throw Error(fmt::format("{}: belongs to another scene or to another state of it: {}", file, head.scene));
  }
  if (head.samples != params.samples || head.seed != params.seed) {
    throw Error(fmt::format("{}: was made with --uncertain {} --seed {}, not with {} and {}", file, head.samples,
                            head.seed, params.samples, params.seed));
  }
}

}  // namespace

std::string FormatSamples(const UncertainRun& run, const std::optional<Shard>& shard) {
  const UncertainHead& head = run.head;
  ordered_json json = {
      {"kerf", {{"version", VersionString()}, {"commit", CommitString()}, {"compiler", CompilerString()}}},
      {"schema", kSamplesSchema},
      {"shard", shard ? ordered_json(ToString(*shard)) : ordered_json()},
      {"scene", head.scene},
      {"title", head.title},
      {"law", head.law},
      {"scene_sha256", head.scene_sha256},
      {"bone_hash", fmt::format("{:016x}", head.bone_hash)},
      {"samples", head.samples},
      {"seed", head.seed},
      {"rate_hz", head.rate_hz},
      {"row_ticks", head.row_ticks},
      {"quantities", DrawingToJson(head.drawing)},
      {"rows", {{"time_s", head.rows.time_s}, {"segment", head.rows.segment}, {"travel_mm", head.rows.travel_mm}}},
      {"nominal", SampleJson(head.nominal)},
      {"results", ordered_json::array()}};
  for (const UncertainSample& s : run.samples) json["results"].push_back(SampleJson(s));
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

UncertainRun ParseSamples(const std::string& text, const std::string& file) {
  try {
    const nlohmann::json json = ParseJson(text, file);
    if (GetInt(json.at("schema")) != kSamplesSchema) throw Error("it has another version of the format");
    UncertainRun run{HeadFromJson(json), {}};
    const std::size_t rows = run.head.rows.time_s.size();
    for (const nlohmann::json& sample : json.at("results")) {
      run.samples.push_back(SampleFromJson(sample, run.head.drawing.drawn.size(), rows));
      const int number = run.samples.back().number;
      if (number < 0 || number >= run.head.samples) throw Error(fmt::format("sample {} is out of range", number));
    }
    return run;
  } catch (const nlohmann::json::exception&) {
    throw Error(fmt::format("{}: is not a shard of 'kerf run --uncertain', or is damaged", file));
  } catch (const std::exception& e) {
    throw Error(fmt::format("{}: is not a shard of 'kerf run --uncertain': {}", file, e.what()));
  }
}

MergedRun MergeSamples(const std::string& folder, const Scene& scene, const UncertainParams& params) {
  const std::vector<std::string> files = ListSampleFiles(folder);
  if (files.empty()) throw Error(fmt::format("{}: contains no shards; make them with --shard", folder));
  MergedRun merged;
  std::map<int, std::pair<UncertainSample, std::size_t>> found;  // and the number of its file
  for (std::size_t f = 0; f < files.size(); ++f) {
    UncertainRun run = ParseSamples(ReadTextFile(files[f], kMaxSamplesBytes), files[f]);
    CheckBelongs(run.head, files[f], scene, params);
    if (f == 0) {
      merged.run.head = run.head;
    } else if (!(run.head == merged.run.head)) {
      throw Error(fmt::format("{} and {} differ in the bone, the intervals or the nominal run", files[0], files[f]));
    }
    for (UncertainSample& s : run.samples) {
      const int number = s.number;
      const auto [at, is_new] = found.try_emplace(number, s, f);
      if (is_new) continue;
      ++merged.twice;
      if (!(at->second.first == s)) {
        throw Error(fmt::format("{} and {} differ in sample {}", files[at->second.second], files[f], number));
      }
    }
  }
  merged.files = files.size();
  for (int i = 0; i < params.samples; ++i) {
    const auto at = found.find(i);
    if (at == found.end()) {
      merged.missing.push_back(i);
    } else {
      merged.run.samples.push_back(std::move(at->second.first));
    }
  }
  return merged;
}

std::string DescribeMissing(const MergedRun& merged, const std::string& folder) {
  if (merged.missing.empty()) return "";
  std::string text =
      fmt::format("{}: {} of {} samples are missing", folder, merged.missing.size(), merged.run.head.samples);
  // If all folders are of one split, the shards that are missing can be named.
  std::set<int> counts;
  std::set<int> present;
  for (const std::string& file : ListSampleFiles(folder)) {
    const std::string name = fs::path(file).parent_path().filename().string();
    const std::size_t of = name.find("-of-");
    if (of == std::string::npos) continue;
    present.insert(std::atoi(name.c_str() + 6));
    counts.insert(std::atoi(name.c_str() + of + 4));
  }
  if (counts.size() != 1) return text;
  std::vector<std::string> shards;
  for (int i = 0; i < *counts.begin(); ++i) {
    if (!present.contains(i)) shards.push_back(ToString(Shard{i, *counts.begin()}));
  }
  return shards.empty() ? text : text + fmt::format(": those of shard {}", fmt::join(shards, ", "));
}

}  // namespace kerf
