// `kerf practise`: a student does exercises in depth control and receives a score.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/exercise_list.h"
#include "app/window/practice_panel.h"
#include "app/window/result_checks.h"
#include "app/window/viewer_app.h"
#include "session/practise/coach.h"
#include "session/practise/exercises.h"
#include "session/practise/history.h"
#include "session/practise/progress.h"
#include "session/practise/replay_pair.h"
#include "session/score/columns.h"
#include "session/score/feed_meter.h"
#include "session/score/region_distance.h"
#include "session/score/review.h"
#include "session/score/score.h"
#include "session/watch/cut_film.h"
#include "session/watch/cut_watch.h"

namespace kerf {

struct PracticeOptions {
  ViewerOptions viewer;
  std::string exercise;  // id of the exercise, or a scene file (.toml); empty: chosen from a list
  int level = 1;
  std::string student;  // student whose attempts are stored; empty: they are not stored
};

class Practice final : public Activity {
 public:
  /// Throws Error if there is no display, the exercise does not exist, its file has faults, or the history cannot be
  /// used.
  explicit Practice(const PracticeOptions& options);
  ~Practice() override;

  /// Runs until the window is closed. Returns the recordings. Throws Error if a session failed.
  std::vector<std::string> Run();
  /// As RehearsalResult::left_work, after Run().
  bool left_work() const { return viewer_->left_work(); }

  // ---- for the interface; valid in the states named
  enum class State { kChoosing, kCutting, kScoring, kResult, kReplaying };
  State state() const { return state_; }
  const std::string& student() const { return options_.student; }
  /// Returns the rows of the list of exercises, with the student's progress.
  std::vector<ExerciseRow> MakeRows() const;
  /// kResult: the sheet, its review, and what to do next. The sheet is computed from the session itself; verified()
  /// tells whether a replay of the recording has given the same sheet; unset while that is not known.
  const std::optional<ScoreSheet>& sheet() const { return sheet_; }
  const std::optional<ExerciseReview>& review() const { return review_; }
  const NextStep& next_step() const { return next_; }
  std::optional<bool> verified() const { return checks_.verified(); }
  /// kCutting: the advice to show now, and the aids of the level with those that the user switches.
  std::optional<CoachLine> MakeCoach() const;
  std::optional<StepLine> MakeStep() const;  // the next step on the first level; on all, the way back to the cut
  std::string DescribeSpindleOff() const;
  std::vector<Aid> MakeAids() const;
  /// kReplaying: both tracks and the time that is shown.
  const std::optional<ReplayPair>& pair() const { return pair_; }
  double replay_s() const { return replay_s_; }
  bool replay_runs() const { return replay_runs_; }

  // ---- what buttons do, as the keys
  void Choose();
  void Start(const std::string& id, int level);
  void Finish(bool scored);  // kCutting
  /// kCutting: finishes, but asks first if too little is cut for a score or, without a score, if anything is cut.
  void AskToFinish(bool scored);
  void DoNextStep();               // kResult
  void Replay();                   // kResult; begins as soon as the expert's attempt is available
  void EndReplay();                // kReplaying
  void RestartReplay();            // kReplaying
  void PauseReplay();              // kReplaying: or goes on; at the end, from the beginning
  void SeekReplay(double time_s);  // kReplaying; pauses

 private:
  void AddActions(ActionList& actions) override;
  bool Take(const WindowEvent& event) override;
  void PickMenuRow(int /*row*/) override {}
  void Open(const std::string& path) override;
  void Update(double dt_s) override;
  void Fill(HudState& hud) override;
  void DrawSections(Ui& ui) override;
  void DrawWindows(Ui& ui) override;
  std::vector<TourStep> tour() const override;
  std::optional<Pose> FindRetreat(const Pose& X_start) const override;
  bool has_slices() const override;
  void FillSlices(SliceScene& scene) const override;
  std::optional<Vec3> slice_focus() const override;
  bool has_saw() const override { return state_ == State::kCutting; }
  bool shows_force_first() const override { return true; }
  std::vector<HudKeyGroup> help() const override;
  ViewBasis MakeKeyBasis(const ViewBasis& picture) const override;
  HudKeyGroup saw_help() const override;
  void Relabel() override;
  std::vector<Vec3> kept_clear_W() const override;
  UiBox bottom_box() const override { return state_ == State::kReplaying ? replay_box_ : UiBox{}; }
  std::string DescribeDepthStop() const override;
  std::string DescribeUnsaved() const override;
  std::string save_label() const override;
  void Save() override { Finish(true); }
  void Began() override;
  void Ended(LoopSummary summary) override;
  void Cancelled() override;
  void Describe(nlohmann::json& state) const override;
  void AddAlarms(std::vector<AlarmOverlay>& alarms) override;
  bool cuts() const override { return state_ == State::kCutting; }

  void TakeChoice(ExerciseList::Choice choice);
  void DrawResultDialog(Ui& ui);
  void AskName();
  void UseName(const std::string& entered);
  void AskOpen();
  const Exercise& Find(const std::string& id) const;
  void Score(std::shared_ptr<const Bone> before, Bone after);
  void TakeSheet();
  void SaveAttempt();
  void TakeChecks();
  void UpdateCutting();
  void UpdateReplay(double dt_s);
  void ShowBoneAt(double time_s);
  void FillCutting(HudState& hud);
  void ShowCutAndSaw();
  void ShowGoal();
  void HideGoal();
  std::string DescribePlan() const;
  std::string NameCut(std::size_t i) const;
  bool IsPlanned() const;  // the wanted cut is a planned plane through the bone rather than a line on it
  bool DrillsHoles() const;
  bool HasSeveralCuts() const { return cuts_.size() > 1; }
  const DepthGauge& gauge() const { return gauges_[current_]; }
  const WantedCut& cut() const { return cuts_[current_]; }
  void TakeUpCut(std::size_t i);
  std::optional<DepthReading> Read() const;
  CoachInput MakeCoachInput() const;
  double CalcElapsed_s() const;
  double CalcDone(std::size_t i) const;  // fraction of a cut
  bool IsMade(std::size_t i) const;
  bool IsFinished() const;  // enough is cut for a score
  std::size_t CountMade() const;
  bool AllMade() const { return CountMade() == gauges_.size(); }
  std::pair<std::string, std::string> DescribeDone() const;
  DepthAdvice MakeAdvice() const;
  HudGauge MakeGauge(const std::optional<DepthReading>& reading, const DepthAdvice& advice) const;

  PracticeOptions options_;
  std::optional<History> history_;
  std::unique_ptr<ViewerApp> viewer_;
  State state_ = State::kChoosing;
  std::optional<ExerciseList> list_;  // kChoosing
  std::function<void()> clicked_;     // what was clicked in the last frame; runs before the next one
  std::vector<Exercise> opened_;      // by name or file; one for each id
  const Exercise* exercise_ = nullptr;
  Scene scene_;
  std::vector<WantedCut> cuts_;     // empty before the session has begun
  std::vector<DepthGauge> gauges_;  // of each
  std::size_t current_ = 0;         // cut that the advice is about
  std::future<std::unique_ptr<RegionDistance>> making_nerve_;
  std::unique_ptr<RegionDistance> nerve_;
  bool crosses_nerve_ = false;  // the wanted cuts cross it
  bool begun_ = false;          // the spindle has been on
  bool scored_ = true;          // the attempt is scored when it ends
  std::vector<std::string> recordings_;
  std::mutex mutex_;  // protects the next two
  std::string scoring_stage_;
  double scoring_fraction_ = 0;
  std::atomic<bool> stop_scoring_{false};
  std::future<ScoreSheet> scoring_;
  std::shared_ptr<SessionMeter> meter_;  // of this session; used by its thread until it ends
  std::shared_ptr<ToolTrack> track_;     // likewise
  std::optional<ScoreSheet> sheet_;
  std::optional<ExerciseReview> review_;
  std::vector<Attempt> attempts_;    // of the student, or of this program if no student is named
  std::vector<ScoreSheet> unnamed_;  // attempts that are stored as soon as a student is named
  /// kResult: for whom the attempt is stored, or why it is not; a sentence in the current language.
  std::function<std::string()> stored_;
  NextStep next_;  // kResult: recommended
  CoachState coach_;
  std::optional<FeedMeter> feed_;
  std::optional<double> feed_mm_per_s_;          // of feed_, at the last frame
  std::optional<PlanesReport> report_;           // of the bone as it is cut; none: not yet
  std::string plan_label_;                       // beside the planned plane
  std::vector<std::vector<double>> deepest_mm_;  // of each cut, by column of its gauge; of a hole, one value
  std::size_t shown_made_ = 0;                   // number of cuts that are shown as made
  std::shared_ptr<const Bone> kept_bone_;        // of the last session, uncut; null: none
  SceneBone kept_source_;                        // that it was made of
  std::optional<Pose> touched_at_;               // pose of the saw in the last frame, if it touched bone

  ResultChecks checks_;
  bool wants_replay_ = false;
  double waits_s_ = 0;            // for the expert's attempt
  UiBox replay_box_;              // kReplaying: of its panel
  bool was_translucent_ = false;  // kReplaying: the bone, before
  std::optional<ReplayPair> pair_;
  double replay_s_ = 0;
  bool replay_runs_ = false;
  std::shared_ptr<CutFilm> film_;  // of this session; used by its threads until it ends
};

}  // namespace kerf
