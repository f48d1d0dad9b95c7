#include "experiment/stability_study/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>

#include "experiment/stability/scenarios.h"
#include "experiment/stability_study/stability_subject.h"
#include "experiment/stability_study/sweep_keys.h"
#include "kerf/error.h"
#include "session/run/check_scene.h"
#include "session/run/make_bone.h"
#include "session/run/run_loop.h"
#include "session/run/work_list.h"

namespace kerf {
namespace {

constexpr double kLoop_s = 0.01;  // simulated time for which each case runs the loop itself
constexpr const char* kScenarios[] = {"press_5N", "cut_5N"};

using Clock = std::chrono::steady_clock;

std::string FirstLine(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

/// Returns the number of voxels of a generated bone, or 0 for a bone from a file.
double CountVoxels(const SceneBone& bone) {
  const auto count = [](const Vec3& size_mm, double voxel_mm) {
    return size_mm.x * size_mm.y * size_mm.z / (voxel_mm * voxel_mm * voxel_mm);
  };
  if (bone.source == BoneSource::kFile) return 0;
  if (bone.source == BoneSource::kMandible) {
    return count(MandibleShape(bone.mandible).bounds().size(), bone.mandible.voxel_mm);
  }
  return count(bone.block.size_mm, bone.block.voxel_mm);
}

/// Returns the scene that a file with these values would describe.
Scene MakeCaseScene(const Scene& scene, const SweepCase& which) {
  Scene asked = scene;
  asked.coupling.given = asked.device.given = asked.hand.given = asked.loop.given = true;
  for (const SweepSetting& setting : which.settings) SetSweepKey(asked, setting.key, setting.value);
  Scene read = ParseScene(ResolvedToml(asked), scene.name + ".toml");
  read.name = scene.name;
  return read;
}

const Scenario& FindScenario(const std::string& name) {
  const std::vector<Scenario>& all = Scenarios();
  return *std::find_if(all.begin(), all.end(), [&](const Scenario& s) { return s.name == name; });
}

/// Sets the row's verdict from the figures that violate their bound or could not be judged.
void RunScenarios(const StabilitySubject& subject, SweepRow& row) {
  std::string unjudged;
  for (const char* name : kScenarios) {
    const ScenarioResult result = FindScenario(name).run(subject, 1);
    for (const StabilityFigure& f : result.figures) {
      // A small force, because of a weak spring or a small force scale of the device, is not an instability.
      if (f.holds() || f.name == "force") continue;
      row.verdict = SweepVerdict::kFail;
      row.reason = fmt::format("{}: {} is {:.3g}{}{}, but must be {} {:.3g}", name, f.name, f.value,
                               f.unit.empty() ? "" : " ", f.unit, f.at_most ? "at most" : "at least", f.bound);
      return;
    }
    if (!result.unjudged.empty()) unjudged = fmt::format("{}: {}", name, result.unjudged);
  }
  row.verdict = unjudged.empty() ? SweepVerdict::kPass : SweepVerdict::kNotJudged;
  row.reason = unjudged;
}

/// Runs a case after the check. Throws Error if the loop refuses a scene that the check passed.
void RunCase(const Scene& scene, const CheckedScene& checked, bool begin_only, const std::function<bool()>& late,
             SweepRow& row) {
  const auto stop_when_late = [&](double) {
    if (late()) throw Error("the case was stopped");
  };
  LoopOptions loop;
  loop.seconds = kLoop_s;
  loop.virtual_time = true;
  RunLoop(scene, loop, [&](const std::string&, double f) { stop_when_late(f); });

  if (begin_only) {
    row.verdict = SweepVerdict::kPass;
    return;
  }
  if (scene.tool.rpm < 1) {
    row.verdict = SweepVerdict::kNotJudged;
    row.reason = "the spindle is stopped: the loop starts, but nothing is cut";
    return;
  }
  const Bone bone = MakeSceneBone(scene, stop_when_late);
  std::optional<FirstTouch> touch;
  try {
    touch = FindFirstTouch(scene, bone);
  } catch (const Error& e) {
    row.verdict = SweepVerdict::kNotJudged;
    row.reason = FirstLine(e.what());
    return;
  }
  StabilitySubject subject = MakeStabilitySubject(scene, *checked.loop, bone, *touch);
  subject.stop = late;
  RunScenarios(subject, row);
}

/// Changes the verdict of failed rows to kWarned if the check gives a warning that the first row, the unchanged scene,
/// does not have.
void MarkWarned(std::vector<SweepRow>& rows) {
  const std::vector<std::string> usual = rows.front().warnings;
  for (SweepRow& row : rows) {
    if (row.verdict != SweepVerdict::kFail) continue;
    const auto more = std::find_if(row.warnings.begin(), row.warnings.end(), [&](const std::string& warning) {
      return std::find(usual.begin(), usual.end(), warning) == usual.end();
    });
    if (more == row.warnings.end()) continue;
    row.verdict = SweepVerdict::kWarned;
    row.reason += "; the check warns: " + *more;
  }
}

void CheckOptions(const Scene& scene, const SweepOptions& options) {
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error(
        "[simulation] mode = \"slab\" has no tool coupled to a handle; set mode = \"voxel\" for 'kerf stability'");
  }
  if (scene.tool.rpm < 1) throw Error("[tool] rpm = 0: a stopped tool cuts nothing; set the speed for cutting");
  CheckParameters(options);
}

std::vector<SweepKey> ListWantedKeys(const Scene& scene, const SweepOptions& options) {
  std::vector<SweepKey> keys = ListSweepKeys(scene);
  if (options.only.empty()) return keys;
  std::erase_if(keys, [&](const SweepKey& key) {
    return std::none_of(options.only.begin(), options.only.end(),
                        [&](const std::string& prefix) { return key.name.starts_with(prefix); });
  });
  if (keys.empty()) throw Error(fmt::format("no key of the scene begins with \"{}\"", options.only.front()));
  return keys;
}

}  // namespace

const char* ToString(SweepVerdict verdict) {
  switch (verdict) {
    case SweepVerdict::kPass:
      return "pass";
    case SweepVerdict::kFail:
      return "FAIL";
    case SweepVerdict::kWarned:
      return "warned";
    case SweepVerdict::kRefused:
      return "refused";
    case SweepVerdict::kNotJudged:
      return "not judged";
    case SweepVerdict::kNotRun:
      return "not run";
  }
  return "";
}

int SweepStudy::Count(SweepVerdict verdict) const {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [&](const SweepRow& row) { return row.verdict == verdict; }));
}

std::vector<SweepCase> MakeSweepCases(const Scene& scene, const SweepOptions& options) {
  const std::vector<SweepKey> keys = ListWantedKeys(scene, options);
  std::vector<SweepCase> cases{SweepCase{}};
  for (const SweepKey& key : keys) {
    std::vector<double> tried{key.own};
    for (const double value : {key.least, key.default_value, key.greatest}) {
      if (std::find(tried.begin(), tried.end(), value) != tried.end()) continue;
      tried.push_back(value);
      cases.push_back({{{key.name, value}}});
    }
  }
  if (keys.size() < 2) return cases;
  std::mt19937_64 random(options.seed);
  const auto draw = [&](const SweepKey& key) -> SweepSetting {
    const double fraction = static_cast<double>(random() >> 11U) * 0x1p-53;
    double between = key.least > 0 ? key.least * std::pow(key.greatest / key.least, fraction)
                                   : key.least + fraction * (key.greatest - key.least);
    if (key.own == std::round(key.own) && key.least == std::round(key.least)) between = std::round(between);
    const double values[] = {key.least, key.default_value, key.greatest, between};
    return {key.name, values[random() % 4]};
  };
  for (int i = 0; i < options.pairs; ++i) {
    const std::size_t a = random() % keys.size();
    const std::size_t b = (a + 1 + random() % (keys.size() - 1)) % keys.size();
    const SweepSetting first = draw(keys[std::min(a, b)]);
    const SweepSetting second = draw(keys[std::max(a, b)]);
    cases.push_back({{first, second}});
  }
  return cases;
}

SweepRow TryCase(const Scene& scene, const SweepCase& which, const SweepOptions& options) {
  const auto began = Clock::now();
  const auto elapsed_s = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  const auto late = [&] { return elapsed_s() > options.case_s || (options.stop != nullptr && options.stop->load()); };
  SweepRow row;
  row.settings = which.settings;
  std::optional<Scene> read;
  CheckedScene checked;
  try {
    read = MakeCaseScene(scene, which);
    checked = CheckWholeScene(*read);
  } catch (const Error& e) {
    row.verdict = SweepVerdict::kRefused;
    row.reason = FirstLine(e.what());
    row.wall_s = elapsed_s();
    return row;
  }
  row.warnings = checked.warnings;
  const double voxels = CountVoxels(read->bone);
  if (voxels > options.max_voxels) {
    row.reason = fmt::format("the bone has {:.3g} voxels; a case may have at most {:.3g}", voxels, options.max_voxels);
    return row;
  }
  try {
    RunCase(*read, checked, options.begin_only, late, row);
  } catch (const Error& e) {
    const bool stopped = late();
    row.verdict = stopped ? SweepVerdict::kNotRun : SweepVerdict::kFail;
    row.reason = stopped ? fmt::format("stopped after {:.0f} s", elapsed_s())
                         : fmt::format("'kerf check' accepts it, but the loop refuses it: {}", FirstLine(e.what()));
  }
  row.wall_s = elapsed_s();
  return row;
}

SweepStudy SweepScene(const Scene& scene, const SweepOptions& options,
                      const std::function<void(const std::string& stage, double fraction)>& progress) {
  CheckOptions(scene, options);
  const std::vector<SweepCase> cases = MakeSweepCases(scene, options);
  SweepStudy study;
  study.scene = scene.name;
  study.title = scene.title;
  study.keys = ListWantedKeys(scene, options).size();
  study.seed = options.seed;
  study.rows.resize(cases.size());
  std::vector<char> done(cases.size(), 0);
  WorkList work;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    work.Add("sweeping the scene's numbers", 1, [&, i] {
      study.rows[i] = TryCase(scene, cases[i], options);
      const bool is_interrupted = options.stop != nullptr && options.stop->load();
      done[i] = is_interrupted && study.rows[i].verdict == SweepVerdict::kNotRun ? 0 : 1;
    });
  }
  work.Run(options.threads, options.stop, progress);
  study.complete = std::find(done.begin(), done.end(), 0) == done.end();
  if (done.front() != 0) MarkWarned(study.rows);
  if (!study.complete) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (done[i] != 0) std::swap(study.rows[kept++], study.rows[i]);
    }
    study.rows.resize(kept);
  }
  return study;
}

}  // namespace kerf
