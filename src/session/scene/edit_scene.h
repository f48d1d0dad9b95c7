// Setting values in a scene's text, all else of it as it was: comments, order, spaces.
#pragma once

#include <string>
#include <vector>

namespace kerf {

struct SceneEdit {
  std::string table;  // "bone.block"
  std::string key;    // "voxel_mm"
  std::string value;  // as TOML writes it: "0.125"
};

/// The text with those values set; keys that are not there go behind the head of their table in the order of the edits,
/// a table that is not there to the end. `note`, unless empty, becomes a comment above the topmost edited line,
/// "# kerf tune: <note>", in the place of an earlier one. `file` is named in messages. Throws Error when the text is no
/// scene, or when the result would not be that scene with those values alone changed, as where a table is written in
/// one line.
std::string EditScene(const std::string& text, const std::string& file, const std::vector<SceneEdit>& edits,
                      const std::string& note);

}  // namespace kerf
