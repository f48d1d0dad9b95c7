// Contents of the panels, and what is drawn over the picture.
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "app/window/settings_panel.h"
#include "app/window/viewer_app.h"
#include "view/live/palette.h"
#include "view/ui/banners.h"
#include "view/ui/widgets.h"

namespace kerf {

HudState ViewerApp::MakeHud() {
  HudState hud;
  const bool restarts = activity_->is_restarting();
  hud.show_values = (session_ != nullptr && began_) || restarts;
  hud.show_plot = hud.show_values;
  hud.values.feed_mm_per_s = figures_.feed_mm_per_s;
  hud.values.rpm = std::abs(figures_.in.rpm);
  hud.values.force_N = glm::length(figures_.coupled.f_H_W_N);
  hud.now_s = figures_.time_s;
  if (session_) {
    LiveSession::ForceNote note = session_->MakeForceNote(figures_);
    hud.force_note = std::move(note.text);
    hud.force_details = std::move(note.details);
  }
  const auto recent = std::lower_bound(forces_.begin(), forces_.end(), figures_.time_s - 10.5,
                                       [](const PlotPoint& p, double t) { return p.time_s < t; });
  hud.force.assign(recent, forces_.end());
  hud.status.spindle_on = spindle_on();
  if (session_) hud.values.strokes = CalcStroke(session_->scene().tool.shape) > 0;
  if (session_) hud.status.saw = TrMade(DescribeTool(session_->scene().tool.shape));
  if (now_s_ < said_until_s_) hud.status.message = said_;
  if (now_s_ < warned_until_s_) hud.status.warning = warned_;
  if (is_running()) hud.status.recording_s = figures_.time_s;
  // Some deadlines are missed on every machine, without harm; a noticeable fraction is reported.
  const double missed =
      static_cast<double>(figures_.missed) / static_cast<double>(figures_.number + figures_.missed + 1);
  if (missed > 0.02) {
    hud.status.right = fmt::format(fmt::runtime(Tr("machine too slow: {:.0f} % of ticks late")), 100 * missed);
  }
  hud.legend = view_->legend();
  hud.legend_title = LegendTitle(view_->colour_by());
  if (const std::optional<WorkProgress> now = progress()) {
    const bool loading = session_->stage() == LiveStage::kLoading;
    hud.progress = HudProgress{.title = loading ? Tr("Loading") : Tr("Ending the session"),
                               .stage = Tr(now->stage.c_str()),
                               .fraction = now->fraction};
  }
  activity_->Fill(hud);
  if (activity_->covers_scene()) {
    // What is known of the bone behind does not belong to what is asked.
    hud.show_values = hud.show_plot = false;
    hud.pieces.clear();
    hud.injuries.clear();
    hud.banner.reset();
    return hud;
  }
  // The column keeps its layout, so that a click does not meet something else.
  HudState& from = restarts ? values_before_ : hud;
  HudState& to = restarts ? hud : values_before_;
  to.values = from.values;
  to.gauge = from.gauge;
  to.injuries = from.injuries;
  if (device_ && is_running() && !options_.scripted) {
    if (std::optional<HudBanner> banner = device_->MakeBanner()) hud.banner = std::move(banner);
  }
  return hud;
}

HudKeyGroup Activity::saw_help() const {
  return {Tr("Moving the saw"),
          {{Tr("left drag"), Tr("move across the picture")},
           {Tr("Shift + left drag"), Tr("move into the picture")},
           {Tr("Ctrl + left drag"), Tr("turn")},
           {Tr("arrows, PgUp PgDn"), Tr("the same with keys; with Shift fast")},
           {"W S  A D  Q E", Tr("tilt, swing, roll")}}};
}

std::vector<HudKeyGroup> ViewerApp::ListHelp() const {
  std::vector<HudKeyGroup> help;
  if (activity_->cuts()) help.push_back(activity_->saw_help());
  help.push_back({Tr("Turning the view"),
                  {{Tr("right drag"), Tr("turn")},
                   {Tr("middle drag"), Tr("shift (or Shift + right drag)")},
                   {Tr("wheel"), Tr("zoom")},
                   {Tr("right click"), Tr("menu for this place")}}});
  if (device_ && !options_.scripted) help.push_back(device_->MakeHelp());
  std::vector<HudKeyGroup> of_actions = actions_.ListKeys();
  for (HudKeyGroup& group : activity_->help()) {
    const auto same = std::find_if(of_actions.begin(), of_actions.end(),
                                   [&](const HudKeyGroup& g) { return g.title == group.title; });
    if (same == of_actions.end()) {
      help.push_back(std::move(group));
    } else {
      same->keys.insert(same->keys.end(), group.keys.begin(), group.keys.end());
    }
  }
  help.insert(help.end(), of_actions.begin(), of_actions.end());
  return help;
}

/// Returns the area of points on the screen; empty without any.
UiBox ViewerApp::CalcBox(const std::vector<Vec3>& points_W) const {
  double left = 1e9, top = 1e9, right = -1e9, bottom = -1e9;
  for (const Vec3& p_W : points_W) {
    const std::optional<ScreenPoint> at = view_->camera().Project(p_W);
    if (!at) continue;
    left = std::min(left, at->x);
    right = std::max(right, at->x);
    top = std::min(top, at->y);
    bottom = std::max(bottom, at->y);
  }
  const double rim = 8 * ui_.scale();
  return left > right ? UiBox{} : UiBox{left - rim, top - rim, right - left + 2 * rim, bottom - top + 2 * rim};
}

/// Returns labels and scale bar. During a cut, labels that do not matter give way to it.
PictureMarks ViewerApp::MakePictureMarks() const {
  PictureMarks marks;
  if (const std::optional<ScreenPoint> cut = view_->FindCut()) marks.cut = UiSpot{cut->x, cut->y};
  for (const SceneLabel& label : view_->ListLabels()) {
    marks.labels.push_back({label.text, label.x, label.y, label.colour, marks.cut && !label.matters});
  }
  for (const ScreenPoint& at : view_->ListMeasuredPoints()) {
    const double r = 9 * ui_.scale();
    marks.kept_clear.push_back({at.x - r, at.y - r, 2 * r, 2 * r});
  }
  const ScreenBox tool = view_->CalcToolBox();
  marks.tool = {tool.left, tool.top, tool.width, tool.height};
  if (const auto at = IsSawOutside() ? view_->camera().Project(figures_.coupled.X_WT.p_AB) : std::nullopt) {
    marks.beyond = UiSpot{at->x, at->y};
  }
  marks.mm_per_pixel = view_->camera().WorldPerPixel(view_->camera().target_W());
  marks.keep_clear = CalcBox(activity_->kept_clear_W());
  return marks;
}

void ViewerApp::DrawUi(const HudState& hud) {
  const bool column = values_shown_ && (hud.show_values || !hud.pieces.empty());
  const UiAreas before = std::exchange(areas_, CalcUiAreas(ui_, column, slices_shown_ && activity_->has_slices()));
  const bool lack_room = slices_shown_ && activity_->has_slices() && slices_.has_slices() && areas_.right.empty();
  if (lack_room && !slices_lack_room_) {
    Say(Tr(
        "There is no room for the slices: hide the side panel (F4), make the text smaller (F10) or the window wider."));
  }
  slices_lack_room_ = lack_room;
  // Until the user turns the view, the whole bone is shown.
  if (before.scene.width != areas_.scene.width && !view_changed_) fit_again_ = bone_.surface() != nullptr;
  const bool is_covered = activity_->covers_scene();
  // Labels first: they are drawn in the background.
  PictureMarks marks = MakePictureMarks();
  for (const SceneRing& ring : view_->ListRings()) {
    const HudLevel level = ring.level == AlarmLevel::kDanger    ? HudLevel::kBad
                           : ring.level == AlarmLevel::kWarning ? HudLevel::kWarn
                                                                : HudLevel::kPlain;
    marks.rings.push_back({ring.x, ring.y, level});
    if (level == HudLevel::kBad || (level == HudLevel::kWarn && marks.alarm != HudLevel::kBad)) marks.alarm = level;
  }
  marks.injured = !hud.injuries.empty();
  DrawPictureMarks(ui_, marks, areas_.scene);

  actions_.set_waits(waits());
  if (ImGui::BeginMainMenuBar()) {
    actions_.DrawMenus(ui_);
    ImGui::EndMainMenuBar();
  }
  if (BeginPanel(ui_, "toolbar", areas_.toolbar, false)) {
    actions_.DrawToolbar(ui_);
    ImGui::End();
  }
  if (column && BeginPanel(ui_, "left", areas_.left, true)) {
    GaugeSection(ui_, hud);
    ValuesSection(ui_, hud);
    if (const std::optional<int> row = PiecesSection(ui_, hud)) activity_->PickPieceRow(*row);
    if (activity_->shows_force_first()) ForceSection(ui_, hud);
    activity_->DrawSections(ui_);
    if (!activity_->shows_force_first()) ForceSection(ui_, hud);
    LegendSection(ui_, hud);
    ImGui::End();
  }
  if (slices_shown_ && activity_->has_slices() && slices_.has_slices() && !activity_->covers_slices()) {
    UiBox enlarged = areas_.scene;  // below what the user is asked to do
    if (hud.banner) {
      const double top = CalcBannerBottom(ui_, *hud.banner, areas_.scene);
      enlarged.height -= top - enlarged.top;
      enlarged.top = top;
    }
    slices_.Draw(
        ui_, areas_.right, enlarged, MakeSliceScene(),
        {.wanted = activity_->wants_slice_points(),
         .take = [this](const Vec3& p_W) { activity_->TakeSlicePoint(p_W); },
         .take_back = [this] { activity_->TakeBackSlicePoint(); },
         .move = [this](std::size_t i, const Vec3& p_W, bool first) { activity_->MoveSlicePoint(i, p_W, first); }});
  }
  if (BeginPanel(ui_, "status", areas_.status, false)) {
    // What the activity shows here, such as the clock of an exercise, is always visible, if necessary in short.
    const std::string least = ListStatusTexts(hud.status).back();
    const float reserved = ImGui::CalcTextSize(least.c_str()).x + 24 * ui_.scale();
    // Those of the case before do not belong to what covers it.
    DrawStatusTexts(hud.status, activity_->covers_scene() ? 0 : actions_.DrawIndicators(ui_, reserved));
    ImGui::End();
  }
  if (hud.banner) DrawBanner(ui_, *hud.banner, areas_.scene);
  UiBox below = areas_.scene;
  if (hud.banner) {
    below.top = CalcBannerBottom(ui_, *hud.banner, areas_.scene);
    below.height = areas_.scene.bottom() - below.top;
  }
  // While the user is asked to click a place, only the question covers the picture; its red frame stays.
  if (!hud.banner || hud.banner->kind != HudBanner::Kind::kQuestion) DrawInjuries(ui_, hud.injuries, below);
  if (!is_covered) {
    DrawMessages(ui_, {hud.status.message, hud.status.warning, DescribeStaying()}, areas_.scene,
                 hud.progress ? CalcProgressBox(ui_, areas_.scene) : activity_->bottom_box(),
                 hud.injuries.empty() ? marks.tool : UiBox{}, below.top);
  }
  if (hud.progress && DrawProgressBox(ui_, *hud.progress, areas_.scene)) activity_->Cancel();
  if (hud.menu) {
    if (const std::optional<int> row = DrawMenuDialog(ui_, *hud.menu)) picked_row_ = row;
  }
  activity_->DrawWindows(ui_);
  if (settings_shown_ && DrawSettings(ui_, areas_.scene, languages_, settings_, settings_shown_)) {
    ApplySettings();
    KeepSettings();
    tour_.SetSteps(activity_->tour());
    activity_->Relabel();
    trace_.Write("settings", {{"text_size", settings_.text_size},
                              {"language", CurrentLanguage()},
                              {"theme", settings_.theme == Theme::kDark ? "dark" : "light"},
                              {"mute", settings_.mute}});
  }
  // Not over a question.
  if (tour_.is_open() && !dialogs_.is_open() && !activity_->covers_scene()) {
    tour_.Draw(ui_, areas_.scene, areas_.cube, {marks.keep_clear}, !help_ && !settings_shown_ && !ui_.is_popup_open());
    NoteTour();
  }
  if (help_) DrawHelpDialog(ui_, ListHelp());
  const bool was_open = dialogs_.is_open();
  dialogs_.Draw(ui_);
  if (was_open && !dialogs_.is_open()) ui_.DropText();  // the next key is not meant for its field
}

/// Returns the texts of the status from the longest to the shortest.
std::vector<std::string> ViewerApp::ListStatusTexts(const HudStatus& status) {
  std::string recording, time;
  if (status.recording_s) {
    const long seconds = std::lround(std::max(0.0, *status.recording_s));
    recording = fmt::format(fmt::runtime(Tr("recording {}:{:02}")), seconds / 60, seconds % 60);
    time = fmt::format("{}:{:02}", seconds / 60, seconds % 60);
  }
  const auto join = [](const std::initializer_list<std::string>& parts) {
    std::string text;
    for (const std::string& part : parts) {
      if (!part.empty()) text += (text.empty() ? "" : "   |   ") + part;
    }
    return text;
  };
  std::vector<std::string> texts{join({status.right, status.mode, status.saw, recording})};
  if (!status.short_mode.empty()) {
    texts.push_back(join({status.right, status.mode, status.short_saw}));
    texts.push_back(join({status.right, status.short_mode, status.short_saw}));
    texts.push_back(join({status.short_right, status.short_mode, status.short_saw}));
  } else {
    texts.push_back(join({status.right, status.mode, recording}));
    texts.push_back(join({status.right, recording}));
    texts.push_back(join({status.right, time}));
  }
  return texts;
}

/// `left`: right edge of what stands before.
void ViewerApp::DrawStatusTexts(const HudStatus& status, float left) {
  const std::vector<std::string> texts = ListStatusTexts(status);
  const float from = left + 12 * ui_.scale();
  const float room = ImGui::GetWindowWidth() - from - 10 * ui_.scale();
  if (room < ImGui::CalcTextSize("00:00").x) return;
  // What does not fit is in the tooltip.
  const auto fits = [room](const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x <= room; };
  const auto first = std::find_if(texts.begin(), texts.end(), fits);
  const std::string shown = FitText(first == texts.end() ? texts.back() : *first, room);
  ImGui::SameLine(ImGui::GetWindowWidth() - ImGui::CalcTextSize(shown.c_str()).x - 10 * ui_.scale());
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("%s", shown.c_str());
  if (shown != texts.front()) Tooltip(ui_, texts.front());
}

}  // namespace kerf
