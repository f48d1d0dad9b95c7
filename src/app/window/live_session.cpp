#include "app/window/live_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "base/core/cancelled.h"
#include "bone/grid/shared_leaves.h"
#include "cut/effects/guide.h"
#include "cut/effects/plan.h"
#include "cut/force/measured.h"
#include "kerf/error.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr int kTicksInMoment = 20;  // one point of the curve per 20 ms at 1 kHz
constexpr double kFeedOver_s = 0.1;

constexpr const char* kCoarseStage = Msg("making a coarse bone");
constexpr const char* kLoading = "loading";  // all its stages as one, for the estimate

/// Returns the stages of loading. A coarse bone has so few voxels that it takes a fraction of the time.
OverallProgress MakeLoadingProgress(const Scene& scene, bool coarse) {
  std::vector<ExpectedStage> stages;
  for (const ExpectedStage& stage : ListLoopStages(scene, {}, false)) {
    if (coarse && stages.empty()) stages.push_back({kCoarseStage, 0.1 * stage.seconds});
    if (stage.name != "cutting") stages.push_back(stage);
  }
  return OverallProgress(std::move(stages));
}

bool MovesSaw(const LoopAction& action) {
  using Kind = LoopAction::Kind;
  return action.kind == Kind::kUndo || action.kind == Kind::kRedo || action.kind == Kind::kRetract;
}

}  // namespace

LiveSession::LiveSession(Scene scene, LiveOptions options)
    : scene_(std::move(scene)),
      options_(std::move(options)),
      rpm_(options_.scripted ? scene_.tool.rpm : 0),
      loading_(MakeLoadingProgress(scene_, options_.prepare != nullptr)) {
  asked_.push_back({.at_s = 0, .kind = LoopAction::Kind::kSpindle, .rpm = rpm_, .name = ""});
  if (options_.device != nullptr) SetDevice(scene_, *options_.device);
  Report(options_.prepare ? kCoarseStage : "making the bone", 0);
  thread_ = std::thread([this] { Run(); });
}

LiveSession::~LiveSession() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

void LiveSession::Run() {
  LoopOptions loop;
  loop.seconds = options_.seconds;
  loop.output.log = LoopLog::kNone;
  loop.output.keep_last = true;
  loop.output.keep_on_failure = true;
  loop.stop = &stop_;
  if (options_.bone) {
    loop.read_bone = [this](const ReadBoneOptions& read) {
      return CopyAsStored(*std::exchange(options_.bone, nullptr), read);  // the bone is not needed any more
    };
  }
  loop.output.record = options_.record;
  loop.output.scene_file = options_.scene_file;
  loop.watchers.peer = this;
  loop.watchers.take_tick = [this](const LoopTick& tick, std::span<const double> channels) {
    if (options_.tick) options_.tick(tick);
    if (options_.link != nullptr) options_.link->TakeTick(tick, channels);
    TakeTick(tick, channels);
  };
  if (options_.device != nullptr && !options_.scripted) {
    loop.driver.device = MakeLoopDevice(*options_.device, &stop_, [this](const std::string& message) {
      const std::lock_guard lock(mutex_);
      notes_.push_back(message);
    });
  } else if (!options_.scripted) {
    loop.driver.make_hand = [this](SimulatedDevice& device, const LoopSetup&, const Vec3& p_TC_mm, double) {
      DeviceSample sample;
      device.Read(sample);
      return std::make_unique<MouseHand>(device, target_, sample.X_WH, p_TC_mm);
    };
  }
  try {
    if (options_.prepare) options_.prepare([this](double fraction) { Report(kCoarseStage, fraction); });
    LoopSummary summary =
        RunLoop(scene_, loop, [this](const std::string& stage, double fraction) { Report(stage, fraction); });
    if (!summary.failure.empty()) failure_ = summary.failure;
    summary_.emplace(std::move(summary));
  } catch (const Cancelled&) {
    cancelled_ = true;
    std::error_code ignored;
    std::filesystem::remove(options_.record, ignored);  // it holds no tick
  } catch (const std::exception& e) {
    failure_ = e.what();
  }
  mirror_ = nullptr;
  {
    const std::lock_guard lock(mutex_);
    bones_asked_.clear();  // breaks the promises, so that waiting futures fail
  }
  stage_.store(LiveStage::kEnded);
}

void LiveSession::Report(const std::string& stage, double fraction) {
  if (stop_.load() && stage_.load() == LiveStage::kLoading) throw Cancelled();
  const std::lock_guard lock(mutex_);
  working_on_ = stage;
  if (stage_.load() == LiveStage::kLoading) {
    progress_.Set(kLoading, loading_.Advance(stage, fraction), ProgressMeter::Now_s());
  } else {
    progress_.Set(stage, fraction, ProgressMeter::Now_s());
  }
  if (stop_.load() && stage_.load() == LiveStage::kRunning) stage_.store(LiveStage::kEnding);
}

void LiveSession::Begin(const LoopInitialState& beginning) {
  mirror_ = &beginning.bone;
  const MaterialTable& materials = beginning.bone.materials();
  for (int region = 0; region < 256; ++region) {
    if (materials.Contains(region) && materials.At(region).tissue == Tissue::kTooth) teeth_.push_back(region);
  }
  for (const EffectPlan::Entry& entry : beginning.effects.entries()) {
    if (std::string_view(entry.info->name) == "handpiece") holder_channel_ = entry.first_channel;
    const auto* guide = dynamic_cast<const GuideEffect*>(entry.effect.get());
    if (guide == nullptr) continue;
    guide_channel_ = entry.first_channel + GuideEffect::kForceChannel;
    guide_normal_W_ = glm::normalize(guide->params().normal_W);
  }
  if (options_.begin) options_.begin(beginning.bone, beginning.effects);
  if (options_.link != nullptr) options_.link->Begin(beginning);
  target_.Publish({beginning.X_WT, false});
  {
    const std::lock_guard lock(mutex_);
    figures_.coupled.X_WT = figures_.X_WH = beginning.X_WT;
  }
  stage_.store(LiveStage::kRunning);
}

void LiveSession::TakeLeaf(const LeafMessage& leaf) {
  if (options_.leaf) options_.leaf(leaf);
  if (options_.link != nullptr) options_.link->TakeLeaf(leaf);
  const std::lock_guard lock(mutex_);
  ++figures_.changes;
}

void LiveSession::TakeTick(const LoopTick& tick, std::span<const double> channels) {
  const CoupledOutput& out = tick.coupled;
  const bool stroke_ends = stroke_.Take(tick);
  const std::lock_guard lock(mutex_);
  if (stroke_ends) asked_.push_back({.kind = LoopAction::Kind::kCheckpoint, .name = ""});
  figures_.ContactSums::Take(tick, figures_.time_s);
  static_cast<LoopTick&>(figures_) = tick;
  figures_.removed_mm3 += out.removed_mm3;
  figures_.missed += tick.in.skipped;
  if (std::any_of(teeth_.begin(), teeth_.end(), [&](int region) { return out.HasCut(region); })) {
    figures_.tooth_cut_s = tick.time_s;
  }
  if ((out.status & kCoupledTouchesMetal) != 0) figures_.metal_touch_s = tick.time_s;
  figures_.channels.assign(channels.begin(), channels.end());
  if (guide_channel_ && *guide_channel_ < channels.size()) figures_.guide_force_N = channels[*guide_channel_];
  if (holder_channel_ && *holder_channel_ + 1 < channels.size()) {
    figures_.holder_force_N = channels[*holder_channel_];
    figures_.hub_force_N = channels[*holder_channel_ + 1];
  }

  if (tick.held || tick.stands) {
    figures_.released.reset();
  } else if (!figures_.released) {
    figures_.released = {.p_W_mm = out.X_WT.p_AB, .removed_mm3 = figures_.removed_mm3};
  }

  places_.push_back({tick.time_s, out.X_WT.p_AB});
  while (places_.size() > 2 && tick.time_s - places_.front().time_s > kFeedOver_s) places_.pop_front();
  const double over_s = tick.time_s - places_.front().time_s;
  if (over_s > 0) figures_.feed_mm_per_s = glm::length(out.X_WT.p_AB - places_.front().p_W_mm) / over_s;

  moment_.time_s = tick.time_s;
  moment_.force_N = std::max(moment_.force_N, glm::length(out.f_H_W_N));
  if (++in_moment_ < kTicksInMoment) return;
  forces_.push_back(std::exchange(moment_, {}));
  in_moment_ = 0;
}

std::optional<LoopAction> LiveSession::NextAction() {
  std::vector<std::promise<Bone>> bones;
  std::optional<LoopAction> action;
  {
    const std::lock_guard lock(mutex_);
    bones.swap(bones_asked_);
    if (!asked_.empty()) {
      action = std::move(asked_.front());
      asked_.pop_front();
    }
  }
  for (std::promise<Bone>& bone : bones) bone.set_value(CopySharing(*mirror_));
  return action;
}

void LiveSession::Done(const LoopAction& action, const std::string& failure, std::optional<double> restored_mm3) {
  if (action.kind == LoopAction::Kind::kCheckpoint && action.name.empty()) return;  // of a stroke
  const std::lock_guard lock(mutex_);
  answers_.push_back({action, failure, restored_mm3});
}

WorkProgress LiveSession::progress() const {
  const std::lock_guard lock(mutex_);
  WorkProgress progress = progress_.Get(ProgressMeter::Now_s());
  progress.stage = working_on_;
  return progress;
}

LiveFigures LiveSession::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

LiveSession::ForceNote LiveSession::MakeForceNote(const LiveFigures& figures) const {
  return MakeForceNote(scene_, figures);
}

LiveSession::ForceNote LiveSession::MakeForceNote(const Scene& scene, const LiveFigures& figures) {
  constexpr double kNoBite_mm = 1e-6;
  constexpr double kTouch_s = 0.3;  // a saw that touched bone within this time still does
  constexpr double kAgrees = 1.25;  // studies differ by more
  const double bite_mm = figures.coupled.mean_bite_mm;
  const bool cuts = bite_mm >= kNoBite_mm;
  const ForceLaw& law = scene.force;
  const Tool tool = MakeTool(scene);
  ForceNote note;
  note.details = fmt::format("{}: {}; now {}", law.name(), DescribeAccuracy(law, tool),
                             cuts ? DescribeBite(law, bite_mm) : "no tooth cuts");
  const bool touches = figures.bone_touch_s && figures.time_s < *figures.bone_touch_s + kTouch_s;
  if (figures.guide_force_N.value_or(0) > 0 && !touches) {
    note.text = Tr("The saw touches no bone: the force is the pull of the guide.");
    return note;
  }
  if (!cuts) return note;
  const auto [from_mm, to_mm] = FindDataBites(law);
  const bool is_thin = bite_mm < from_mm;
  const bool is_thick = bite_mm > to_mm;
  if (std::holds_alternative<TwistDrill>(tool)) {
    // docs/validation.md, macavelia_2012: 0.47 to 0.54 of the measured thrust.
    const bool is_compared = law.name() == std::string_view("two_component") &&
                             law.values() == ForceLaw("two_component").values() && !law.has_own_table();
    note.text = is_compared ? Tr("The force of drills is about half of the thrust measured on bone: it is an estimate.")
                            : Tr("The force of drills is an estimate.");
  } else if (!IsBlade(tool)) {
    note.text = Tr("The force of burs has not been compared with tests on bone: it is an estimate.");
  } else if (law.table() != nullptr) {
    note.text = is_thin    ? Tr("The chips are thinner than in the table of the force law: the force is an estimate.")
                : is_thick ? Tr("The chips are thicker than in the table of the force law: the force is an estimate.")
                           : Tr("The chips are as thick as in the table of the force law.");
  } else if (is_thin) {
    note.text = Tr("The chips are thinner than in published tests on bone: the force is an estimate.");
  } else if (is_thick) {
    note.text = Tr("The chips are thicker than in published tests on bone: the force is an estimate.");
  } else if (const double factor = CalcThrustFactor(law, tool, bite_mm); factor > kAgrees || factor < 1 / kAgrees) {
    note.text = fmt::format(fmt::runtime(Tr("The force is about {} times that of published tests on bone.")),
                            ShowNumber(factor, 1));
  } else {
    note.text = Tr("The chips are as thick as in published tests on bone.");
  }
  return note;
}

std::vector<ForceMoment> LiveSession::TakeForces() {
  const std::lock_guard lock(mutex_);
  return std::exchange(forces_, {});
}

std::vector<std::string> LiveSession::TakeNotes() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notes_, {});
}

std::vector<LiveSession::Answer> LiveSession::TakeAnswers() {
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mutex_);
    answers.swap(answers_);
  }
  for (const Answer& answer : answers) moves_asked_ -= MovesSaw(answer.action) ? 1 : 0;
  return answers;
}

void LiveSession::Ask(LoopAction action) {
  moves_asked_ += MovesSaw(action) ? 1 : 0;
  const std::lock_guard lock(mutex_);
  asked_.push_back(std::move(action));
}

void LiveSession::SetSpindle(double rpm) {
  rpm_.store(rpm);
  Ask({.at_s = 0, .kind = LoopAction::Kind::kSpindle, .rpm = rpm, .name = ""});
}

std::future<Bone> LiveSession::AskBone() {
  const std::lock_guard lock(mutex_);
  return bones_asked_.emplace_back().get_future();
}

LoopSummary LiveSession::TakeSummary() {
  if (thread_.joinable()) thread_.join();
  if (!summary_) throw Error(failure_.empty() ? "the session has no result" : failure_);
  return std::move(*summary_);
}

}  // namespace kerf
