#include "experiment/effect_costs/effect_costs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "base/core/hash.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "device/devices/simulated_device.h"
#include "experiment/bench/measure.h"
#include "kerf/error.h"
#include "loop/haptics/haptic_step.h"
#include "session/run/bone_cache.h"
#include "session/run/hand_motion.h"
#include "session/run/loop_setup.h"
#include "session/run/make_bone.h"
#include "session/scene/path.h"

namespace kerf {
namespace {

constexpr double kMaxFollowed_s = 6;     // maximum duration of the cut that is followed, from the first contact
constexpr double kMaxSearch_s = 120;     // simulated time after which the search for the first contact is given up
constexpr std::size_t kBlock = 100;      // ticks of one side before switching to the other
constexpr std::size_t kLiftSpeedup = 8;  // how many times faster the tool leaves the cut than it entered it
constexpr std::size_t kRefill = 1024;
constexpr double kHover_mm = 5;
constexpr double kSwing_mm = 2;
constexpr double kSwing_Hz = 3;  // peak speed 38 mm/s
constexpr double kSwing_s = 1;

struct Step {
  Pose X_W;  // of the handle, or of the position-controlled tool
  Vec3 v_W_mm_per_s{0};
  Vec3 w_W_rad_per_s{0};
};

/// The motion that every measurement repeats.
struct MeasuredCut {
  Bone bone;
  bool by_hand = true;
  CoupledParams coupled_params;
  SimulationParams path_params;
  Pose X_WT_start;
  double dt_s = 0.001;
  double rpm = 0;
  std::vector<Step> steps;
  std::vector<Step> hover;  // from the start further into the air and back
  std::size_t begin = 0;    // first measured step; `end` is one past the last
  std::size_t end = 0;
  double mean_teeth = 0;
};

/// Times of ticks, each of which is repeated in several passes.
class RepeatedTimes {
 public:
  explicit RepeatedTimes(std::size_t ticks) : best_us_(ticks, 1e300) { all_us_.reserve(ticks); }

  template <typename Work>
  void Time(std::size_t tick, Work&& work) {
    const WorkTime time = TimeWork(work);
    best_us_[tick] = std::min(best_us_[tick], time.us());
    if (time.undisturbed) {
      all_us_.push_back(time.us());
    } else {
      ++disturbed_;
    }
  }
  Percentiles CalcBest() const { return CalcPercentiles(best_us_); }
  Percentiles CalcAll() const { return CalcPercentiles(all_us_); }
  std::size_t disturbed() const { return disturbed_; }

 private:
  std::vector<double> best_us_;
  std::vector<double> all_us_;
  std::size_t disturbed_ = 0;
};

/// A simulation with some effects.
class Subject {
 public:
  Subject(const MeasuredCut& cut, const EffectChoices& effects) : cut_(cut) {
    if (cut.by_hand) {
      CoupledParams params = cut.coupled_params;
      params.effects = effects;
      coupled_ = std::make_unique<CoupledSimulation>(cut.bone, params, cut.X_WT_start);
    } else {
      SimulationParams params = cut.path_params;
      params.effects = effects;
      on_path_ = std::make_unique<Simulation>(cut.bone, params, cut.X_WT_start);
    }
  }

  /// Runs a tick, which is the part that is timed.
  void Tick(const Step& step) {
    if (coupled_) {
      coupled_out_ = coupled_->Tick({step.X_W, step.v_W_mm_per_s, step.w_W_rad_per_s, cut_.dt_s, cut_.rpm});
    } else {
      path_out_ = on_path_->Tick({step.X_W, cut_.dt_s, cut_.rpm});
    }
  }
  /// Runs between ticks.
  void Note() {
    if (coupled_) {
      coupled_->ClearChanged();
      Mix(coupled_out_.f_H_W_N);
      Mix(coupled_out_.X_WT.p_AB);
    } else {
      if (++ticks_ % kRefill == 0) on_path_->Refill();
      Mix(path_out_.f_T_W_N);
    }
  }
  void Go(const Step& step) {
    Tick(step);
    Note();
  }
  void GoTimed(const Step& step, std::size_t tick, RepeatedTimes& times) {
    times.Time(tick, [&] { Tick(step); });
    Note();
  }

  double engaged_teeth() const { return coupled_ ? coupled_out_.engaged_teeth : path_out_.engaged_teeth; }
  std::uint64_t force_hash() const { return hash_; }
  std::uint64_t CalcBoneHash() const {
    return coupled_ ? coupled_->UpdateBone().CalcHash() : on_path_->UpdateBone().CalcHash();
  }
  const EffectPlan& effects() const {
    return coupled_ ? EffectsOf(std::as_const(*coupled_)) : EffectsOf(std::as_const(*on_path_));
  }
  double CalcMemoryMB() const {
    return 1e-6 * static_cast<double>(coupled_ ? coupled_->CalcMemoryBytes() : effects().CalcMemoryBytes());
  }
  CoupledSimulation& coupled() { return *coupled_; }

 private:
  void Mix(const Vec3& v) {
    for (int axis = 0; axis < 3; ++axis) hash_ = MixHash(hash_ ^ std::bit_cast<std::uint64_t>(v[axis]));
  }

  const MeasuredCut& cut_;
  std::unique_ptr<CoupledSimulation> coupled_;
  std::unique_ptr<Simulation> on_path_;
  CoupledOutput coupled_out_;
  TickOutput path_out_;
  std::uint64_t hash_ = 0;
  std::size_t ticks_ = 0;
};

void CheckStop(const EffectCostOptions& options) {
  if (options.stop != nullptr && options.stop->load()) throw Error("stopped before the costs were measured");
}

/// Follows the cut with the scene's own effects, as `kerf loop` or `kerf run` does, until the followed part is long
/// enough.
class Scout {
 public:
  Scout(MeasuredCut& cut, const EffectCostOptions& options) : cut_(cut), options_(options) {}

  void Go(const Scene& scene) {
    Subject subject(cut_, scene.effects);
    if (cut_.by_hand) {
      FollowHand(scene, subject);
    } else {
      FollowPath(scene, subject);
    }
    Choose(scene);
  }

 private:
  bool IsEnough() {
    if (steps_ % 256 == 0) CheckStop(options_);
    ++steps_;
    const double followed_s = cut_.dt_s * static_cast<double>(steps_ - first_);
    return touched_ ? followed_s > kMaxFollowed_s : cut_.dt_s * static_cast<double>(steps_) > kMaxSearch_s;
  }
  void Keep(const Step& step, double teeth) {
    cut_.steps.push_back(step);
    teeth_.push_back(teeth);
    if (!touched_ && teeth > 0) {
      touched_ = true;
      first_ = steps_;
    }
  }

  void FollowHand(const Scene& scene, Subject& subject) {
    const LoopSetup setup = MakeLoopSetup(scene);
    const Vec3 p_TC_mm = cut_.coupled_params.coupling.p_TC_mm;
    SimulatedDeviceOptions device_options;
    device_options.p_TC_mm = p_TC_mm;
    SimulatedDevice device(setup.profile, setup.hand, cut_.X_WT_start, device_options);
    HandMotion motion(device, MakePath(scene), scene.hand, p_TC_mm,
                      cut_.coupled_params.coupling.stiffness_N_per_mm * setup.force_scale);
    HapticStep haptics(subject.coupled(), setup.profile, setup.force_map);
    while (!IsEnough()) {
      motion.Advance(cut_.dt_s);
      const HapticTick out = haptics.Step(device, {.dt_s = cut_.dt_s, .rpm = cut_.rpm});
      subject.coupled().ClearChanged();
      Keep({out.X_WH, out.v_H_W_mm_per_s, out.w_H_W_rad_per_s}, out.coupled.engaged_teeth);
    }
  }
  void FollowPath(const Scene& scene, Subject& subject) {
    const Path path = MakePath(scene);
    PathDriver driver(path, 1 / cut_.dt_s);
    // Goes to the end of the first stroke, including the segments that continue it without a retract.
    while (const std::optional<PathStep> next = driver.Next()) {
      if (next->set_down && next->segment == 0) continue;
      if (next->set_down || IsEnough()) return;
      const Step step{next->X_WT};
      subject.Go(step);
      Keep(step, subject.engaged_teeth());
    }
  }

  /// Selects the part with the most teeth engaged.
  void Choose(const Scene& scene) {
    if (!touched_) {
      throw Error(fmt::format("{}: the tool touches no bone in the first {:.0f} s; there is nothing to measure",
                              scene.name, cut_.dt_s * static_cast<double>(cut_.steps.size())));
    }
    const std::size_t count =
        std::min(cut_.steps.size(), static_cast<std::size_t>(std::lround(options_.seconds / cut_.dt_s)));
    double sum = 0;
    double max_sum = -1;
    for (std::size_t i = 0; i < teeth_.size(); ++i) {
      sum += teeth_[i];
      if (i >= count) sum -= teeth_[i - count];
      if (i + 1 >= count && sum > max_sum) {
        max_sum = sum;
        cut_.end = i + 1;
      }
    }
    cut_.begin = cut_.end - count;
    cut_.mean_teeth = max_sum / static_cast<double>(count);
    cut_.steps.resize(cut_.end);
    // The tool swings in the air beyond the start, where it has had no contact.
    const Vec3 back = cut_.X_WT_start.p_AB - cut_.steps[(cut_.begin + cut_.end) / 2].X_W.p_AB;
    const Vec3 away = glm::length(back) > 1e-6 ? glm::normalize(back) : Vec3(0, 0, 1);
    const auto ticks = static_cast<std::size_t>(std::lround(kSwing_s / cut_.dt_s));
    const auto out = ticks / 4;
    const auto place = [&](double mm) {
      Step step{cut_.X_WT_start};
      step.X_W.p_AB += mm * away;
      return step;
    };
    for (std::size_t i = 0; i < out; ++i) {
      cut_.hover.push_back(place(kHover_mm * static_cast<double>(i) / static_cast<double>(out)));
    }
    for (std::size_t i = 0; i < ticks; ++i) {
      const double t_s = cut_.dt_s * static_cast<double>(i);
      cut_.hover.push_back(place(kHover_mm + kSwing_mm * std::sin(2 * std::numbers::pi * kSwing_Hz * t_s)));
    }
    for (std::size_t i = 0; i < out; ++i) {
      cut_.hover.push_back(place(kHover_mm * (1 - static_cast<double>(i) / static_cast<double>(out))));
    }
  }

  MeasuredCut& cut_;
  const EffectCostOptions& options_;
  std::vector<double> teeth_;
  std::size_t steps_ = 0;
  std::size_t first_ = 0;
  bool touched_ = false;
};

/// Alternates between the two sides of a comparison.
class Pair {
 public:
  Pair(const MeasuredCut& cut, const EffectChoices& without, const EffectChoices& with)
      : cut_(cut), choices_{without, with}, sides_{Side(cut), Side(cut)} {}

  void Pass(const EffectCostOptions& options) {
    std::array<std::unique_ptr<Subject>, 2> subjects;
    for (std::size_t i = 0; i < 2; ++i) subjects[i] = std::make_unique<Subject>(cut_, choices_[i]);
    Hover(subjects, &Side::air, options);
    for (const auto& subject : subjects) {
      for (std::size_t k = 0; k < cut_.begin; ++k) {
        subject->Go(cut_.steps[k]);
        if (k % 256 == 0) CheckStop(options);
      }
    }
    InTurn(cut_.begin, cut_.end, options, [&](std::size_t i, std::size_t k) {
      subjects[i]->GoTimed(cut_.steps[k], k - cut_.begin, sides_[i].cutting);
    });
    for (std::size_t i = 0; i < 2; ++i) {
      const std::uint64_t force_hash = subjects[i]->force_hash();
      const std::uint64_t bone_hash = subjects[i]->CalcBoneHash();
      if (passes_ > 0 && (force_hash != sides_[i].force_hash || bone_hash != sides_[i].bone_hash)) {
        throw Error("two passes through the cut gave different results; this is a bug in kerf");
      }
      sides_[i].force_hash = force_hash;
      sides_[i].bone_hash = bone_hash;
    }
    ++passes_;
    by_effect_.clear();
    for (const EffectPlan::Entry& entry : subjects[1]->effects().entries()) {
      by_effect_.emplace_back(entry.info->name, 1e-6 * static_cast<double>(entry.effect->CalcMemoryBytes()));
    }
    simulation_MB_ = subjects[1]->CalcMemoryMB();
    for (const auto& subject : subjects) LiftOut(*subject);
    Hover(subjects, &Side::air_after, options);
  }

  void Finish(EffectCost& cost) const {
    const std::array<TickCosts*, 2> into{&cost.without_it, &cost.with_it};
    for (std::size_t i = 0; i < 2; ++i) {
      const Side& side = sides_[i];
      into[i]->cutting = side.cutting.CalcBest();
      into[i]->all = side.cutting.CalcAll();
      into[i]->disturbed = side.cutting.disturbed();
      into[i]->air = side.air.CalcBest();
      into[i]->air_after = side.air_after.CalcBest();
      into[i]->bone_hash = side.bone_hash;
      into[i]->force_hash = side.force_hash;
    }
  }
  double MemoryOf(const std::string& name) const {
    double MB = 0;
    for (const auto& [effect, of_it_MB] : by_effect_) {
      if (name == effect) MB = of_it_MB;
    }
    return MB;
  }
  double simulation_MB() const { return simulation_MB_; }

 private:
  struct Side {
    explicit Side(const MeasuredCut& cut)
        : cutting(cut.end - cut.begin), air(CountAir(cut)), air_after(CountAir(cut)) {}
    RepeatedTimes cutting, air, air_after;
    std::uint64_t bone_hash = 0;
    std::uint64_t force_hash = 0;
  };
  using Subjects = std::array<std::unique_ptr<Subject>, 2>;

  // Numbers of ticks of the hover: the motions out and back (CountEdge ticks each) are not timed; the part in between
  // (CountAir ticks) is.
  static std::size_t CountEdge(const MeasuredCut& cut) { return cut.hover.size() / 6; }
  static std::size_t CountAir(const MeasuredCut& cut) { return cut.hover.size() - 2 * CountEdge(cut); }

  /// Runs the two sides alternately in blocks of ticks; the side that goes first alternates too.
  template <typename Work>
  void InTurn(std::size_t begin, std::size_t end, const EffectCostOptions& options, Work&& work) {
    std::size_t first = 0;
    for (std::size_t at = begin; at < end; at += kBlock) {
      for (const std::size_t i : {first, 1 - first}) {
        for (std::size_t k = at; k < std::min(at + kBlock, end); ++k) work(i, k);
      }
      first = 1 - first;
      CheckStop(options);
    }
  }
  void Hover(Subjects& subjects, RepeatedTimes Side::*timer, const EffectCostOptions& options) {
    const std::size_t edge = CountEdge(cut_);
    const std::size_t last = cut_.hover.size() - edge;
    for (const auto& subject : subjects) {
      for (std::size_t k = 0; k < edge; ++k) subject->Go(cut_.hover[k]);
    }
    InTurn(edge, last, options,
           [&](std::size_t i, std::size_t k) { subjects[i]->GoTimed(cut_.hover[k], k - edge, sides_[i].*timer); });
    for (const auto& subject : subjects) {
      for (std::size_t k = last; k < cut_.hover.size(); ++k) subject->Go(cut_.hover[k]);
    }
  }
  void LiftOut(Subject& subject) const {
    Vec3 p_before = cut_.steps[cut_.end - 1].X_W.p_AB;
    for (std::size_t k = cut_.end; k > 0; k -= std::min(k, kLiftSpeedup)) {
      Step step{cut_.steps[k - 1].X_W};
      step.v_W_mm_per_s = (step.X_W.p_AB - p_before) / cut_.dt_s;
      p_before = step.X_W.p_AB;
      subject.Go(step);
    }
  }

  const MeasuredCut& cut_;
  std::array<EffectChoices, 2> choices_;
  std::array<Side, 2> sides_;
  std::vector<std::pair<std::string, double>> by_effect_;
  double simulation_MB_ = 0;
  int passes_ = 0;
};

MeasuredCut MakeMeasuredCut(const Scene& scene, const EffectCostOptions& options,
                            const std::function<void(double)>& progress) {
  MeasuredCut cut;
  cut.by_hand = options.by_hand;
  cut.bone = MakeSceneBone(scene, progress);
  FinishKeepingBones();
  cut.X_WT_start = MakePath(scene).CalcPose(0, 0);
  cut.rpm = scene.tool.CalcTickRpm();
  if (options.by_hand) {
    cut.coupled_params = MakeCoupledParams(scene);
    cut.coupled_params.coupling = MakeLoopSetup(scene).fitted.coupling;
    cut.coupled_params.spare_leaves = CountSpareLeaves(cut.bone);
    cut.dt_s = 1 / scene.loop.rate_hz;
  } else {
    cut.path_params = MakeSimulationParams(scene);
    cut.dt_s = 1 / scene.simulation.rate_hz;
  }
  return cut;
}

/// The effects to measure, and the reasons for leaving out the others.
struct EffectSelection {
  EffectChoices choices;  // in the registry's order
  std::vector<std::string> why;
  std::vector<EffectLeftOut> left_out;
};

/// Returns the effects that an effect needs, directly or indirectly, in the order of `choices`.
EffectChoices TakeNeeded(const EffectInfo& info, const EffectChoices& choices) {
  std::set<std::string> names(info.needs.begin(), info.needs.end());
  for (auto choice = choices.rbegin(); choice != choices.rend(); ++choice) {
    const auto& needs = choice->info().needs;
    if (names.contains(choice->name())) names.insert(needs.begin(), needs.end());
  }
  EffectChoices needed;
  std::copy_if(choices.begin(), choices.end(), std::back_inserter(needed),
               [&](const EffectChoice& choice) { return names.contains(choice.name()); });
  return needed;
}

EffectSelection SelectEffects(const Scene& scene, const EffectCostOptions& options, const MeasuredCut& cut) {
  EffectSelection selection;
  for (const EffectInfo* info : Effects()) {
    const EffectChoice* named = FindChoice(scene.effects, info->name);
    if (named == nullptr && !options.all) {
      selection.left_out.push_back({info->name, "the scene does not name it"});
      continue;
    }
    if (info->tool == EffectTool::kInHand && !options.by_hand) {
      selection.left_out.push_back({info->name, "it needs a tool coupled to a handle, and 'kerf run' has none"});
      continue;
    }
    const EffectChoice choice = named != nullptr ? *named : EffectChoice(info->name);
    if (named == nullptr) {
      // An effect with its default parameters may not fit the scene.
      try {
        EffectChoices alone = TakeNeeded(*info, selection.choices);
        alone.push_back(choice);
        const Subject probe(cut, alone);
      } catch (const Error& e) {
        selection.left_out.push_back({info->name, e.what()});
        continue;
      }
    }
    selection.choices.push_back(choice);
    selection.why.emplace_back(named != nullptr ? "the scene names it" : "requested, with its defaults");
  }
  return selection;
}

}  // namespace

EffectCosts MeasureEffects(const Scene& scene, const EffectCostOptions& options) {
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error("[simulation] mode = \"slab\" has no effects; set mode = \"voxel\" for 'kerf effects'");
  }
  CheckParameters(options);
  const auto show = [&](const std::string& stage, double fraction) {
    if (options.progress) options.progress(stage, fraction);
  };
  EffectCosts costs;
  costs.scene = scene.name;
  costs.title = scene.title;
  costs.run = ReadRunInfo(options.core, options.realtime);
  costs.by_hand = options.by_hand;
  costs.passes = std::max(1, options.passes);

  MeasuredCut cut = MakeMeasuredCut(scene, options, [&](double f) { show("making the bone", f); });
  const EffectSelection selection = SelectEffects(scene, options, cut);
  costs.left_out = selection.left_out;
  std::unique_ptr<PinnedToCore> pinned;
  if (options.core) pinned = std::make_unique<PinnedToCore>(*options.core, options.realtime);
  show("measuring", 0);
  Scout(cut, options).Go(scene);
  costs.voxel_mm = cut.bone.voxel_mm();
  costs.rate_hz = 1 / cut.dt_s;
  costs.begin_s = cut.dt_s * static_cast<double>(cut.begin);
  costs.seconds = cut.dt_s * static_cast<double>(cut.end - cut.begin);
  costs.mean_teeth = cut.mean_teeth;
  costs.bone_MB = 1e-6 * static_cast<double>(cut.bone.CalcMemoryBytes());

  const std::size_t one_by_one = options.together_only ? 0 : selection.choices.size();
  const double work = static_cast<double>((one_by_one + 1) * static_cast<std::size_t>(costs.passes));
  double done = 0;
  const auto measure = [&](const EffectChoices& without, const EffectChoices& with, EffectCost& cost) {
    Pair pair(cut, without, with);
    for (int n = 0; n < costs.passes; ++n) {
      pair.Pass(options);
      show("measuring", ++done / work);
    }
    pair.Finish(cost);
    return pair;
  };
  for (std::size_t i = 0; i < one_by_one; ++i) {
    const EffectChoice& choice = selection.choices[i];
    EffectCost cost;
    cost.name = choice.name();
    cost.why = selection.why[i];
    const EffectChoices without = TakeNeeded(choice.info(), selection.choices);
    for (const EffectChoice& needed : without) cost.with.emplace_back(needed.name());
    EffectChoices with = without;
    with.push_back(choice);
    cost.memory_MB = measure(without, with, cost).MemoryOf(cost.name);
    costs.effects.push_back(cost);
  }
  costs.together.name = "all";
  const Pair all = measure({}, selection.choices, costs.together);
  costs.simulation_MB = all.simulation_MB();
  for (const EffectChoice& choice : selection.choices) costs.together.memory_MB += all.MemoryOf(choice.name());
  return costs;
}

}  // namespace kerf
