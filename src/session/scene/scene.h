// A scene: all inputs of a run. The structs are the schema of the TOML file (docs/scene.md): a field has the name, unit
// and default of its key. Ranges and meanings are in src/session/scene/schema.h and, for parameters that the library
// has too, next to its structs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "cut/tool/sense.h"
#include "kerf/effects.h"
#include "kerf/geometry.h"
#include "kerf/material.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"
#include "session/plan/plan.h"
#include "session/scene/exercise.h"
#include "session/scene/hand_held.h"

namespace kerf {

/// Source of the bone.
enum class BoneSource { kFile, kMandible, kBlock, kPlate };

struct SceneBone {
  BoneSource source = BoneSource::kBlock;
  std::string file;  // kFile only: a .vdb, absolute path
  // A region table (CSV), absolute path; empty: the file's own or, for a model, the built-in one.
  std::string materials;
  BlockParams block;        // kBlock and kPlate
  MandibleParams mandible;  // kMandible
};

/// Source of the bone's stiffness.
enum class MaterialKind { kRegions, kUniform, kCt };

struct SceneMaterial {
  MaterialKind kind = MaterialKind::kRegions;
  // kUniform: region 24 of the paper
  double E_GPa = 19.3;
  double nu = 0.28;
  // kCt: E from the CT numbers in the bone's file; nu by region
  std::string ct_law;          // its name
  std::string ct_law_file;     // a table of laws (CSV), absolute path; empty: the built-in ones
  std::string ct_calibration;  // "HU:density HU:density ..."; empty: the law's own
  bool ct_all = false;         // false: cancellous regions only
  /// Direction of the osteons, world frame; any length but 0. nullopt: unknown.
  std::optional<Vec3> osteon_direction;
};

struct SceneTool {
  Tool shape = DiscSaw{};  // all keys but the next three, with the library's names; MakeTool() sets its E
  double rpm = 7500;       // speed of the disc; if a scene states none, CalcOrdinaryRate() of its shape
  bool reverse = false;    // turns against GetSense(); only of a tool that turns
  double E_GPa = 205;

  /// Returns `rpm` of a tick at a speed of 0 or more: negative for a tool that turns about -z.
  double CalcTickRpm(double speed_rpm) const { return (GetSense(shape) < 0) == reverse ? speed_rpm : 0 - speed_rpm; }
  double CalcTickRpm() const { return CalcTickRpm(rpm); }
};

/// A straight stroke of the tool's origin at constant feed rate; the tool rotates only about its spindle.
struct SceneStroke {
  Vec3 start_mm{0};  // tool's origin, world frame
  Vec3 end_mm{0};
  double feed_mm_per_s = 3;
  Vec3 disc_normal{0, 1, 0};  // z axis of the tool frame, world frame; any length but 0
  double dwell_s = 0;         // the tool rests at end_mm, driven
  /// True: before the stroke the tool is lifted out and placed at start_mm, instantly and without cutting. False: the
  /// stroke continues from the end of the previous one, with the same disc_normal.
  bool retract = true;
};

/// A row of a path file.
struct TimedPose {
  double time_s = 0;
  Pose X_WT;
};

/// Path of the tool: either strokes or a file.
struct ScenePath {
  std::vector<SceneStroke> strokes;
  std::string file;              // CSV, absolute path; empty: strokes
  std::vector<TimedPose> poses;  // the file's rows, time strictly increasing, at least 2
};

/// kVoxel: the disc removes voxels. kSlab: the bone is cut into three parts beforehand, and the slice slides
/// (docs/slab.md).
enum class SceneMode { kVoxel, kSlab };

struct SceneSimulation {
  SceneMode mode = SceneMode::kVoxel;
  double rate_hz = 1000;
  int rim_samples_per_pitch = 16;
  int substeps = 1;
  int carve_interval_ticks = 1;
};

/// Source of the slab's depths and materials.
enum class SlabDepth { kBone, kPaperTable2 };

/// Slab mode; `kerf compare` also uses this section. The plane is the disc's plane at the start of the path, and the
/// slice is as thick as the disc.
struct SceneSlab {
  bool given = false;       // the file has the section; not a key
  Vec3 direction{0, 1, 0};  // of the cut, world frame; any length but 0
  SlabDepth depth_by = SlabDepth::kBone;
  SlabBody hold = SlabBody::kSlice;
  SlabParams params;  // all but its saw and its direction
};

struct SceneOutput {
  bool pictures = true;
  bool pieces = true;
  bool bone = true;
  double smallest_piece_mm3 = 1;
  int forces_every_ticks = 1;
};

struct Scene {
  std::string name;   // the scene file without folder and extension; not a key
  std::string title;  // one line of description
  const std::string& TitleOrName() const { return title.empty() ? name : title; }
  SceneBone bone;
  SceneMaterial material;
  SceneTool tool;
  ScenePath path;
  ForceLaw force;
  std::string force_file;  // table that the law was read from; empty: none
  SceneSimulation simulation;
  SceneSlab slab;
  SceneOutput output;
  EffectChoices effects;                // effects that the file names, in its order
  Plan plan;                            // planned cuts, including planes read from other files
  std::vector<std::string> plan_files;  // of these planes, absolute paths
  SceneCoupling coupling;
  SceneDevice device;
  SceneHand hand;
  SceneLoop loop;
  SceneExercise exercise;
};

/// Reads a scene and its path file, if any. Relative file names are relative to the scene file. Throws kerf::Error that
/// names every fault, one line each: `scenes/x.toml:14:1: thickness_mm = -0.1 is below 0.02; ...`. Does not open the
/// bone, the region table or the table of CT laws.
Scene ReadScene(const std::string& file);
/// Parses a scene from text, with the same errors. `file` is used in messages and as the base of relative file names.
Scene ParseScene(const std::string& text, const std::string& file);

/// Returns the scene as commented TOML with all its values, each with unit, range and meaning. ParseScene() of it gives
/// an equal scene.
std::string ResolvedToml(const Scene& scene);
/// Returns a commented, complete scene that can be run; alternatives to its settings are given as comments.
std::string DefaultSceneToml();

/// The following functions convert the scene's values to the library's units.
Tool MakeTool(const Scene& scene);
/// Returns the disc, for functions that require one. Throws kerf::Error for another tool.
DiscSaw MakeDiscSaw(const Scene& scene);
SimulationParams MakeSimulationParams(const Scene& scene);
CoupledParams MakeCoupledParams(const Scene& scene);
SlabParams MakeSlabParams(const Scene& scene);
/// Returns the plane of the slab: the disc's plane at the start of the path. Throws kerf::Error if the cut direction
/// does not lie in it, or if the path leaves it by more than the tolerance for a hand's motion, or leaves the slice.
CutPlane MakeSlabPlane(const Scene& scene);

}  // namespace kerf
