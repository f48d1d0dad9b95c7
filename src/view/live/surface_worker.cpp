#include "view/live/surface_worker.h"

#include <malloc.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <tuple>
#include <utility>

#include "bone/grid/shared_leaves.h"

namespace kerf {
namespace {

using Index = std::array<int, 3>;

constexpr std::chrono::seconds kRest{2};  // without work, after which freed memory is returned to the system

// Bounds of both boxes.
Box3 Join(Box3 a, const Box3& b) {
  if (!b.empty()) {
    a.Include(b.lower);
    a.Include(b.upper);
  }
  return a;
}

}  // namespace

struct SurfaceWorker::State {
  State(Bone bone, int threads, const Bone* before)
      : bounds_W(bone.CalcBounds()),
        drawn_bounds_W(before == nullptr ? bounds_W : Join(bounds_W, before->CalcBounds())),
        has_hu(bone.has_hu()),
        chunks(std::move(bone), before),
        origin_W(chunks.origin_W()),
        passes(MakePasses(chunks.bone().voxel_mm())),
        arena(threads > 0 ? threads : tbb::task_arena::automatic) {}

  // Progress of meshing all chunks at one step.
  struct Pass {
    int step;
    std::size_t next;  // index in `all`
  };
  // Cells of up to 0.85 mm show a bone well enough to begin with. Finer cells follow. Coarser ones up to 1.25 mm come
  // last: only a slow machine draws them, and only from a distance.
  static std::vector<Pass> MakePasses(double voxel_mm) {
    std::vector<Pass> first, last;
    for (const int step : BoneChunks::kSteps) {
      if (step * voxel_mm <= 0.85 || step == 1) {
        first.push_back({step, 0});
      } else if (step * voxel_mm <= 1.25) {
        last.push_back({step, 0});
      }
    }
    first.insert(first.end(), last.begin(), last.end());
    return first;
  }
  // Returns the pass to continue with; null if all passes are done.
  Pass* FindPass() {
    const auto at =
        std::find_if(passes.begin(), passes.end(), [&](const Pass& pass) { return pass.next < all.size(); });
    return at == passes.end() ? nullptr : &*at;
  }
  bool FirstDone() const { return passes.front().next == all.size(); }

  const Box3 bounds_W, drawn_bounds_W;
  const bool has_hu;

  // The bone and its chunks: changed by the worker, read by other threads.
  mutable std::shared_mutex bone_mutex;
  BoneChunks chunks;
  const Vec3 origin_W;

  // Protects everything below.
  mutable std::mutex mutex;
  std::condition_variable wake;
  mutable std::condition_variable idle;
  std::map<Index, LeafMessage> leaves;
  std::uint64_t offered = 0;  // leaves so far
  std::uint64_t meshed = 0;   // all leaves up to this number are in the finished chunks
  std::uint64_t due = 0;      // those that the next Fetch() must return
  struct Key {
    Index index;
    int step;
    bool operator<(const Key& other) const { return std::tie(index, step) < std::tie(other.index, other.step); }
  };
  std::map<Key, ChunkMesh> finished;
  std::deque<Key> order;
  std::map<int, SliceSpec> slice_jobs;
  std::map<int, SliceImage> slice_images;
  std::shared_ptr<const InnerSurfaces> inner;
  CtSource ct;
  std::optional<std::vector<PlaneOverlay>> plane_job;
  std::optional<std::vector<PlaneLineOverlay>> plane_lines;
  bool stop = false;
  bool working = true;
  SurfaceCounts counts;
  bool first_done = false;

  bool has_slice_job() const { return !slice_jobs.empty() || plane_job; }

  // Used only by the worker.
  int last_view = -1;
  std::uint64_t taken = 0;  // leaves so far that are in the bone
  std::vector<Index> all;
  std::vector<Pass> passes;
  tbb::task_arena arena;
  std::thread thread;

  void Hand(std::vector<ChunkMesh> meshes) {
    const std::lock_guard lock(mutex);
    for (ChunkMesh& mesh : meshes) {
      const Key key{mesh.index, mesh.step};
      const auto [at, is_new] = finished.insert_or_assign(key, std::move(mesh));
      if (is_new) order.push_back(key);
      ++counts.chunks;
    }
  }

  void MeshAll(const std::vector<Index>& which, int step) {
    std::vector<ChunkMesh> meshes(which.size());
    {
      const std::shared_lock lock(bone_mutex);
      if (which.size() == 1) {
        chunks.Mesh(which[0], step, meshes[0]);
      } else {
        arena.execute([&] {
          tbb::parallel_for(std::size_t{0}, which.size(),
                            [&](std::size_t i) { chunks.Mesh(which[i], step, meshes[i]); });
        });
      }
    }
    // Drops the meshes of chunks that have always been empty.
    meshes.erase(std::remove_if(meshes.begin(), meshes.end(),
                                [](const ChunkMesh& mesh) { return mesh.vertices.empty() && !mesh.cut; }),
                 meshes.end());
    Hand(std::move(meshes));
  }

  void TakeLeaves() {
    std::map<Index, LeafMessage> changed;
    {
      const std::lock_guard lock(mutex);
      changed.swap(leaves);
      taken = offered;
    }
    if (changed.empty()) return;
    const std::lock_guard lock(bone_mutex);
    for (const auto& [index, leaf] : changed) chunks.Take(leaf);
  }

  // Computes one requested slice, or the planes' lines. Returns false if none is requested.
  bool MakeSlice() {
    std::optional<std::pair<int, SliceSpec>> wanted;
    std::optional<std::vector<PlaneOverlay>> planes;
    std::shared_ptr<const InnerSurfaces> surfaces;
    CtSource whole_ct;
    {
      const std::lock_guard lock(mutex);
      surfaces = inner;
      whole_ct = ct;
      if (!slice_jobs.empty()) {
        // The view after the one that was served last, so that no view waits for ever.
        auto at = slice_jobs.upper_bound(last_view);
        if (at == slice_jobs.end()) at = slice_jobs.begin();
        wanted = *at;
        last_view = at->first;
        slice_jobs.erase(at);
      }
      std::swap(planes, plane_job);
    }
    if (planes) {
      std::vector<PlaneLineOverlay> lines;
      {
        const std::shared_lock lock(bone_mutex);
        const double step_mm = std::max(0.2, chunks.bone().voxel_mm());
        for (const PlaneOverlay& plane : *planes) {
          arena.execute([&] {
            lines.push_back({CalcSectionLines(chunks.bone(), plane, step_mm), plane.colour, plane.selected});
          });
        }
      }
      const std::lock_guard lock(mutex);
      plane_lines = std::move(lines);
    }
    if (wanted) {
      SliceImage made;
      {
        const std::shared_lock lock(bone_mutex);
        arena.execute(
            [&] { made = CalcSlice(chunks.bone(), wanted->second, surfaces.get(), whole_ct ? &whole_ct : nullptr); });
      }
      const std::lock_guard lock(mutex);
      slice_images.insert_or_assign(wanted->first, std::move(made));
    }
    return planes.has_value() || wanted.has_value();
  }

  // Returns false if no chunk was dirty.
  bool MeshDirty() {
    const std::vector<Index> dirty = chunks.TakeDirty(chunks.CountDirty());
    if (!dirty.empty()) {
      MeshAll(dirty, 1);
      MeshAll(dirty, 2);  // for views from a distance
    }
    const std::lock_guard lock(mutex);
    meshed = taken;
    idle.notify_all();
    return !dirty.empty();
  }

  // Does one unit of work. Returns false if there is none.
  bool Step() {
    constexpr std::size_t kBatch = 64;
    TakeLeaves();
    {
      const std::lock_guard lock(mutex);
      counts.dirty = chunks.CountDirty();
    }
    if (FirstDone()) {
      // Cut chunks have priority once there is a first picture.
      const bool remeshed = MeshDirty();
      const bool sliced = MakeSlice();
      if (remeshed || sliced) return true;
    }
    Pass* pass = FindPass();
    if (pass == nullptr) return false;
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(pass->next);
    pass->next = std::min(all.size(), pass->next + kBatch);
    MeshAll({begin, all.begin() + static_cast<std::ptrdiff_t>(pass->next)}, pass->step);
    const std::lock_guard lock(mutex);
    if (FirstDone() && !first_done) {
      first_done = true;
      idle.notify_all();
    }
    counts.first_left = 0;
    for (const Pass& p : passes) counts.first_left += all.size() - p.next;
    return true;
  }

  void Run() {
    all = chunks.ListChunks(bounds_W.empty() ? Vec3{0} : bounds_W.centre());
    {
      const std::lock_guard lock(mutex);
      if (all.empty()) first_done = true;
      idle.notify_all();
    }
    for (;;) {
      const bool worked = Step();
      std::unique_lock lock(mutex);
      if (stop) return;
      if (worked) continue;
      const auto has_work = [&] { return stop || !leaves.empty() || has_slice_job() || FindPass() != nullptr; };
      if (has_work()) continue;
      working = false;
      idle.notify_all();
      if (!wake.wait_for(lock, kRest, has_work)) {
        lock.unlock();
        malloc_trim(0);  // what meshes, undo and reading a bone have freed, malloc would keep
        lock.lock();
        wake.wait(lock, has_work);
      }
      working = true;
      if (stop) return;
    }
  }
};

SurfaceWorker::SurfaceWorker(Bone bone, int threads, const Bone* before)
    : state_(std::make_unique<State>(std::move(bone), threads, before)) {
  state_->thread = std::thread([this] { state_->Run(); });
}

SurfaceWorker::~SurfaceWorker() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->wake.notify_all();
  state_->thread.join();
}

Vec3 SurfaceWorker::origin_W() const {
  return state_->origin_W;
}

Box3 SurfaceWorker::bounds_W() const {
  return state_->bounds_W;
}

Box3 SurfaceWorker::drawn_bounds_W() const {
  return state_->drawn_bounds_W;
}

bool SurfaceWorker::has_hu() const {
  return state_->has_hu;
}

void SurfaceWorker::Offer(const LeafMessage& leaf) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->leaves.insert_or_assign(leaf.index, leaf);
    ++state_->offered;
  }
  state_->wake.notify_one();
}

std::vector<ChunkMesh> SurfaceWorker::Fetch(std::size_t at_most, std::chrono::milliseconds longest_wait) {
  std::vector<ChunkMesh> meshes;
  std::unique_lock lock(state_->mutex);
  if (state_->first_done) {
    state_->idle.wait_for(lock, longest_wait, [&] { return state_->meshed >= state_->due; });
    state_->due = state_->offered;
  }
  while (!state_->order.empty() && meshes.size() < at_most) {
    const auto at = state_->finished.find(state_->order.front());
    meshes.push_back(std::move(at->second));
    state_->finished.erase(at);
    state_->order.pop_front();
  }
  return meshes;
}

SurfaceCounts SurfaceWorker::counts() const {
  const std::lock_guard lock(state_->mutex);
  SurfaceCounts counts = state_->counts;
  counts.leaves_waiting = state_->leaves.size();
  return counts;
}

bool SurfaceWorker::first_done() const {
  const std::lock_guard lock(state_->mutex);
  return state_->first_done;
}

void SurfaceWorker::WaitIdle() {
  std::unique_lock lock(state_->mutex);
  state_->idle.wait(lock, [&] { return !state_->working && state_->leaves.empty() && !state_->has_slice_job(); });
}

void SurfaceWorker::WaitFirst() {
  std::unique_lock lock(state_->mutex);
  state_->idle.wait(lock, [&] { return state_->first_done; });
}

void SurfaceWorker::SetInnerSurfaces(std::shared_ptr<const InnerSurfaces> inner) {
  const std::lock_guard lock(state_->mutex);
  state_->inner = std::move(inner);
}

void SurfaceWorker::SetCt(CtSource ct) {
  const std::lock_guard lock(state_->mutex);
  state_->ct = std::move(ct);
}

void SurfaceWorker::RequestSlice(int view, const SliceSpec& spec) {
  CalcSliceFrame(spec);  // checks the spec in the caller's thread
  {
    const std::lock_guard lock(state_->mutex);
    state_->slice_jobs.insert_or_assign(view, spec);
  }
  state_->wake.notify_one();
}

std::map<int, SliceImage> SurfaceWorker::FetchSliceImages() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->slice_images, {});
}

void SurfaceWorker::RequestPlaneLines(std::vector<PlaneOverlay> planes) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->plane_job = std::move(planes);
  }
  state_->wake.notify_one();
}

std::optional<std::vector<PlaneLineOverlay>> SurfaceWorker::FetchPlaneLines() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->plane_lines, std::nullopt);
}

std::optional<Vec3> SurfaceWorker::Pick(const Ray& ray) const {
  const std::shared_lock lock(state_->bone_mutex);
  Vec3 p_W{0};
  if (!FindSurface(state_->chunks.bone(), ray.origin_W, ray.direction_W, p_W)) return std::nullopt;
  return p_W;
}

Bone SurfaceWorker::CopyBone() const {
  const std::shared_lock lock(state_->bone_mutex);
  return CopySharing(state_->chunks.bone());
}

}  // namespace kerf
