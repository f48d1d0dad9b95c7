// `kerf rehearse`: a surgeon cuts a bone freely, with mouse and keys or with a device.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/bone_saver.h"
#include "app/window/case_sessions.h"
#include "app/window/case_writer.h"
#include "app/window/ct_preview.h"
#include "app/window/input_loader.h"
#include "app/window/menu.h"
#include "app/window/pieces_mode.h"
#include "app/window/plan_editor.h"
#include "app/window/saw_distances.h"
#include "app/window/scene_change.h"
#include "app/window/viewer_app.h"
#include "session/plan/plan.h"

namespace kerf {

struct RehearsalOptions {
  ViewerOptions viewer;
  std::string input;               // see OpenInput()
  double voxel_mm = 0.2;           // of an imported bone
  std::vector<std::string> plans;  // .mrk.json files with planes
  std::vector<Saw> saws;           // saws to choose from; not empty
  bool obj = false;                // pieces are exported as OBJ, otherwise as STL
};

/// Output of a rehearsal.
struct RehearsalResult {
  std::vector<std::string> recordings;
  std::string take_away;              // folder of the exported files; empty: nothing was exported
  std::vector<std::string> warnings;  // one sentence for each bone that could not be saved
  /// True if a step of loading that cannot be interrupted is still running. The destructor of Rehearsal waits for it;
  /// the program may end at once instead.
  bool left_work = false;
};

class Rehearsal final : public Activity {
 public:
  /// Throws Error if there is no display or a plan cannot be read.
  explicit Rehearsal(const RehearsalOptions& options);

  /// Runs until the window is closed. Throws Error if the input of the options cannot be opened or a session failed.
  RehearsalResult Run();

 private:
  /// Ends the current session, whose recording is kept, discards plan, checkpoints and pieces, and opens another input
  /// (see OpenInput()) in the same window. If it cannot be opened, a message says why, and the window stays empty.
  void Open(const std::string& path) override;
  /// Ends the opening or loading that is in progress. The window is then empty, and another input can be opened.
  void Cancel() override;
  void AddActions(ActionList& actions) override;
  bool Take(const WindowEvent& event) override;
  void PickMenuRow(int row) override;
  void PickPieceRow(int row) override;
  void DrawSections(Ui& ui) override;
  void DrawWindows(Ui& ui) override;
  void OpenContextMenu(const ScreenPoint& at) override;
  bool TakeSlicePoint(const Vec3& p_W) override;
  bool has_slices() const override { return true; }
  void AddAlarms(std::vector<AlarmOverlay>& alarms) override;
  void FillSlices(SliceScene& scene) const override;
  bool is_restarting() const override { return change_.is_pending(); }
  bool takes_escape() const override;
  std::string DescribeUnsaved() const override;
  void Save() override;
  std::vector<TourStep> tour() const override;
  void Update(double dt_s) override;
  void Fill(HudState& hud) override;
  std::vector<HudKeyGroup> help() const override;
  void Began() override;
  void Ended(LoopSummary summary) override;
  void Cancelled() override;
  bool TakeFailure(const std::string& sentence) override;
  void Describe(nlohmann::json& state) const override;
  bool cuts() const override;

  /// Returns true while an input is opened or its session is loading.
  bool is_loading() const;
  void ChooseFromMenu(const Menu& menu);
  void AskOpen();
  void SetMenu(Menu menu);
  void SelectSaw(std::size_t number);
  void ToggleGuide();
  /// Ends the session, changes the scene, and continues with the current bone.
  void ContinueWith(const std::string& what, std::function<void(Scene&)> change);
  void Restart(std::shared_ptr<const Bone> bone, bool same_bone);
  void BeginOpening(const std::string& input);
  void FollowOpening();
  void FollowChange();
  void Reset();
  void EndWork();

  void RequestCheckpoint();
  void ShowCheckpoints();
  void GoBack(const std::string& name);
  void GoForward();
  void Undo();

  void ShowPlanMenu();
  void FollowCut();
  void EnterPieces();
  void LeavePieces();
  /// Returns the figures of the session that is or was running.
  ProjectSession MakeSession() const;
  CaseContent MakeContent() const;
  void TakeSettings(const std::map<std::string, std::string>& settings);
  void ShowImportNotes();
  void Export();
  /// `quits`: the program ends once the project is saved. Asks for its place if it has none.
  void SaveProject(bool quits);
  void SaveProjectIn(const std::string& file, bool quits);
  void AskProjectFile(bool quits);

  RehearsalOptions options_;
  std::vector<PlannedPlane> given_planes_;  // by the options, until an input is open
  std::unique_ptr<ViewerApp> viewer_;
  PlanEditor editor_{*viewer_};
  PiecesMode pieces_{*viewer_};
  SawDistances distances_{*viewer_, editor_.document};
  CaseWriter writer_{*viewer_, editor_.document, pieces_};
  InputLoader loader_{*viewer_};
  CtPreview preview_;
  RehearsalResult result_;
  std::optional<std::string> to_open_;  // after the end of the session
  bool is_command_line_ = true;         // the input is that of the options
  Scene scene_;
  std::string scene_file_;
  std::shared_ptr<const Bone> before_;    // bone at the start of the first session
  std::shared_ptr<const Bone> original_;  // of a project: the bone before its cuts; otherwise null

  std::size_t saw_ = 0;
  bool saw_is_listed_ = false;  // true if saws[saw_] is in use
  std::string saw_name_;        // empty: the scene's own tool
  std::string session_saw_;     // saw of the session that is or was running, for its figures
  std::optional<Menu> menu_;
  std::vector<std::string> checkpoints_;

  SceneChange change_;
  struct ToSave {
    std::shared_ptr<const Bone> bone;
    std::string path;
  };
  std::optional<ToSave> to_save_;  // once the session with this bone runs
  BoneSaver saver_;
  bool is_new_bone_ = false;         // the session is the first one of its input
  int inputs_ = 0;                   // opened so far
  std::size_t first_recording_ = 0;  // of the current input

  std::vector<ProjectView> views_;
  bool shows_import_ = false;                    // the notes on the import, once its bone is shown
  std::vector<std::string> earlier_recordings_;  // of a project
  std::vector<ProjectSession> sessions_;         // of the case, without the running one
  std::string project_file_;                     // where the project is saved; empty: the user is asked
  std::string pieces_json_;                      // of a project, until the pieces are entered
  std::vector<std::string> recent_;              // files of the menu
  std::vector<std::string> saw_tips_;            // of the menu
  bool guided_ = false;
  std::optional<PlanesReport> cut_;  // latest state of the planned planes
  bool in_pieces_ = false;
};

}  // namespace kerf
