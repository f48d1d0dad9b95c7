// Table of saws, any of which can replace a scene's tool.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

struct Saw {
  std::string name;
  SceneTool tool;
  std::string source;  // source of its dimensions
};

/// Largest number of saws in a table.
inline constexpr std::size_t kMaxSaws = 40;

/// Reads a table such as volumes/saws.csv; `file` names it in messages. The columns name, shape, rpm and source are
/// required. Any other one is a key of a shape in [tool], with "none" for a saw whose shape does not have it. A key
/// without a column has its default. Throws kerf::Error with the place of the first fault: an unknown column, a value
/// outside the scene's range, a duplicate name, no saw, or more than kMaxSaws.
std::vector<Saw> ParseSaws(const std::string& text, const std::string& file);
/// Returns the saws that are built into kerf.
const std::vector<Saw>& BuiltInSaws();

/// Returns the speed of a tool, such as "7500 rpm" or "15000 double strokes a minute".
std::string DescribeRate(const SceneTool& tool);
/// Returns the sense in which a tool turns, such as "clockwise as seen from the handpiece"; empty for a stroke.
std::string DescribeSense(const SceneTool& tool);
/// Returns what the tool is and how it moves, such as
/// "disc 22 x 0.25 mm, 24 teeth, 7500 rpm, counter-clockwise as seen from the handpiece".
std::string DescribeDrivenTool(const SceneTool& tool);

/// Replaces the scene's tool with this saw. Keeps the grip, unless the handpiece is held at another side of the tool.
/// For any tool but a disc, removes [slab].
void UseSaw(Scene& scene, const Saw& saw);

}  // namespace kerf
