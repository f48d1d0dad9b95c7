#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "base/files/files.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/marks/mark_file.h"
#include "session/project/members.h"
#include "session/project/project.h"
#include "session/project/zip_file.h"
#include "session/run/session_recorder.h"

namespace kerf {
namespace {

using OrderedJson = nlohmann::ordered_json;
using namespace project_detail;
namespace fs = std::filesystem;

std::string Dump(const OrderedJson& json) {
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::string FormatNow() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

/// Returns a file name with only valid characters.
std::string MakePlain(const std::string& name) {
  std::string plain;
  for (const char c : name.substr(0, 80)) plain += IsFileName(std::string("a") + c) ? c : '_';
  return plain;
}

/// The members of a project, and the entries of its manifest.
class MemberList {
 public:
  void AddText(std::string_view name, const std::string& text) {
    if (text.size() > kMaxTextBytes) {
      throw Error(fmt::format("'{}' of the project has {} bytes; the largest possible size is {}", name, text.size(),
                              kMaxTextBytes));
    }
    Add(name, text.size(), CalcDigest(text));
    zip_.AddText(std::string(name), text);
  }
  void AddInput(std::string_view name, const std::string& text) {
    Add(name, text.size(), CalcDigest(text));
    zip_.AddText(std::string(name), text);
  }
  void AddFile(std::string_view name, const std::string& file) {
    const FileDigest found = CalcFileDigest(file);
    Add(name, found.bytes, found.digest);
    zip_.AddFile(std::string(name), file, found.bytes);
  }
  const OrderedJson& list() const { return list_; }
  ZipWriter& zip() { return zip_; }

 private:
  void Add(std::string_view name, std::uint64_t bytes, const Digest& digest) {
    list_.push_back({{"name", name}, {"bytes", bytes}, {"blake2b", ToHex(digest)}});
  }
  OrderedJson list_ = OrderedJson::array();
  ZipWriter zip_;
};

void ReplaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

/// Returns a name in quotes as ResolvedToml() writes it.
std::string Quoted(const std::string& name) {
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

/// Adds the scene's input files and returns the scene's text, which names them by their members.
std::string AddScene(const Project& project, MemberList& members) {
  Scene scene = project.scene;
  if (scene.bone.source == BoneSource::kFile) scene.bone.file = "/bone.vdb";  // replaced below
  const std::map<std::string, std::string> files = ReadSceneFiles(scene, "", project.scene_files);
  std::string toml = ResolvedToml(scene);
  int number = 0;
  for (const auto& [file, content] : files) {
    const std::string name =
        fmt::format("{}{}-{}", kInputFolder, ++number, MakePlain(fs::path(file).filename().string()));
    members.AddInput(name, content);
    ReplaceAll(toml, Quoted(file), Quoted(name));
  }
  ReplaceAll(toml, Quoted("/bone.vdb"), Quoted(std::string(kBone)));
  return toml;
}

}  // namespace

void WriteProject(const std::string& path, const Project& project) {
  CheckPlan(project.scene.plan);
  CheckMarks(project.marks);
  CheckMeasuredPoints(project.measurements, project.pieces_json, path);
  CheckWritable(path);
  if (project.recordings.size() > kMaxProjectRecordings) {
    throw Error(fmt::format("{}: a project has at most {} recordings", path, kMaxProjectRecordings));
  }
  if (project.sessions.size() > kMaxSessions) {
    throw Error(fmt::format("{}: a project has at most {} sessions", path, kMaxSessions));
  }
  if (project.scene.bone.source == BoneSource::kFile && project.bone_file.empty()) {
    throw Error(fmt::format("{}: the project has no bone", path));
  }
  MemberList members;
  members.AddText(kSceneToml, AddScene(project, members));
  const bool placed =
      std::any_of(project.marks.begin(), project.marks.end(), [](const Mark& mark) { return !mark.points_W.empty(); });
  if (placed) members.AddText(kMarks, FormatMarks(project.marks));
  if (!project.pieces_json.empty()) members.AddText(kPieces, project.pieces_json);
  if (!project.measurements.empty()) members.AddText(kMeasurements, FormatMeasuredPoints(project.measurements));
  if (!project.views.empty()) members.AddText(kViews, FormatViews(project.views));
  if (!project.settings.empty()) members.AddText(kSettings, Dump(OrderedJson(project.settings)));
  if (!project.sessions.empty()) members.AddText(kSessions, FormatSessions(project.sessions));
  if (!project.bone_file.empty()) members.AddFile(kBone, project.bone_file);
  if (!project.cut_bone_file.empty()) members.AddFile(kCutBone, project.cut_bone_file);
  for (const auto& [hash, file] : project.bones) {
    members.AddFile(fmt::format("{}{:016x}.vdb", kBoneFolder, hash), file);
  }
  OrderedJson recordings = OrderedJson::array();
  std::set<std::string> names;
  for (const std::string& recording : project.recordings) {
    std::string name = MakePlain(fs::path(recording).stem().string());
    if (name.empty() || name.front() == '.') name = "session";
    std::string unique = name;
    for (int i = 2; !names.insert(unique).second; ++i) unique = fmt::format("{}-{}", name, i);
    const std::string member = fmt::format("{}{}.kerf", kRecordingFolder, unique);
    members.AddFile(member, recording);
    recordings.push_back(member);
  }
  const OrderedJson manifest{
      {"format", "kerf project"},         {"version", kProjectVersion}, {"kerf", VersionString()},
      {"commit", CommitString()},         {"created", FormatNow()},     {"title", project.title},
      {"scene_name", project.scene.name}, {"recordings", recordings},   {"members", members.list()}};
  members.zip().AddText(std::string(kManifest), Dump(manifest));
  WriteAtomically(path, [&](const std::string& temporary) {
    try {
      members.zip().Write(temporary);
    } catch (const Error& e) {
      throw Error(fmt::format("{}: can't be written: {}", path, e.what()));
    }
  });
}

}  // namespace kerf
