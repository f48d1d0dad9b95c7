#include "session/run/overall_progress.h"

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "session/run/bone_cache.h"
#include "session/scene/path.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

// Expected durations, measured with the default scene on two cores of 2.5 GHz. A face is a square of voxels on the
// bone's surface.
constexpr double kReadFace_s = 2.5e-7;
constexpr double kMakeFace_s = 2e-6;     // of the mandible
constexpr double kMakeVoxel_s = 1e-8;    // of a block
constexpr double kPrepareFace_s = 5e-7;  // of a loop
constexpr double kSeparateFace_s = 8e-7;
constexpr double kWriteFace_s = 2.1e-6;  // as a reduced surface
constexpr double kBeforeFace_s = 5e-7;   // in the picture before the cut
constexpr double kPicture_s = 0.5;       // of those after the cut
constexpr double kPathTick_s = 3.5e-5;
constexpr double kSlabTick_s = 2e-6;
constexpr double kHandTick_s = 1e-4;
constexpr double kLeast_s = 0.05;
constexpr double kMandible_mm2 = 3e4;  // area of the surface, with cavities
constexpr double kFaceBytes = 22;      // of a bone's file

double Square(double x) {
  return x * x;
}

double CountBlockVoxels(const BlockParams& block) {
  const Vec3 count = block.size_mm / block.voxel_mm;
  return count.x * count.y * count.z;
}

/// Estimates the number of faces of the bone's surface.
double EstimateFaces(const SceneBone& bone) {
  switch (bone.source) {
    case BoneSource::kFile: {
      std::error_code missing;
      const std::uintmax_t bytes = std::filesystem::file_size(bone.file, missing);
      return missing ? 0 : static_cast<double>(bytes) / kFaceBytes;
    }
    case BoneSource::kBlock:
    case BoneSource::kPlate: {
      const Vec3& size = bone.block.size_mm;
      return 2 * (size.x * size.y + size.y * size.z + size.z * size.x) / Square(bone.block.voxel_mm);
    }
    case BoneSource::kMandible:
      return kMandible_mm2 / Square(bone.mandible.voxel_mm);
  }
  return 0;
}

double EstimateBone_s(const SceneBone& bone) {
  const double faces = EstimateFaces(bone);
  switch (bone.source) {
    case BoneSource::kFile:
      return kLeast_s + kReadFace_s * faces;
    case BoneSource::kBlock:
    case BoneSource::kPlate:
      return kLeast_s + kMakeVoxel_s * CountBlockVoxels(bone.block);
    case BoneSource::kMandible:
      return kLeast_s + (IsMandibleCached(bone.mandible) ? kReadFace_s : kMakeFace_s) * faces;
  }
  return kLeast_s;
}

/// `before_first`: before.png is drawn while the pieces are separated and made.
void AddResults(const Scene& scene, bool before_first, std::vector<ExpectedStage>& stages) {
  const double faces = EstimateFaces(scene.bone);
  const bool pictures = scene.output.pictures && kPicturesBuilt;
  const double before_s = pictures ? kBeforeFace_s * faces : 0;
  stages.push_back({"separating the pieces", kLeast_s + kSeparateFace_s * faces + (before_first ? before_s : 0)});
  stages.push_back({"writing the pieces", kLeast_s + (scene.output.pieces || pictures ? kWriteFace_s * faces : 0)});
  stages.push_back({"drawing the pictures", (pictures ? 3 * kPicture_s : 0) + (before_first ? 0 : before_s)});
}

void AddSlabResults(const Scene& scene, std::vector<ExpectedStage>& stages) {
  stages.push_back({"cutting the bone into its three parts", kLeast_s + kWriteFace_s * EstimateFaces(scene.bone)});
  stages.push_back({"drawing the pictures", scene.output.pictures && kPicturesBuilt ? kPicture_s : 0});
}

}  // namespace

std::vector<ExpectedStage> ListRunStages(const Scene& scene, bool results) {
  const bool slab = scene.simulation.mode == SceneMode::kSlab;
  const auto ticks = static_cast<double>(MakePath(scene).CountTicks(scene.simulation.rate_hz));
  std::vector<ExpectedStage> stages{{"making the bone", EstimateBone_s(scene.bone)},
                                    {"cutting", ticks * (slab ? kSlabTick_s : kPathTick_s)}};
  if (results && slab) AddSlabResults(scene, stages);
  if (results && !slab) AddResults(scene, true, stages);
  return stages;
}

std::vector<ExpectedStage> ListLoopStages(const Scene& scene, const LoopOptions& options, bool results) {
  const double ticks_s = options.seconds * scene.loop.rate_hz * kHandTick_s;
  std::vector<ExpectedStage> stages{{"making the bone", EstimateBone_s(scene.bone)},
                                    {"preparing the session", kLeast_s + kPrepareFace_s * EstimateFaces(scene.bone)}};
  if (options.replay.continues) stages.push_back({"repeating the recording", ticks_s});
  stages.push_back({"cutting", options.virtual_time ? ticks_s : options.seconds, true});
  if (results) AddResults(scene, false, stages);
  return stages;
}

double OverallProgress::Advance(const std::string& stage, double fraction) {
  const auto found =
      std::find_if(stages_.begin(), stages_.end(), [&](const ExpectedStage& s) { return s.name == stage; });
  if (found == stages_.end()) return completed_;
  const auto index = static_cast<std::size_t>(found - stages_.begin());
  if (index != now_ && stages_[now_].may_end_early) stages_[now_].seconds *= fraction_;
  now_ = index;
  fraction_ = std::clamp(fraction, 0.0, 1.0);
  const auto sum_s = [](auto from, auto to) {
    return std::accumulate(from, to, 0.0, [](double sum, const ExpectedStage& s) { return sum + s.seconds; });
  };
  const double total_s = sum_s(stages_.begin(), stages_.end());
  if (!(total_s > 0)) return completed_;
  completed_ = std::max(completed_, (sum_s(stages_.begin(), found) + fraction_ * found->seconds) / total_s);
  return completed_;
}

}  // namespace kerf
