#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "base/files/disk_space.h"
#include "base/files/extension.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "session/marks/mark_file.h"
#include "session/project/members.h"
#include "session/project/project.h"
#include "session/project/project_texts.h"
#include "session/project/zip_file.h"
#include "session/run/run_scene.h"

namespace kerf {

bool IsProjectPath(const std::string& path) {
  return LowerExtension(path) == kProjectExtension;
}

Project ReadProject(const std::string& path, const std::string& folder) {
  using namespace project_detail;
  const ZipReader zip(path);
  const std::vector<ZipMember>& members = zip.members();
  const ProjectTexts texts = ReadProjectTexts(zip, path);
  const Manifest& manifest = texts.manifest;

  MakeFolder(folder);
  const std::string root = std::filesystem::absolute(folder).lexically_normal().string();
  std::vector<ExpectedFile> expected;
  for (const ZipMember& member : members) {
    if (IsFileMember(member.name)) {
      expected.push_back({fmt::format("{}/{}", root, member.name), static_cast<double>(member.bytes)});
    }
  }
  for (const std::string_view sub : {kRecordingFolder, kInputFolder, kBoneFolder}) {
    const bool used =
        std::any_of(members.begin(), members.end(), [&](const ZipMember& m) { return m.name.starts_with(sub); });
    if (used) MakeFolder(fmt::format("{}/{}", root, sub));
  }
  if (const std::string lack = DescribeLackOfSpace(expected); !lack.empty()) throw Error(lack);

  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::string& name = members[i].name;
    if (!IsFileMember(name)) continue;
    GrowingFile file(fmt::format("{}/{}", root, name));
    CheckMemberDigest(manifest, name, zip.Unpack(i, [&](std::string_view block) { file.Append(block); }), path);
    file.Commit();
  }

  Project project;
  project.title = manifest.title;
  project.created = manifest.created;
  project.version = manifest.version;
  const auto place = [&](std::string_view name) { return fmt::format("{}/{}", root, name); };
  project.scene = ParseScene(texts.Get(kSceneToml), place(kSceneToml));
  project.scene.name = manifest.scene_name;
  if (manifest.Find(kBone) != nullptr) project.bone_file = place(kBone);
  if (manifest.Find(kCutBone) != nullptr) project.cut_bone_file = place(kCutBone);
  for (const ZipMember& member : members) {
    if (!IsInFolder(member.name, kBoneFolder)) continue;
    const std::string name = member.name.substr(kBoneFolder.size());
    std::uint64_t hash = 0;
    const auto [end, failed] = std::from_chars(name.data(), name.data() + name.size(), hash, 16);
    if (failed != std::errc() || std::string_view(end) != ".vdb") {
      throw Error(fmt::format("{}: '{}' is not named by the hash of a bone", path, member.name));
    }
    project.bones[hash] = place(member.name);
  }
  const std::string& bone = project.cut_bone_file.empty() ? project.bone_file : project.cut_bone_file;
  if (!bone.empty()) {
    project.scene.bone.source = BoneSource::kFile;
    project.scene.bone.file = bone;
  } else if (project.scene.bone.source == BoneSource::kFile) {
    throw Error(fmt::format("{}: is incomplete: it has no bone", path));
  }
  for (const std::string& input : ListInputs(project.scene, "")) {
    if (input.empty() || std::filesystem::path(input).lexically_normal().string().starts_with(root + "/")) continue;
    throw Error(fmt::format("{}: its scene names a file outside the project", path));
  }
  if (const std::string marks = texts.Get(kMarks); !marks.empty()) {
    project.marks = ParseMarks(marks, fmt::format("{}: {}", path, kMarks));
  }
  project.pieces_json = texts.Get(kPieces);
  if (const std::string measurements = texts.Get(kMeasurements); !measurements.empty()) {
    project.measurements = ParseMeasuredPoints(measurements, fmt::format("{}: {}", path, kMeasurements));
    CheckMeasuredPoints(project.measurements, project.pieces_json, path);
  }
  if (const std::string views = texts.Get(kViews); !views.empty()) {
    project.views = ParseViews(views, fmt::format("{}: {}", path, kViews));
  }
  if (const std::string settings = texts.Get(kSettings); !settings.empty()) {
    project.settings = ParseSettings(settings, fmt::format("{}: {}", path, kSettings));
  }
  if (const std::string sessions = texts.Get(kSessions); !sessions.empty()) {
    project.sessions = ParseSessions(sessions, fmt::format("{}: {}", path, kSessions));
    const auto recorded = std::count_if(project.sessions.begin(), project.sessions.end(),
                                        [](const ProjectSession& session) { return session.recorded; });
    if (static_cast<std::size_t>(recorded) > manifest.recordings.size()) {
      throw Error(fmt::format("{}: {} lists {} recorded sessions, but there are {} recordings", path, kSessions,
                              recorded, manifest.recordings.size()));
    }
  }
  for (const std::string& recording : manifest.recordings) project.recordings.push_back(place(recording));
  return project;
}

}  // namespace kerf
