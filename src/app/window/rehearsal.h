// `kerf rehearse`: a surgeon cuts a bone freely, with mouse and keys or with a device.
#pragma once

#include <deque>
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
#include "app/window/ct_reader.h"
#include "app/window/input_loader.h"
#include "app/window/jaw_separation.h"
#include "app/window/menu.h"
#include "app/window/pieces_mode.h"
#include "app/window/plan_editor.h"
#include "app/window/plan_link.h"
#include "app/window/saw_distances.h"
#include "app/window/scan_check.h"
#include "app/window/scene_change.h"
#include "app/window/unsaved_cut.h"
#include "app/window/viewer_app.h"
#include "bone/import/dicom.h"
#include "bone/import/isolate.h"
#include "bone/import/mesh_units.h"
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
  std::vector<std::string> exports;   // folders of all exports, in order
  std::string project;                // file in which the project was last saved; empty: it was not
  std::vector<std::string> warnings;  // one sentence for each bone that could not be saved
  std::vector<std::string> failures;  // why sessions ended by themselves, and a project was not saved; a sentence each
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
  /// Opens another input (see OpenInput()) in the same window. Once it is open, the current session ends; its recording
  /// is kept, its plan, checkpoints and pieces are discarded. If it cannot be opened, a dialog says why, and the case
  /// that was open goes on.
  void Open(const std::string& path) override;
  /// Ends the opening or loading that is in progress. The case that was open before goes on, if there is one.
  void Cancel() override;
  void AddActions(ActionList& actions) override;
  bool Take(const WindowEvent& event) override;
  void PickMenuRow(int row) override;
  void PickPieceRow(int row) override;
  void DrawSections(Ui& ui) override;
  void DrawWindows(Ui& ui) override;
  void OpenContextMenu(const ScreenPoint& at) override;
  bool wants_slice_points() const override;
  void TakeSlicePoint(const Vec3& p_W) override;
  void TakeBackSlicePoint() override;
  void MoveSlicePoint(std::size_t i, const Vec3& p_W, bool first) override;
  std::optional<Vec3> slice_point() const override;
  std::optional<Vec3> slice_focus() const override { return plane_focus_W_; }
  bool has_slices() const override { return true; }
  bool covers_slices() const override { return loader_.ct() != nullptr || asks_about_ct(); }
  bool covers_scene() const override { return asks_about_ct(); }
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
  bool TakeFailure(const std::string& sentence, LoopSummary* summary) override;
  std::string ExplainFailure(const LiveSession::Answer& answer) const override;
  void Describe(nlohmann::json& state) const override;
  bool cuts() const override;

  /// Returns true while an input is opened or its session is loading.
  bool is_loading() const;
  void ChooseFromMenu(const Menu& menu);
  void AskOpen();
  /// Opens an input. `accepts_loss`: the user has agreed that what is not saved is lost.
  void OpenNow(const std::string& path, bool accepts_loss);
  void BeginCase(OpenedInput opened);
  /// Returns true if a case is open, which an input that is being opened will replace.
  bool has_case() const { return ended_work_ || viewer_->is_running() || change_.is_pending(); }
  bool is_opening() const {
    return loader_.is_opening() || opened_.has_value() || scan_check_.has_value() || separation_.has_value();
  }
  bool asks_about_scan() const { return scan_check_ && scan_check_->asks(); }
  bool asks_for_points() const { return separation_ && separation_->asks(); }
  bool asks_about_ct() const { return asks_about_scan() || asks_for_points(); }
  std::string BeginQuestion(const char* event, const std::string& why);
  void AskForUnit(const UnclearUnit& e);
  void AskForSeries(const UnclearSeries& e);
  void AskAboutScan(const std::shared_ptr<const Volume>& ct, const std::optional<AssumedPlacing>& placing,
                    const std::optional<NotHu>& values);
  void ImportChecked();
  void AskForPoints(const std::shared_ptr<const Volume>& ct, const NotIsolated& e);
  void SeparateJaws();
  /// Forgets the answers about the CT that is being opened.
  void EndQuestions();
  void FailToOpen(const std::string& sentence);
  void ShowOpeningFault();
  bool AskBeforeCaseEnds();
  bool RefuseWhileOpening();
  /// Returns what is not saved, as a sentence; empty: nothing.
  std::string DescribeChanges() const;
  std::string AskToSaveBefore(const std::string& path) const;
  /// Returns whether the file is the bone that a peer of the link has sent.
  bool is_sent(const std::string& path) const { return !sent_bone_.empty() && path == sent_bone_; }
  void SetMenu(Menu menu);
  /// Returns the guide along the plan; the end of the scene's effects if it has none.
  static std::vector<EffectChoice>::const_iterator FindGuide(const Scene& scene);
  void SelectSaw(std::size_t number);
  /// Returns true if the saw of the list is in use: it was chosen, or is that of the scene.
  bool IsUsed(std::size_t number) const;
  void ToggleGuide();
  void UseGuide(bool on);
  void FollowGuide();
  /// Ends the session, changes the scene, and continues with the current bone.
  void ContinueWith(const std::string& what, std::function<void(Scene&)> change);
  void Restart(std::shared_ptr<const Bone> bone, bool same_bone);
  void BeginOpening(const std::string& input);
  void FollowOpening();
  void ReadCtAgain();
  void FollowCtReader();
  void FollowSentBone();
  void FollowChange();
  void FollowSaving();
  void KeepWork(const std::string& message, const std::string& failure, Scene scene, std::shared_ptr<const Bone> bone);
  void Reset();
  void EndWork();

  void RequestCheckpoint();
  void ShowCheckpoints();
  void GoBack(const std::string& name);
  void GoForward();
  bool RefuseWhileRetracting();
  void Undo();

  void ShowPlanMenu();
  void FollowCut();
  void FollowPlane();
  void EnterPieces();
  void LeavePieces();
  /// Returns true if there is something to save and to export.
  bool has_work() const { return ended_work_ || (viewer_->is_running() && !change_.is_pending()); }
  /// Returns the figures of the session that is or was running.
  ProjectSession MakeSession() const;
  CaseContent MakeContent(const std::string& project_file);
  void TakeSettings(const std::map<std::string, std::string>& settings);
  void ShowImportNotes();
  void Export();
  void ExportInto(const std::string& folder);
  std::vector<std::pair<std::string, std::string>> GrabPictures();
  std::string chosen_project() const;
  /// `quits`: the program ends once the project is saved. Asks for its place if it has none.
  void SaveProject(bool quits);
  /// Saves it now, or when it is saved again if it is being saved.
  void SaveProjectIn(const std::string& file, bool quits);
  void AskProjectFile(bool quits);

  RehearsalOptions options_;
  std::vector<PlannedPlane> given_planes_;  // by the options, until an input is open
  std::unique_ptr<ViewerApp> viewer_;
  PlanEditor editor_{*viewer_};
  PiecesMode pieces_{*viewer_};
  PlanLink plan_link_{*viewer_, editor_.document};
  SawDistances distances_{*viewer_, editor_.document};
  UnsavedCut unsaved_cut_;
  CaseWriter writer_{*viewer_, editor_.document, pieces_, unsaved_cut_};
  InputLoader loader_{*viewer_};
  CtPreview preview_;
  CtReader ct_reader_;                       // of a project's CT
  std::string mesh_units_;                   // of a surface, from the question for it until it is open
  std::string series_;                       // likewise: of a folder
  std::optional<ScanCheck> scan_check_;      // from the questions about the CT until it is open
  std::optional<JawSeparation> separation_;  // from the first question for points until the CT is open
  RehearsalResult result_;
  std::optional<std::string> to_open_;             // in the next frame in which that is possible
  std::optional<OpenedInput> opened_;              // while the case before it ends
  bool keeps_case_ = false;                        // while an input is opened: a case was open at the beginning
  bool accepts_loss_ = false;                      // likewise: of what is not saved in that case
  std::string opening_fault_;                      // to be shown once no other dialog is open
  std::optional<std::string> interrupted_;         // input that was loading when another one was opened
  std::string sent_bone_;                          // file of the bone that a peer of the link has sent last
  int sent_bones_ = 0;                             // so far
  std::optional<std::string> to_open_once_saved_;  // chosen while something was not saved
  bool is_command_line_ = true;                    // the input is that of the options
  std::string input_;                              // file or folder of the case's bone or CT, as the user gave it
  Scene scene_;
  std::string scene_file_;
  std::map<std::string, std::string> scene_files_;  // contents of the scene's files in the output folder, by path
  std::shared_ptr<const Bone> before_;              // bone at the start of the first session
  std::shared_ptr<const Bone> original_;            // of a project: the bone before its cuts; otherwise null

  struct Choice {
    std::size_t saw = 0;
    bool saw_is_listed = false;  // true if saws[saw] is in use
    std::string saw_name;        // empty: the scene's own tool
    bool guided = false;         // the guide along the plan is on
  };
  Choice choice_;
  Choice former_choice_;     // before the pending change of the scene
  std::string session_saw_;  // saw of the session that is or was running, for its figures
  std::optional<Menu> menu_;
  std::vector<std::string> checkpoints_;

  SceneChange change_;
  struct ToSave {
    std::shared_ptr<const Bone> bone;
    std::string path;
  };
  std::optional<ToSave> to_save_;  // once the session with this bone runs
  /// Work of a session that ended by a failure. It can be saved and exported, but not be continued.
  struct EndedWork {
    Scene scene;
    std::shared_ptr<const Bone> bone;
    bool saved = false;
  };
  std::optional<EndedWork> ended_work_;
  std::shared_ptr<const Bone> before_change_;  // bone at the end of the session, while the change is made
  BoneSaver saver_;
  bool is_new_bone_ = false;         // the session is the first one of its input
  int inputs_ = 0;                   // opened so far
  std::size_t first_recording_ = 0;  // of the current input

  std::vector<ProjectView> views_;
  bool shows_import_ = false;                           // the notes on the import, once its bone is shown
  std::vector<std::string> earlier_recordings_;         // of a project
  std::map<std::uint64_t, std::string> earlier_bones_;  // of a project
  std::vector<ProjectSession> sessions_;                // of the case, without the running one
  std::string project_file_;                            // where the project was last saved; empty: the user is asked
  std::deque<SaveOrder> save_orders_;                   // requested while the project was being saved
  std::string pieces_json_;                             // of a project, until its session begins
  std::vector<MeasuredPoints> measurements_;            // of a project, until its session begins
  std::vector<std::string> recent_;                     // files of the menu
  bool guides_other_plane_ = false;                     // the guide holds another plane than the selected one
  std::string selected_plane_;                          // its name in the last frame
  bool guide_waits_ = false;  // it moves to the selected plane once the saw is clear of the bone
  bool said_guide_waits_ = false;
  bool warns_after_change_ = false;        // the message of the pending change is a warning
  std::optional<Vec3> plane_in_slices_W_;  // middle of the selected plane in the last frame
  std::optional<Vec3> plane_focus_W_;      // the slices go through it until the saw is moved
  std::optional<PlanesReport> cut_;        // latest state of the planned planes
  bool in_pieces_ = false;
  std::optional<std::uint64_t> left_pieces_at_;  // LiveFigures::changes when the pieces were left; none since an undo
  bool begins_in_pieces_ = false;                // as the project was saved, until its session begins
};

}  // namespace kerf
