// `kerf practise`: a student does exercises in depth control and receives a score.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/menu.h"
#include "app/window/viewer_app.h"
#include "session/practise/exercises.h"
#include "session/practise/history.h"
#include "session/score/columns.h"
#include "session/score/region_distance.h"
#include "session/score/score.h"

namespace kerf {

class Beeper;

struct PracticeOptions {
  ViewerOptions viewer;
  std::string exercise;  // id of the exercise; empty: chosen from a list
  int level = 1;
  std::string student;  // student whose attempts are stored; empty: they are not stored
};

class Practice final : public Activity {
 public:
  /// Throws Error if there is no display, the exercise does not exist, or the history cannot be used.
  explicit Practice(const PracticeOptions& options);
  ~Practice() override;

  /// Runs until the window is closed. Returns the recordings. Throws Error if a session failed.
  std::vector<std::string> Run();

 private:
  void AddActions(ActionList& actions) override;
  bool Take(const WindowEvent& event) override;
  void PickMenuRow(int row) override;
  void Open(const std::string& path) override;
  void Update(double dt_s) override;
  void Fill(HudState& hud) override;
  void Began() override;
  void Ended(LoopSummary summary) override;
  void Describe(nlohmann::json& state) const override;
  bool cuts() const override { return state_ == State::kCutting; }

  enum class State { kChoosing, kCutting, kScoring, kResult };
  void Choose();
  void ChooseLevel(const Exercise& exercise);
  void Start(const std::string& id, int level);
  void Finish(bool scored);
  void Score();
  void ShowGoal();
  std::optional<DepthReading> Read() const;
  HudGauge MakeGauge(const std::optional<DepthReading>& reading) const;
  HudResult MakeResult() const;

  PracticeOptions options_;
  std::optional<History> history_;
  std::unique_ptr<ViewerApp> viewer_;
  State state_ = State::kChoosing;
  std::optional<Menu> menu_;
  const Exercise* exercise_ = nullptr;
  Scene scene_;
  std::unique_ptr<DepthGauge> gauge_;
  std::future<std::unique_ptr<RegionDistance>> making_nerve_;
  std::unique_ptr<RegionDistance> nerve_;
  bool begun_ = false;  // the spindle has been on
  bool scored_ = true;  // the attempt is scored when it ends
  std::vector<std::string> recordings_;
  std::mutex mutex_;  // protects the next two
  std::string scoring_stage_;
  double scoring_fraction_ = 0;
  std::atomic<bool> stop_scoring_{false};
  std::future<ScoreSheet> scoring_;
  std::optional<ScoreSheet> sheet_;
  std::unique_ptr<Beeper> beeper_;
};

}  // namespace kerf
