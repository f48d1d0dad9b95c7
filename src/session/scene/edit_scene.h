// Sets values in a scene's text and preserves everything else: comments, order, spaces.
#pragma once

#include <string>
#include <vector>

namespace kerf {

struct SceneEdit {
  std::string table;  // "bone.block"
  std::string key;    // "voxel_mm"
  std::string value;  // in TOML notation, such as "0.125"
};

/// As EditScene(), but the result need not be a scene.
std::string EditSceneText(const std::string& text, const std::string& file, const std::vector<SceneEdit>& edits,
                          const std::string& note);

/// Returns the text with the edited values. New keys are inserted after the header of their table in the order of the
/// edits; a new table is appended at the end. `note`, unless empty, becomes a comment above the topmost edited line, "#
/// kerf tune: <note>", and replaces an earlier one. `file` is used in messages. Throws kerf::Error if the text is not a
/// scene, or if the result would not be the same scene with only those values changed, for example because a table is
/// written on one line.
std::string EditScene(const std::string& text, const std::string& file, const std::vector<SceneEdit>& edits,
                      const std::string& note);

}  // namespace kerf
