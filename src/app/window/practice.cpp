#include "app/window/practice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <type_traits>
#include <utility>

#include "app/window/cut_panel.h"
#include "app/window/is_ready.h"
#include "app/window/practice_widgets.h"
#include "kerf/error.h"
#include "session/plan/plan.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Stiffness of the depth stop. That of a guide in the hand, 5 N/mm, would give way by some tenths of a millimetre,
/// which cost points.
constexpr double kStopStiffness_N_per_mm = 200;
/// Force above which the stop gives way, far above what a hand exerts.
constexpr double kStopForce_N = 100;
/// Step of the arrow keys in a replay.
constexpr double kSeek_s = 0.5;

/// Returns the values of parameters that have a Describe(), in its order.
template <typename Params>
std::vector<double> ListValues(Params params) {
  std::vector<double> values;
  Describe(params, [&values](const char*, const auto& value, const auto&...) {
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(value)>>) {
      values.push_back(static_cast<double>(value));
    } else {
      for (int i = 0; i < value.length(); ++i) values.push_back(value[i]);  // a vector or a quaternion
    }
  });
  return values;
}

/// Returns true if two exercises have the same bone, so that it need not be made again.
bool IsSameModel(const SceneBone& a, const SceneBone& b) {
  if (a.source != b.source || a.materials != b.materials) return false;
  switch (a.source) {
    case BoneSource::kMandible:
      return ListValues(a.mandible) == ListValues(b.mandible);
    case BoneSource::kBlock:
    case BoneSource::kPlate:
      return ListValues(a.block) == ListValues(b.block) &&
             std::equal(a.block.layers.begin(), a.block.layers.end(), b.block.layers.begin(), b.block.layers.end(),
                        [](const MaterialLayer& x, const MaterialLayer& y) { return ListValues(x) == ListValues(y); });
    case BoneSource::kFile:
      break;
  }
  return false;  // the file may have changed
}

}  // namespace

Practice::Practice(const PracticeOptions& options) : options_(options) {
  options_.viewer.ghost = false;  // the handle's picture would hide the blade's colour
  options_.viewer.watch = true;
  if (!options_.exercise.empty()) options_.exercise = opened_.emplace_back(OpenExercise(options_.exercise)).id;
  const std::string student = std::exchange(options_.student, "");
  if (!student.empty()) {
    history_.emplace(FindHistoryFile());
    attempts_ = history_->List(student);
  }
  viewer_ = std::make_unique<ViewerApp>(options_.viewer);
  // The student of the last session goes on, unless another one is named.
  if (!student.empty()) {
    UseName(student);
  } else if (!viewer_->settings().student.empty() && !options_.viewer.scripted) {
    UseName(viewer_->settings().student);
  }
}

Practice::~Practice() {
  stop_scoring_ = true;
}

std::vector<std::string> Practice::Run() {
  if (options_.exercise.empty()) {
    Choose();
  } else {
    Start(options_.exercise, options_.level);
  }
  viewer_->Run(*this);
  return recordings_;
}

std::vector<ExerciseRow> Practice::MakeRows() const {
  std::vector<ExerciseRow> rows = ListProgress(attempts_);
  for (const Exercise& opened : opened_) {
    ExerciseRow row = MakeProgress(attempts_, opened);
    const auto same = std::find_if(rows.begin(), rows.end(), [&](const ExerciseRow& r) { return r.id == row.id; });
    if (same == rows.end()) {
      rows.push_back(std::move(row));
    } else {
      *same = std::move(row);
    }
  }
  return rows;
}

/// Returns the exercise of a file that was opened, or a built-in one.
const Exercise& Practice::Find(const std::string& id) const {
  const auto opened = std::find_if(opened_.begin(), opened_.end(), [&](const Exercise& e) { return e.id == id; });
  return opened != opened_.end() ? *opened : FindExercise(id);
}

void Practice::Choose() {
  checks_.End();
  state_ = State::kChoosing;
  HideGoal();
  std::vector<ExerciseRow> rows = MakeRows();
  NextStep next = FindNextStep(attempts_);
  viewer_->trace().Write("recommended", {{"exercise", next.exercise}, {"level", next.level}});
  list_.emplace(std::move(rows), options_.student, std::move(next));
  viewer_->RestartTour();
}

void Practice::TakeChoice(ExerciseList::Choice choice) {
  if (choice == ExerciseList::Choice::kName) return AskName();
  if (choice == ExerciseList::Choice::kStart) Start(std::string(list_->exercise()), list_->level());
}

void Practice::AskName() {
  viewer_->AskText(Tr("Your name, under which your attempts are stored:"), options_.student,
                   [this](const std::optional<std::string>& name) {
                     const std::string student = TrimStudentName(name.value_or(""));
                     if (!student.empty()) UseName(student);
                   });
  viewer_->dialogs().CheckText([](const std::string& name) -> std::string {
    const std::string student = TrimStudentName(name);
    try {
      if (!student.empty()) CheckStudentName(student);
    } catch (const Error&) {
      return Tr("This name cannot be stored: it is too long, or contains characters that cannot be shown.");
    }
    return "";
  });
  try {
    // A history that does not exist is not made before it is needed.
    if (!history_ && !std::filesystem::exists(FindHistoryFile())) return;
    if (!history_) history_.emplace(FindHistoryFile());
    viewer_->dialogs().OfferTexts(Tr("Or choose who has practised here before:"), ListStudents(history_->List()));
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
}

/// Stores the attempts of the student from now on, and those that were made before without a name.
void Practice::UseName(const std::string& entered) {
  std::string student;
  try {
    CheckStudentName(entered);
    if (!history_) history_.emplace(FindHistoryFile());
    student = FindSameStudent(history_->List(), entered);
    for (const ScoreSheet& sheet : unnamed_) history_->Add(MakeAttempt(sheet, student));
    unnamed_.clear();
    attempts_ = history_->List(student);
  } catch (const Error& e) {
    return viewer_->Say(e.what());
  }
  options_.student = student;
  if (student != entered) {
    viewer_->Say(fmt::format(fmt::runtime(Tr("Your attempts are stored with the earlier ones of {}")), student));
  }
  if (viewer_->settings().student != student) {
    viewer_->settings().student = student;
    viewer_->KeepSettings();
  }
  viewer_->trace().Write("student", {{"name", student}});
  if (state_ == State::kChoosing && list_) return Choose();
  if (state_ != State::kResult) return;
  stored_ = [student] { return fmt::format(fmt::runtime(Tr("The attempt is saved for {}")), student); };
  next_ = Recommend(attempts_, *exercise_, options_.level, sheet_->total);
}

void Practice::Start(const std::string& id, int level) {
  checks_.End();
  viewer_->EndTourStep("choose");
  list_.reset();
  exercise_ = &Find(id);
  scene_ = MakeExerciseScene(*exercise_, level);
  if (scene_.exercise.depth_stop) {
    const WantedCut cut = MakeWantedCut(scene_.exercise, MakeTool(scene_));
    const DepthStop stop{.name = "goal", .p_W_mm = cut.start_W, .direction_W = cut.into_W, .depth_mm = cut.depth_mm};
    EffectChoice guide = MakeGuide(nullptr, &stop);
    // The mouse's hand presses with up to 8.4 N.
    guide.Set("stiffness_N_per_mm", kStopStiffness_N_per_mm);
    guide.Set("max_force_N", kStopForce_N);
    scene_.effects.push_back(std::move(guide));
  }
  options_.level = level;
  cuts_.clear();
  gauges_.clear();
  current_ = 0;
  nerve_.reset();
  sheet_.reset();
  review_.reset();
  pair_.reset();
  coach_ = {};
  report_.reset();
  scored_ = true;
  state_ = State::kCutting;
  meter_ = std::make_shared<SessionMeter>(scene_);
  track_ = std::make_shared<ToolTrack>();
  film_ = std::make_shared<CutFilm>();
  viewer_->set_take_tick([meter = meter_, track = track_, film = film_](const LoopTick& tick) {
    meter->Take(tick);
    track->Take(tick);
    film->set_time_s(tick.time_s);
  });
  viewer_->set_take_leaf([film = film_](const LeafMessage& leaf) { film->Take(leaf.index, leaf.values); });
  HideGoal();  // of another exercise, while the bone of this one is made
  const bool same = kept_bone_ && IsSameModel(kept_source_, scene_.bone);
  if (same) {
    viewer_->ShowUncut();
    viewer_->controls().Release();
  } else {
    kept_bone_.reset();
    viewer_->bone().Clear();
  }
  viewer_->trace().Write("exercise", {{"id", id}, {"level", level}, {"bone_is_kept", same}});
  viewer_->Begin(scene_, exercise_->file, same, kept_bone_);
  recordings_.push_back(viewer_->recording());
}

void Practice::Finish(bool scored) {
  scored_ = scored;
  viewer_->sound().SetAlarm(AlarmKind::kDepth, std::nullopt);
  viewer_->SetSpindle(false);
  viewer_->End();
}

void Practice::AskToFinish(bool scored) {
  if (scored ? IsFinished() : !(viewer_->figures().removed_mm3 > 0)) return Finish(scored);
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  // The attempt may end by its time limit before the question is answered.
  const auto finish = [this, session = viewer_->sessions()](bool with_score) {
    return [this, session, with_score] {
      if (state_ == State::kCutting && viewer_->is_running() && viewer_->sessions() == session) Finish(with_score);
    };
  };
  if (scored) {
    viewer_->dialogs().Ask(
        Tr("Too little of the wanted cut is made for a score, and the time runs on. If you finish now, the attempt is "
           "stored as unfinished."),
        {{Tr("Finish without a score"), finish(true)}, {Tr("Go on"), nullptr}});
    return viewer_->dialogs().IgnoreEnter();  // which has just started the attempt, perhaps
  }
  viewer_->dialogs().Ask(
      Tr("The attempt is not finished, and its time runs on. If you leave it, it is not scored and not saved."),
      {{Tr("Finish and see the score"), finish(true)}, {Tr("Leave it"), finish(false)}, {Tr("Go on"), nullptr}});
}

std::string Practice::DescribeUnsaved() const {
  const bool unfinished = state_ == State::kCutting && viewer_->is_running() && viewer_->figures().removed_mm3 > 0;
  return unfinished
             ? Tr("The attempt is not finished, and its time runs on. If you quit, it is not scored and not saved.")
             : "";
}

std::string Practice::save_label() const {
  return Tr("Finish and see the score");
}

void Practice::Ended(LoopSummary summary) {
  viewer_->sound().SetAlarm(AlarmKind::kDepth, std::nullopt);
  viewer_->view().ClearTool();
  viewer_->view().SetAlarms({});
  if (viewer_->quitting()) return;
  if (scored_) {
    Score(viewer_->bone_at_start(), std::move(summary.after));
  } else {
    Choose();
  }
}

void Practice::Cancelled() {
  recordings_.pop_back();
  if (!viewer_->quitting()) Choose();
}

void Practice::Open(const std::string& path) {
  if (std::filesystem::path(path).extension() != ".toml") {
    return viewer_->Say(
        Tr("Only scenes with an exercise (.toml) can be opened here; use 'kerf rehearse' to open a bone or a CT"));
  }
  if (state_ == State::kCutting || state_ == State::kScoring) {
    return viewer_->Say(Tr("Finish or leave the exercise before you open another one"));
  }
  try {
    Exercise exercise = ReadExercise(path);
    std::erase_if(opened_, [&](const Exercise& e) { return e.id == exercise.id; });
    opened_.push_back(std::move(exercise));
  } catch (const Error& e) {
    return viewer_->dialogs().Ask(TrMade(e.what()), {{Tr("OK"), nullptr}});
  }
  if (state_ == State::kReplaying) EndReplay();
  Start(opened_.back().id, 1);
}

bool Practice::Take(const WindowEvent& event) {
  const bool seeks = event.key == Key::kLeft || event.key == Key::kRight;
  if (state_ == State::kReplaying && event.kind == WindowEvent::Kind::kKeyDown && seeks) {
    SeekReplay(replay_s_ + (event.key == Key::kLeft ? -kSeek_s : kSeek_s));
    return true;
  }
  const bool function_key = event.key >= Key::kF1 && event.key <= Key::kF12;
  if (!list_ || event.kind != WindowEvent::Kind::kKeyDown || event.control || function_key) return false;
  TakeChoice(list_->Take(event));
  return true;
}

void Practice::Update(double dt_s) {
  if (const auto clicked = std::exchange(clicked_, nullptr)) clicked();
  if (IsReady(making_nerve_)) {
    nerve_ = making_nerve_.get();
    crosses_nerve_ = nerve_->CalcFrom(cuts_) <= 0;
  }
  if (state_ == State::kCutting && viewer_->is_running()) UpdateCutting();
  if (state_ == State::kReplaying) UpdateReplay(dt_s);
  if (wants_replay_) waits_s_ += dt_s;
  TakeChecks();
  if (IsReady(scoring_)) TakeSheet();
}

void Practice::Fill(HudState& hud) {
  hud.status.mode = exercise_ != nullptr && state_ != State::kChoosing
                        ? fmt::format(fmt::runtime(Tr("{}, level {}")), Tr(exercise_->title.c_str()), options_.level)
                        : Tr("Practise");
  if (exercise_ != nullptr && state_ != State::kChoosing) {
    hud.status.short_mode = exercise_->difficulty > 0 ? fmt::format(fmt::runtime(Tr("exercise {}, level {}")),
                                                                    exercise_->difficulty, options_.level)
                                                      : fmt::format(fmt::runtime(Tr("level {}")), options_.level);
    const std::string saw = TrMade(DescribeTool(scene_.tool.shape));
    hud.status.short_saw = saw.substr(0, saw.find(", "));  // "disc 22 x 0.25 mm"
  }
  if (state_ == State::kCutting && viewer_->is_running()) FillCutting(hud);
  if (state_ == State::kScoring) {
    const std::lock_guard lock(mutex_);
    hud.progress =
        HudProgress{.title = Tr("Scoring"), .stage = Tr(scoring_stage_.c_str()), .fraction = scoring_fraction_};
  }
  if (state_ == State::kReplaying) {
    const std::optional<DepthReading> reading = gauge().Calc(pair_->student.Calc(replay_s_).X_WT);
    const CoachState depth{.zone = reading ? FindDepthZone(*reading) : DepthZone::kAbove};
    hud.gauge = MakeGauge(reading, MakeDepthAdvice(depth, false));
    hud.banner = HudBanner{
        .kind = HudBanner::Kind::kNotice,
        .text = Tr("Orange: your saw and its path. Blue: those of the expert."),
        .answers = replay_runs_
                       ? Tr("Space: pause   Left, Right: back, forward   Enter: from the beginning   Esc: result")
                       : Tr("Space: go on   Left, Right: back, forward   Enter: from the beginning   Esc: result")};
  }
}

void Practice::DrawSections(Ui& ui) {
  if (state_ != State::kCutting || !viewer_->is_running()) return;
  if (IsPlanned() && report_) DrawCrossed(ui, *report_);
  DrawAids(ui, MakeAids());
}

void Practice::DrawWindows(Ui& ui) {
  if (state_ == State::kChoosing && list_) {
    const ExerciseList::Choice choice = list_->Draw(ui);
    if (choice != ExerciseList::Choice::kNone) clicked_ = [this, choice] { TakeChoice(choice); };
  }
  if (state_ == State::kResult && sheet_ && review_) DrawResultDialog(ui);
  if (state_ != State::kReplaying) return;
  const UiBox scene = CalcUiAreas(ui, false, false).scene;
  const double counted_s = sheet_->Get("time_total_s").value_or(0);
  replay_box_ = CalcReplayBox(ui, *pair_, counted_s, scene);
  double chosen_s = replay_s_;
  const ReplayChoice choice = DrawReplay(ui, *pair_, cut().depth_mm, counted_s, replay_runs_, chosen_s, scene);
  if (chosen_s != replay_s_) clicked_ = [this, chosen_s] { SeekReplay(chosen_s); };
  switch (choice) {
    case ReplayChoice::kNone:
      break;
    case ReplayChoice::kRestart:
      clicked_ = [this] { RestartReplay(); };
      break;
    case ReplayChoice::kPause:
      clicked_ = [this] { PauseReplay(); };
      break;
    case ReplayChoice::kBack:
      clicked_ = [this] { EndReplay(); };
      break;
  }
}

void Practice::Describe(nlohmann::json& state) const {
  state["mode"] = state_ == State::kChoosing  ? "choosing"
                  : state_ == State::kCutting ? "cutting"
                  : state_ == State::kScoring ? "scoring"
                  : state_ == State::kResult  ? "result"
                                              : "replaying";
  state["exercise"] = exercise_ != nullptr ? exercise_->id : "";
  state["level"] = options_.level;
  if (!gauges_.empty()) {
    state["cut"] = current_ + 1;
    state["cuts_made"] = CountMade();
  }
  if (list_) state["menu"] = list_->title();
  if (const std::optional<DepthReading> reading = Read()) {
    state["depth_mm"] = std::round(100 * reading->depth_mm) / 100;
    state["to_goal_mm"] = std::round(100 * reading->to_goal_mm) / 100;
  }
  if (state_ == State::kCutting && viewer_->is_running()) state["elapsed_s"] = std::round(10 * CalcElapsed_s()) / 10;
  if (const std::optional<CoachLine> line = MakeCoach()) {
    state["coach"] = FormatMessage(line->message);
    if (line->way) state["way"] = FormatMessage(*line->way);
  }
  if (const std::optional<StepLine> step = MakeStep()) {
    state["step"] = FormatMessage(step->message);
    if (step->way) state["step_way"] = FormatMessage(*step->way);
  }
  if (feed_mm_per_s_) state["feed_mm_per_s"] = std::round(100 * *feed_mm_per_s_) / 100;
  if (state_ == State::kReplaying) {
    state["replay_s"] = replay_s_;
    state["replay_runs"] = replay_runs_;
  }
}

}  // namespace kerf
