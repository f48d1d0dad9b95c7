// Members of a project's ZIP file: their names and limits.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kerf::project_detail {

inline constexpr int kProjectVersion = 2;

inline constexpr std::string_view kManifest = "manifest.json";
inline constexpr std::string_view kSceneToml = "scene.toml";
inline constexpr std::string_view kMarks = "marks.mrk.json";
inline constexpr std::string_view kPieces = "pieces.json";
inline constexpr std::string_view kMeasurements = "measurements.json";
inline constexpr std::string_view kViews = "views.json";
inline constexpr std::string_view kSettings = "settings.json";
inline constexpr std::string_view kSessions = "sessions.json";
inline constexpr std::string_view kBone = "bone.vdb";
inline constexpr std::string_view kCutBone = "cut.vdb";
inline constexpr std::string_view kRecordingFolder = "recordings/";
inline constexpr std::string_view kBoneFolder = "bones/";
inline constexpr std::string_view kInputFolder = "inputs/";

inline constexpr std::size_t kMaxManifestBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxTextBytes = std::size_t{16} << 20;  // of a text member
inline constexpr std::size_t kMaxProjectRecordings = 500;
inline constexpr std::size_t kMaxMeasurements = 1000;
inline constexpr std::size_t kMaxViews = 200;
inline constexpr std::size_t kMaxSettings = 1000;
inline constexpr std::size_t kMaxSessions = 500;
inline constexpr std::size_t kMaxForces = 200'000;  // points of all sessions

/// Returns true for a file name of letters, digits, '_', '-' and '.', at most 120 characters long, that does not begin
/// with a dot.
inline bool IsFileName(std::string_view name) {
  if (name.empty() || name.size() > 120 || name.front() == '.') return false;
  for (const char c : name) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
    if (!plain) return false;
  }
  return true;
}

/// Returns true for the members that are texts and are kept in memory.
inline bool IsTextMember(std::string_view name) {
  return name == kManifest || name == kSceneToml || name == kMarks || name == kPieces || name == kMeasurements ||
         name == kViews || name == kSettings || name == kSessions;
}
inline bool IsInFolder(std::string_view name, std::string_view folder) {
  return name.starts_with(folder) && IsFileName(name.substr(folder.size()));
}
/// Returns true for the members that are unpacked as files.
inline bool IsFileMember(std::string_view name) {
  return name == kBone || name == kCutBone || IsInFolder(name, kInputFolder) ||
         (IsInFolder(name, kRecordingFolder) && name.ends_with(".kerf")) ||
         (IsInFolder(name, kBoneFolder) && name.ends_with(".vdb"));
}

}  // namespace kerf::project_detail
