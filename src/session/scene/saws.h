// Table of saws, any of which can replace a scene's tool.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

struct Saw {
  std::string name;
  SceneTool tool;
  std::string source;  // source of its dimensions
};

/// Reads a table such as volumes/saws.csv; `file` names it in messages. Throws kerf::Error with the place of the first
/// fault: an unknown column, a value outside the scene's range, a duplicate name, no saw, or more than 9.
std::vector<Saw> ParseSaws(const std::string& text, const std::string& file);
/// Returns the saws that are built into kerf.
const std::vector<Saw>& BuiltInSaws();

/// Replaces the scene's tool with this saw, but keeps the grip. For any tool but a disc, removes [slab].
void UseSaw(Scene& scene, const Saw& saw);

}  // namespace kerf
