#include "experiment/uncertainty/uncertain.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <thread>
#include <utility>

#include "base/core/hash.h"
#include "base/core/sha256.h"
#include "base/files/memory.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/run_scene.h"
#include "session/run/work_list.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxRows = 2000;
constexpr double kBytesPerTickOfRun = 600;

/// The end of each row, as the number of the tick after its last.
std::vector<std::size_t> SplitRows(const std::vector<TickRecord>& ticks, std::size_t row_ticks) {
  std::vector<std::size_t> ends;
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= ticks.size(); ++i) {
    if (i < ticks.size() && i - begin < row_ticks && ticks[i].segment == ticks[begin].segment) continue;
    ends.push_back(i);
    begin = i;
  }
  return ends;
}

BandRows MakeRows(const std::vector<TickRecord>& ticks, const std::vector<std::size_t>& ends) {
  BandRows rows;
  for (const std::size_t end : ends) {
    const TickRecord& last = ticks[end - 1];
    rows.time_s.push_back(last.time_s);
    rows.segment.push_back(last.segment);
    rows.travel_mm.push_back(last.travel_mm);
  }
  return rows;
}

/// What all samples share.
struct Shared {
  const Scene& scene;
  const Bone& bone;
  const Path& path;
};

struct SampleRun {
  UncertainSample sample;
  std::vector<TickRecord> ticks;
};

SampleRun RunSample(const Shared& shared, const Drawing& drawing, int number, std::vector<double> fractions,
                    const std::function<void(double)>& progress) {
  Scene scene = shared.scene;
  Bone bone = shared.bone;
  if (!fractions.empty()) {
    scene.force = ApplyToLaw(drawing, fractions, scene.force);
    bone.OverrideMaterials(ApplyToMaterials(drawing, fractions, bone.materials()));
  }
  const double rate_hz = scene.simulation.rate_hz;
  RunResult result =
      RunPath(std::move(bone), MakeSimulationParams(scene), shared.path, rate_hz, scene.tool.CalcTickRpm(), progress);
  const ForceSummary force = SummarizeForces(result.ticks, rate_hz);
  SampleRun run;
  run.sample.number = number;
  run.sample.fractions = std::move(fractions);
  run.sample.peak_N = force.peak_N;
  run.sample.mean_N = force.mean_N;
  run.sample.work_mJ = force.work_Nmm;
  run.sample.cutting_J = CalcRunEnergy(scene, shared.path, result, force).work_J;
  run.ticks = std::move(result.ticks);
  return run;
}

void FillRows(const std::vector<TickRecord>& ticks, const std::vector<std::size_t>& ends, UncertainSample& sample) {
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    double force_N = 0;
    double thrust_N = 0;
    for (const TickRecord& t : std::span(ticks).subspan(begin, end - begin)) {
      force_N += glm::length(t.out.f_T_W_N);
      thrust_N += t.out.thrust_sum_N;
    }
    const auto count = static_cast<double>(end - begin);
    sample.force_N.push_back(force_N / count);
    sample.thrust_N.push_back(thrust_N / count);
    begin = end;
  }
}

void CheckUncertainScene(const Scene& scene) {
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error(fmt::format("{}: --uncertain works in voxel mode only, and the scene has [simulation] mode = \"slab\"",
                            scene.name));
  }
}

void CheckAnythingDrawn(const Scene& scene, const Drawing& drawing) {
  if (!drawing.drawn.empty()) return;
  std::string why;
  for (const FixedQuantity& q : drawing.fixed) why += fmt::format("; {}: {}", q.name, q.why);
  throw Error(
      fmt::format("{}: nothing to draw: no parameter of the law {} and no region of this bone has an interval{}",
                  scene.name, scene.force.name(), why));
}

int CountThreads(int jobs, std::size_t samples) {
  const int threads = jobs > 0 ? jobs : static_cast<int>(std::max(std::thread::hardware_concurrency(), 1U));
  return std::min(threads, static_cast<int>(std::max<std::size_t>(samples, 1)));
}

/// Throws kerf::Error if the runs would need more memory than there is.
void CheckRunsMemory(const Shared& shared, std::size_t ticks, std::size_t rows, std::size_t samples, int threads) {
  const double run =
      2 * static_cast<double>(shared.bone.CalcMemoryBytes()) + kBytesPerTickOfRun * static_cast<double>(ticks);
  const double kept = 2 * sizeof(double) * static_cast<double>(rows) * static_cast<double>(samples);
  CheckMemory(threads * run + kept, fmt::format("{} runs at once", threads), "compute fewer at once with --jobs");
}

}  // namespace

std::string HashScene(const Scene& scene) {
  const std::string text = ResolvedToml(scene);
  return CalcSha256({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

UncertainRun RunUncertain(const Scene& scene, const UncertainParams& params, const std::optional<Shard>& shard,
                          const std::function<void(const std::string& stage, double fraction)>& progress) {
  const auto stage = [&](const char* name) {
    return [&progress, name](double fraction) {
      if (progress) progress(name, fraction);
    };
  };
  CheckUncertainScene(scene);
  const Path path = MakePath(scene);
  CheckRunTicks(path, scene.simulation.rate_hz);
  MaterialSummary material;
  const Bone bone = MakeSceneBone(scene, stage("making the bone"), &material);
  UncertainRun run;
  UncertainHead& head = run.head;
  head.drawing = FindDrawing(scene, bone, material.ct_regions, params.fit);
  CheckAnythingDrawn(scene, head.drawing);
  head.scene = scene.name;
  head.title = scene.title;
  head.law = scene.force.name();
  head.scene_sha256 = HashScene(scene);
  head.bone_hash = bone.CalcHash() ^ MixHash(bone.CalcMaterialHash());
  head.samples = params.samples;
  head.seed = params.seed;
  head.rate_hz = scene.simulation.rate_hz;

  const Shared shared{scene, bone, path};
  SampleRun nominal = RunSample(shared, head.drawing, -1, {}, stage("the nominal run"));
  const std::size_t ticks = nominal.ticks.size();
  const auto row_ticks = std::max<std::size_t>(static_cast<std::size_t>(std::max(scene.output.forces_every_ticks, 1)),
                                               (ticks + kMaxRows - 1) / kMaxRows);
  const std::vector<std::size_t> ends = SplitRows(nominal.ticks, row_ticks);
  head.row_ticks = static_cast<int>(row_ticks);
  head.rows = MakeRows(nominal.ticks, ends);
  FillRows(nominal.ticks, ends, nominal.sample);
  head.nominal = std::move(nominal.sample);

  const Shard part = shard.value_or(Shard{});
  for (int i = part.index; i < params.samples; i += part.count) run.samples.emplace_back().number = i;
  const int threads = CountThreads(params.jobs, run.samples.size());
  CheckRunsMemory(shared, ticks, ends.size(), run.samples.size(), threads);
  WorkList list;
  for (UncertainSample& sample : run.samples) {
    list.Add("the drawn runs", 1, [&] {
      SampleRun one = RunSample(shared, head.drawing, sample.number,
                                DrawFractions(head.drawing, params.seed, sample.number), nullptr);
      FillRows(one.ticks, ends, one.sample);
      sample = std::move(one.sample);
    });
  }
  if (!run.samples.empty()) list.Run(threads, nullptr, progress);
  return run;
}

}  // namespace kerf
