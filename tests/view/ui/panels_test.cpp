// Tests that panels stay inside the window and apart, and that their texts are legible.
#include "view/ui/panels.h"

#include <gtest/gtest.h>
#include <imgui_internal.h>

#include "support/colour_vision.h"
#include "support/view_scene.h"
#include "view/ui/banners.h"

namespace kerf {
namespace {

struct WindowSize {
  int width;
  int height;
  double scale;
};
constexpr WindowSize kSizes[] = {{1280, 720, 1}, {1920, 1080, 1}, {2560, 1440, 2}, {1024, 768, 1}, {1366, 700, 1},
                                 {800, 600, 1},  {640, 480, 1},   {3840, 1100, 1}, {640, 900, 1},  {640, 400, 1}};

// Submits all panels and returns the areas.
UiAreas DrawAll(Ui& ui, const HudState& hud) {
  UiAreas areas;
  for (int frame = 0; frame < 2; ++frame) {
    ui.BeginFrame(0.02);
    areas = CalcUiAreas(ui, true, true);
    if (BeginPanel(ui, "left", areas.left, true)) {
      GaugeSection(ui, hud);
      ValuesSection(ui, hud);
      PiecesSection(ui, hud);
      ForceSection(ui, hud);
      LegendSection(ui, hud);
      ImGui::End();
    }
    if (BeginPanel(ui, "right", areas.right, true)) ImGui::End();
    if (BeginPanel(ui, "toolbar", areas.toolbar, false)) ImGui::End();
    if (BeginPanel(ui, "status", areas.status, false)) ImGui::End();
    if (hud.banner) DrawBanner(ui, *hud.banner, areas.scene);
    DrawMessages(ui, {hud.status.message, "The saw is beside the plane", "The blade binds"}, areas.scene,
                 hud.progress ? CalcProgressBox(ui, areas.scene) : UiBox{});
    if (hud.progress) DrawProgressBox(ui, *hud.progress, areas.scene);
    ui.EndFrame();
  }
  return areas;
}

TEST(Messages, StayingMessageGivesWayToTheTool) {
  Ui ui;
  ui.SetSize(1280, 720, 1);
  const UiBox scene{262, 59, 1018, 629}, tool{450, 180, 380, 430}, far{450, 180, 380, 100};
  const auto place = [&](const UiBox& avoided) {
    ui.BeginFrame(0.02);
    DrawMessages(ui, {"", "", "The depth stop holds the saw"}, scene, {}, avoided, 120);
    const UiBox at = ui.noted().at("staying message");
    ui.EndFrame();
    return at;
  };
  EXPECT_GT(place(far).top, tool.bottom() - 40);
  EXPECT_TRUE(Overlap(place(far), tool));
  EXPECT_LT(place(tool).bottom(), 180);
  EXPECT_GE(place(tool).top, 120);
}

TEST(UiAreas, NeverOverlapOrLeaveTheWindow) {
  Ui ui;
  for (const WindowSize& size : kSizes) {
    for (const double text : {0.8, 1.0, 1.5, 2.0}) {
      ui.SetSize(size.width, size.height, size.scale);
      ui.set_text_size(text);
      ui.BeginFrame(0.02);
      ui.EndFrame();
      for (const bool left : {false, true}) {
        for (const bool right : {false, true}) {
          const UiAreas a = CalcUiAreas(ui, left, right);
          const UiBox boxes[] = {a.menu, a.toolbar, a.left, a.right, a.status, a.scene};
          for (std::size_t i = 0; i < std::size(boxes); ++i) {
            if (boxes[i].empty()) continue;
            EXPECT_GE(boxes[i].left, 0);
            EXPECT_GE(boxes[i].top, 0);
            EXPECT_LE(boxes[i].right(), size.width + 1e-9);
            EXPECT_LE(boxes[i].bottom(), size.height + 1e-9);
            for (std::size_t j = 0; j < i; ++j) {
              EXPECT_FALSE(!boxes[j].empty() && Overlap(boxes[i], boxes[j]))
                  << size.width << " x " << size.height << ", text " << text << ": " << i << " and " << j;
            }
          }
        }
      }
    }
  }
  ui.set_text_size(1);
}

TEST(UiAreas, MostOfTheWindowIsLeftForTheBone) {
  Ui ui;
  ui.SetSize(1280, 720, 1);
  ui.BeginFrame(0.02);
  ui.EndFrame();
  const UiAreas a = CalcUiAreas(ui, true, true);
  EXPECT_FALSE(a.left.empty());
  EXPECT_FALSE(a.right.empty());
  EXPECT_FALSE(a.cube.empty());
  EXPECT_GT(a.scene.width * a.scene.height, 0.5 * 1280 * 720);
}

TEST(UiPanels, BannerMessageAndProgressStayInTheScene) {
  Ui ui;
  HudState hud = test::MakeFullHud();
  hud.banner = HudBanner{HudBanner::Kind::kWarning,
                         "The nerve's canal is nearer than 2 mm: turn the blade away or draw it back before you go on",
                         "Enter: go on    Esc: stop"};
  hud.progress = HudProgress{"Loading body_osteotomy.toml", "meshing the surface of the bone", 0.42, 75, true};
  for (const WindowSize& size : kSizes) {
    ui.SetSize(size.width, size.height, size.scale);
    const UiAreas areas = DrawAll(ui, hud);
    for (const char* name : {"banner", "message", "staying message", "progress"}) {
      const ImGuiWindow* window = ImGui::FindWindowByName(name);
      if (window == nullptr || !window->WasActive) continue;
      EXPECT_GE(window->Pos.x, areas.scene.left - 1) << name << " " << size.width;
      EXPECT_LE(window->Pos.x + window->Size.x, areas.scene.right() + 1) << name << " " << size.width;
      EXPECT_GE(window->Pos.y, areas.scene.top - 1) << name << " " << size.width;
      EXPECT_LE(window->Pos.y + window->Size.y, areas.scene.bottom() + 1) << name << " " << size.width;
    }
    // The progress box, which is drawn last, hides no message.
    const ImGuiWindow* progress = ImGui::FindWindowByName("progress");
    if (progress == nullptr || !progress->WasActive) continue;
    for (const char* name : {"message", "staying message"}) {
      const ImGuiWindow* message = ImGui::FindWindowByName(name);
      if (message == nullptr || !message->WasActive) continue;
      EXPECT_LE(message->Pos.y + message->Size.y, progress->Pos.y) << name << " " << size.width;
    }
  }
}

// A banner that would cover much of the picture has one line until it is clicked.
TEST(UiPanels, LongBannersHaveOneLineUntilTheyAreClicked) {
  Ui ui;
  ui.SetSize(1024, 768, 1);
  ui.set_text_size(1.5);
  HudState hud = test::MakeFullHud();
  hud.banner =
      HudBanner{HudBanner::Kind::kWarning,
                "The session has ended. What was done can still be saved and exported, in another place if the "
                "one before is gone or full. The bone as it is now, the plan, the marks and the pieces are kept until "
                "the window is closed. If the folder of the session is full or gone, the recording ends here; what was "
                "recorded before can be replayed, and the bone can be cut again in a new session.",
                "Ctrl+Shift+S: save the project as   F9: export   Ctrl+O: open"};
  const std::vector<std::string> injuries{
      "Nerve, patient's left: severed. 4.2 mm³ removed at 25.1 mm left, 3.2 mm back.",
      "Tooth 4 from the middle, patient's left: cut. 3.1 mm³ removed at 20 mm left."};
  const auto draw = [&] {
    const UiAreas areas = DrawAll(ui, hud);
    for (int i = 0; i < 2; ++i) {
      ui.BeginFrame(0.02);
      DrawBanner(ui, *hud.banner, areas.scene);
      UiBox below = areas.scene;
      below.top = CalcBannerBottom(ui, *hud.banner, areas.scene);
      DrawInjuries(ui, injuries, below);
      ui.EndFrame();
    }
    return areas;
  };
  const auto share = [](const char* name, const UiAreas& areas) {
    return static_cast<double>(ImGui::FindWindowByName(name)->Size.y) / areas.scene.height;
  };
  const UiAreas areas = draw();
  EXPECT_LT(share("banner", areas), 0.16);
  EXPECT_LT(share("injuries", areas), 0.16);
  ui.set_shows_long_banners(true);
  draw();
  EXPECT_GT(share("banner", areas), 0.16) << "the whole text";
  ui.set_shows_long_banners(false);
  ui.set_text_size(1);
}

TEST(UiPanels, NothingIsCutOffAtTheNormalSize) {
  Ui ui;
  ui.SetSize(1280, 720, 1);
  HudState hud = test::MakeFullHud();
  DrawAll(ui, hud);
  for (const std::string& text : ui.cut_texts()) ADD_FAILURE() << "does not fit: " << text;
  hud.gauge->word = "a word that is much longer than the column of the gauge";
  DrawAll(ui, hud);
  EXPECT_EQ(ui.cut_texts().size(), 1u);
}

TEST(UiPanels, ClickOnAPieceIsReportedOnce) {
  Ui ui;
  ui.SetSize(1280, 720, 1);
  const HudState hud = test::MakeFullHud();
  const UiAreas areas = DrawAll(ui, hud);
  const UiBox row = ui.noted().at("piece 1");
  WindowEvent event;
  event.x = row.left + 0.5 * row.width;
  event.y = row.top + 0.5 * row.height;
  EXPECT_TRUE(ui.IsOnPanel(event.x, event.y));
  EXPECT_FALSE(ui.IsOnPanel(areas.scene.left + 300, areas.scene.top + 200));
  // Press and release arrive within one frame, as from a fast mouse or a slow machine.
  event.kind = WindowEvent::Kind::kMouseDown;
  ui.Take(event);
  event.kind = WindowEvent::Kind::kMouseUp;
  ui.Take(event);
  int clicks = 0;
  for (int frame = 0; frame < 5; ++frame) {
    ui.BeginFrame(0.02);
    if (BeginPanel(ui, "left", areas.left, true)) {
      GaugeSection(ui, hud);
      ValuesSection(ui, hud);
      if (const std::optional<int> picked = PiecesSection(ui, hud)) {
        EXPECT_EQ(*picked, 1);
        ++clicks;
      }
      ImGui::End();
    }
    ui.EndFrame();
  }
  EXPECT_EQ(clicks, 1);
}

TEST(Ui, KeysWaitForTheTextFieldThatIsExpected) {
  Ui ui;
  ui.SetSize(800, 600, 1);
  std::string text = "old";
  ui.ExpectText(true);
  WindowEvent event;
  event.kind = WindowEvent::Kind::kText;
  for (const char32_t c : U"n\u00e4") {
    event.character = c;
    if (c != 0) ui.Take(event);
  }
  for (int frame = 0; frame < 6; ++frame) {
    ui.BeginFrame(0.02);
    ImGui::Begin("field");
    if (frame == 0) ImGui::SetKeyboardFocusHere();
    char buffer[64] = {};
    text.copy(buffer, sizeof buffer - 1);
    ImGui::InputText("##text", buffer, sizeof buffer, ImGuiInputTextFlags_AutoSelectAll);
    text = buffer;
    ImGui::End();
    ui.EndFrame();
  }
  EXPECT_TRUE(ui.takes_text());
  EXPECT_EQ(text, "n\xC3\xA4");  // the initial text was selected, and is replaced
  ui.DropText();
  EXPECT_FALSE(ui.takes_text());
}

// WCAG 2 requires a contrast of 4.5 for text.
TEST(UiColours, TextHasContrastWithItsBackground) {
  for (const Theme theme : {Theme::kLight, Theme::kDark}) {
    const UiColours& c = ColoursOf(theme);
    for (const Rgb8& ground : {c.ground, c.panel, c.selected, c.button}) {
      EXPECT_GT(test::CalcContrast(c.text, ground), 4.5);
    }
    EXPECT_GT(test::CalcContrast(c.faint, c.panel), 4.5);
    EXPECT_GT(test::CalcContrast(c.faint, c.ground), 4.5);
    EXPECT_GT(test::CalcContrast(c.accent, c.panel), 4.5);
  }
}

TEST(UiColours, LevelsAreDistinguishableWithAnyColourVision) {
  test::ExpectApart({LevelColour(HudLevel::kGood), LevelColour(HudLevel::kWarn), LevelColour(HudLevel::kBad)}, 20,
                    "level");
}

}  // namespace
}  // namespace kerf
