#include "cut/removal/near_bricks.h"

#include <algorithm>
#include <bit>

namespace kerf {
namespace {

constexpr double kSlackVoxels = 0.25;  // a larger slack finds more bricks, a smaller one more often
constexpr double kLongestStep = 0.4;   // of the steps for which bricks are kept, in slacks
constexpr float kTurns = 3;            // rotations of a solid in a step for which bricks are found
constexpr std::size_t kMaxKept = 4096;

/// Returns the part of the slack, 9/16 to 1, for which a leaf's bricks are kept. It differs between neighbours, so that
/// they are not all found again in the same step.
double CalcShare(const LeafIndex& leaf) {
  const unsigned order = static_cast<unsigned>(5 * leaf.x + 3 * leaf.y + 7 * leaf.z) & 7u;
  return 0.5 + (order + 1) / 16.0;
}

unsigned CalcHash(const LeafIndex& leaf) {
  const unsigned mixed = static_cast<unsigned>(leaf.x) * 73856093u ^ static_cast<unsigned>(leaf.y) * 19349663u ^
                         static_cast<unsigned>(leaf.z) * 83492791u;
  return mixed ^ mixed >> 15;
}

}  // namespace

NearBricks::NearBricks(double voxel_mm, const LeafIndex& origin, std::size_t leaves)
    : voxel_mm_(voxel_mm), origin_(origin), kept_(std::bit_ceil(std::clamp<std::size_t>(leaves, 1, kMaxKept))) {}

void NearBricks::Forget() {
  ++epoch_;
  moved_mm_ = 0;
}

void NearBricks::Begin(const Sweep& sweep, const Pose& X_from, bool same_zone) {
  step_ = &sweep.step;
  widened_.reset();
  searched_ = 0;
  keeps_ = same_zone && Keeps(sweep.zone);
  if (sweep.zone.solid && sweep.flank_slack_mm > 0) {
    // A step of a solid that turns leaves out what the same step, made again, would cut beside its start.
    widened_ = sweep.step;
    widened_->flank_slack *= kTurns;
  }
  if (!keeps_) return;
  way_mm_ = sweep.zone.BoundTravel(X_from, sweep.X_to);
  moved_mm_ += way_mm_;
  keeps_ = way_mm_ <= kLongestStep * kSlackVoxels * voxel_mm_;
}

std::uint64_t NearBricks::Find(const LeafIndex& leaf, const std::array<float, 3>& corner_T) {
  const bool all_zone = !step_->new_only;
  const LeafIndex from_origin{leaf.x - origin_.x, leaf.y - origin_.y, leaf.z - origin_.z};
  Kept& kept = kept_[CalcHash(from_origin) & (kept_.size() - 1)];
  const bool is_kept = kept.epoch == epoch_ && kept.leaf == leaf && moved_mm_ <= kept.until_mm;
  if (keeps_ && is_kept && (kept.all_zone || !all_zone)) return kept.bricks;
  ++searched_;
  if (!keeps_) return FindBricks(widened_ ? *widened_ : *step_, corner_T);
  const double slack_mm = kSlackVoxels * voxel_mm_;
  if (!widened_) widened_ = step_->Widened(static_cast<float>(slack_mm));
  kept = {leaf, epoch_, all_zone, moved_mm_ + CalcShare(from_origin) * (slack_mm - way_mm_),
          FindBricks(*widened_, corner_T)};
  return kept.bricks;
}

}  // namespace kerf
