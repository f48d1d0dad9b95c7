// A scene: everything that a run is made of. The structs are the schema of the TOML file (docs/scene.md): a field has
// the name, the unit and the default of its key. Ranges and meanings stand in src/session/scene/schema.h.
#pragma once

#include <string>
#include <vector>

#include "bone/models/block.h"
#include "bone/models/mandible.h"
#include "kerf/effects.h"
#include "kerf/geometry.h"
#include "kerf/material.h"
#include "kerf/simulation.h"
#include "kerf/slab.h"
#include "session/plan/plan.h"
#include "session/scene/exercise.h"
#include "session/scene/hand_held.h"

namespace kerf {

/// Where the bone comes from.
enum class BoneSource { kFile, kMandible, kBlock, kPlate };

struct SceneBone {
  BoneSource source = BoneSource::kBlock;
  std::string file;  // kFile only: a .vdb, absolute path
  std::string
      materials;      // a region table (CSV), absolute path; empty: the file's own or, for a model, the one built in
  BlockParams block;  // kBlock and kPlate
  MandibleParams mandible;  // kMandible
};

/// What the bone's stiffness is taken from.
enum class MaterialKind { kRegions, kUniform, kCt };

struct SceneMaterial {
  MaterialKind kind = MaterialKind::kRegions;
  // kUniform: the paper's region 24
  double E_GPa = 19.3;
  double nu = 0.28;
  // kCt: E from the CT numbers that the bone's file keeps; nu by region
  std::string ct_law;          // its name
  std::string ct_law_file;     // a table of laws (CSV), absolute path; empty: the built-in ones
  std::string ct_calibration;  // "HU:density HU:density ..."; empty: the law's own
  bool ct_all = false;         // false: cancellous regions only
};

enum class ToolKind { kDisc, kBall };

struct SceneTool {
  ToolKind kind = ToolKind::kDisc;
  double diameter_mm = 22;     // of the disc, 6 when a ball does not say
  double thickness_mm = 0.25;  // this and the next: kDisc
  int teeth = 24;
  int flutes = 8;  // this and the next: kBall
  double tooth_width_mm = 0.5;
  double rpm = 7500;
  double E_GPa = 205;
  double nu = 0.28;
  Vec3 grip_mm{0, 0, 80};  // in the tool frame
};

/// A straight stroke of the disc's centre at constant feed, the disc not turning but about its spindle.
struct SceneStroke {
  Vec3 start_mm{0};  // disc centre, world frame
  Vec3 end_mm{0};
  double feed_mm_per_s = 3;
  Vec3 disc_normal{0, 1, 0};  // spindle axis, world frame; of any length but 0
  double dwell_s = 0;         // the disc rests at end_mm, spinning
  /// True: before the stroke the tool is lifted out and set down at start_mm, in no time and without cutting.
  /// False: the stroke goes on where the one before ended, with the same disc_normal.
  bool retract = true;
};

/// A row of a path file.
struct TimedPose {
  double time_s = 0;
  Pose X_WT;
};

/// Either strokes or a file.
struct ScenePath {
  std::vector<SceneStroke> strokes;
  std::string file;              // CSV, absolute path; empty: strokes
  std::vector<TimedPose> poses;  // the file's rows, time strictly increasing, at least 2
};

/// kVoxel: the disc removes voxels. kSlab: the bone is cut into three beforehand, and the slice slides (docs/slab.md).
enum class SceneMode { kVoxel, kSlab };

struct SceneSimulation {
  SceneMode mode = SceneMode::kVoxel;
  double rate_hz = 1000;
  int rim_samples_per_pitch = 16;
  int substeps = 1;
  int carve_interval_ticks = 1;
};

/// Where the slab's depths and materials come from.
enum class SlabDepth { kBone, kPaperTable2 };

/// Slab mode; also what `kerf compare` holds against voxel mode. The plane is the disc's where the path starts, and the
/// slice is as thick as the disc.
struct SceneSlab {
  bool given = false;       // the file has the section; not a key
  Vec3 direction{0, 1, 0};  // of the cut, world frame; of any length but 0
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
  std::string title;  // one line for people
  SceneBone bone;
  SceneMaterial material;
  SceneTool tool;
  ScenePath path;
  ForceLaw force;
  SceneSimulation simulation;
  SceneSlab slab;
  SceneOutput output;
  EffectChoices effects;  // those that the file names, in its order
  Plan plan;              // what is meant to be cut; a plane that the file takes from another file stands here itself
  SceneCoupling coupling;
  SceneDevice device;
  SceneHand hand;
  SceneLoop loop;
  SceneExercise exercise;
};

/// Reads a scene and the path file that it names, if any. Relative file names are relative to the scene file.
/// Throws Error that names every fault, one line each: `scenes/x.toml:14:1: thickness_mm = -0.1 is below 0.02; ...`.
/// Does not open the bone, the region table or the table of CT laws.
Scene ReadScene(const std::string& file);
/// The same from text; `file` is named in messages and is what relative file names are relative to.
Scene ParseScene(const std::string& text, const std::string& file);

/// The scene as commented TOML with every value of it, each with unit, range and meaning. ParseScene() of it gives an
/// equal scene.
std::string ResolvedToml(const Scene& scene);
/// A commented full scene that runs as it stands; what the default leaves out stands in it as comments.
std::string DefaultSceneToml();

/// The scene's values in the library's units.
Tool MakeTool(const Scene& scene);
/// For people: "disc 22 x 0.25 mm, 24 teeth", "ball burr 6 mm, 8 flutes".
std::string DescribeTool(const SceneTool& tool);
/// For what only a disc can do. Throws Error when the tool is another.
DiscSaw MakeDiscSaw(const Scene& scene);
SimulationParams MakeSimulationParams(const Scene& scene);
CoupledParams MakeCoupledParams(const Scene& scene);
SlabParams MakeSlabParams(const Scene& scene);
/// The plane of the slab: the disc's where the path starts. Throws Error when the cut direction does not lie in it, or
/// the path leaves it by more than a hand wavers, or goes past the slice.
CutPlane MakeSlabPlane(const Scene& scene);

}  // namespace kerf
