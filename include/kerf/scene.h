// A scene: a TOML file with all inputs of a run (docs/scene.md), read strictly, and what kerf makes of it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "kerf/coupled.h"
#include "kerf/path.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"
#include "kerf/tool.h"

namespace kerf {

struct Scene;

/// Called with the completed fraction, 0 to 1, in the calling thread. Returning false cancels the work, which then
/// throws kerf::Error.
using ShowProgress = std::function<bool(double fraction)>;

/// A scene file's text and its values. Value type; copies are cheap. All functions that throw kerf::Error name each
/// fault with file, line and column, as the program does.
class SceneFile {
 public:
  /// The default scene: a block of bone with one stroke of the disc.
  SceneFile();
  /// Reads a scene. Relative file names in it are relative to its folder.
  static SceneFile Read(const std::string& path);
  /// Parses a scene. `path` is used in messages and as the base of relative file names; it need not exist.
  static SceneFile Parse(const std::string& toml, const std::string& path = "scene.toml");

  /// Returns a copy with another value: Set("bone.block", "voxel_mm", "0.2"). `value` is written in TOML, so a text
  /// needs quotes. A key or table that the scene lacks is added. Throws kerf::Error for a value that the scene cannot
  /// have.
  SceneFile With(const std::string& table, const std::string& key, const std::string& value) const;

  const std::string& toml() const;   // the text
  const std::string& path() const;   // as given to Read() or Parse()
  const std::string& name() const;   // the file's name without folder and extension
  const std::string& title() const;  // "" if there is none
  /// Returns the scene with all its keys, each with unit, range and meaning in a comment.
  std::string Resolve() const;

  bool is_slab() const;    // [simulation] mode = "slab"
  double rate_hz() const;  // ticks per second along the path
  double rpm() const;      // of a tick: the speed, negative for a tool that turns about -z
  Tool tool() const;
  SimulationParams MakeSimulationParams() const;
  CoupledParams MakeCoupledParams() const;
  SlabParams MakeSlabParams() const;
  /// Reads or makes the bone, with the scene's material. Throws kerf::Error.
  Bone MakeBone(const ShowProgress& progress = {}) const;
  /// Computes the material in front of the blade in slab mode. Throws kerf::Error if the scene has no plane of a slab.
  SlabProfile MakeSlabProfile(const Bone& bone) const;
  /// Returns the ticks and placements of the path. The first is the placement at which a simulation starts.
  std::vector<PathStep> ListPathSteps() const;

  /// For kerf's own functions.
  const Scene& scene() const { return *scene_; }
  /// Returns a copy for a scene with values that its text lacks.
  explicit SceneFile(const Scene& scene, std::string path);

 private:
  SceneFile(std::string text, std::string path, std::shared_ptr<const Scene> scene);
  std::string text_;
  std::string path_;
  std::shared_ptr<const Scene> scene_;
};

}  // namespace kerf
