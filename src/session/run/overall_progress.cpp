#include "session/run/overall_progress.h"

#include <algorithm>
#include <filesystem>

#include "bone/grid/build_times.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

// Expected durations on one core of 2.5 GHz.
constexpr double kBlockVoxel_s = 2e-8;
constexpr double kFileByte_s = 1e-8;
constexpr double kPathTick_s = 2e-5;
constexpr double kSlabTick_s = 2e-6;
constexpr double kHandTick_s = 1e-4;
constexpr double kPieces_s = 1;
constexpr double kPictures_s = 3;
constexpr double kLeast_s = 0.05;  // of making a bone

double EstimateBone_s(const Scene& scene) {
  const SceneBone& bone = scene.bone;
  switch (bone.source) {
    case BoneSource::kFile: {
      std::error_code missing;
      const std::uintmax_t bytes = std::filesystem::file_size(bone.file, missing);
      return kLeast_s + (missing ? 0 : kFileByte_s * static_cast<double>(bytes));
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate: {
      const Vec3 count = bone.block.size_mm / bone.block.voxel_mm;
      return kLeast_s + kBlockVoxel_s * count.x * count.y * count.z;
    }
    case BoneSource::kMandible: {
      const double voxel_mm = bone.mandible.voxel_mm;
      return EstimateBuildTimes(voxel_mm, std::max(voxel_mm, 0.2), false).total_s();
    }
  }
  return kLeast_s;
}

void AddResults(const Scene& scene, const char* pieces, std::vector<ExpectedStage>& stages) {
  stages.push_back({pieces, kPieces_s});
  stages.push_back({"drawing the pictures", scene.output.pictures ? kPictures_s : 0});
}

}  // namespace

std::vector<ExpectedStage> ListRunStages(const Scene& scene, bool results) {
  const bool slab = scene.simulation.mode == SceneMode::kSlab;
  const auto ticks = static_cast<double>(MakePath(scene).CountTicks(scene.simulation.rate_hz));
  std::vector<ExpectedStage> stages{{"making the bone", EstimateBone_s(scene)},
                                    {"cutting", ticks * (slab ? kSlabTick_s : kPathTick_s)}};
  if (results) AddResults(scene, slab ? "cutting the bone into its three parts" : "separating the pieces", stages);
  return stages;
}

std::vector<ExpectedStage> ListLoopStages(const Scene& scene, const LoopOptions& options, bool results) {
  const double bone_s = EstimateBone_s(scene);
  const double ticks_s = options.seconds * scene.loop.rate_hz * kHandTick_s;
  std::vector<ExpectedStage> stages{{"making the bone", bone_s}, {"preparing the session", 0.2 * bone_s}};
  if (options.replay.continues) stages.push_back({"repeating the recording", ticks_s});
  stages.push_back({"cutting", options.virtual_time ? ticks_s : options.seconds});
  if (results) AddResults(scene, "separating the pieces", stages);
  return stages;
}

double OverallProgress::Advance(const std::string& stage, double fraction) {
  double before_s = 0, total_s = 0, stage_s = 0;
  bool found = false;
  for (const ExpectedStage& s : stages_) {
    if (s.name == stage) {
      found = true;
      before_s = total_s;
      stage_s = s.seconds;
    }
    total_s += s.seconds;
  }
  if (!found || !(total_s > 0)) return completed_;
  completed_ = std::max(completed_, (before_s + std::clamp(fraction, 0.0, 1.0) * stage_s) / total_s);
  return completed_;
}

}  // namespace kerf
