// One case of a study: a path, a way of holding the tool and settings, run for its errors or for its costs.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiment/reference/reference.h"
#include "experiment/study/knobs.h"
#include "experiment/study/records.h"
#include "kerf/bone.h"
#include "kerf/coupled.h"

namespace kerf {

/// A way for the handle or the tool, and the bone that it meets.
struct StudyPath {
  std::string name;   // "slot"; letters, digits, '-' and '_'
  std::string title;  // for people, in a line
  DiscSaw saw;
  double rpm = 7500;
  double duration_s = 0;
  std::function<Pose(Holding, double t_s)> pose;  // 0 to duration_s; of the handle (kHand) or the tool (kPath)
  /// Rising: after these times the tool is lifted out of the bone and set down where pose() goes on.
  std::vector<double> lifts_s;
  CouplingParams coupling;  // kHand
  ForceLaw law;             // its parameters, for settings that name it; others have the presets
  MaterialTable materials;
  ExactSolid solid;  // with `materials`, by regions; the truth
  /// The same with E from the CT, and what makes a bone of make_bone() take its E from there; empty without CT numbers.
  ExactSolid ct_solid;
  std::function<void(Bone&)> use_ct;
  Box3 bounds_W;  // holds all of the solid that the tool can come near
  std::vector<Holding> holdings;
  /// The solid as kerf holds it, by regions. Any thread, several at once. Throws Error.
  std::function<Bone(double voxel_mm, int band_voxels)> make_bone;
};

/// The built-in paths by name; those whose data are not there are left out, with the reason.
struct StudyPathList {
  std::vector<StudyPath> paths;
  std::vector<std::pair<std::string, std::string>> left_out;  // name, why
};
/// `names` empty: all. `data_folder`: ../shared/data or empty. What takes long to import is kept in `cache_folder`,
/// which is made if need be, and read from there (empty: neither). Throws Error for a name that there is not.
StudyPathList MakeStudyPaths(const std::vector<std::string>& names, const std::string& data_folder,
                             const std::string& cache_folder = "");
std::vector<std::string> NamesOfStudyPaths();
/// The bone of a scene file, and its path up to the first stroke that begins with the tool lifted out and set down, or
/// with all `strokes`. Throws Error.
enum class SceneStrokes { kUntilLifted, kAll };
StudyPath MakeScenePath(const std::string& name, const std::string& scene_file,
                        SceneStrokes strokes = SceneStrokes::kUntilLifted);

/// A reference that settings are held against: law, material and coupling as theirs, all else as fine as it takes.
struct StudyReference {
  ReferenceRecord record;
  double tick_s = 0.00025;           // so often it was written down
  std::vector<ReferenceTick> ticks;  // at tick_s
  double removed_mm3 = 0;            // in all
  std::shared_ptr<const ExactBone> bone;
};
/// "law=..." or empty: settings with the same word share a reference.
std::string VariantOf(const StudySettings& settings);
/// Refined until two refinements differ by less than `tolerance` (a share of the force, as force_p95), or the most that
/// is tried. Read from `file` when it is there and of the same input, else written to it (empty: neither).
StudyReference MakeStudyReference(const StudyPath& path, Holding holding, const StudySettings& settings,
                                  double tolerance, const std::string& file, const std::atomic<bool>* stop);

/// Throws Error when timed ticks can't be held to that core.
void CheckCore(std::optional<int> core);

struct CaseOutcome {
  CaseState state = CaseState::kDone;
  std::string why;
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
};
/// Errors; any thread, several at once.
CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference);
/// Costs: at least so many ticks, the path anew as often as it takes; nothing else should run meanwhile.
CaseOutcome RunForCosts(const StudyPath& path, Holding holding, const StudySettings& settings, std::uint64_t ticks,
                        std::optional<int> core);

}  // namespace kerf
