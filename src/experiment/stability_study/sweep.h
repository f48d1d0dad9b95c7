// Runs a scene's loop at the limits of its numeric keys, for `kerf stability --sweep`.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/table/table.h"
#include "session/scene/scene.h"

namespace kerf {

enum class SweepVerdict {
  kPass,
  kFail,       // not stable, or the loop refuses a scene that the check passes
  kWarned,     // not stable, but the check gives a warning that the unchanged scene does not have: no failure
  kRefused,    // by the check, with its reason: no failure
  kNotJudged,  // nothing could be judged: the path does not enter the bone, or the tool cut through at once
  kNotRun,     // the bone is too large for a case, or the time limit ended the case
};
const char* ToString(SweepVerdict verdict);

struct SweepSetting {
  std::string key;  // "coupling.stiffness_N_per_mm"
  double value = 0;
  friend bool operator==(const SweepSetting&, const SweepSetting&) = default;
};

struct SweepCase {
  std::vector<SweepSetting> settings;  // empty: the unchanged scene
};

struct SweepRow {
  std::vector<SweepSetting> settings;
  SweepVerdict verdict = SweepVerdict::kNotRun;
  std::string reason;                 // one line; empty if passed
  std::vector<std::string> warnings;  // of the check
  double wall_s = 0;
};

struct SweepOptions {
  int pairs = 100;
  std::uint64_t seed = 1;
  double case_s = 20;
  double max_voxels = 20e6;                 // of a generated bone; cases with larger bones are not run
  std::vector<std::string> only;            // only the keys whose names begin with one of these; empty: all
  bool begin_only = false;                  // only check the scene and start the loop, without the scenarios
  int threads = 0;                          // 0: number of the machine's cores
  const std::atomic<bool>* stop = nullptr;  // may be null
};

template <typename V>
void Describe(SweepOptions& p, V&& visit) {
  visit("pairs", p.pairs, Range{0, 100'000}, "number of random pairs of the sweep");
  visit("case_s", p.case_s, Range{0.1, 3600}, "time limit of a case of the sweep");
}

struct SweepStudy {
  std::string scene;
  std::string title;
  std::size_t keys = 0;
  std::uint64_t seed = 1;
  std::vector<SweepRow> rows;
  bool complete = true;  // false: ended early
  int Count(SweepVerdict verdict) const;
};

/// Returns the cases: the unchanged scene, each key at its minimum, default and maximum, then random pairs of different
/// keys, each at one of these three values or between them.
std::vector<SweepCase> MakeSweepCases(const Scene& scene, const SweepOptions& options);

/// Runs one case: writes it as a scene file, reads and checks it as `kerf check` does, starts it as `kerf loop` does,
/// and then runs the scenarios press_5N and cut_5N of `kerf stability`.
SweepRow TryCase(const Scene& scene, const SweepCase& which, const SweepOptions& options);

/// Throws Error for slab mode and a stopped spindle, as ExamineStability() does, and if no key matches `only`.
SweepStudy SweepScene(const Scene& scene, const SweepOptions& options,
                      const std::function<void(const std::string& stage, double fraction)>& progress);

/// "coupling.stiffness_N_per_mm = 1000, loop.rate_hz = 250"; "unchanged" for the unchanged scene.
std::string DescribeSettings(const std::vector<SweepSetting>& settings);
/// Formats one line for each row, and the counts.
std::string FormatSweepTable(const SweepStudy& study);
/// Describes the columns of the CSV.
const Columns<SweepRow>& SweepColumns();
std::string FormatSweepJson(const SweepStudy& study);

}  // namespace kerf
