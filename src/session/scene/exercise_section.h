// Section [exercise] of a scene: the wanted cuts or holes.
#pragma once

#include <string>

#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "session/scene/exercise.h"
#include "session/scene/schema.h"

namespace kerf {

/// Reads [exercise] and its cuts. `tool` is the tool that makes them.
void ReadExercise(TableReader& root, SceneExercise& exercise, const SceneTool& tool, const std::string& scene_file,
                  Faults& faults);

}  // namespace kerf
