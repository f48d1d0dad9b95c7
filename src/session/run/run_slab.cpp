#include "session/run/run_slab.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

#include "base/core/hash.h"
#include "kerf/error.h"

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

class SlabPathBody final : public PathBody {
 public:
  SlabPathBody(SlabProfile profile, const SlabParams& params, const Pose& X_WT_start, SlabBody hold, std::size_t ticks)
      : simulation_(std::move(profile), params, X_WT_start) {
    simulation_.Hold(hold);
    states_.reserve(ticks);
  }

  void SetDown(const Pose& X_WT, double) override { simulation_.SetDown(X_WT); }
  TickOutput Tick(const TickInput& in) override { return simulation_.Tick(in); }
  /// There are no voxels; the hash of the bodies' state takes their place.
  std::uint64_t TakeHash() override {
    const SlabState& state = simulation_.state();
    std::uint64_t hash = 0;
    for (const double x : {state.blade_mm, state.left_mm, state.right_mm, state.deepest_mm, state.hand_work_mJ}) {
      hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(x));
    }
    return hash;
  }
  void End(TickRecord& record, double, double) override {
    states_.push_back(simulation_.state());
    record.touched = states_.back().depth_mm > 0;
    record.travel_mm = std::max(0.0, states_.back().depth_mm);
  }

  std::vector<SlabState> TakeStates() { return std::move(states_); }
  std::uint64_t CalcMemoryBytes() const { return simulation_.CalcMemoryBytes(); }

 private:
  SlabSimulation simulation_;
  std::vector<SlabState> states_;
};

/// Throws kerf::Error if a stroke begins past the slice.
void CheckStrokes(const Path& path, const SlabProfile& profile, const SlabParams& params) {
  for (std::size_t i = 1; i < path.segments().size(); ++i) {
    const Vec3 p_W = path.CalcPose(i, path.segments()[i].start_s).p_AB;
    const double depth_mm = CalcBladeDepth(profile, params, p_W);
    if (path.segments()[i].retract_before && depth_mm >= profile.end_mm) {
      throw Error(fmt::format("stroke {} sets the blade down {:.2f} mm deep, past the slice, which ends at {:.2f} mm",
                              i + 1, depth_mm, profile.end_mm));
    }
  }
}

}  // namespace

SlabRun RunSlab(const Scene& scene, SlabProfile profile, const std::function<void(double)>& progress,
                const PathTape& tape) {
  const Path path = MakePath(scene);
  const SlabParams params = MakeSlabParams(scene);
  CheckStrokes(path, profile, params);
  const std::size_t ticks = path.CountTicks(scene.simulation.rate_hz);
  SlabRun run;
  run.profile = profile;
  SlabPathBody body(std::move(profile), params, path.CalcPose(0, 0), scene.slab.hold, ticks);
  PathDriver driver(path, scene.simulation.rate_hz);
  driver.Next();  // the simulation starts with the blade placed
  PathSession session(driver, body, scene.tool.CalcTickRpm(), ticks, tape);
  session.Run(progress);
  run.wall_s = session.CalcElapsed_s();
  run.times = session.CalcTimes();
  run.ticks = session.TakeTicks();
  run.states = body.TakeStates();
  run.memory_bytes = body.CalcMemoryBytes();
  return run;
}

const Columns<SlabRow>& SlabColumns() {
  const auto state = [](auto SlabState::*value) {
    return [value](const SlabRow& r) -> TableCell {
      // A truth value is written as 1 or 0.
      if constexpr (std::is_same_v<decltype(value), bool SlabState::*>)
        return r.state.*value ? 1 : 0;
      else
        return r.state.*value;
    };
  };
  const char* const kDepth = "depth of the blade's edge below the first bone; its maximum so far";
  const char* const kMoved = "displacements along the direction since the start";
  const char* const kState = "1 if the slice sticks; 1 if it has left the jaw; otherwise 0";
  const char* const kEnergy = "energies since the start; [slab.md](slab.md) describes their balance";
  static const Columns<SlabRow> kColumns{{"time_s", "{:.6f}", "time", &SlabRow::time_s},
                                         {"depth_mm", "{:.6f}", kDepth, state(&SlabState::depth_mm)},
                                         {"deepest_mm", "{:.6f}", kDepth, state(&SlabState::deepest_mm)},
                                         {"blade_mm", "{:.6f}", kMoved, state(&SlabState::blade_mm)},
                                         {"left_mm", "{:.6f}", kMoved, state(&SlabState::left_mm)},
                                         {"right_mm", "{:.6f}", kMoved, state(&SlabState::right_mm)},
                                         {"sticking", "{}", kState, state(&SlabState::sticking)},
                                         {"free", "{}", kState, state(&SlabState::free)},
                                         {"kinetic_mJ", "{:.6g}", kEnergy, state(&SlabState::kinetic_mJ)},
                                         {"elastic_mJ", "{:.6g}", kEnergy, state(&SlabState::elastic_mJ)},
                                         {"hand_work_mJ", "{:.6g}", kEnergy, state(&SlabState::hand_work_mJ)},
                                         {"friction_mJ", "{:.6g}", kEnergy, state(&SlabState::friction_mJ)},
                                         {"cutting_mJ", "{:.6g}", kEnergy, state(&SlabState::cutting_mJ)},
                                         {"damping_mJ", "{:.6g}", kEnergy, state(&SlabState::damping_mJ)},
                                         {"released_mJ", "{:.6g}", kEnergy, state(&SlabState::released_mJ)},
                                         {"numerical_mJ", "{:.6g}", kEnergy, state(&SlabState::numerical_mJ)}};
  return kColumns;
}

std::string FormatSlabLog(const SlabRun& run, int every) {
  std::vector<SlabRow> rows;
  const auto step = static_cast<std::size_t>(std::max(every, 1));
  for (std::size_t i = 0; i < run.states.size(); ++i) {
    if ((i + 1) % step == 0 || i + 1 == run.states.size()) rows.push_back({run.ticks[i].time_s, run.states[i]});
  }
  return FormatCsv(SlabColumns(), rows);
}

}  // namespace kerf
