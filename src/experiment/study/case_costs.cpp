// The costs of a case: the time of every tick, the memory, and the time to create the bone and the simulation.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/core/log_histogram.h"
#include "experiment/bench/measure.h"
#include "experiment/study/case_run.h"
#include "kerf/error.h"

namespace kerf {
namespace {

class PassTimer {
 public:
  template <typename Work>
  void Time(Work&& work) {
    const WorkTime time = TimeWork(work);
    all_->Add(time.ns);
    if (time.ns > limit_ns_) ++misses_;
    if (time.undisturbed) undisturbed_->Add(time.ns);
  }
  explicit PassTimer(double limit_s) : limit_ns_(static_cast<std::int64_t>(1e9 * limit_s)) {}

  const LogHistogram& all() const { return *all_; }
  const LogHistogram& undisturbed() const { return *undisturbed_; }
  std::uint64_t misses() const { return misses_; }

 private:
  std::unique_ptr<LogHistogram> all_ = std::make_unique<LogHistogram>();
  std::unique_ptr<LogHistogram> undisturbed_ = std::make_unique<LogHistogram>();
  std::int64_t limit_ns_;
  std::uint64_t misses_ = 0;
};

CaseOutcome Measure(const StudyPath& path, Holding holding, const StudySettings& settings, std::uint64_t ticks,
                    std::optional<int> core) {
  std::optional<PinnedToCore> pinned;
  if (core) pinned.emplace(*core);
  const std::vector<CaseInput> inputs = MakeCaseInputs(path, holding, settings.rate_hz);
  CaseOutcome outcome;
  CostFigures costs;
  PassTimer timer(1 / settings.rate_hz);
  for (int pass = 0; costs.ticks < ticks || pass < 2; ++pass) {
    std::int64_t start_ns = ReadClock_ns();
    const std::unique_ptr<CaseSubject> subject = MakeCaseSubject(path, holding, settings, MakeCaseBone(path, settings));
    // Only the first pass counts, since it may have to make the bone, of which later passes get a copy.
    if (pass == 0) costs.setup_s = CalcSecondsSince(start_ns);
    std::uint64_t force_hash = 0;
    const bool warm_up = pass == 0;
    start_ns = ReadClock_ns();
    for (const CaseInput& in : inputs) {
      Vec3 f_W_N{0};
      if (in.set_down) {
        subject->SetDown(in.X_W);
      } else if (warm_up) {
        f_W_N = subject->Tick(in);
      } else {
        timer.Time([&] { f_W_N = subject->Tick(in); });
        ++costs.ticks;
      }
      subject->BetweenTicks();
      force_hash = MixForce(force_hash, f_W_N);
    }
    const double seconds = CalcSecondsSince(start_ns);
    // The shortest time counts, because a busy machine can only add time.
    if (!warm_up) costs.whole_s = pass == 1 ? seconds : std::min(costs.whole_s, seconds);
    if (warm_up) costs.memory_MB = 1e-6 * static_cast<double>(subject->CalcMemoryBytes());
    const std::optional<Bone> bone = subject->TakeBone();
    const std::uint64_t bone_hash = bone ? bone->CalcHash() : 0;
    if (warm_up) {
      outcome.force_hash = force_hash;
      outcome.bone_hash = bone_hash;
    } else if (force_hash != outcome.force_hash || bone_hash != outcome.bone_hash) {
      throw Error(fmt::format("two passes gave different {}; this is a bug in kerf",
                              force_hash != outcome.force_hash ? "forces" : "bones"));
    }
  }
  costs.tick = CalcPercentiles(timer.all());
  costs.undisturbed = CalcPercentiles(timer.undisturbed());
  costs.misses_per_million = 1e6 * static_cast<double>(timer.misses()) / static_cast<double>(costs.ticks);
  for (std::size_t bucket = 0; bucket < LogHistogram::kBuckets; ++bucket) {
    if (const std::uint64_t count = timer.all().count(bucket); count > 0) {
      costs.histogram.emplace_back(static_cast<int>(bucket), count);
    }
  }
  outcome.costs = std::move(costs);
  return outcome;
}

}  // namespace

void CheckCore(std::optional<int> core) {
  if (!core) return;
  const PinnedToCore tried(*core);
}

CaseOutcome RunForCosts(const StudyPath& path, Holding holding, const StudySettings& settings, std::uint64_t ticks,
                        std::optional<int> core) {
  CaseOutcome outcome;
  try {
    outcome.why = FindOmission(path, holding, settings);
    if (outcome.why.empty()) return Measure(path, holding, settings, ticks, core);
    outcome.state = CaseState::kOmitted;
  } catch (const Omission& omission) {
    outcome = {};
    outcome.state = CaseState::kOmitted;
    outcome.why = omission.what();
  } catch (const std::exception& error) {
    outcome = {};
    outcome.state = CaseState::kFailed;
    outcome.why = error.what();
  }
  return outcome;
}

}  // namespace kerf
