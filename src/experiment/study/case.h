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
  std::string title;  // one line, shown to the user
  DiscSaw saw;
  double rpm = 7500;
  double duration_s = 0;
  std::function<Pose(Holding, double t_s)> pose;  // of the handle (kHand) or of the tool (kPath); t_s: 0 to duration_s
  /// Times, ascending, after which the tool is lifted out of the bone and set down where pose() continues.
  std::vector<double> lifts_s;
  CouplingParams coupling;  // kHand
  ForceLaw law;             // used if the settings select this law; other laws use their default parameters
  MaterialTable materials;
  ExactSolid solid;  // the exact solid, with the constants from `materials`
  /// The same solid with E from the CT, and a function that assigns this E to a bone made by make_bone(). Both are
  /// empty if there are no CT numbers.
  ExactSolid ct_solid;
  std::function<void(Bone&)> use_ct;
  Box3 bounds_W;  // contains every part of the solid that the tool may come near
  std::vector<Holding> holdings;
  /// Returns the solid as a voxel bone, by regions. May be called from several threads at once. Throws Error if the
  /// bone cannot be made.
  std::function<Bone(double voxel_mm, int band_voxels)> make_bone;
};

/// The built-in paths by name. Paths whose data are missing are listed in `left_out`, with the reason.
struct StudyPathList {
  std::vector<StudyPath> paths;
  std::vector<std::pair<std::string, std::string>> left_out;  // name and reason
};
/// Makes the paths in `names`, or all paths if it is empty. `data_folder` is ../shared/data, or empty if there is none.
/// Bones that take long to import are stored in `cache_folder`, which is created if needed, and read from there; if it
/// is empty, they are not stored. Throws Error for an unknown name.
StudyPathList MakeStudyPaths(const std::vector<std::string>& names, const std::string& data_folder,
                             const std::string& cache_folder = "");
std::vector<std::string> NamesOfStudyPaths();
/// Makes a study path from the bone and all strokes of a scene file. Throws Error if the scene cannot be read.
StudyPath MakeScenePath(const std::string& name, const std::string& scene_file);

/// The reference for some settings: computed with the same law, material and coupling, and with everything else as fine
/// as necessary.
struct StudyReference {
  ReferenceRecord record;
  double tick_s = 0.00025;           // interval of the stored ticks
  std::vector<ReferenceTick> ticks;  // one every tick_s
  double removed_mm3 = 0;            // over the whole path
  std::shared_ptr<const ExactBone> bone;
};
/// Returns the law, unless it is hertz_chip, and the material, unless it is "regions", e.g. "law=two_component".
/// On the same path and with the same holding, settings with the same string share a reference.
std::string VariantOf(const StudySettings& settings);
/// Refines the reference until two successive refinements differ by at most `tolerance` (a fraction of the force, as
/// force_p95), or up to the maximum refinement. If `file` exists and has the same input, reads the reference from it;
/// otherwise writes the reference there. If `file` is empty, does neither.
StudyReference MakeStudyReference(const StudyPath& path, Holding holding, const StudySettings& settings,
                                  double tolerance, const std::string& file, const std::atomic<bool>* stop);

/// Throws Error if `core` is set and the timed ticks cannot be bound to that core.
void CheckCore(std::optional<int> core);

struct CaseOutcome {
  CaseState state = CaseState::kDone;
  std::string why;
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
};
/// Computes the errors of a case. May be called from several threads at once.
CaseOutcome RunForErrors(const StudyPath& path, Holding holding, const StudySettings& settings,
                         const StudyReference& reference);
/// Measures the costs of a case over at least `ticks` ticks, repeating the path as often as necessary. Nothing else
/// should run at the same time.
CaseOutcome RunForCosts(const StudyPath& path, Holding holding, const StudySettings& settings, std::uint64_t ticks,
                        std::optional<int> core);

}  // namespace kerf
