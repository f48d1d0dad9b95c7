#include "session/run/run_slab.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <iterator>
#include <limits>

#include "base/core/hash.h"
#include "kerf/error.h"
#include "session/run/tick_interceptor.h"

namespace kerf {

SlabProfile MakeSlabProfile(const Scene& scene, const Bone& bone) {
  const CutPlane plane = MakeSlabPlane(scene);
  const SlabParams params = MakeSlabParams(scene);
  SlabProfile profile =
      MakeBoneProfile(bone, plane, params.saw.thickness_mm, params.direction_W, params.saw.radius_mm());
  if (scene.slab.depth_by == SlabDepth::kPaperTable2) {
    const double slice_mm3 = profile.slice_mm3;
    profile = MakePaperProfile(bone.materials(), profile.entry_mm);
    profile.slice_mm3 = slice_mm3;
  }
  return profile;
}

double CalcBladeDepth(const SlabProfile& profile, const SlabParams& params, const Vec3& p_W) {
  return glm::dot(p_W, params.direction_W) + params.saw.radius_mm() - profile.entry_mm;
}

namespace {

std::uint64_t HashOf(const SlabState& state) {
  std::uint64_t hash = 0;
  for (const double x : {state.blade_mm, state.left_mm, state.right_mm, state.deepest_mm, state.hand_work_mJ}) {
    hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(x));
  }
  return hash;
}

}  // namespace

SlabRun RunSlab(const Scene& scene, SlabProfile profile, const std::function<void(double)>& progress,
                TickInterceptor* tap) {
  using Clock = std::chrono::steady_clock;
  const Path path = MakePath(scene);
  const double rate_hz = scene.simulation.rate_hz;
  SlabRun run;
  run.profile = profile;
  const std::size_t total = path.CountTicks(rate_hz);
  run.ticks.reserve(total);
  run.states.reserve(total);
  std::vector<double> times_us;
  times_us.reserve(total);

  const SlabParams params = MakeSlabParams(scene);
  for (std::size_t i = 1; i < path.segments().size(); ++i) {
    const Vec3 p_W = path.CalcPose(i, path.segments()[i].start_s).p_AB;
    const double depth_mm = CalcBladeDepth(profile, params, p_W);
    if (path.segments()[i].retract_before && depth_mm >= profile.end_mm) {
      throw Error(fmt::format("stroke {} sets the blade down {:.2f} mm deep, past the slice, which ends at {:.2f} mm",
                              i + 1, depth_mm, profile.end_mm));
    }
  }
  SlabSimulation simulation(std::move(profile), params, path.CalcPose(0, 0));
  simulation.Hold(scene.slab.hold);
  const Clock::time_point start = Clock::now();
  bool keep_going = true;
  for (std::size_t segment = 0; segment < path.segments().size() && keep_going; ++segment) {
    const PathSegment& path_segment = path.segments()[segment];
    if (path_segment.retract_before && segment > 0) {
      Pose X_down = path.CalcPose(segment, path_segment.start_s);
      keep_going = tap == nullptr || tap->SetDown(X_down);
      if (!keep_going) break;
      simulation.SetDown(X_down);
    }
    double time_s = path_segment.start_s;
    const std::size_t count = path.CountTicks(segment, rate_hz);
    for (std::size_t k = 1; k <= count; ++k) {
      const double end_s = std::min(path_segment.start_s + static_cast<double>(k) / rate_hz, path_segment.end_s);
      TickInput in{path.CalcPose(segment, end_s), end_s - time_s, scene.tool.rpm};
      keep_going = tap == nullptr || tap->Begin(in);
      if (!keep_going) break;
      TickRecord record;
      record.X_WT = in.X_WT;
      const Clock::time_point before = Clock::now();
      record.out = simulation.Tick(in);
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - before).count());
      const SlabState& state = simulation.state();
      // There are no voxels; the hash of the bodies' state takes their place.
      if (tap != nullptr) tap->End(in, record.out, HashOf(state));
      record.time_s = time_s = end_s;
      record.segment = segment;
      record.touched = state.depth_mm > 0;
      record.travel_mm = std::max(0.0, state.depth_mm);
      run.ticks.push_back(record);
      run.states.push_back(state);
      if (progress && k % 4096 == 0) progress(static_cast<double>(run.ticks.size()) / static_cast<double>(total));
    }
  }
  run.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  run.times = CalcPercentiles(times_us);
  run.memory_bytes = simulation.CalcMemoryBytes();
  return run;
}

std::string FormatSlabLog(const SlabRun& run, int every) {
  std::string csv =
      "time_s,depth_mm,deepest_mm,blade_mm,left_mm,right_mm,sticking,free,kinetic_mJ,elastic_mJ,hand_work_mJ,"
      "friction_mJ,cutting_mJ,damping_mJ,released_mJ,numerical_mJ\n";
  const auto step = static_cast<std::size_t>(std::max(every, 1));
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    if ((i + 1) % step != 0 && i + 1 != run.states.size()) continue;
    const SlabState& s = run.states[i];
    fmt::format_to(std::back_inserter(csv),
                   "{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},"
                   "{:.6g}\n",
                   run.ticks[i].time_s, s.depth_mm, s.deepest_mm, s.blade_mm, s.left_mm, s.right_mm, s.sticking ? 1 : 0,
                   s.free ? 1 : 0, s.kinetic_mJ, s.elastic_mJ, s.hand_work_mJ, s.friction_mJ, s.cutting_mJ,
                   s.damping_mJ, s.released_mJ, s.numerical_mJ);
  }
  return csv;
}

}  // namespace kerf
