// `kerf rehearse`: a surgeon cuts a bone freely, by mouse and keys or with a device.
#pragma once

#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/window/menu.h"
#include "app/window/open_input.h"
#include "app/window/theatre.h"
#include "session/plan/plan.h"
#include "session/score/columns.h"
#include "session/score/region_distance.h"

namespace kerf {

class PiecesMode;

struct RehearsalOptions {
  TheatreOptions theatre;
  std::string input;  // OpenInput()
  OpenOptions open;
  std::vector<std::string> plans;  // .mrk.json files of planes
  std::vector<Saw> saws;           // to switch among; not empty
  bool obj = false;                // pieces are taken away as OBJ, else as STL
};

/// What was left behind.
struct RehearsalResult {
  std::vector<std::string> recordings;
  std::string take_away;  // its folder; empty: nothing was taken away
};

class Rehearsal final : public Activity {
 public:
  /// Throws Error where there is no display, and for a plan that can't be read.
  explicit Rehearsal(const RehearsalOptions& options);
  ~Rehearsal() override;

  /// Until the window is closed. Throws Error for an input that can't be opened or a session that failed.
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
  void TakeUpSawNumber(std::size_t number);
  void ToggleGuide();
  /// Ends the session, changes the scene, goes on with the bone as it is.
  void GoOnWith(const std::string& what, std::function<void(Scene&)> change);
  void BeginAnew();

  void AskCheckpoint();
  void ShowCheckpoints();
  void GoBack(const std::string& name);
  void GoForward();

  void ShowPlan();
  void PickPoints(const std::string& prompt, std::size_t count, std::function<void(const std::vector<Vec3>&)> done);
  void ShowPlanInPicture();
  const PlannedPlane* plane() const;
  void AskDepth(const Vec3& p_W);
  void AlignToPlane();
  void WritePlan();

  void EnterPieces();
  void TakeAway();

  RehearsalOptions options_;
  std::unique_ptr<Theatre> theatre_;
  RehearsalResult result_;
  std::future<OpenedInput> opening_;
  std::mutex mutex_;  // of the next two
  std::string opening_stage_;
  double opening_share_ = 0;
  Scene scene_;
  std::string scene_file_;
  std::shared_ptr<const Bone> before_;  // as the first session began

  std::size_t saw_ = 0;
  bool of_catalogue_ = false;  // saw_ is in the hand; else the scene's own tool
  std::optional<Menu> menu_;
  std::vector<std::string> checkpoints_;

  struct Change {
    std::string what;
    std::function<void(Scene&)> apply;
  };
  std::optional<Change> change_;
  std::future<Scene> changing_;

  Plan plan_;
  std::size_t plane_ = 0;  // the one that counts
  bool guided_ = false;
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
  std::unique_ptr<PiecesMode> pieces_;   // once it was entered
  bool in_pieces_ = false;
  std::future<std::string> taking_away_;
};

}  // namespace kerf
