#include "experiment/bench/tick_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/core/nearest_name.h"
#include "experiment/bench/cut_cases.h"
#include "experiment/bench/other_cases.h"
#include "kerf/error.h"

namespace kerf {
namespace {

struct Entry {
  std::string name;
  std::function<BenchResult(const BenchOptions&)> run;
};

BenchTarget AtMost(const char* what, double limit, const char* unit, double measured) {
  return {what, unit, limit, measured, false};
}
BenchTarget AtLeast(const char* what, double limit, const char* unit, double measured) {
  return {what, unit, limit, measured, true};
}

/// Makes the entry of a cut. The limits are those of the median and of the 99th percentile, us, and of the ratio of the
/// baseline's median to the cut's; 0 means no limit.
Entry Cut(const CutCase& cut, double p50_us, double p99_us, double times_faster) {
  return {cut.name, [=](const BenchOptions& options) {
            BenchResult r = RunCut(cut, options);
            if (p50_us > 0) r.targets.push_back(AtMost("p50", p50_us, "us", r.times.p50_us));
            if (p99_us > 0) r.targets.push_back(AtMost("p99", p99_us, "us", r.times.p99_us));
            if (times_faster > 0)
              r.targets.push_back(AtLeast("speedup over the baseline", times_faster, "", r.TimesFaster()));
            return r;
          }};
}

/// Does the same as Cut(). In addition, the volume that the ball removes must equal its sweep to within one layer of
/// voxels along that part of the ball's outline that is in the bone.
Entry BallCut(double voxel_mm, double feed_mm_per_s, bool whole, double p50_us, double p99_us) {
  const Entry cut = Cut(MakeBallCut(voxel_mm, feed_mm_per_s, whole), p50_us, p99_us, 0);
  return {cut.name, [=](const BenchOptions& options) {
            BenchResult r = cut.run(options);
            const double half_angle = std::acos(1.0 / 3);
            const double outline_mm = 2 * 3 * half_angle;
            const double section_mm2 = 9 * half_angle - std::sqrt(8.0);
            const double off = std::abs(r.Find("removed minus swept")->value);
            r.targets.push_back(AtMost("removed volume differs from swept volume by",
                                       100 * outline_mm * voxel_mm / section_mm2, "%", off));
            return r;
          }};
}

const std::vector<Entry>& Entries() {
  static const std::vector<Entry> entries = {
      Cut(MakeDiscCut(0.1), 50, 100, 100),
      Cut(MakeEffectsCut(), 0, 0, 0),
      Cut(MakeHandCut(), 50, 100, 0),
      Cut(MakeBuriedCut(), 0, 0, 0),
      Cut(MakeDiscCut(0.2), 0, 60, 0),
      Cut(MakeDiscCut(0.05), 0, 250, 0),
      BallCut(0.2, 10, true, 50, 150),
      BallCut(0.2, 5, true, 50, 150),
      BallCut(0.2, 1, true, 50, 150),
      BallCut(0.1, 10, false, 0, 500),
      BallCut(0.3, 10, false, 0, 0),
      Cut(MakeThickDiscCut(), 0, 300, 0),
      Cut(MakeBurCut(0.1), 0, 0, 50),
      Cut(MakeDrillCut(0.1), 0, 0, 50),
      Cut(MakeSawnCut(ReciprocatingBlade{}, 15000, 12, 0.1), 0, 0, 50),
      Cut(MakeSawnCut(OscillatingBlade{}, 15000, 6, 0.1), 0, 0, 50),
      Cut(MakeSawnCut(PiezoInsert{}, 1.7e6, 3, 0.1), 0, 0, 50),
      // These cuts are created only when they run, so that merely listing the names, e.g. for the help, does not take a
      // tenth of a second.
      {"mandible-block", [](const BenchOptions& options) { return RunCut(MakeMandibleCut(false), options); }},
      {"mandible", [](const BenchOptions& options) { return RunCut(MakeMandibleCut(true), options); }},
      {"idle",
       [](const BenchOptions& options) {
         BenchResult r = RunIdle(options);
         r.targets.push_back(AtMost("p99", 2, "us", r.times.p99_us));
         return r;
       }},
      {"memory", RunMemory},
  };
  return entries;
}

BenchResult* Find(std::vector<BenchResult>& results, const std::string& name) {
  const auto found = std::find_if(results.begin(), results.end(), [&](const BenchResult& r) { return r.name == name; });
  return found == results.end() ? nullptr : &*found;
}

/// If both mandible cases ran, adds the requirement that the size of the bone has no effect on the time.
void CompareMandibles(std::vector<BenchResult>& results) {
  const BenchResult* block = Find(results, "mandible-block");
  BenchResult* whole = Find(results, "mandible");
  if (!block || !whole) return;
  const double ratio = whole->times.p50_us / block->times.p50_us;
  whole->targets.push_back(
      AtMost("ratio of p50 to the p50 of the block, or its inverse", 1.2, "", std::max(ratio, 1 / ratio)));
}

/// If the disc ran with and without all effects, adds the limit of what they cost.
void CompareEffects(std::vector<BenchResult>& results) {
  const BenchResult* without = Find(results, "disc-0.1");
  BenchResult* with = Find(results, "disc-0.1-effects");
  if (!without || !with) return;
  with->targets.push_back(
      AtMost("ratio of p50 to the p50 without effects", 1.3, "", with->times.p50_us / without->times.p50_us));
}

/// If several of the ball cases ran, adds the requirement that the removed volume does not depend on the voxel size.
void CompareGrids(std::vector<BenchResult>& results) {
  double min_mm3 = 1e300;
  double max_mm3 = 0;
  int count = 0;
  for (const char* name : {"ball-0.1", "ball-0.2", "ball-0.3"}) {
    if (const BenchResult* r = Find(results, name)) {
      min_mm3 = std::min(min_mm3, r->Find("removed")->value);
      max_mm3 = std::max(max_mm3, r->Find("removed")->value);
      ++count;
    }
  }
  BenchResult* middle = Find(results, "ball-0.2");
  if (!middle || count < 2) return;
  middle->targets.push_back(AtMost("removed volume differs between grids by", 2, "%", 100 * (max_mm3 / min_mm3 - 1)));
}

}  // namespace

std::vector<std::string> NamesOfTickCases() {
  std::vector<std::string> names;
  for (const Entry& entry : Entries()) names.push_back(entry.name);
  return names;
}

void CheckTickCases(const std::vector<std::string>& names) {
  const std::vector<std::string> known = NamesOfTickCases();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string nearest = FindNearestName(name, known);
    throw Error(fmt::format("there is no case \"{}\"{}; the cases are {}", name,
                            nearest.empty() ? "" : fmt::format("; the nearest is \"{}\"", nearest),
                            fmt::join(known, ", ")));
  }
}

std::vector<BenchResult> RunTickCases(const std::vector<std::string>& names, const BenchOptions& options) {
  CheckTickCases(names);
  std::vector<BenchResult> results;
  for (const Entry& entry : Entries()) {
    if (!names.empty() && std::find(names.begin(), names.end(), entry.name) == names.end()) continue;
    results.push_back(entry.run(options));
  }
  CompareMandibles(results);
  CompareEffects(results);
  CompareGrids(results);
  return results;
}

}  // namespace kerf
