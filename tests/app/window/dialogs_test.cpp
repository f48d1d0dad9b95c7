// Dialogs that take all keys and clicks at once, as a slow window gets them.
#include "app/window/dialogs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "support/folder.h"
#include "view/ui/panels.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using Kind = WindowEvent::Kind;

class DialogsTest : public ::testing::Test {
 protected:
  DialogsTest() { ui_.SetSize(1280, 720, 1); }

  void Send(Kind kind, Key key, char32_t character = 0) {
    WindowEvent event;
    event.kind = kind;
    event.key = key;
    event.character = character;
    dialogs_.Take(ui_, event);
  }
  /// Queues the press, the letter and the release of each key; "\n" is Enter.
  void Type(const std::string& text) {
    for (const char c : text) {
      const bool letter = c >= 'a' && c <= 'z';
      const Key key = c == '\n' ? Key::kEnter : letter ? static_cast<Key>(c - 'a' + 'A') : Key::kNone;
      Send(Kind::kKeyDown, key);
      if (c != '\n') Send(Kind::kText, Key::kNone, static_cast<char32_t>(c));
      Send(Kind::kKeyUp, key);
    }
  }
  void Click(const UiBox& box) {
    WindowEvent event;
    event.x = box.left + 5;
    event.y = box.top + 5;
    for (const Kind kind : {Kind::kMouseMove, Kind::kMouseDown, Kind::kMouseUp}) {
      event.kind = kind;
      ui_.Take(event);
    }
  }
  /// Draws frames until no event waits and the dialog is idle, and returns how many had events.
  int Draw(double frame_s = 0.5) {
    int frames = 0;
    for (int idle = 0; idle < 4; ++idle) {
      if (ui_.has_waiting_events()) {
        ++frames;
        idle = 0;
      }
      ui_.BeginFrame(frame_s);
      dialogs_.Draw(ui_);
      ui_.EndFrame();
      dialogs_.RunDecided();
    }
    return frames;
  }

  Ui ui_;
  Dialogs dialogs_;
};

TEST_F(DialogsTest, LettersDoNotWaitForFrames) {
  std::optional<std::string> given;
  dialogs_.AskText(ui_, "Name?", "old", [&](const auto& text) { given = text; });
  Type("banana and more letters than frames\n");
  EXPECT_LT(Draw(), 10);
  EXPECT_EQ(given, "banana and more letters than frames");
}

TEST_F(DialogsTest, WhatIsTypedBehindARefusedTextReplacesIt) {
  std::optional<std::string> given;
  dialogs_.AskText(ui_, "Name?", "", [&](const auto& text) { given = text; });
  dialogs_.CheckText([](const std::string& text) { return text == "no" ? "Another one." : ""; });
  Type("no\nyes\n");
  Draw();
  EXPECT_EQ(given, "yes");
}

TEST_F(DialogsTest, WhatIsTypedBehindAFileThatIsNotThereReplacesIt) {
  const test::Folder folder;
  std::ofstream(folder.file("bar.toml")) << "x";
  std::string chosen;
  dialogs_.ChooseFile(ui_, "Open", folder.path(), {}, false, "", [&](const auto& file) { chosen = file; });
  Type("none.toml\nbar.toml\n");
  Draw();
  EXPECT_EQ(fs::path(chosen).filename(), "bar.toml");
}

// A panel appears in one of the frames from the one before the dialog to some with the text half typed: as where a
// session begins to run, whose panels appear then.
TEST_F(DialogsTest, APanelThatAppearsLeavesTheInputToTheDialog) {
  const auto frame = [&](const char* panel) {
    ui_.BeginFrame(0.02);
    if (panel != nullptr && BeginPanel(ui_, panel, {0, 0, 200, 300}, false)) EndPanel();
    dialogs_.Draw(ui_);
    ui_.EndFrame();
    dialogs_.RunDecided();
  };
  for (int appears = 0; appears < 20; ++appears) {
    std::optional<std::string> given;
    const std::string name = "panel " + std::to_string(appears);
    for (int i = 0; i < 24; ++i) {
      if (i == 1) dialogs_.AskText(ui_, "Name?", "", [&](const auto& text) { given = text; });
      if (i == 2) Type("one ");
      if (i == 10) Type("two");
      if (i == 14) Type("\n");
      frame(i >= appears ? name.c_str() : nullptr);
    }
    EXPECT_EQ(given, "one two") << "appears in frame " << appears;
    Send(Kind::kKeyDown, Key::kEscape);
    dialogs_.RunDecided();
    frame(nullptr);
  }
}

// The dialog gives its line of text the input in its first frames, which must not take a click away.
TEST_F(DialogsTest, AClickInTheFirstFramesOfADialogIsNotLost) {
  const test::Folder folder;
  std::ofstream(folder.file("notes.txt")) << "x";
  for (int clicked = 1; clicked < 10; ++clicked) {
    dialogs_.ChooseFile(ui_, "Open", folder.path(), {".toml"}, false, "", [](const auto&) {});
    for (int i = 0; i < clicked; ++i) {
      ui_.BeginFrame(0.1);
      dialogs_.Draw(ui_);
      ui_.EndFrame();
    }
    EXPECT_FALSE(ui_.noted().contains("file notes.txt"));
    Click(ui_.noted().at("dialog.all"));
    Draw(0.1);
    EXPECT_TRUE(ui_.noted().contains("file notes.txt")) << "clicked after frame " << clicked;
    Send(Kind::kKeyDown, Key::kEscape);
    Draw(0.1);
  }
}

TEST_F(DialogsTest, FilesWithoutAnExtensionAreListedWhereTheyCanBeOpened) {
  const test::Folder folder;
  for (const char* name : {"IM0001", "1.2.840.7", "ct.dcm", "notes.txt"}) std::ofstream(folder.file(name)) << "x";
  const auto listed = [&](std::vector<std::string> extensions) {
    dialogs_.ChooseFile(ui_, "Open", folder.path(), std::move(extensions), false, "", [](const auto&) {});
    Draw();
    std::vector<std::string> files;
    for (const auto& [name, box] : ui_.noted()) {
      if (name.starts_with("file ")) files.push_back(name.substr(5));
    }
    std::sort(files.begin(), files.end());
    return files;
  };
  EXPECT_EQ(listed({".dcm", ""}), (std::vector<std::string>{"1.2.840.7", "IM0001", "ct.dcm"}));
  EXPECT_EQ(listed({".dcm"}), std::vector<std::string>{"ct.dcm"});
}

TEST_F(DialogsTest, EnterAnswersNoQuestionThatNeedsAClick) {
  int answers = 0;
  const auto ask = [&] { dialogs_.Ask("Which?", {{"this", [&] { ++answers; }}, {"Cancel", nullptr}}); };
  const auto press = [&] {
    Send(Kind::kKeyDown, Key::kEnter);
    Draw();
  };
  ask();
  dialogs_.IgnoreEnter();
  press();
  EXPECT_EQ(answers, 0);
  EXPECT_TRUE(dialogs_.is_open());
  ask();
  press();
  EXPECT_EQ(answers, 1);
  EXPECT_FALSE(dialogs_.is_open());
}

TEST_F(DialogsTest, DoubleClickOnAFolderEntersOne) {
  const test::Folder folder;
  fs::create_directories(folder.file("a/b/c"));
  for (const double frame_s : {0.02, 0.2, 0.5}) {
    dialogs_.ChooseFile(ui_, "Open", folder.file("a"), {}, false, "", [](const auto&) {});
    for (int i = 0; i < 100; ++i) Draw(frame_s);  // no click came for a while
    ASSERT_TRUE(ui_.noted().contains("folder b"));
    const UiBox at = ui_.noted().at("folder b");
    Click(at);
    if (frame_s < 0.1) Draw(frame_s);  // a quick window draws frames between the clicks
    Click(at);
    Draw(frame_s);
    EXPECT_TRUE(ui_.noted().contains("folder c")) << frame_s;
  }
}

}  // namespace
}  // namespace kerf
