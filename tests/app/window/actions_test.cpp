#include "app/window/actions.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace kerf
