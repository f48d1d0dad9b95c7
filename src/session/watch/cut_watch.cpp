#include "session/watch/cut_watch.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "bone/grid/piece_finder.h"
#include "bone/grid/removed.h"
#include "bone/grid/set_leaf.h"
#include "kerf/surface.h"
#include "session/marks/injury_finder.h"

namespace kerf {
namespace {

using WatchClock = std::chrono::steady_clock;
using LeafIndex = std::array<int, 3>;
using LeafValues = std::array<float, 512>;

double SecondsSince(WatchClock::time_point start) {
  return std::chrono::duration<double>(WatchClock::now() - start).count();
}

/// Returns the volume of the piece among `split` that has the same voxels; the sum of its voxels if there is none.
double CalcExactVolume(const FoundPiece& piece, const PieceFinder& finder, const Pieces& split, double voxel_mm) {
  std::optional<Vec3> inside_W;  // the centre of one of its voxels
  finder.ForEachLeaf(piece.id, [&](const LeafIndex& leaf, const LeafMask& voxels) {
    for (std::size_t x = 0; x < voxels.size() && !inside_W; ++x) {
      if (voxels[x] == 0) continue;
      const int bit = std::countr_zero(voxels[x]);
      inside_W = voxel_mm * Vec3(8 * leaf[0] + static_cast<int>(x), 8 * leaf[1] + bit / 8, 8 * leaf[2] + bit % 8);
    }
  });
  if (!inside_W) return piece.volume_mm3;
  const auto same = std::find_if(split.pieces.begin(), split.pieces.end(),
                                 [&](const Bone& part) { return part.SignedDistance(*inside_W) < 0; });
  return same == split.pieces.end() ? piece.volume_mm3 : same->CalcVolume();
}

}  // namespace

struct CutWatch::State {
  State(std::shared_ptr<const Bone> bone_before, Bone bone_now, const CutWatchOptions& watch_options)
      : options(watch_options), before(std::move(bone_before)), now(std::move(bone_now)) {}

  const CutWatchOptions options;
  const std::shared_ptr<const Bone> before;

  mutable std::mutex mutex;  // protects everything below up to `thread`
  std::condition_variable wake;
  std::condition_variable idle;
  std::map<LeafIndex, LeafValues> leaves;
  std::vector<PlannedPlane> planes;
  std::vector<Mark> marks;
  std::function<std::vector<double>(const Bone&, const Bone&)> measure;
  std::function<bool(const Vec3&)> is_wanted;
  bool plan_changed = false;  // the planes, the marks or the measure
  bool hurry = false;         // a caller waits for the analysis
  bool stop = false;
  bool working = true;
  std::optional<PlanesReport> report;
  std::vector<FreedPiece> freed;
  Costs costs;
  std::thread thread;

  // Used only by the thread.
  Bone now;

  void Analyse(PieceFinder& finder, InjuryFinder& injury_finder, const std::map<LeafIndex, LeafValues>& changed,
               const std::vector<PlannedPlane>& wanted, const std::vector<Mark>& marked,
               const std::function<std::vector<double>(const Bone&, const Bone&)>& measured,
               const std::function<bool(const Vec3&)>& wants) {
    const auto start = WatchClock::now();
    std::vector<LeafIndex> indices;
    for (const auto& [index, values] : changed) {
      SetCut(now, index, values);
      LeafValues phi;
      GetLeaf(now, index, phi);
      finder.Change(index, phi);
      indices.push_back(index);
    }
    injury_finder.Change(now, indices);
    injury_finder.SetMarks(marked);
    std::vector<FreedPiece> separated;
    const FoundPieces& found = finder.Find();
    // A piece comes free rarely, so it may be split off for its exact volume.
    const Pieces split = found.came_off.empty() ? Pieces{} : SplitPieces(now, options.min_piece_mm3);
    for (const FoundPiece& piece : found.came_off) {
      separated.push_back({.id = piece.id,
                           .volume_mm3 = CalcExactVolume(piece, finder, split, now.voxel_mm()),
                           .bounds_W = piece.bounds_W,
                           .main_region = finder.FindMainRegion(piece.id)});
    }
    PlanesReport next;
    next.piece_count = found.pieces.size();
    for (const PlannedPlane& plane : wanted) {
      next.planes.push_back({.name = plane.name, .state = CalcCutState(*before, now, plane)});
    }
    next.injuries = injury_finder.Find(now);
    if (wants) {
      next.injuries = injury_finder.FindAt(wants);
      next.beside = injury_finder.FindAt([&](const Vec3& p_W) { return !wants(p_W); });
      // Whether this part of the cut alone goes through a structure is not known.
      for (StructureResult& structure : next.beside) structure.is_severed = false;
    }
    if (measured) next.measured = measured(*before, now);
    const std::lock_guard lock(mutex);
    report = std::move(next);
    freed.insert(freed.end(), separated.begin(), separated.end());
    costs.last_s = SecondsSince(start);
    costs.largest_s = std::max(costs.largest_s, costs.last_s);
    ++costs.analyses;
  }

  void Run() {
    const auto start = WatchClock::now();
    PieceFinder finder(now, options.min_piece_mm3);
    InjuryFinder injury_finder(before);
    injury_finder.Change(now, FindChangedLeaves(*before, now));
    std::unique_lock lock(mutex);
    costs.start_s = SecondsSince(start);
    const auto period = std::chrono::duration<double>(options.period_s);
    while (true) {
      wake.wait(lock, [&] { return stop || !leaves.empty() || plan_changed; });
      if (stop) return;
      std::map<LeafIndex, LeafValues> changed;
      changed.swap(leaves);
      plan_changed = false;
      const std::vector<PlannedPlane> wanted = planes;
      const std::vector<Mark> marked = marks;
      const auto measured = measure;
      const auto wants = is_wanted;
      lock.unlock();
      Analyse(finder, injury_finder, changed, wanted, marked, measured, wants);
      lock.lock();
      if (leaves.empty() && !plan_changed) {
        working = false;
        hurry = false;
        idle.notify_all();
      }
      wake.wait_for(lock, period, [&] { return stop || hurry; });
    }
  }
};

CutWatch::CutWatch(std::shared_ptr<const Bone> before, Bone now, const CutWatchOptions& options)
    : state_(std::make_unique<State>(std::move(before), std::move(now), options)) {
  state_->plan_changed = true;  // a first report, with the number of pieces
  state_->thread = std::thread([state = state_.get()] { state->Run(); });
}

CutWatch::~CutWatch() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->wake.notify_all();
  state_->thread.join();
}

void CutWatch::Offer(const std::array<int, 3>& index, std::span<const float, 512> values) {
  {
    const std::lock_guard lock(state_->mutex);
    std::copy(values.begin(), values.end(), state_->leaves[index].begin());
    state_->working = true;
  }
  state_->wake.notify_one();
}

void CutWatch::SetPlanes(std::vector<PlannedPlane> planes) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->planes = std::move(planes);
    state_->plan_changed = true;
    state_->working = true;
  }
  state_->wake.notify_one();
}

void CutWatch::SetMeasure(std::function<std::vector<double>(const Bone& before, const Bone& now)> measure) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->measure = std::move(measure);
    state_->plan_changed = true;
    state_->working = true;
  }
  state_->wake.notify_one();
}

void CutWatch::SetWanted(std::function<bool(const Vec3& p_W)> is_wanted) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->is_wanted = std::move(is_wanted);
    state_->plan_changed = true;
    state_->working = true;
  }
  state_->wake.notify_one();
}

void CutWatch::SetMarks(std::vector<Mark> marks) {
  {
    const std::lock_guard lock(state_->mutex);
    if (state_->marks == marks) return;
    state_->marks = std::move(marks);
    state_->plan_changed = true;
    state_->working = true;
  }
  state_->wake.notify_one();
}

std::optional<PlanesReport> CutWatch::Fetch() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->report, std::nullopt);
}

std::vector<FreedPiece> CutWatch::TakeFreed() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->freed, {});
}

void CutWatch::WaitIdle() {
  std::unique_lock lock(state_->mutex);
  state_->hurry = true;
  state_->wake.notify_all();
  state_->idle.wait(lock, [&] { return !state_->working; });
  state_->hurry = false;
}

CutWatch::Costs CutWatch::costs() const {
  const std::lock_guard lock(state_->mutex);
  return state_->costs;
}

}  // namespace kerf
