// A scene's loop at the ends of the ranges of its numbers: what `kerf stability --sweep` examines.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

enum class SweepVerdict {
  kPass,
  kFail,       // not stable, or the loop refuses what the check passes
  kWarned,     // not stable, and the check warns of it as it does not of the scene as it is: no failure
  kRefused,    // by the check, with its reason: no failure
  kNotJudged,  // nothing could be judged: the path does not lead into the bone, the tool was through at once
  kNotRun,     // too large for a case, or stopped by its time limit
};
const char* ToString(SweepVerdict verdict);

struct SweepSetting {
  std::string key;  // "coupling.stiffness_N_per_mm"
  double value = 0;
  friend bool operator==(const SweepSetting&, const SweepSetting&) = default;
};

struct SweepCase {
  std::vector<SweepSetting> settings;  // none: the scene as it is
};

struct SweepRow {
  std::vector<SweepSetting> settings;
  SweepVerdict verdict = SweepVerdict::kNotRun;
  std::string reason;                 // one line; empty for a pass
  std::vector<std::string> warnings;  // of the check
  double wall_s = 0;
};

struct SweepOptions {
  int pairs = 100;  // 0 to 100000
  std::uint64_t seed = 1;
  double case_s = 20;                       // time limit of a case
  double most_voxels = 20e6;                // of a bone that is generated; larger ones are not run
  std::vector<std::string> only;            // of the keys, those whose name begins with one of these; empty: all
  bool begin_only = false;                  // check and begin the loop alone, without the scenarios
  int threads = 0;                          // 0: as many as the machine has
  const std::atomic<bool>* stop = nullptr;  // may be null
};

struct SweepStudy {
  std::string scene;
  std::string title;
  std::size_t keys = 0;
  std::uint64_t seed = 1;
  std::vector<SweepRow> rows;
  bool complete = true;  // false: it was ended before
  int Count(SweepVerdict verdict) const;
};

/// The scene as it is, each key at its least, default and greatest value, then random pairs of different keys, each at
/// one of those three or between.
std::vector<SweepCase> MakeSweepCases(const Scene& scene, const SweepOptions& options);

/// One case: written as a scene file, read and checked as `kerf check` does, begun as `kerf loop` begins it, and then
/// the scenarios press_5N and cut_5N of `kerf stability`.
SweepRow TryCase(const Scene& scene, const SweepCase& which, const SweepOptions& options);

/// Throws Error for slab mode and a stopped spindle, as ExamineStability(), and for `only` that no key matches.
SweepStudy SweepScene(const Scene& scene, const SweepOptions& options,
                      const std::function<void(const std::string& stage, double fraction)>& progress);

/// "coupling.stiffness_N_per_mm = 1000, loop.rate_hz = 250"; "as it is".
std::string DescribeSettings(const std::vector<SweepSetting>& settings);
/// A line for each row, and the counts.
std::string FormatSweepTable(const SweepStudy& study);
/// verdict,key_1,value_1,key_2,value_2,wall_s,reason
std::string FormatSweepCsv(const SweepStudy& study);
std::string FormatSweepJson(const SweepStudy& study);

}  // namespace kerf
