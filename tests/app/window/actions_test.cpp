#include "app/window/actions.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include "view/ui/panels.h"

namespace kerf {
namespace {

TEST(ActionList, ListsAllKeysWhileNothingCanBeDone) {
  ActionList actions;
  bool runs = false;
  actions.Add({.id = "open", .menu = "File", .label = "Open", .shortcut = {Key::kO, true}, .run = [] {}});
  actions.Add({.id = "cut",
               .menu = "Saw",
               .label = "Cut",
               .shortcut = {Key::kSpace},
               .run = [] {},
               .enabled = [&] { return runs; }});
  actions.Add({.id = "no key", .menu = "Saw", .label = "Without a key", .run = [] {}});
  EXPECT_EQ(actions.ListKeys(false).size(), 1u);
  const std::vector<HudKeyGroup> all = actions.ListKeys(true);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].title, "Saw");
  ASSERT_EQ(all[1].keys.size(), 1u);
  EXPECT_EQ(all[1].keys[0].meaning, "Cut");
  runs = true;
  EXPECT_EQ(actions.ListKeys(false).size(), 2u);
}

// Buttons that do not fit are replaced by an ellipsis, and indicators leave the room that is reserved.
TEST(ActionList, FitsToolbarAndIndicatorsIntoTheirWidth) {
  ActionList actions;
  for (int i = 0; i < 8; ++i) {
    actions.Add({.id = fmt::format("{}", i),
                 .menu = "Saw",
                 .label = "Do it",
                 .run = [] {},
                 .on = [] { return false; },
                 .button = "Button",
                 .indicator = "Indicator"});
  }
  const auto draw = [&](Ui& ui, double width) {
    for (int i = 0; i < 2; ++i) {
      ui.BeginFrame(0.02);
      ASSERT_TRUE(BeginPanel(ui, "toolbar", {0, 0, width, 36}, false));
      actions.DrawToolbar(ui);
      ImGui::End();
      ASSERT_TRUE(BeginPanel(ui, "status", {0, 40, width, 36}, false));
      actions.DrawIndicators(ui, 200);
      ImGui::End();
      ui.EndFrame();
    }
  };
  Ui ui;
  ui.SetSize(1600, 480, 1);
  draw(ui, 1600);
  EXPECT_TRUE(ui.noted().contains("button 7"));
  EXPECT_FALSE(ui.noted().contains("button more"));
  EXPECT_TRUE(ui.noted().contains("indicator 7"));
  EXPECT_FALSE(ui.noted().contains("indicators more"));
  draw(ui, 400);
  EXPECT_FALSE(ui.noted().contains("button 7"));
  ASSERT_TRUE(ui.noted().contains("button more"));
  EXPECT_LE(ui.noted().at("button more").right(), 400);
  int indicators = 0;
  for (const auto& [name, box] : ui.noted()) {
    if (!name.starts_with("indicator")) continue;
    ++indicators;
    EXPECT_LE(box.right(), 200) << name;
  }
  EXPECT_GE(indicators, 2) << "one, and the menu with the others";
  EXPECT_FALSE(ui.noted().contains("indicator 7"));
  ASSERT_TRUE(ui.noted().contains("indicators more"));
  // Too narrow for any: the menu has them all.
  draw(ui, 260);
  EXPECT_FALSE(ui.noted().contains("indicator 0"));
  EXPECT_TRUE(ui.noted().contains("indicators more"));
}

}  // namespace
}  // namespace kerf
