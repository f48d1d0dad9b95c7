// `kerf rehearse`: a surgeon cuts a bone freely, with mouse and keys or with a device.
#pragma once

#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/window/menu.h"
#include "app/window/open_input.h"
#include "app/window/viewer_app.h"
#include "session/plan/plan.h"
#include "session/score/columns.h"
#include "session/score/region_distance.h"

namespace kerf {

class PiecesMode;

struct RehearsalOptions {
  ViewerOptions viewer;
  std::string input;  // see OpenInput()
  OpenOptions open;
  std::vector<std::string> plans;  // .mrk.json files with planes
  std::vector<Saw> saws;           // saws to choose from; not empty
  bool obj = false;                // pieces are exported as OBJ, otherwise as STL
};

/// Output of a rehearsal.
struct RehearsalResult {
  std::vector<std::string> recordings;
  std::string take_away;  // folder of the exported files; empty: nothing was exported
};

class Rehearsal final : public Activity {
 public:
  /// Throws Error if there is no display or a plan cannot be read.
  explicit Rehearsal(const RehearsalOptions& options);
  ~Rehearsal() override;

  /// Runs until the window is closed. Throws Error if the input cannot be opened or a session failed.
  RehearsalResult Run();

 private:
  bool Take(const WindowEvent& event) override;
  void Update(double dt_s) override;
  void Fill(HudState& hud) override;
  std::vector<HudKeyGroup> help() const override;
  void Began() override;
  void Ended(LoopSummary summary) override;
  void Describe(nlohmann::json& state) const override;
  bool cuts() const override;

  bool TakeKey(const WindowEvent& event);
  bool TakeClick(const WindowEvent& event);
  void SetMenu(Menu menu);
  void SelectSaw(std::size_t number);
  void ToggleGuide();
  /// Ends the session, changes the scene, and continues with the current bone.
  void ContinueWith(const std::string& what, std::function<void(Scene&)> change);
  void Restart();

  void RequestCheckpoint();
  void ShowCheckpoints();
  void GoBack(const std::string& name);
  void GoForward();

  void ShowPlan();
  void PickPoints(const std::string& prompt, std::size_t count, std::function<void(const std::vector<Vec3>&)> done);
  void ShowPlanInPicture();
  void FollowCut();
  const PlannedPlane* plane() const;
  void AskDepth(const Vec3& p_W);
  void AlignToPlane();
  void WritePlan();

  void EnterPieces();
  void Export();
  void SaveProject();

  RehearsalOptions options_;
  std::unique_ptr<ViewerApp> viewer_;
  RehearsalResult result_;
  std::future<OpenedInput> opening_;
  std::mutex mutex_;  // protects the next two
  std::string opening_stage_;
  double opening_fraction_ = 0;
  Scene scene_;
  std::string scene_file_;
  std::shared_ptr<const Bone> before_;  // bone at the start of the first session

  std::size_t saw_ = 0;
  bool saw_is_listed_ = false;  // true if saws[saw_] is in use, otherwise the scene's own tool
  std::optional<Menu> menu_;
  std::vector<std::string> checkpoints_;

  struct Change {
    std::string what;
    std::function<void(Scene&)> apply;
  };
  std::optional<Change> change_;
  std::future<Scene> changing_;

  Plan plan_;
  std::size_t plane_ = 0;  // the active plane
  bool guided_ = false;
  std::optional<PlanesReport> cut_;  // latest state of the planned planes
  std::vector<Mark> marks_;          // nerves and other structures that the user has marked
  std::vector<MarkTube> mark_tubes_;
  struct Picking {
    std::string prompt;
    std::size_t count = 0;
    std::vector<Vec3> points;
    std::function<void(const std::vector<Vec3>&)> done;
  };
  std::optional<Picking> picking_;

  std::future<std::unique_ptr<RegionDistance>> making_nerve_;
  std::unique_ptr<RegionDistance> nerve_;
  std::unique_ptr<PhiSampler> sampler_;  // of before_
  std::unique_ptr<PiecesMode> pieces_;   // null until first entered
  bool in_pieces_ = false;
  std::future<std::string> exporting_;
  std::future<std::string> saving_;  // of the project; returns its path
};

}  // namespace kerf
