// The score of an attempt, its result, and the attempt beside that of the expert.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "app/window/cut_panel.h"
#include "app/window/practice.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Speed of the replay beside the expert, as a multiple of real time.
constexpr double kReplaySpeed = 1;

/// Returns the path of the score sheet next to a recording.
std::string PageOf(const std::string& recording) {
  return recording.substr(0, recording.rfind('.')) + ".html";
}

/// Returns the outline of a tool with a cross at its origin.
std::vector<std::vector<Vec3>> MakeOutline(const Pose& X_WT, const WantedCut& cut) {
  constexpr int kPoints = 72;
  const bool blade = cut.form == ToolForm::kBlade;
  const Vec3 x_W = blade ? X_WT.Vector({1, 0, 0}) : cut.along_W;
  const Vec3 y_W = blade ? X_WT.Vector({0, 1, 0}) : cut.into_W;
  std::vector<Vec3> outline_W;
  for (const Vec3& stw : cut.CalcOutline(X_WT, kPoints)) outline_W.push_back(cut.ToWorld(stw));
  outline_W.push_back(outline_W.front());
  const double arm_mm = 0.15 * cut.radius_mm;
  return {std::move(outline_W),
          {X_WT.p_AB - arm_mm * x_W, X_WT.p_AB + arm_mm * x_W},
          {X_WT.p_AB - arm_mm * y_W, X_WT.p_AB + arm_mm * y_W}};
}

/// Returns that what holds the tool was inside the bone; empty: it was not.
std::string DescribeHolderOf(const HolderPlaces& places) {
  if (places.hub_W) {
    return Tr("The hub of the blade was inside the bone. Here it met no resistance; in theatre it stops the blade.");
  }
  if (places.handpiece_W) {
    return Tr("The handpiece was inside the bone. Here it met no resistance; in theatre it has no room there.");
  }
  return {};
}

}  // namespace

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
  next_ = Recommend(attempts_, *exercise_, options_.level, sheet_->total);
  state_ = State::kResult;
  viewer_->EndTourStep("result");
  nlohmann::json figures = nlohmann::json::array();
  for (const ReviewFigure& figure : review_->figures) figures.push_back(figure.info->key);
  viewer_->trace().Write("score", {{"total", sheet_->total ? nlohmann::json(*sheet_->total) : nullptr},
                                   {"headline", FormatMessage(review_->headline)},
                                   {"nerve", review_->nerve ? FormatMessage(*review_->nerve) : ""},
                                   {"figures", std::move(figures)},
                                   {"next_exercise", next_.exercise},
                                   {"next_level", next_.level},
                                   {"sheet", nlohmann::json(SheetJson(*sheet_))}});
  wants_replay_ = false;
  checks_.Begin(scene_, recordings_.back(), *sheet_);
}

/// Adds the attempt to the history and to what the recommendations consider.
void Practice::SaveAttempt() {
  if (sheet_->Get("removed_mm3").value_or(0) <= 0) {
    stored_ = [] { return std::string(Tr("Nothing was cut, so the attempt is not saved")); };
    return viewer_->Say(stored_());
  }
  Attempt attempt;
  attempt.exercise = exercise_->id;
  attempt.level = options_.level;
  attempt.total = sheet_->total;
  attempt.incomplete = fmt::format("{}", fmt::join(sheet_->incomplete, "; "));
  attempts_.push_back(attempt);
  if (!history_) {
    unnamed_.push_back(*sheet_);
    stored_ = [] { return std::string(Tr("The attempt is not saved, because no name was entered.")); };
    return;
  }
  try {
    history_->Add(MakeAttempt(*sheet_, options_.student));
    stored_ = [student = options_.student] {
      return fmt::format(fmt::runtime(Tr("The attempt is saved for {}")), student);
    };
  } catch (const Error& e) {
    stored_ = [why = std::string(e.what()), recording = recordings_.back()] {
      return fmt::format(fmt::runtime(Tr("Not saved: {}; use 'kerf practise --hand-in {}' later")), why, recording);
    };
  }
  viewer_->Say(stored_());
}

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

void Practice::DrawResultDialog(Ui& ui) {
  const ResultContents contents{
      .title = Tr(exercise_->title.c_str()),
      .level = options_.level,
      .sheet = *sheet_,
      .review = *review_,
      .next = next_,
      .verified = checks_.verified(),
      .verification_failed = checks_.failed(),
      // Bone that meets what holds the tool keeps it out.
      .holder = viewer_->figures().holder_force_N ? "" : DescribeHolderOf(viewer_->holder_places()),
      .stored = stored_ ? stored_() : "",
      .asks_name = options_.student.empty() && !unnamed_.empty(),
      .expert_ready = checks_.expert() != nullptr,
      .waits_s = wants_replay_ && !checks_.failed() ? std::optional(waits_s_) : std::nullopt};
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

void Practice::Replay() {
  if (!checks_.expert()) {
    if (!std::exchange(wants_replay_, true)) waits_s_ = 0;
    return viewer_->Say(Tr("The expert's attempt is being computed; the replay begins as soon as it is ready"));
  }
  if (std::exchange(wants_replay_, false)) viewer_->Say("");  // that it is awaited
  // The saws are also seen behind bone.
  was_translucent_ = viewer_->view().translucent();
  viewer_->view().set_translucent(true);
  pair_ = MakeReplayPair(*track_, *checks_.expert(), gauges_);
  state_ = State::kReplaying;
  replay_box_ = {};
  ShowCutAndSaw();
  viewer_->view().SetTool(MakeTool(scene_));
  viewer_->view().SetToolColour(kMadeColour);
  ShowGoal();
  RestartReplay();
}

void Practice::RestartReplay() {
  replay_s_ = 0;
  replay_runs_ = true;
  UpdateReplay(0);
}

void Practice::PauseReplay() {
  if (replay_s_ >= pair_->duration_s()) return RestartReplay();
  replay_runs_ = !replay_runs_;
}

void Practice::SeekReplay(double time_s) {
  replay_s_ = std::clamp(time_s, 0.0, pair_->duration_s());
  replay_runs_ = false;
}

void Practice::EndReplay() {
  viewer_->view().set_translucent(was_translucent_);
  viewer_->view().ClearTool();
  viewer_->view().SetPlaneLines({});
  ShowBoneAt(std::numeric_limits<double>::infinity());
  ShowGoal();
  state_ = State::kResult;
}

void Practice::UpdateReplay(double dt_s) {
  if (replay_runs_) replay_s_ = std::min(replay_s_ + kReplaySpeed * dt_s, pair_->duration_s());
  const TrackPoint student = pair_->student.Calc(replay_s_);
  const Pose X_expert = pair_->expert.Calc(replay_s_).X_WT;
  const auto nearest = static_cast<std::size_t>(&FindNearestGauge(gauges_, student.X_WT) - gauges_.data());
  if (current_ != nearest) {
    current_ = nearest;
    ShowGoal();
  }
  viewer_->view().SetToolPose(student.X_WT, student.rpm, 0);
  // Only the outline of the expert's saw: two discs over each other could not be distinguished.
  viewer_->view().SetPlaneLines({{.lines_W = {pair_->student_line_W}, .colour = kMadeColour},
                                 {.lines_W = {pair_->expert_line_W}, .colour = kWantedColour},
                                 {.lines_W = MakeOutline(X_expert, FindNearestGauge(gauges_, X_expert).cut()),
                                  .colour = kWantedColour,
                                  .selected = true}});
  ShowBoneAt(pair_->student.begins_s() + replay_s_);
}

/// Shows the bone as it was at a time of the session.
void Practice::ShowBoneAt(double time_s) {
  if (!viewer_->bone().surface()) return;
  for (const FilmLeaf& leaf : film_->Seek(time_s, *viewer_->bone_at_start())) {
    viewer_->bone().surface()->Offer({.index = leaf.index, .values = leaf.values});
  }
}

}  // namespace kerf
