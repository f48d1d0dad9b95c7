#include "app/window/actions.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <vector>

#include "view/ui/panels.h"

namespace kerf {
namespace {

TEST(ActionList, ListsTheKeysOfAllActionsAlsoOfThoseThatCannotBeChosenNow) {
  ActionList actions;
  actions.Add({.id = "open", .menu = "File", .label = "Open", .shortcut = {Key::kO, true}, .run = [] {}});
  actions.Add({.id = "cut",
               .menu = "Saw",
               .label = "Cut",
               .shortcut = {Key::kSpace},
               .run = [] {},
               .enabled = [] { return false; }});
  actions.Add({.id = "no key", .menu = "Saw", .label = "Without a key", .run = [] {}});
  const std::vector<HudKeyGroup> all = actions.ListKeys();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].title, "Saw");
  ASSERT_EQ(all[1].keys.size(), 1u);
  EXPECT_EQ(all[1].keys[0].meaning, "Cut");
}

TEST(ActionList, ListsTheKeysOfEachStateApart) {
  ActionList actions;
  for (const char* when : {"while cutting", "at the result"}) {
    actions.Add(
        {.id = when, .menu = "Exercise", .label = "Go on", .shortcut = {Key::kEnter}, .when = when, .run = [] {}});
  }
  const std::vector<HudKeyGroup> all = actions.ListKeys();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].title, "Exercise: while cutting");
  EXPECT_EQ(all[1].title, "Exercise: at the result");
  EXPECT_EQ(all[0].keys.size(), 1u);
}

// A click while the saw is being changed is carried out afterwards; one while something can't be done at all is not.
TEST(ActionList, RunsWhatWasChosenWhileItWaited) {
  ActionList actions;
  bool enabled = false;
  int runs = 0;
  actions.Add({.id = "spin",
               .menu = "Saw",
               .label = "Spin",
               .run = [&] { ++runs; },
               .enabled = [&] { return enabled; },
               .button = "Spin"});
  Ui ui;
  ui.SetSize(400, 300, 1);
  const auto frames = [&](int count, const std::vector<WindowEvent>& events = {}) {
    for (const WindowEvent& event : events) ui.Take(event);
    for (int i = 0; i < count; ++i) {
      ui.BeginFrame(0.02);
      ASSERT_TRUE(BeginPanel(ui, "toolbar", {0, 0, 400, 36}, false));
      actions.DrawToolbar(ui);
      ImGui::End();
      ui.EndFrame();
      actions.RunChosen();
    }
  };
  const auto click = [&] {
    const UiBox at = ui.noted().at("button spin");
    WindowEvent event;
    event.x = at.left + 0.5 * at.width;
    event.y = at.top + 0.5 * at.height;
    event.kind = WindowEvent::Kind::kMouseMove;
    std::vector<WindowEvent> events{event};
    event.kind = WindowEvent::Kind::kMouseDown;
    events.push_back(event);
    event.kind = WindowEvent::Kind::kMouseUp;
    events.push_back(event);
    frames(6, events);
  };
  frames(3);
  click();
  EXPECT_EQ(runs, 0);
  actions.set_waits(true);
  click();
  EXPECT_EQ(runs, 0);
  actions.set_waits(false);
  enabled = true;
  frames(3);
  EXPECT_EQ(runs, 1);
  // What can't be done after the wait either is dropped.
  enabled = false;
  actions.set_waits(true);
  click();
  actions.set_waits(false);
  frames(2);
  enabled = true;
  frames(2);
  EXPECT_EQ(runs, 1);
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
