// What the user does in the window: rehearsing or practising.
#pragma once

#include <string>
#include <vector>

#include "app/window/actions.h"
#include "app/window/live_session.h"
#include "app/window/saw_controls.h"
#include "app/window/tour.h"
#include "view/live/camera.h"
#include "view/live/overlays.h"
#include "view/live/slice_view.h"
#include "view/ui/event.h"
#include "view/ui/hud.h"
#include "view/ui/translate.h"
#include "view/ui/ui.h"

namespace kerf {

/// Called by the viewer, in the window's thread.
class Activity {
 public:
  Activity() = default;
  Activity(const Activity&) = delete;
  Activity& operator=(const Activity&) = delete;
  virtual ~Activity() = default;

  /// Adds the activity's actions, once, before the first frame.
  virtual void AddActions(ActionList& actions) = 0;
  /// Called before the viewer handles the event. Returns true if the event was for the activity.
  virtual bool Take(const WindowEvent& event) = 0;
  /// Called once per frame; `dt_s`: time since the last frame.
  virtual void Update(double dt_s) = 0;
  /// Adds the activity's contents to what the viewer has already filled in.
  virtual void Fill(HudState& hud) = 0;
  /// Called when a row of the activity's list was clicked.
  virtual void PickMenuRow(int row) = 0;
  virtual void PickPieceRow(int /*row*/) {}
  /// Returns true if the user is asked for points that can be clicked in slices.
  virtual bool wants_slice_points() const { return false; }
  /// Takes a point that was clicked in a slice.
  virtual void TakeSlicePoint(const Vec3& /*p_W*/) {}
  /// Takes back the last one.
  virtual void TakeBackSlicePoint() {}
  /// Moves a point that FillSlices() has listed. `first`: with the first motion of a drag.
  virtual void MoveSlicePoint(std::size_t /*i*/, const Vec3& /*p_W*/, bool /*first*/) {}
  /// Returns the point of these through which all slices go meanwhile, instead of following the saw; none: no point.
  virtual std::optional<Vec3> slice_point() const { return {}; }
  /// Returns the point that the slices follow instead of the saw, unless the user chooses another one; none: the saw.
  virtual std::optional<Vec3> slice_focus() const { return {}; }
  /// Returns false if the activity has no use for slices.
  virtual bool has_slices() const { return false; }
  /// Returns true while the activity draws something else in the place of the slices.
  virtual bool covers_slices() const { return false; }
  /// Returns true while the activity draws something else over the scene.
  virtual bool covers_scene() const { return false; }
  /// Returns the area at the bottom of the scene above which messages are shown; empty: there is none.
  virtual UiBox bottom_box() const { return {}; }
  /// Adds alarms: places that the saw should not come near to.
  virtual void AddAlarms(std::vector<AlarmOverlay>& /*alarms*/) {}
  /// Adds what else is drawn in slices.
  virtual void FillSlices(SliceScene& /*scene*/) const {}
  /// Adds the activity's own sections to the left column, and its own windows.
  virtual void DrawSections(Ui& /*ui*/) {}
  virtual void DrawWindows(Ui& /*ui*/) {}
  /// Called for a right click in the picture without a drag.
  virtual void OpenContextMenu(const ScreenPoint& /*at*/) {}
  /// Opens a file or folder that was dropped into the window.
  virtual void Open(const std::string& path) = 0;
  /// Returns true between two sessions on the same bone, which can take seconds. Clicks and keys wait until then.
  virtual bool is_restarting() const { return false; }
  /// Returns true if Escape ends something of the activity.
  virtual bool takes_escape() const { return false; }
  /// Returns what would be lost at the end, as a sentence; empty: nothing.
  virtual std::string DescribeUnsaved() const { return {}; }
  /// Saves that, and then quits.
  virtual void Save() {}
  /// Returns the name of Save(), for the user.
  virtual std::string save_label() const { return Tr("Save"); }
  /// Cancels what is in progress.
  virtual void Cancel() {}
  /// Called when the language may have changed, for names in the picture.
  virtual void Relabel() {}
  /// Returns points of the picture between which nothing flat is drawn.
  virtual std::vector<Vec3> kept_clear_W() const { return {}; }
  /// Returns the steps of the first-run tour.
  virtual std::vector<TourStep> tour() const { return {}; }
  /// Returns whether the tour is shown at the first start.
  virtual bool begins_with_tour() const { return true; }
  /// Returns where a saw that is retracted goes, wherever the user looks from; none: where it is seen. `X_start`: pose
  /// of the saw at the start.
  virtual std::optional<Pose> FindRetreat(const Pose& /*X_start*/) const { return {}; }
  /// Returns false if there is no saw to move or to switch on, whose buttons and modes are then not shown.
  virtual bool has_saw() const { return true; }
  /// Returns true if the force is shown above the activity's own sections.
  virtual bool shows_force_first() const { return false; }
  /// Returns what is said while a depth stop that cannot be switched off holds the saw.
  virtual std::string DescribeDepthStop() const {
    return Tr("The depth stop holds the saw: this is the wanted depth. Go on along the cut.");
  }
  /// Returns the directions in which keys and mouse move the saw. `picture`: those of the picture.
  virtual ViewBasis MakeKeyBasis(const ViewBasis& picture) const { return picture; }
  /// Returns how keys and mouse move the saw, for the help.
  virtual HudKeyGroup saw_help() const;
  /// Returns the mouse's and the held keys' functions that are not actions, for the help.
  virtual std::vector<HudKeyGroup> help() const { return {}; }
  /// Called when the bone is ready, in the window's thread.
  virtual void Began() = 0;
  /// Called when the session has ended, whether or not this was requested.
  virtual void Ended(LoopSummary summary) = 0;
  /// Called when the session was cancelled before its bone was ready.
  virtual void Cancelled() {}
  /// Called when the session failed. `summary`: of what was done before, with the bone; null if it could not begin or
  /// its bone is lost. Returns true if the window stays open.
  virtual bool TakeFailure(const std::string& /*sentence*/, LoopSummary* /*summary*/) { return false; }
  /// Returns why a requested action, such as undo, was not possible, in the language of the window.
  virtual std::string ExplainFailure(const LiveSession::Answer& answer) const { return TrMade(answer.failure); }
  /// Adds the activity's state to the trace.
  virtual void Describe(nlohmann::json& state) const = 0;
  /// Returns true if the saw may be moved and switched now.
  virtual bool cuts() const = 0;
};

}  // namespace kerf
