#include "app/window/practice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <utility>

#include "app/window/cut_panel.h"
#include "app/window/is_ready.h"
#include "app/window/nerve_alarm.h"
#include "app/window/practice_widgets.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/plan/plan.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// The gauge asks the student to slow down from kSlow_mm before the goal on, and to stop from kStop_mm on.
constexpr double kSlow_mm = 1.0;
constexpr double kStop_mm = 0.3;

HudLevel LevelOf(double to_goal_mm) {
  return to_goal_mm < -kSlow_mm   ? HudLevel::kBad
         : to_goal_mm < -kStop_mm ? HudLevel::kWarn
         : to_goal_mm < kStop_mm  ? HudLevel::kGood
         : to_goal_mm < kSlow_mm  ? HudLevel::kWarn
                                  : HudLevel::kPlain;
}

/// Speed of the replay beside the expert, as a multiple of real time.
constexpr double kReplaySpeed = 1;

/// Returns the path of the score sheet next to a recording.
std::string PageOf(const std::string& recording) {
  return recording.substr(0, recording.rfind('.')) + ".html";
}

/// Returns the colour of the blade. The colours are distinguishable with red-green colour blindness.
Rgb8 ColourOf(HudLevel level) {
  switch (level) {
    case HudLevel::kGood:
      return {0, 158, 115};
    case HudLevel::kWarn:
      return {230, 159, 0};
    case HudLevel::kBad:
      return {170, 40, 60};
    default:
      return kSteelColour;
  }
}

}  // namespace

Practice::Practice(const PracticeOptions& options) : options_(options) {
  options_.viewer.ghost = false;  // the handle's picture would hide the blade's colour
  if (!options_.exercise.empty()) FindExercise(options_.exercise);
  if (!options_.student.empty()) {
    history_.emplace(FindHistoryFile());
    attempts_ = history_->List(options_.student);
  }
  viewer_ = std::make_unique<ViewerApp>(options_.viewer);
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

// ---- choosing

std::vector<ExerciseRow> Practice::MakeRows() const {
  return ListProgress(attempts_);
}

void Practice::Choose() {
  checks_.End();
  state_ = State::kChoosing;
  list_.emplace(MakeRows(), options_.student);
}

void Practice::TakeChoice(ExerciseList::Choice choice) {
  if (choice == ExerciseList::Choice::kName) return AskName();
  if (choice == ExerciseList::Choice::kStart) Start(std::string(list_->exercise()), list_->level());
}

void Practice::AskName() {
  viewer_->AskText(Tr("Your name, under which your attempts are stored:"), options_.student,
                   [this](const std::optional<std::string>& name) {
                     if (name && !name->empty()) UseName(*name);
                   });
}

/// Stores the attempts of the student from now on, and those that were made before without a name.
void Practice::UseName(const std::string& student) {
  try {
    CheckStudentName(student);
    if (!history_) history_.emplace(FindHistoryFile());
    for (const ScoreSheet& sheet : unnamed_) history_->Add(MakeAttempt(sheet, student));
    unnamed_.clear();
    attempts_ = history_->List(student);
  } catch (const Error& e) {
    return viewer_->Say(e.what());
  }
  options_.student = student;
  viewer_->trace().Write("student", {{"name", student}});
  if (state_ == State::kChoosing) return Choose();
  if (state_ != State::kResult) return;
  stored_ = fmt::format(fmt::runtime(Tr("The attempt is saved for {}")), student);
  next_ = Recommend(attempts_, exercise_->id, options_.level);
}

void Practice::Start(const std::string& id, int level) {
  checks_.End();
  list_.reset();
  exercise_ = &FindExercise(id);
  scene_ = MakeExerciseScene(id, level);
  if (scene_.exercise.depth_stop) {
    const WantedCut cut = MakeWantedCut(scene_.exercise, MakeTool(scene_));
    const DepthStop stop{.name = "goal", .p_W_mm = cut.start_W, .direction_W = cut.into_W, .depth_mm = cut.depth_mm};
    scene_.effects.push_back(MakeGuide(nullptr, &stop));
  }
  options_.level = level;
  gauge_.reset();
  nerve_.reset();
  sheet_.reset();
  review_.reset();
  pair_.reset();
  coach_ = {};
  scored_ = true;
  state_ = State::kCutting;
  meter_ = std::make_shared<SessionMeter>(scene_);
  track_ = std::make_shared<ToolTrack>();
  viewer_->set_take_tick([meter = meter_, track = track_](const LoopTick& tick) {
    meter->Take(tick);
    track->Take(tick);
  });
  viewer_->Begin(scene_, exercise_->file);
  recordings_.push_back(viewer_->recording());
}

// ---- cutting

void Practice::Began() {
  const std::shared_ptr<const Bone> bone = viewer_->bone_at_start();
  gauge_ = std::make_unique<DepthGauge>(*bone, MakeWantedCut(scene_.exercise, MakeTool(scene_)));
  deepest_mm_.assign(gauge_->columns().size(), -kAbove_mm);
  touched_at_.reset();
  making_nerve_ =
      std::async(std::launch::async, [bone] { return std::make_unique<RegionDistance>(*bone, Tissue::kCanal); });
  ShowGoal();
  // View from the side and a little from above, with the line across the picture. Motion is restricted to the blade's
  // plane, so that cuts are straight.
  const WantedCut& cut = gauge_->cut();
  const Vec3 side_W = glm::cross(cut.along_W, -cut.into_W);  // the line points to the right
  const Vec3 middle_W = cut.ToWorld({0.5 * cut.length_mm, 0, 0});
  // Look at the cut from outside the bone.
  const bool inside = glm::dot(side_W, middle_W - viewer_->bone_at_start()->CalcBounds().centre()) < -1;
  ViewCamera& camera = viewer_->view().camera();
  camera.Look((inside ? -side_W : side_W) - 0.6 * cut.into_W, -cut.into_W);
  viewer_->view().FitAll();
  camera.set_target_W(middle_W - 0.25 * cut.radius_mm * cut.into_W);
  camera.set_height_mm(std::min(camera.height_mm(), 3.2 * cut.radius_mm + cut.length_mm));
  viewer_->controls().set_in_blade_plane(true);
  begun_ = false;
}

void Practice::ShowGoal() {
  const WantedCut& cut = gauge_->cut();
  GuideOverlay line;
  line.points_W = {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})};
  viewer_->view().SetGuides({line});
  if (exercise_->toml.find("\"osteotomy\"") == std::string::npos) return viewer_->view().SetPlanes({});
  viewer_->view().SetPlanes({{.name = Tr("plan"),
                              .p_W = cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}),
                              .normal_W = cut.across_W,
                              .width_mm = cut.length_mm + 20,
                              .height_mm = cut.depth_mm + 20,
                              .up_W = -cut.into_W}});
}

void Practice::Finish(bool scored) {
  scored_ = scored;
  viewer_->sound().SetAlarm(AlarmKind::kDepth, std::nullopt);
  viewer_->SetSpindle(false);
  viewer_->End();
}

std::optional<DepthReading> Practice::Read() const {
  return gauge_ && viewer_->is_running() ? gauge_->Calc(viewer_->figures().coupled.X_WT) : std::nullopt;
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

/// Scores the session from what was measured while it ran; if ticks are missing, from its recording.
void Practice::Score(std::shared_ptr<const Bone> before, Bone after) {
  state_ = State::kScoring;
  scoring_ = std::async(std::launch::async,
                        [this, file = recordings_.back(), before = std::move(before), after = std::move(after),
                         meter = meter_, nerve = std::shared_ptr<const RegionDistance>(std::move(nerve_))] {
                          RecordingReader recording(file);
                          if (meter->is_complete() && recording.damage().state == RecordingState::kWhole) {
                            return meter->Score(recording, *before, after, nerve.get());
                          }
                          ScoreOptions score;
                          score.stop = &stop_scoring_;
                          return ScoreRecording(recording, score, [this](const std::string& stage, double fraction) {
                            const std::lock_guard lock(mutex_);
                            scoring_stage_ = stage;
                            scoring_fraction_ = fraction;
                          });
                        });
}

// ---- behind the result

void Practice::TakeChecks() {
  const ResultChecks::News news = checks_.Take();
  if (news.expert) viewer_->trace().Write("expert");
  if (news.verified) {
    viewer_->trace().Write("verified", {{"same", *checks_.verified()}});
    if (!*checks_.verified()) {
      viewer_->Say(Tr("The replay of the recording gives another score: compare it with 'kerf score'"));
    }
  }
  if (!news.failure.empty()) viewer_->Say(news.failure);
  if (wants_replay_ && checks_.expert() && state_ == State::kResult) Replay();
}

// ---- the attempt beside the expert's

void Practice::Replay() {
  if (!checks_.expert()) {
    wants_replay_ = true;
    return viewer_->Say(Tr("The expert's attempt is being computed; the replay begins as soon as it is ready"));
  }
  wants_replay_ = false;
  pair_ = MakeReplayPair(*track_, *checks_.expert(), *gauge_);
  replay_s_ = 0;
  state_ = State::kReplaying;
  const WantedCut& cut = gauge_->cut();
  viewer_->view().SetTool(MakeTool(scene_));
  viewer_->view().SetToolColour(kMadeColour);
  viewer_->view().SetGuides({{.points_W = {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})}}});
  viewer_->view().SetPlaneLines({{.lines_W = {pair_->student_line_W}, .colour = kMadeColour},
                                 {.lines_W = {pair_->expert_line_W}, .colour = kWantedColour}});
  UpdateReplay(0);
}

void Practice::EndReplay() {
  viewer_->view().ClearTool();
  viewer_->view().SetGhost({});
  viewer_->view().SetPlaneLines({});
  ShowGoal();
  state_ = State::kResult;
}

void Practice::UpdateReplay(double dt_s) {
  replay_s_ = std::min(replay_s_ + kReplaySpeed * dt_s, pair_->duration_s());
  const TrackPoint student = pair_->student.Calc(replay_s_);
  viewer_->view().SetToolPose(student.X_WT, student.rpm, 0);
  viewer_->view().SetGhost(pair_->expert.Calc(replay_s_).X_WT);
}

// ---- the result

void Practice::DrawResultDialog(Ui& ui) {
  const ResultContents contents{.title = Tr(exercise_->title.c_str()),
                                .level = options_.level,
                                .sheet = *sheet_,
                                .review = *review_,
                                .next = next_,
                                .verified = checks_.verified(),
                                .verification_failed = checks_.failed(),
                                .stored = stored_,
                                .asks_name = options_.student.empty() && !unnamed_.empty(),
                                .expert_ready = checks_.expert() != nullptr};
  switch (DrawResult(ui, contents)) {
    case ResultChoice::kNone:
      break;
    case ResultChoice::kStep:
      clicked_ = [this] { DoNextStep(); };
      break;
    case ResultChoice::kAgain:
      clicked_ = [this] { Start(exercise_->id, options_.level); };
      break;
    case ResultChoice::kNextLevel:
      clicked_ = [this] { Start(exercise_->id, options_.level + 1); };
      break;
    case ResultChoice::kReplay:
      clicked_ = [this] { Replay(); };
      break;
    case ResultChoice::kList:
      clicked_ = [this] { Choose(); };
      break;
    case ResultChoice::kName:
      clicked_ = [this] { AskName(); };
      break;
  }
}

void Practice::DoNextStep() {
  if (next_.kind == NextStep::Kind::kFinished) return Choose();
  Start(next_.exercise, next_.level);
}

// ---- events and frames

void Practice::AddActions(ActionList& actions) {
  actions.Add({.id = "exercise.finish",
               .menu = Msg("Exercise"),
               .label = Msg("Finish and see the score"),
               .shortcut = {Key::kEnter},
               .run = [this] { Finish(true); },
               .enabled = [this] { return state_ == State::kCutting && viewer_->is_running(); },
               .relevant = [this] { return state_ == State::kCutting; },
               .button = Msg("Finish")});
  actions.Add({.id = "exercise.leave",
               .menu = Msg("Exercise"),
               .label = Msg("Leave without a score"),
               .shortcut = {Key::kEscape},
               .run = [this] { Finish(false); },
               .enabled = [this] { return state_ == State::kCutting && viewer_->is_running(); }});
  const auto at_result = [this] { return state_ == State::kResult; };
  actions.Add({.id = "exercise.step",
               .menu = Msg("Exercise"),
               .label = Msg("Recommended next step"),
               .shortcut = {Key::kEnter},
               .run = [this] { DoNextStep(); },
               .enabled = at_result,
               .relevant = at_result,
               .button = Msg("Next step")});
  actions.Add({.id = "exercise.again",
               .menu = Msg("Exercise"),
               .label = Msg("Try again"),
               .shortcut = {Key::kA},
               .run = [this] { Start(exercise_->id, options_.level); },
               .enabled = at_result,
               .relevant = at_result,
               .button = Msg("Try again")});
  actions.Add({.id = "exercise.replay",
               .menu = Msg("Exercise"),
               .label = Msg("Watch the attempt beside the expert's"),
               .shortcut = {Key::kW},
               .run = [this] { Replay(); },
               .enabled = at_result,
               .relevant = at_result,
               .button = Msg("Watch")});
  actions.Add({.id = "exercise.restart_replay",
               .menu = Msg("Exercise"),
               .label = Msg("Watch from the beginning"),
               .shortcut = {Key::kEnter},
               .run = [this] { replay_s_ = 0; },
               .enabled = [this] { return state_ == State::kReplaying; }});
  actions.Add({.id = "exercise.end_replay",
               .menu = Msg("Exercise"),
               .label = Msg("Return to the result"),
               .shortcut = {Key::kEscape},
               .run = [this] { EndReplay(); },
               .enabled = [this] { return state_ == State::kReplaying; },
               .relevant = [this] { return state_ == State::kReplaying; },
               .button = Msg("Back to the result")});
  actions.Add({.id = "exercise.next",
               .menu = Msg("Exercise"),
               .label = Msg("Next level"),
               .shortcut = {Key::kN},
               .run = [this] { Start(exercise_->id, options_.level + 1); },
               .enabled = [this] { return state_ == State::kResult && options_.level < kLevels; }});
  actions.Add({.id = "exercise.list",
               .menu = Msg("Exercise"),
               .label = Msg("Other exercises"),
               .shortcut = {Key::kEscape},
               .run = [this] { Choose(); },
               .enabled = [this] { return state_ == State::kResult; }});
}

void Practice::Open(const std::string& /*path*/) {
  viewer_->Say(Tr("An exercise brings its own bone; use 'kerf rehearse' to open a file"));
}

bool Practice::Take(const WindowEvent& event) {
  const bool function_key = event.key >= Key::kF1 && event.key <= Key::kF12;
  if (!list_ || event.kind != WindowEvent::Kind::kKeyDown || event.control || function_key) return false;
  TakeChoice(list_->Take(event));
  return true;
}

void Practice::UpdateCutting() {
  const double limit_s = scene_.exercise.time_limit_s;
  if (limit_s > 0 && viewer_->figures().time_s > limit_s) {
    viewer_->Say(Tr("Time is up"));
    Finish(true);
  }
  const std::optional<DepthReading> reading = Read();
  const bool in_bone = reading && reading->depth_mm > 0;
  if (scene_.exercise.sound) {
    viewer_->sound().SetAlarm(AlarmKind::kDepth, in_bone ? std::optional(reading->to_goal_mm) : std::nullopt);
  }
  if (scene_.exercise.colour) {
    viewer_->view().SetToolColour(in_bone ? ColourOf(LevelOf(reading->to_goal_mm)) : kSteelColour);
  }
  const CoachInput input = MakeCoachInput();
  coach_ = UpdateCoach(coach_, gauge_->cut(), input);
  // The saw has also been between the places of two frames.
  constexpr double kStep_mm = 0.1;
  if (input.touches) {
    const Pose from = touched_at_.value_or(input.X_WT);
    const double steps = std::clamp(std::ceil(glm::distance(from.p_AB, input.X_WT.p_AB) / kStep_mm), 1.0, 100.0);
    for (int i = 1; i <= static_cast<int>(steps); ++i) {
      const double f = i / steps;
      gauge_->TakeDepths(
          {glm::normalize(glm::slerp(from.R_AB, input.X_WT.R_AB, f)), glm::mix(from.p_AB, input.X_WT.p_AB, f)},
          deepest_mm_);
    }
  }
  touched_at_ = input.touches ? std::optional(input.X_WT) : std::nullopt;
}

void Practice::AddAlarms(std::vector<AlarmOverlay>& alarms) {
  std::optional<AlarmOverlay> nerve =
      MakeNerveAlarm(viewer_->bone(), nerve_.get(), MakeTool(scene_), viewer_->figures().coupled.X_WT);
  if (nerve) alarms.push_back(std::move(*nerve));
}

CoachInput Practice::MakeCoachInput() const {
  const LiveFigures& figures = viewer_->figures();
  CoachInput input;
  input.time_s = figures.time_s;
  input.X_WT = figures.coupled.X_WT;
  input.depth = Read();
  // The canal is to be spared only in some exercises.
  const bool spares = IsMeaningful(FindMeasure("nerve_distance_mm"), scene_.exercise.kind);
  if (spares && nerve_ && !nerve_->empty() && viewer_->spindle_on()) {
    input.nerve_mm = nerve_->Calc(MakeTool(scene_), input.X_WT);
  }
  input.touches = figures.coupled.engaged_teeth > 0 || glm::length(figures.coupled.f_face_W_N) > 0;
  return input;
}

std::optional<CoachLine> Practice::MakeCoach() const {
  // The last level has no aids.
  if (state_ != State::kCutting || !viewer_->is_running() || !gauge_ || !scene_.exercise.gauge) return {};
  return MakeCoachLine(coach_, gauge_->cut(), MakeCoachInput());
}

std::optional<Message> Practice::MakeStep() const {
  if (state_ != State::kCutting || !viewer_->is_running() || !gauge_ || scene_.exercise.level > 1) return {};
  const double done = CalcLineDone(*gauge_, deepest_mm_);
  return DescribeStep(FindStep(MakeCoachInput(), viewer_->spindle_on(), done), gauge_->cut(), done);
}

std::vector<Aid> Practice::MakeAids() const {
  return ListAids(scene_.exercise, viewer_->controls().in_blade_plane(), viewer_->view().translucent());
}

void Practice::Update(double dt_s) {
  if (const auto clicked = std::exchange(clicked_, nullptr)) clicked();
  if (IsReady(making_nerve_)) nerve_ = making_nerve_.get();
  if (state_ == State::kCutting && viewer_->is_running()) UpdateCutting();
  if (state_ == State::kReplaying) UpdateReplay(dt_s);
  TakeChecks();
  if (IsReady(scoring_)) TakeSheet();
}

void Practice::TakeSheet() {
  try {
    sheet_ = scoring_.get();
    WriteTextFile(PageOf(recordings_.back()), FormatSheetHtml(*sheet_));
  } catch (const Error& e) {
    viewer_->Say(e.what());
    if (!sheet_) return Choose();
  }
  review_ = MakeReview(*sheet_);
  SaveAttempt();
  next_ = Recommend(attempts_, exercise_->id, options_.level);
  state_ = State::kResult;
  viewer_->trace().Write("score", {{"total", sheet_->total ? nlohmann::json(*sheet_->total) : nullptr},
                                   {"headline", FormatMessage(review_->headline)},
                                   {"next_exercise", next_.exercise},
                                   {"next_level", next_.level},
                                   {"sheet", nlohmann::json(SheetJson(*sheet_))}});
  wants_replay_ = false;
  checks_.Begin(scene_, recordings_.back(), *sheet_);
}

/// Adds the attempt to the history and to what the recommendations consider.
void Practice::SaveAttempt() {
  if (sheet_->Get("removed_mm3").value_or(0) <= 0) {
    stored_ = Tr("Nothing was cut, so the attempt is not saved");
    return viewer_->Say(stored_);
  }
  Attempt attempt;
  attempt.exercise = exercise_->id;
  attempt.level = options_.level;
  attempt.total = sheet_->total;
  attempt.incomplete = fmt::format("{}", fmt::join(sheet_->incomplete, "; "));
  attempts_.push_back(attempt);
  if (!history_) {
    unnamed_.push_back(*sheet_);
    stored_ = Tr("The attempt is not saved, because no name was entered.");
    return;
  }
  try {
    history_->Add(MakeAttempt(*sheet_, options_.student));
    stored_ = fmt::format(fmt::runtime(Tr("The attempt is saved for {}")), options_.student);
  } catch (const Error& e) {
    stored_ = fmt::format(fmt::runtime(Tr("Not saved: {}; use 'kerf practise --hand-in {}' later")), e.what(),
                          recordings_.back());
  }
  viewer_->Say(stored_);
}

HudGauge Practice::MakeGauge(const std::optional<DepthReading>& reading) const {
  HudGauge gauge;
  gauge.title = Tr("Depth");
  gauge.upper = scene_.exercise.depth_mm + 1.8 * kSlow_mm;
  gauge.good = kStop_mm;
  gauge.warn = kSlow_mm;
  gauge.goal = scene_.exercise.depth_mm;
  if (!reading) return gauge;
  gauge.value = reading->depth_mm;
  gauge.level = LevelOf(reading->to_goal_mm);
  gauge.word = reading->depth_mm < 0             ? Tr("above the bone")
               : reading->to_goal_mm < -kStop_mm ? Tr("too deep")
               : reading->to_goal_mm < kStop_mm  ? Tr("stop: deep enough")
               : reading->to_goal_mm < kSlow_mm  ? Tr("slow down")
                                                 : Tr("continue");
  return gauge;
}

void Practice::Fill(HudState& hud) {
  hud.status.mode = exercise_ != nullptr && state_ != State::kChoosing
                        ? fmt::format(fmt::runtime(Tr("{}, level {}")), Tr(exercise_->title.c_str()), options_.level)
                        : Tr("Practise");
  if (state_ == State::kCutting && viewer_->is_running()) FillCutting(hud);
  if (state_ == State::kScoring) {
    const std::lock_guard lock(mutex_);
    hud.progress =
        HudProgress{.title = Tr("Scoring"), .stage = Tr(scoring_stage_.c_str()), .fraction = scoring_fraction_};
  }
  if (state_ == State::kReplaying) {
    const std::optional<DepthReading> reading = gauge_->Calc(pair_->student.Calc(replay_s_).X_WT);
    hud.gauge = MakeGauge(reading);
    hud.banner = HudBanner{
        .kind = HudBanner::Kind::kNotice,
        .text = fmt::format(fmt::runtime(Tr("Your saw is orange, the expert's is blue: {:.0f} s of {:.0f} s")),
                            replay_s_, pair_->duration_s()),
        .answers = Tr("Enter: from the beginning   Esc: back to the result")};
  }
}

void Practice::DrawSections(Ui& ui) {
  if (state_ == State::kCutting && viewer_->is_running()) DrawAids(ui, MakeAids());
}

void Practice::DrawWindows(Ui& ui) {
  if (state_ == State::kChoosing && list_) {
    const ExerciseList::Choice choice = list_->Draw(ui);
    if (choice != ExerciseList::Choice::kNone) clicked_ = [this, choice] { TakeChoice(choice); };
  }
  if (state_ == State::kResult && sheet_ && review_) DrawResultDialog(ui);
  if (state_ != State::kReplaying) return;
  const UiBox scene = CalcUiAreas(ui, false, false).scene;
  switch (DrawReplay(ui, *pair_, scene_.exercise.depth_mm, replay_s_, scene)) {
    case ReplayChoice::kNone:
      break;
    case ReplayChoice::kRestart:
      clicked_ = [this] { replay_s_ = 0; };
      break;
    case ReplayChoice::kBack:
      clicked_ = [this] { EndReplay(); };
      break;
  }
}

void Practice::FillCutting(HudState& hud) {
  const std::optional<DepthReading> reading = Read();
  // Without the gauge the depth is not shown either.
  if (scene_.exercise.gauge) {
    hud.gauge = MakeGauge(reading);
    if (reading) hud.values.depth_mm = reading->depth_mm;
  }
  hud.values.nerve_is_marked = !nerve_ || !nerve_->empty();
  if (nerve_ && !nerve_->empty()) {
    hud.values.nerve_mm = nerve_->Calc(MakeTool(scene_), viewer_->figures().coupled.X_WT);
  }
  begun_ = begun_ || viewer_->spindle_on();
  if (!begun_) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                           .text = Translate(exercise_->goal_message),
                           .answers = Tr("Space: spindle   Arrows or left drag: move   Enter: finish   F1: help")};
  } else if (const std::optional<CoachLine> line = MakeCoach()) {
    hud.banner = HudBanner{.kind = line->urgent ? HudBanner::Kind::kWarning : HudBanner::Kind::kNotice,
                           .text = Translate(line->message),
                           .answers = ""};
  } else if (const std::optional<Message> step = MakeStep()) {
    hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                           .text = Translate(*step),
                           .answers = Tr("Space: spindle   Arrows or left drag: move   Enter: finish")};
  }
  const double limit_s = scene_.exercise.time_limit_s;
  if (limit_s > 0) {
    hud.status.right =
        fmt::format(fmt::runtime(Tr("{:.0f} s left")), std::max(0.0, limit_s - viewer_->figures().time_s));
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
  if (list_) state["menu"] = list_->title();
  if (const std::optional<DepthReading> reading = Read()) {
    state["depth_mm"] = std::round(100 * reading->depth_mm) / 100;
    state["to_goal_mm"] = std::round(100 * reading->to_goal_mm) / 100;
  }
  if (const std::optional<CoachLine> line = MakeCoach()) state["coach"] = FormatMessage(line->message);
  if (const std::optional<Message> step = MakeStep()) state["step"] = FormatMessage(*step);
  if (state_ == State::kReplaying) state["replay_s"] = replay_s_;
}

}  // namespace kerf
