// Keys and menus that rehearsing and practising share.
#include <fmt/format.h>

#include <limits>

#include "app/window/seen_pose.h"
#include "app/window/viewer_app.h"
#include "kerf/version.h"

namespace kerf {

void ViewerApp::AddActions() {
  const auto cuts = [this] { return activity_->cuts(); };
  const auto has_saw = [this] { return activity_->has_saw(); };
  const auto feed = [this](double factor) {
    controls_->set_feed_mm_per_s(factor * controls_->feed_mm_per_s());
    Say(fmt::format(fmt::runtime(Tr("Keys move the saw at {} mm/s")), ShowNumber(controls_->feed_mm_per_s(), 1)));
  };
  // ---- saw
  actions_.Add({.id = "saw.spindle",
                .menu = Msg("Saw"),
                .label = Msg("Start or stop the spindle"),
                .shortcut = {Key::kSpace},
                .tip = Msg("A turning saw cuts what it touches; a stopped saw only pushes"),
                .run =
                    [this] {
                      if (retracting_) return Say(Tr("The saw is being brought back; start the spindle after that."));
                      SetSpindle(!spindle_on());
                    },
                .enabled =
                    [this] {
                      return activity_->cuts() && is_running() && !activity_->is_restarting() &&
                             (spindle_on() || !is_turning());
                    },
                .on = [this] { return spindle_on(); },
                .relevant = has_saw,
                .button = Msg("Spindle"),
                .indicator = Msg("Spindle")});
  actions_.Add(
      {.id = "saw.plane_lock",
       .menu = Msg("Saw"),
       .label = Msg("Stay in the blade's plane"),
       .shortcut = {Key::kL},
       .tip = Msg("Mouse and keys move the saw only within the plane of its blade: a straight cut stays straight"),
       .run =
           [this] {
             controls_->set_in_blade_plane(!controls_->in_blade_plane());
             Say(!controls_->in_blade_plane()  ? Tr("The saw moves freely")
                 : controls_->has_lock_plane() ? Tr("The saw stays in the exercise's plane; from beside it, it moves "
                                                    "only towards it")
                                               : Tr("The saw moves in the blade's plane only"));
           },
       .enabled = cuts,
       .on = [this] { return controls_->in_blade_plane(); },
       .relevant = has_saw,
       .indicator = Msg("Plane lock")});
  actions_.Add({.id = "saw.retract",
                .menu = Msg("Saw"),
                .label = Msg("Retract: bring the saw back into view"),
                .shortcut = {Key::kR},
                .tip = Msg("With the spindle off, the saw leaves the bone and returns to where it began or, if that is "
                           "not seen, in front of the bone"),
                .run = [this] { Retract(); },
                .enabled = [this] { return steers() && !activity_->is_restarting(); },
                .relevant = has_saw,
                .button = Msg("Retract")});
  actions_.Add({.id = "saw.slower",
                .menu = Msg("Saw"),
                .label = Msg("Keys move the saw slower"),
                .shortcut = {Key::kLeftBracket},
                .run = [feed] { feed(1 / 1.25); },
                .enabled = cuts,
                .repeats = true});
  actions_.Add({.id = "saw.faster",
                .menu = Msg("Saw"),
                .label = Msg("Keys move the saw faster"),
                .shortcut = {Key::kRightBracket},
                .run = [feed] { feed(1.25); },
                .enabled = cuts,
                .repeats = true});
  const auto louder = [this](double percent) {
    sound_.SetVolume(sound_.volume_percent() + percent);
    settings_.volume = 0.01 * sound_.volume_percent();
    KeepSettings();
    Say(fmt::format(fmt::runtime(Tr("The volume is {} %.")), ShowNumber(sound_.volume_percent(), 0)));
  };
  actions_.Add({.id = "sound.mute",
                .menu = Msg("Saw"),
                .label = Msg("Sound"),
                .shortcut = {Key::kU},
                .run =
                    [this] {
                      sound_.SetMuted(!sound_.muted());
                      settings_.mute = sound_.muted();
                      KeepSettings();
                      std::string text = sound_.muted() ? Tr("The sound is off.") : Tr("The sound is on.");
                      if (!sound_.has_sound()) {
                        text += fmt::format(" {}", Tr("No sound can be played, because no audio device was found."));
                      }
                      Say(text);
                    },
                .on = [this] { return sound_.has_sound() && !sound_.muted(); },
                .indicator = Msg("Sound"),
                .state = [this] { return sound_.has_sound() ? nullptr : Tr("not available"); },
                .begins_group = true});
  actions_.Add({.id = "sound.quieter",
                .menu = Msg("Saw"),
                .label = Msg("Quieter"),
                .shortcut = {Key::kMinus},
                .run = [louder] { louder(-10); },
                .repeats = true});
  actions_.Add({.id = "sound.louder",
                .menu = Msg("Saw"),
                .label = Msg("Louder"),
                .shortcut = {Key::kEqual},
                .run = [louder] { louder(10); },
                .repeats = true});
  // ---- view
  actions_.Add({.id = "view.next",
                .menu = Msg("View"),
                .label = Msg("Next view: front, left, right, top, back, bottom, three-quarter"),
                .shortcut = {Key::kV},
                .run = [this] { LookNext(1); },
                .button = Msg("View")});
  actions_.Add({.id = "view.previous",
                .menu = Msg("View"),
                .label = Msg("Previous view"),
                .shortcut = {.key = Key::kV, .shift = true},
                .run = [this] { LookNext(-1); }});
  actions_.Add(
      {.id = "view.all", .menu = Msg("View"), .label = Msg("Show all"), .shortcut = {Key::kHome}, .run = [this] {
         shown_place_.reset();
         view_->FitAll();
       }});
  actions_.Add({.id = "view.translucent",
                .menu = Msg("View"),
                .label = Msg("Translucent bone: nerve and roots"),
                .shortcut = {Key::kT},
                .tip = Msg("Draws the bone like glass, so that the nerve canal and the roots of the teeth are visible"),
                .run =
                    [this] {
                      view_->set_translucent(!view_->translucent());
                      Say(view_->translucent() ? Tr("The bone is drawn translucent") : Tr("The bone is drawn solid"));
                    },
                .on = [this] { return view_->translucent(); },
                .indicator = Msg("Translucent"),
                .begins_group = true});
  actions_.Add({.id = "view.colours",
                .menu = Msg("View"),
                .label = Msg("Next colours: plain, tissue, region"),
                .shortcut = {Key::kM},
                .run = [this] {
                  const ColourBy next = view_->colour_by() == ColourBy::kPlain    ? ColourBy::kTissue
                                        : view_->colour_by() == ColourBy::kTissue ? ColourBy::kRegion
                                                                                  : ColourBy::kPlain;
                  view_->set_colour_by(next);
                  Say(next == ColourBy::kPlain    ? Tr("Colours: plain bone, cut faces by tissue")
                      : next == ColourBy::kTissue ? Tr("Colours: by tissue")
                                                  : Tr("Colours: by region of the material table"));
                }});
  actions_.Add({.id = "view.slices",
                .menu = Msg("View"),
                .label = Msg("Slices"),
                .shortcut = {Key::kX},
                .run =
                    [this] {
                      slices_shown_ = !slices_shown_;
                      if (slices_shown_ && bone_.surface() && !bone_.surface()->has_hu()) {
                        Say(Tr("This bone has no CT numbers: the slices show its tissues"));
                      }
                    },
                .on = [this] { return slices_shown_; }});
  actions_.Add({.id = "view.panels",
                .menu = Msg("View"),
                .label = Msg("Side panel"),
                .shortcut = {Key::kF4},
                .run = [this] { values_shown_ = !values_shown_; },
                .on = [this] { return values_shown_; }});
  actions_.Add({.id = "view.full_screen",
                .menu = Msg("View"),
                .label = Msg("Full screen"),
                .shortcut = {Key::kF11},
                .run = [this] { window_.set_full_screen(!window_.full_screen()); },
                .on = [this] { return window_.full_screen(); }});
  actions_.Add({.id = "view.picture",
                .menu = Msg("View"),
                .label = Msg("Save a picture"),
                .shortcut = {Key::kF12},
                .run = [this] { ++pictures_asked_; },
                .begins_group = true});
  actions_.Add({.id = "view.settings",
                .menu = Msg("View"),
                .label = Msg("Settings"),
                .shortcut = {Key::kF10},
                .tip = Msg("Colours, size of text, language, sound"),
                .run = [this] { settings_shown_ = !settings_shown_; },
                .on = [this] { return settings_shown_; }});
}

void ViewerApp::AddLastActions() {
  // These come after the activity's, so that its menus stand between View and Help.
  actions_.Add({.id = "help.keys",
                .menu = Msg("Help"),
                .label = Msg("Keys and mouse"),
                .shortcut = {Key::kF1},
                .run = [this] { ToggleHelp(); },
                .button = Msg("Help")});
  if (!activity_->tour().empty()) {
    actions_.Add({.id = "help.tour", .menu = Msg("Help"), .label = Msg("Tour of the window"), .run = [this] {
                    tour_.Start(activity_->tour());
                  }});
  }
  actions_.Add({.id = "help.about", .menu = Msg("Help"), .label = Msg("About kerf"), .run = [this] {
                  dialogs_.Ask(
                      fmt::format("kerf {}\n\n{}\n\n{}", VersionString(),
                                  Tr("For research and teaching; not a medical device."), Tr("Licence: Apache-2.0")),
                      {{Tr("OK"), nullptr}});
                }});
  actions_.Add({.id = "file.quit",
                .menu = Msg("File"),
                .label = Msg("Quit"),
                .shortcut = {.key = Key::kQ, .control = true},
                .run = [this] { AskToQuit(); },
                .begins_group = true});
}

void ViewerApp::ToggleHelp() {
  help_ = !help_;
  controls_->Release();
}

void ViewerApp::AskToQuit() {
  const std::string unsaved = activity_->DescribeUnsaved();
  if (unsaved.empty()) return Quit();
  SetSpindle(false);
  controls_->Release();
  dialogs_.Ask(unsaved, {{activity_->save_label(), [this] { activity_->Save(); }},
                         {Tr("Quit without saving"), [this] { Quit(); }},
                         {Tr("Stay"), nullptr}});
}

void ViewerApp::Retract() {
  if (spindle_on()) {
    return Say(Tr("The saw returns only with the spindle off; turn it off first (Space)"));
  }
  const std::optional<Pose> X_retreat = activity_->FindRetreat(*X_home_);
  if (device_ && device_->holds()) {
    controls_->Set({X_retreat.value_or(*X_home_).R_AB, figures_.coupled.X_WT.p_AB});
    return Say(Tr("The saw has its initial orientation; the handle sets its position"));
  }
  if (retracting_) return;
  controls_->Release();
  LoopAction retract{.kind = LoopAction::Kind::kRetract, .name = ""};
  if (X_retreat) {
    retract.X_to = X_retreat;
  } else if (const std::shared_ptr<const Bone> bone = bone_at_start()) {
    const ScreenBox area{areas_.scene.left, areas_.scene.top, areas_.scene.width, areas_.scene.height};
    retract.X_to = FindSeenPose(view_->camera(), area, PhiSampler(*bone), bone->CalcBounds(),
                                MakeTool(session_->scene()), *X_home_);
  }
  session_->Ask(std::move(retract));
  retracting_ = true;
  Say(Tr("Bringing the saw back..."));
  said_until_s_ = std::numeric_limits<double>::infinity();  // until the answer
}

}  // namespace kerf
