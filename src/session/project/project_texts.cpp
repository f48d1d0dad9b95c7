#include "session/project/project_texts.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "base/core/printable.h"
#include "base/files/json_text.h"
#include "kerf/error.h"
#include "session/project/members.h"
#include "session/project/project.h"

namespace kerf {
namespace project_detail {
namespace {

using Json = nlohmann::json;

std::string TextOf(const Json& json, const char* key, const std::string& path) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_string()) {
    throw Error(fmt::format("{}: the manifest has no text '{}'", path, key));
  }
  return Printable(found->get<std::string>().substr(0, 1000));
}

const Json& ListOf(const Json& json, const char* key, const std::string& path) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_array()) {
    throw Error(fmt::format("{}: the manifest has no list '{}'", path, key));
  }
  return *found;
}

Manifest ParseManifest(const std::string& text, const std::string& path) {
  const Json json = ParseJson(text, path);
  if (!json.is_object() || json.value("format", Json()) != "kerf project") {
    throw Error(fmt::format("{}: is not a kerf project", path));
  }
  const Json version = json.value("version", Json());
  if (!version.is_number_integer() || GetInt(version) < 1) {
    throw Error(fmt::format("{}: the manifest states no version of the format", path));
  }
  if (GetInt(version) > kProjectVersion) {
    throw Error(fmt::format("{}: was written by a newer kerf (project format {}; this kerf reads up to {})", path,
                            GetInt(version), kProjectVersion));
  }
  Manifest manifest{.title = TextOf(json, "title", path),
                    .scene_name = TextOf(json, "scene_name", path),
                    .created = TextOf(json, "created", path),
                    .version = TextOf(json, "kerf", path),
                    .members = {},
                    .recordings = {}};
  for (const Json& entry : ListOf(json, "members", path)) {
    const Json name = entry.is_object() ? entry.value("name", Json()) : Json();
    const Json bytes = entry.is_object() ? entry.value("bytes", Json()) : Json();
    const Json digest = entry.is_object() ? entry.value("blake2b", Json()) : Json();
    if (!name.is_string() || !bytes.is_number_unsigned() || !digest.is_string()) {
      throw Error(fmt::format("{}: an entry of the manifest's list 'members' is not valid", path));
    }
    manifest.members.push_back(
        {.name = name.get<std::string>(), .bytes = bytes.get<std::uint64_t>(), .digest = digest.get<std::string>()});
  }
  for (const Json& entry : ListOf(json, "recordings", path)) {
    if (!entry.is_string() || !IsInFolder(entry.get<std::string>(), kRecordingFolder)) {
      throw Error(fmt::format("{}: an entry of the manifest's list 'recordings' is not valid", path));
    }
    manifest.recordings.push_back(entry.get<std::string>());
  }
  return manifest;
}

/// Compares the manifest with the members of the archive.
void CheckMembers(const Manifest& manifest, const std::vector<ZipMember>& members, const std::string& path) {
  std::set<std::string> listed;
  for (const Manifest::Member& member : manifest.members) {
    if (!listed.insert(member.name).second) {
      throw Error(fmt::format("{}: the manifest lists '{}' twice", path, Printable(member.name.substr(0, 200))));
    }
  }
  std::set<std::string> recordings(manifest.recordings.begin(), manifest.recordings.end());
  if (recordings.size() != manifest.recordings.size()) {
    throw Error(fmt::format("{}: the manifest lists a recording twice", path));
  }
  std::size_t found = 0;
  for (const ZipMember& member : members) {
    if (member.name == kManifest) continue;
    if (!IsTextMember(member.name) && !IsFileMember(member.name)) {
      throw Error(fmt::format("{}: contains '{}', which does not belong into a project", path, member.name));
    }
    const Manifest::Member* stated = manifest.Find(member.name);
    if (stated == nullptr) throw Error(fmt::format("{}: the manifest does not list '{}'", path, member.name));
    if (stated->bytes != member.bytes) {
      throw Error(fmt::format("{}: is damaged: '{}' has {} bytes instead of {}", path, member.name, member.bytes,
                              stated->bytes));
    }
    if (IsInFolder(member.name, kRecordingFolder) && recordings.count(member.name) == 0) {
      throw Error(fmt::format("{}: the manifest does not list the recording '{}'", path, member.name));
    }
    if (IsTextMember(member.name) && member.bytes > kMaxTextBytes) {
      throw Error(fmt::format("{}: '{}' has {} bytes; the largest possible size is {}", path, member.name, member.bytes,
                              kMaxTextBytes));
    }
    ++found;
  }
  if (found != manifest.members.size()) {
    throw Error(fmt::format("{}: is incomplete: a member that the manifest lists is missing", path));
  }
  for (const std::string& recording : manifest.recordings) {
    if (manifest.Find(recording) == nullptr) {
      throw Error(fmt::format("{}: is incomplete: the recording '{}' is missing", path, recording));
    }
  }
  if (manifest.Find(kSceneToml) == nullptr) throw Error(fmt::format("{}: is incomplete: it has no scene", path));
}

}  // namespace

void CheckMemberDigest(const Manifest& manifest, const std::string& name, const Digest& digest,
                       const std::string& path) {
  if (ToHex(digest) == manifest.Find(name)->digest) return;
  throw Error(fmt::format("{}: is damaged: '{}' is not as it was written", path, name));
}

ProjectTexts ReadProjectTexts(const ZipReader& zip, const std::string& path) {
  const std::vector<ZipMember>& members = zip.members();
  const auto manifest_at =
      std::find_if(members.begin(), members.end(), [](const ZipMember& m) { return m.name == kManifest; });
  if (manifest_at == members.end()) throw Error(fmt::format("{}: is not a kerf project: it has no manifest", path));
  const auto index = static_cast<std::size_t>(manifest_at - members.begin());
  ProjectTexts out{.manifest = ParseManifest(zip.UnpackText(index, kMaxManifestBytes), path), .texts = {}};
  CheckMembers(out.manifest, members, path);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::string& name = members[i].name;
    if (name == kManifest || !IsTextMember(name)) continue;
    Digest digest{};
    out.texts[name] = zip.UnpackText(i, kMaxTextBytes, &digest);
    CheckMemberDigest(out.manifest, name, digest, path);
  }
  return out;
}

std::map<std::string, std::string> ParseSettings(const std::string& text, const std::string& path) {
  const Json json = ParseJson(text, path);
  if (!json.is_object() || json.size() > kMaxSettings) {
    throw Error(fmt::format("{}: the settings are not an object with at most {} values", path, kMaxSettings));
  }
  std::map<std::string, std::string> settings;
  for (const auto& [name, value] : json.items()) {
    if (!value.is_string()) throw Error(fmt::format("{}: a setting is not a text", path));
    settings[name] = value.get<std::string>();
  }
  return settings;
}

}  // namespace project_detail

namespace {

Vec3 VectorOf(const nlohmann::json& view, const char* key, Range range, const std::string& path) {
  const nlohmann::json list = view.value(key, nlohmann::json());
  Vec3 v(0);
  bool valid = list.is_array() && list.size() == 3;
  for (int a = 0; valid && a < 3; ++a) {
    const nlohmann::json& number = list[static_cast<std::size_t>(a)];
    valid = number.is_number() && range.Contains(number.get<double>());
    if (valid) v[a] = number.get<double>();
  }
  if (!valid) throw Error(fmt::format("{}: '{}' of a view is not a list of three valid numbers", path, key));
  return v;
}

}  // namespace

std::string FormatViews(const std::vector<ProjectView>& views) {
  const auto list = [](const Vec3& v) { return nlohmann::ordered_json::array({v.x, v.y, v.z}); };
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ProjectView& view : views) {
    json.push_back({{"name", view.name},
                    {"target_mm", list(view.target_W_mm)},
                    {"toward_eye", list(view.toward_eye_W)},
                    {"up", list(view.up_W)},
                    {"height_mm", view.height_mm},
                    {"parallel", view.parallel}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::vector<ProjectView> ParseViews(const std::string& text, const std::string& path) {
  const nlohmann::json json = ParseJson(text, path);
  if (!json.is_array() || json.size() > project_detail::kMaxViews) {
    throw Error(fmt::format("{}: the views are not a list of at most {} views", path, project_detail::kMaxViews));
  }
  std::vector<ProjectView> views;
  for (const nlohmann::json& entry : json) {
    if (!entry.is_object()) throw Error(fmt::format("{}: a view is not an object", path));
    ProjectView view;
    const nlohmann::json name = entry.value("name", nlohmann::json());
    const nlohmann::json height = entry.value("height_mm", nlohmann::json());
    const nlohmann::json parallel = entry.value("parallel", nlohmann::json());
    constexpr Range kHeightRange_mm{0.1, 10000};
    if (!name.is_string() || !parallel.is_boolean() || !height.is_number() ||
        !kHeightRange_mm.Contains(height.get<double>())) {
      throw Error(fmt::format("{}: a view has no valid name, height_mm or parallel", path));
    }
    view.name = name.get<std::string>();
    view.height_mm = height.get<double>();
    view.parallel = parallel.get<bool>();
    view.target_W_mm = VectorOf(entry, "target_mm", kCoordinateRange_mm, path);
    view.toward_eye_W = VectorOf(entry, "toward_eye", Range{-2, 2}, path);
    view.up_W = VectorOf(entry, "up", Range{-2, 2}, path);
    const Vec3 across = glm::cross(view.toward_eye_W, view.up_W);
    if (!(glm::length(across) > 1e-3)) {
      throw Error(fmt::format("{}: a view's directions 'toward_eye' and 'up' are parallel or zero", path));
    }
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace kerf
