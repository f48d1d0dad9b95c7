// A project: everything about a case in one file.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bone/pieces/piece_measure.h"
#include "session/marks/mark.h"
#include "session/scene/scene.h"

namespace kerf {

/// A viewpoint with a name; world frame.
struct ProjectView {
  std::string name;
  Vec3 target_W_mm{0};          // point that the camera looks at
  Vec3 toward_eye_W{0, -1, 0};  // unit length
  Vec3 up_W{0, 0, 1};           // unit length
  double height_mm = 150;       // of the view, in the plane through the target
  bool parallel = false;

  bool operator==(const ProjectView&) const = default;
};

/// What is known about a session of a case.
struct ProjectSession {
  std::string saw;  // its name, or what it is
  std::optional<double> duration_s{};
  std::optional<double> removed_mm3{};
  std::optional<double> largest_force_N{};             // on the hand
  std::vector<std::pair<double, double>> forces_sN{};  // force on the hand, N, by time since the session's beginning, s
  bool recorded = true;                                // false: its recording is lost
  std::optional<double> turning_force_N{};             // while the saw touched bone and the spindle turned
  std::optional<double> stopped_force_N{};             // and while it did not
  std::optional<double> in_bone_s{};                   // time in which the saw touched the bone
  std::optional<Vec3> hub_in_bone_W{};        // where the blade's hub was in the bone during a cut; none: never
  std::optional<Vec3> handpiece_in_bone_W{};  // the same for the handpiece

  bool operator==(const ProjectSession&) const = default;
};

struct Project {
  std::string title;  // one line
  Scene scene;        // with the plan; its bone: the model or file from which the case began
  /// Contents of files that the scene names, by path. The others are read.
  std::map<std::string, std::string> scene_files;
  std::string bone_file;      // .vdb: the bone before the first cut; empty: none
  std::string cut_bone_file;  // .vdb: the bone as it is now; empty: it was not cut
  std::vector<Mark> marks;
  std::vector<std::string> recordings;   // .kerf files, in the order of the sessions
  std::vector<ProjectSession> sessions;  // in order
  /// Further bones with which recordings begin: .vdb files by hash (RecordingHeader::bone_hash).
  std::map<std::uint64_t, std::string> bones;
  std::string pieces_json;                   // PieceSet::FormatJson(); empty: none
  std::vector<MeasuredPoints> measurements;  // between points of these pieces
  std::vector<ProjectView> views;
  std::map<std::string, std::string> settings;  // of the window, by name
  // Set by ReadProject(), ignored by WriteProject().
  std::string created;  // UTC, such as "2026-11-25T22:00:00Z"
  std::string version;  // of the kerf that wrote the file
};

inline constexpr const char* kProjectExtension = ".kerf-project";

/// Writes a project: a ZIP file (docs/formats.md). It includes the files that the scene names (materials, CT laws,
/// paths, surfaces, ...), the bones and the recordings. Texts are compressed; bones and recordings are compressed
/// already and are stored as they are. Writes through a temporary file, so that an existing project stays intact until
/// the new one is complete. Throws kerf::Error if a file cannot be read or written, if the marks, the plan or the
/// measurements are not valid, or if there are too many recordings or sessions.
void WriteProject(const std::string& path, const Project& project);

/// Reads a project. Bones, recordings and inputs of the scene are written into `folder`, which is created if missing;
/// existing files of these names are replaced. The result has their paths. If the project has a bone, the scene's bone
/// is that file: the cut one if there is one.
///
/// The file may come from anybody. A member must have one of the names that WriteProject() uses, so that nothing can be
/// written elsewhere. Sizes are checked before anything is unpacked: the number of members, the size of each text, the
/// ratio of the sizes before and after compression, and the free space of the disk. Each member must have the digest
/// that the manifest states. Throws kerf::Error with one sentence that names the fault. What was unpacked before a
/// fault was found remains in the folder.
Project ReadProject(const std::string& path, const std::string& folder);

/// Returns true if the name ends in kProjectExtension, in any case.
bool IsProjectPath(const std::string& path);

/// Text of a project's views.
std::string FormatViews(const std::vector<ProjectView>& views);
std::vector<ProjectView> ParseViews(const std::string& text, const std::string& path);

/// Text of a project's sessions.
std::string FormatSessions(const std::vector<ProjectSession>& sessions);
std::vector<ProjectSession> ParseSessions(const std::string& text, const std::string& path);

/// Text of a project's measurements.
std::string FormatMeasuredPoints(const std::vector<MeasuredPoints>& measurements);
std::vector<MeasuredPoints> ParseMeasuredPoints(const std::string& text, const std::string& path);
/// Throws kerf::Error if there are too many measurements, if one has neither 2 nor 3 points, or if a point belongs to
/// no piece of `pieces_json`.
void CheckMeasuredPoints(const std::vector<MeasuredPoints>& measurements, const std::string& pieces_json,
                         const std::string& path);

}  // namespace kerf
