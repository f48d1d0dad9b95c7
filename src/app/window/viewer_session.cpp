// The session: its beginning, what is followed while it runs, and its end.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "app/window/contact_sums.h"
#include "app/window/open_input.h"
#include "app/window/viewer_app.h"
#include "bone/grid/ct_modulus.h"
#include "bone/grid/shared_leaves.h"
#include "bone/vdb/bonefile.h"
#include "cut/tool/looks.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxForces = 200'000;  // maximum number of points: more than an hour of the force curve

/// Returns the bone with the CT numbers of the bone file, if it has any. The slices need them, but the loop does not.
Bone WithCtNumbers(const Bone& bone, const std::string& file) {
  if (file.empty() || bone.has_hu()) return CopySharing(bone);
  Bone read = ReadBone(file, {.hu = true});
  return read.has_hu() ? read : CopySharing(bone);
}

}  // namespace

void ViewerApp::Clear() {
  {
    const std::lock_guard lock(mutex_);
    watch_.reset();
  }
  leaf_watch_.reset();
  leaf_receiver_.reset();
  bone_.Clear();
  figures_ = {};
  forces_.clear();
  fitted_ = fit_again_ = view_changed_ = false;
  shown_place_.reset();
  X_home_.reset();
  waiting_.clear();
  view_->ClearTool();
  view_->SetGhost(std::nullopt);
  view_->SetForce(std::nullopt);
  view_->SetContact(std::nullopt);
  view_->SetAlarms({});
  view_->SetPlaneLines({});
  cut_place_.Clear();
  slices_ = {};
  lined_planes_.clear();
}

void ViewerApp::Begin(const Scene& scene, const std::string& scene_file, bool same_bone,
                      std::shared_ptr<const Bone> bone) {
  TakeBone(true);  // the session goes on with the bone that is shown last
  const bool goes_on = same_bone && bone_.surface() != nullptr;
  goes_on_ = goes_on;
  session_.reset();
  began_ = retracting_ = false;
  ++sessions_;
  recording_ = fmt::format("{}/session{}.kerf", options_.folder, sessions_ == 1 ? "" : fmt::format("-{}", sessions_));
  leaf_receiver_ = goes_on ? bone_.surface() : nullptr;
  leaf_watch_ = goes_on ? cut_watch() : nullptr;
  figures_ = {};
  cut_place_.Clear();
  shown_removed_mm3_ = 0;
  forces_.clear();
  fitted_ = fitted_ && goes_on;
  if (!goes_on) shown_place_.reset();
  LiveOptions live;
  live.record = recording_;
  live.scene_file = scene_file;
  live.leaf = [this, take = std::exchange(take_leaf_, nullptr)](const LeafMessage& leaf) {
    if (take) take(leaf);
    if (leaf_receiver_) leaf_receiver_->Offer(leaf);
    if (leaf_watch_) leaf_watch_->Offer(leaf.index, leaf.values);
  };
  live.tick = std::exchange(take_tick_, nullptr);
  live.scripted = options_.scripted;
  if (device_ && device_->holds()) live.device = &device_->servo();
  if (options_.link) options_.link->Show(scene.TitleOrName(), MakeToolLooks(MakeTool(scene)).whole);
  live.link = options_.link.get();
  live.begin = [this, goes_on, original = original_, with_hu = bone && bone->has_hu() ? bone : nullptr,
                file = scene.bone.source == BoneSource::kFile && !bone ? scene.bone.file : ""](
                   const Bone& made, const EffectPlan&) mutable {
    if (!goes_on) {
      auto shown = std::make_shared<Bone>(WithCtNumbers(made, file));
      if (with_hu && !shown->has_hu()) CopyHu(*shown, *with_hu);
      leaf_receiver_ = bone_.Show(std::move(shown), true, original.get());
    }
    with_hu.reset();
    if (!options_.watch || leaf_watch_) return;
    leaf_watch_ = std::make_shared<CutWatch>(original ? original : bone_at_start(), CopySharing(made));
    const std::lock_guard lock(mutex_);
    watch_ = leaf_watch_;
  };
  // A coarse bone is ready within a second; the final one takes longer.
  if (!goes_on && !bone && scene.bone.source == BoneSource::kMandible) {
    live.prepare = [this, coarse = MakeCoarse(scene)](const std::function<void(double)>& progress) {
      bone_.Show(std::make_shared<const Bone>(MakeSceneBone(coarse, progress)), false);
    };
  }
  live.bone = std::move(bone);
  trace_.Write("session", {{"recording", recording_}, {"tool", DescribeTool(scene.tool.shape)}});
  session_ = std::make_unique<LiveSession>(scene, std::move(live));
}

std::shared_ptr<CutWatch> ViewerApp::cut_watch() {
  const std::lock_guard lock(mutex_);
  return watch_;
}

void ViewerApp::End() {
  if (session_) session_->Stop();
}

std::optional<WorkProgress> ViewerApp::progress() const {
  if (!session_ || is_running()) return std::nullopt;
  return session_->progress();
}

bool ViewerApp::spindle_on() const {
  return session_ && session_->rpm() != 0;
}

bool ViewerApp::steers() const {
  return is_running() && activity_->cuts() && !options_.scripted && !session_->moves_saw();
}

bool ViewerApp::touches() const {
  return Touches(figures_.coupled);
}

void ViewerApp::SetSpindle(bool on) {
  if (!is_running() || on == spindle_on()) return;
  session_->SetSpindle(on ? session_->scene().tool.rpm : 0);
  trace_.Write("spindle", {{"on", on}});
}

void ViewerApp::FollowSession() {
  FollowBone();
  if (!session_) return;
  const LiveStage stage = session_->stage();
  if (stage == LiveStage::kRunning) {
    FollowRunning();
  } else if (stage == LiveStage::kEnded) {
    if (session_->cancelled()) {
      trace_.Write("cancelled", {{"recording", recording_}});
      --sessions_;
      session_.reset();
      activity_->Cancelled();
      return;
    }
    const std::string failure = session_->failure();
    if (!failure.empty()) {
      trace_.Write("ended", {{"failure", failure}, {"recording", recording_}});
      std::optional<LoopSummary> summary;
      if (session_->has_summary()) {
        figures_ = session_->figures();
        TakeForces();
        summary = session_->TakeSummary();
      }
      session_.reset();
      if (!activity_->TakeFailure(failure, summary ? &*summary : nullptr)) throw Error(failure);
      return;
    }
    figures_ = session_->figures();
    TakeForces();
    LoopSummary summary = session_->TakeSummary();
    trace_.Write("ended", {{"failure", ""},
                           {"recording", recording_},
                           {"ticks", summary.counts.ticks},
                           {"missed", summary.counts.missed},
                           {"scheduling", summary.grants.scheduling},
                           {"lateness_p50_us", summary.lateness.p50_us},
                           {"lateness_p99_us", summary.lateness.p99_us},
                           {"lateness_p999_us", summary.lateness.p999_us},
                           {"lateness_max_us", summary.lateness.max_us},
                           {"tick_p50_us", summary.tick.p50_us},
                           {"tick_p99_us", summary.tick.p99_us}});
    // The activity may have begun a new session; otherwise the ended one is removed.
    view_->SetForce(std::nullopt);
    view_->SetContact(std::nullopt);
    view_->SetGhost(std::nullopt);
    const LiveSession* over = session_.get();
    activity_->Ended(std::move(summary));
    if (session_.get() == over) session_.reset();
    if (quitting_ && !session_) done_ = true;
  }
}

void ViewerApp::TakeForces() {
  for (const ForceMoment& moment : session_->TakeForces()) {
    if (forces_.size() < kMaxForces) forces_.push_back({moment.time_s, moment.force_N});
  }
}

void ViewerApp::FollowRunning() {
  figures_ = session_->figures();
  if (!began_) {
    began_ = true;
    if (!goes_on_) controls_->Release();
    controls_->Continue(figures_.coupled.X_WT);  // a motion that was asked for, such as into a plane, goes on
    if (!X_home_ || !goes_on_) X_home_ = figures_.coupled.X_WT;
    const Tool tool = MakeTool(session_->scene());
    view_->SetTool(tool);
    holder_.SetTool(tool);
    X_holder_.reset();
    activity_->Began();
    view_->SetToolPose(figures_.coupled.X_WT, figures_.in.rpm, spin_rad_, figures_.coupled.displacement_mm);
    if (goes_on_ && IsSawOutside()) ShowSaw();  // another saw that begins at the place of the one before
    trace_.Write("running");
  }
  TakeForces();
  for (const LiveSession::Answer& answer : session_->TakeAnswers()) ShowAnswer(answer);
}

void ViewerApp::ShowAnswer(const LiveSession::Answer& answer) {
  using Kind = LoopAction::Kind;
  const Kind kind = answer.action.kind;
  if (kind == Kind::kSpindle) return;
  if (kind == Kind::kRetract) retracting_ = false;
  const char* what = kind == Kind::kUndo      ? Msg("Undone")
                     : kind == Kind::kRedo    ? Msg("Redone")
                     : kind == Kind::kRetract ? Msg("Retracted")
                                              : Msg("Checkpoint");
  trace_.Write("answer", {{"what", what}, {"name", answer.action.name}, {"failure", answer.failure}});
  if (!answer.failure.empty()) {
    std::string why = activity_->ExplainFailure(answer);
    if (!why.empty()) why[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(why[0])));
    return Say(why);
  }
  std::string text = answer.action.name.empty() ? Tr(what) : fmt::format("{}: {}", Tr(what), answer.action.name);
  if (answer.restored_mm3 && (kind == Kind::kUndo || kind == Kind::kRedo)) {
    text += " \u2013 " +
            fmt::format(fmt::runtime(kind == Kind::kUndo ? Tr("{} are bone again") : Tr("{} are cut out again")),
                        ShowVolume(*answer.restored_mm3));
  }
  Say(text);
  if (kind != Kind::kCheckpoint) figures_ = session_->figures();
}

void ViewerApp::FollowDevice(double dt_s) {
  const HandDeviceFrame frame = device_->Update(dt_s, MakeBasis(), figures_.coupled.X_WT, *controls_);
  for (const std::string& message : frame.messages) Say(message);
  for (const std::string& note : session_->TakeNotes()) Say(TrReport(note));
  if (frame.switches_spindle && steers()) SetSpindle(!spindle_on());
}

/// Finds out why the saw is held, and makes its sound.
void ViewerApp::FollowSaw(double dt_s) {
  const bool cuts = is_running() && began_ && activity_->cuts();
  sound_.SetSaw(cuts ? figures_.in.rpm : 0, glm::length(figures_.coupled.f_H_W_N));
  HeldSawInput in;
  if (began_ && steers() && !(device_ && device_->holds())) {
    in.tool = MakeTool(session_->scene());
    in.X_WT = figures_.coupled.X_WT;
    in.X_wanted = controls_->wanted();
    in.holds = controls_->holds();
    in.spindle_on = spindle_on();
    in.coupled = figures_.coupled;
    in.guide_force_N = figures_.guide_force_N;
    in.guide_normal_W = session_->guide_normal_W();
  }
  const std::optional<HeldReason> before = held_saw_.reason();
  held_saw_.Update(dt_s, in);
  if (held_saw_.reason() == before) return;
  trace_.Write("held", {{"reason", held_reason()}});
}

void ViewerApp::TurnSaw(std::vector<Pose> way) {
  turn_way_.assign(way.rbegin(), way.rend());
  TurnOn();
}

/// Begins the next part of the way.
void ViewerApp::TurnOn() {
  const Pose X_goal = turn_way_.back();
  turn_way_.pop_back();
  controls_->Set(X_goal);
  turn_.Begin(X_goal, CalcReach(MakeTool(session_->scene())));
}

/// Ends a turn of the saw. What waited for it follows, unless the turn failed.
void ViewerApp::FollowTurn(double dt_s) {
  using State = SawTurn::State;
  if (!is_running() || !began_ || activity_->is_restarting()) return;
  const State state = turn_.Update(dt_s, figures_.coupled.X_WT, controls_->has_goal());
  if (state == State::kNone || state == State::kTurning) return;
  if (state == State::kDone && !turn_way_.empty()) return TurnOn();
  // Nothing may pull the saw through bone on which it rests once the spindle turns.
  if (state == State::kStuck || (state == State::kDone && touches())) controls_->Release();
  if (state == State::kDone) return;
  const std::string dropped = ForgetWaiting();
  if (state == State::kInterrupted) return dropped.empty() ? void() : Say(dropped);
  const std::string stuck =
      Tr("The saw cannot turn into the plane, because bone is in its way. Bring it clear of the bone, then turn it "
         "again.");
  Warn(dropped.empty() ? stuck : fmt::format("{} {}", stuck, dropped));
}

/// Forgets the keys and clicks that wait, and returns a sentence on them; empty: none waited.
std::string ViewerApp::ForgetWaiting() {
  std::vector<std::string> names = actions_.ForgetChosen();
  for (const WindowEvent& event : std::exchange(waiting_, {})) {
    if (event.kind == WindowEvent::Kind::kKeyDown) {
      names.push_back(ShowShortcut({event.key, event.control, event.shift}));
    }
  }
  if (names.empty()) return {};
  return fmt::format(fmt::runtime(Tr("What you asked for meanwhile was not done: {}.")),
                     fmt::format("{}", fmt::join(names, ", ")));
}

bool ViewerApp::IsSawOutside() const {
  if (!began_ || !steers() || areas_.scene.empty()) return false;
  const ScreenBox tool = view_->CalcToolBox();
  const UiBox box{tool.left, tool.top, tool.width, tool.height};
  return box.empty() || !Overlap(box, areas_.scene);
}

/// Returns the message that stays while its cause lasts; empty: none.
std::string ViewerApp::DescribeStaying() const {
  if (std::string held = held_reason(); !held.empty()) return held;
  if (retracting_) return {};
  if (std::string holder = DescribeHolder(); !holder.empty() && !is_warning(holder)) return holder;
  if (slices_.is_enlarged() || !IsSawOutside()) return {};
  const std::string key = ShowShortcut(actions_.Find("saw.retract")->shortcut);
  return spindle_on()
             ? fmt::format(fmt::runtime(Tr("The saw is outside the picture: stop the spindle, then {} brings it back")),
                           key)
             : fmt::format(fmt::runtime(Tr("The saw is outside the picture: {} brings it back")), key);
}

/// Returns that what holds the blade is against or inside the bone while the saw is used; empty if it is not.
std::string ViewerApp::DescribeHolder() const {
  if (!options_.watch || !is_running() || !began_ || !activity_->cuts()) return {};
  if (figures_.holder_force_N) {
    constexpr double kFelt_N = 0.2;
    if (*figures_.hub_force_N > kFelt_N) {
      return Tr("The hub of the blade is on the bone and stops the blade: cut the rest from another side.");
    }
    if (*figures_.holder_force_N > kFelt_N) return Tr("The handpiece is against the bone: it has no room there.");
    return {};
  }
  if (holder_.hub_in_bone()) {
    return Tr(
        "The hub of the blade is inside the bone. Here it meets no resistance; in theatre it stops the blade: cut the "
        "rest from another side.");
  }
  if (holder_.handpiece_in_bone() && TouchesBone(figures_.coupled)) {
    return Tr("The handpiece is inside the bone. Here it meets no resistance; in theatre it has no room there.");
  }
  return {};
}

std::string ViewerApp::held_reason() const {
  if (!held_saw_.reason()) return "";
  // The depth stop of an exercise cannot be switched off.
  if (*held_saw_.reason() == HeldReason::kGuideDepth && actions_.Find("plan.guide") == nullptr) {
    return activity_->DescribeDepthStop();
  }
  return Tr(DescribeHeldReason(*held_saw_.reason()));
}

}  // namespace kerf
