// One case of a study: a path, a way of holding the tool, and settings. A case is run for its errors or for its costs.
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

/// A motion of the handle or the tool, and the bone that it cuts.
struct StudyPath {
  std::string name;   // "slot"; letters, digits, '-' and '_'
  std::string title;  // for the user, one line
  DiscSaw saw;
  double rpm = 7500;
  double duration_s = 0;
  std::function<Pose(Holding, double t_s)> pose;  // 0 to duration_s; of the handle (kHand) or the tool (kPath)
  /// Ascending. After these times the tool is lifted out of the bone and set down where pose() continues.
  std::vector<double> lifts_s;
  CouplingParams coupling;  // kHand
  ForceLaw law;             // its parameters, for settings that select it; other laws use their defaults
  MaterialTable materials;
  ExactSolid solid;  // exact solid by regions, consistent with `materials`
  /// The same solid with E from the CT, and a function that assigns this E to a bone of make_bone(); empty without CT
  /// numbers.
  ExactSolid ct_solid;
  std::function<void(Bone&)> use_ct;
  Box3 bounds_W;  // contains all of the solid that the tool may approach
  std::vector<Holding> holdings;
  /// Returns the solid as a voxel bone, by regions. May be called from several threads at once. Throws Error if the
  /// bone cannot be made.
  std::function<Bone(double voxel_mm, int band_voxels)> make_bone;
};

/// The built-in paths by name. Paths whose data are missing are listed in `left_out`, with the reason.
struct StudyPathList {
  std::vector<StudyPath> paths;
  std::vector<std::pair<std::string, std::string>> left_out;  // name, why
};
/// `names`: empty for all. `data_folder`: ../shared/data or empty. Bones that take long to import are stored in
/// `cache_folder`, which is created if needed, and read from there (empty: no cache). Throws Error for an unknown name.
StudyPathList MakeStudyPaths(const std::vector<std::string>& names, const std::string& data_folder,
                             const std::string& cache_folder = "");
std::vector<std::string> NamesOfStudyPaths();
/// The bone and the path of a scene file, either up to the first stroke before which the tool is lifted out and set
/// down, or with all strokes. Throws Error if the scene cannot be read.
enum class SceneStrokes { kUntilLifted, kAll };
StudyPath MakeScenePath(const std::string& name, const std::string& scene_file,
                        SceneStrokes strokes = SceneStrokes::kUntilLifted);

/// Reference for settings: same law, material and coupling, with all other settings as fine as necessary.
struct StudyReference {
  ReferenceRecord record;
  double tick_s = 0.00025;           // interval of the stored ticks
  std::vector<ReferenceTick> ticks;  // at tick_s
  double removed_mm3 = 0;            // total
  std::shared_ptr<const ExactBone> bone;
};
/// "law=..." or empty; settings with the same string share a reference.
std::string VariantOf(const StudySettings& settings);
/// Refines until two refinements differ by less than `tolerance` (a fraction of the force, as force_p95), or up to the
/// maximum refinement. Reads the reference from `file` if it exists and has the same input, otherwise writes it there
/// (empty: neither).
StudyReference MakeStudyReference(const StudyPath& path, Holding holding, const StudySettings& settings,
                                  double tolerance, const std::string& file, const std::atomic<bool>* stop);

/// Throws Error if the timed ticks cannot be bound to that core.
void CheckCore(std::optional<int> core);

struct CaseOutcome {
  CaseState state = CaseState::kDone;
  std::string why;
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
};
/// Computes errors. May be called from several threads at once.
CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference);
/// Measures costs over at least `ticks` ticks; the path is repeated as often as necessary. Nothing else should run at
/// the same time.
CaseOutcome RunForCosts(const StudyPath& path, Holding holding, const StudySettings& settings, std::uint64_t ticks,
                        std::optional<int> core);

}  // namespace kerf
