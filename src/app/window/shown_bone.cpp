#include "app/window/shown_bone.h"

#include <chrono>
#include <utility>

#include "app/window/is_ready.h"
#include "base/realtime/realtime.h"
#include "bone/grid/shared_leaves.h"

namespace kerf {

std::shared_ptr<SurfaceWorker> ShownBone::Show(std::shared_ptr<const Bone> bone, bool final, const Bone* before) {
  auto surface = std::make_shared<SurfaceWorker>(CopySharing(*bone), 0, before);
  Made made{
      .surface = surface, .bone = final ? bone : nullptr, .materials = bone->materials(), .voxel_mm = bone->voxel_mm()};
  const std::lock_guard lock(mutex_);
  surface->SetCt(ct_);
  made_ = std::move(made);
  if (final) at_start_ = std::move(bone);
  return surface;
}

std::shared_ptr<const Bone> ShownBone::at_start() const {
  const std::lock_guard lock(mutex_);
  return at_start_;
}

void ShownBone::set_ct(CtSource ct) {
  const std::lock_guard lock(mutex_);
  ct_ = std::move(ct);
  if (made_) made_->surface->SetCt(ct_);
  if (surface_) surface_->SetCt(ct_);
}

CtSource ShownBone::ct() const {
  const std::lock_guard lock(mutex_);
  return ct_;
}

bool ShownBone::Take(bool at_once) {
  std::optional<Made> made;
  {
    const std::lock_guard lock(mutex_);
    if (made_ && surface_ && !at_once && !made_->surface->first_done()) return false;
    made.swap(made_);
  }
  if (!made) return false;
  surface_ = std::move(made->surface);
  inner_.reset();
  view_.BeginBone(made->materials, surface_->origin_W(), surface_->drawn_bounds_W(), made->voxel_mm);
  trace_.Write("bone", {{"final", made->bone != nullptr}, {"voxel_mm", made->voxel_mm}});
  if (!made->bone) return true;
  if (making_inner_.valid()) unused_inner_.push_back(std::move(making_inner_));
  making_inner_ = std::async(std::launch::async, [bone = std::move(made->bone)] {
    LowerPriority();
    return MakeInnerSurfaces(*bone);
  });
  return true;
}

void ShownBone::Update(LogHistogram& uploads) {
  if (IsReady(making_inner_)) {
    inner_ = std::make_shared<const InnerSurfaces>(making_inner_.get());
    view_.SetInnerSurfaces(*inner_);
    if (surface_) surface_->SetInnerSurfaces(inner_);
  }
  std::erase_if(unused_inner_, [](const std::future<InnerSurfaces>& making) { return IsReady(making); });
  if (!surface_) return;
  for (const ChunkMesh& chunk : surface_->Fetch()) {
    const auto began = std::chrono::steady_clock::now();
    view_.SetChunk(chunk);
    const std::chrono::nanoseconds duration = std::chrono::steady_clock::now() - began;
    if (chunk.cut) uploads.Add(duration.count());
  }
}

void ShownBone::Clear() {
  {
    const std::lock_guard lock(mutex_);
    made_.reset();
    at_start_.reset();
    ct_ = nullptr;
  }
  if (making_inner_.valid()) unused_inner_.push_back(std::move(making_inner_));
  surface_.reset();
  inner_.reset();
  view_.BeginBone({}, Vec3{0}, Box3{}, 1);
  view_.SetInnerSurfaces({});
}

}  // namespace kerf
