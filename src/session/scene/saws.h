// The saws to choose from: a table of tools, one of which a scene's tool becomes.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

struct Saw {
  std::string name;
  SceneTool tool;
  std::string source;  // of its sizes
};

/// Reads a table such as volumes/saws.csv; `file` names it in messages. Throws Error with the place of the first fault:
/// an unknown column, a value out of the scene's range for it, a name given twice, no saw at all, more than 9.
std::vector<Saw> ParseSaws(const std::string& text, const std::string& file);
/// Those that come with kerf.
const std::vector<Saw>& BuiltInSaws();

/// The scene with that saw in the hand that holds its tool now. What only a disc can have goes with a ball: [slab].
void TakeUpSaw(Scene& scene, const Saw& saw);

}  // namespace kerf
