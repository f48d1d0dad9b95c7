// Tests the panels of `kerf practise`: no text is cut off, also in a language with longer texts, and clicks and keys
// choose what they say.
#include "app/window/practice_panel.h"
#include "app/window/dialogs.h"
#include "app/window/exercise_list.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <utility>

#include "session/practise/exercises.h"
#include "session/score/measures.h"
#include "support/folder.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Writes a catalogue of GNU gettext (manual, "The Format of GNU MO Files").
void WriteCatalogue(const std::string& path, const std::map<std::string, std::string>& texts) {
  const auto count = static_cast<std::uint32_t>(texts.size());
  std::vector<std::uint32_t> head{0x950412de, 0, count, 28, 28 + 8 * count, 0, 28 + 16 * count};
  std::vector<std::uint32_t> keys, values;
  std::string bytes;
  const auto add = [&](std::vector<std::uint32_t>& table, const std::string& text) {
    table.push_back(static_cast<std::uint32_t>(text.size()));
    table.push_back(static_cast<std::uint32_t>(28 + 16 * count + bytes.size()));
    bytes += text + '\0';
  };
  for (const auto& [key, value] : texts) add(keys, key);
  for (const auto& [key, value] : texts) add(values, value);
  head.insert(head.end(), keys.begin(), keys.end());
  head.insert(head.end(), values.begin(), values.end());
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(head.data()), 4 * head.size()) << bytes;
}

// Returns translations that are 30 % longer than the English texts.
std::map<std::string, std::string> MakeLongTexts() {
  std::map<std::string, std::string> texts{{"", "Content-Type: text/plain; charset=UTF-8\n"}};
  const auto add = [&](const std::string& text) { texts[text] = text + std::string((text.size() * 3 + 9) / 10, 'e'); };
  for (const MeasureInfo& info : Measures()) add(LabelOf(info));
  for (const Exercise& exercise : ListExercises()) {
    add(exercise.title);
    add(exercise.goal_message.text);
  }
  for (const char* text : {"Level {}",
                           "Level {} (recommended)",
                           "Level",
                           "Best",
                           "Aids",
                           "Trend",
                           "Exercise",
                           "\u2191 rising",
                           "\u2192 steady",
                           "\u2193 falling",
                           "all aids",
                           "no depth stop",
                           "gauge and blade colour",
                           "gauge only",
                           "no aids",
                           "From above",
                           "From the side",
                           "Figure",
                           "Value",
                           "Goal",
                           "Points lost",
                           "Depth over time (mm)",
                           "Exercises of {}, easy to hard",
                           "Exercises, easy to hard",
                           "Depth stop",
                           "Colour of the blade",
                           "Depth gauge and advice",
                           "Try again",
                           "Try level {} again",
                           "Go on with level {}",
                           "Watch beside the expert",
                           "Other exercises",
                           "Next level",
                           "From the beginning",
                           "Back to the result",
                           "you: {}",
                           "expert: {}",
                           "wanted",
                           "made",
                           "bone",
                           "line to follow"}) {
    add(text);
  }
  return texts;
}

WindowEvent KeyDown(Key key) {
  WindowEvent event;
  event.kind = WindowEvent::Kind::kKeyDown;
  event.key = key;
  return event;
}

Attempt MakeGraded(const std::string& exercise, int level, double total) {
  Attempt attempt;
  attempt.exercise = exercise;
  attempt.level = level;
  attempt.total = total;
  return attempt;
}

ExerciseList MakeList(const char* student, const char* recommended = "groove") {
  std::vector<Attempt> attempts;
  for (const double total : {40.0, 55.0, 64.0}) attempts.push_back(MakeGraded("groove", 1, total));
  for (const double total : {90.0, 60.0, 31.0}) attempts.push_back(MakeGraded("bicortical", 3, total));
  for (const double total : {50.0, 50.0, 50.0}) attempts.push_back(MakeGraded("mandibulotomy", 5, total));
  std::vector<ExerciseRow> rows = ListProgress(attempts);
  NextStep next = Recommend(attempts, recommended, 1, 50.0);
  return ExerciseList(std::move(rows), student, std::move(next));
}

// A groove 0.4 mm too deep, with pictures of the wanted and the made cut.
ScoreSheet MakeGrooveSheet() {
  ScoreSheet sheet = MakeSheet(ExerciseKind::kGroove);
  sheet.exercise = MakeExerciseScene("groove", 1).exercise;
  sheet.level = 1;
  for (const MeasureInfo& info : Measures()) SetValue(sheet, info.key, 1.25);
  SetValue(sheet, "too_deep_mm", 0.4);
  for (const char* key : {"cut_share", "line_share"}) SetValue(sheet, key, 1);
  CalcTotal(sheet);
  CutView view;
  view.wanted = {{{0, -0.2}, {16, -0.2}, {16, 0.2}, {0, 0.2}, {0, -0.2}}};
  view.made = {{{0, 0.1}, {16, 0.1}, {16, 0.5}, {0, 0.5}, {0, 0.1}}};
  view.bone = {{{-4, -3}, {20, -3}}};
  view.line = {{0, 0}, {16, 0}};
  view.left_mm = -4;
  view.right_mm = 20;
  view.bottom_mm = -3;
  view.top_mm = 3;
  sheet.picture = CutPicture{view, view, 10};
  return sheet;
}

ReplayPair MakePair() {
  ReplayPair pair;
  for (int i = 0; i <= 100; ++i) {
    pair.student_depth.push_back({0.1 * i, 0.02 * i});
    pair.expert_depth.push_back({0.1 * i, 0.015 * i});
  }
  return pair;
}

class PracticePanel : public testing::Test {
 protected:
  void SetUp() override { ui_.SetSize(1280, 720, 1); }

  void Frame(const std::function<void()>& draw) {
    ui_.BeginFrame(0.02);
    draw();
    ui_.EndFrame();
  }
  // Presses and releases the left button on an item of the last frame.
  void Click(const std::string& item, const std::function<void()>& draw) {
    ASSERT_TRUE(ui_.noted().contains(item)) << item;
    const UiBox box = ui_.noted().at(item);
    WindowEvent event;
    event.x = box.left + 0.5 * box.width;
    event.y = box.top + 0.5 * box.height;
    for (const auto kind :
         {WindowEvent::Kind::kMouseMove, WindowEvent::Kind::kMouseDown, WindowEvent::Kind::kMouseUp}) {
      event.kind = kind;
      ui_.Take(event);
      Frame(draw);
    }
    Frame(draw);
  }
  ResultChoice Result(const NextStep& next) {
    return DrawResult(ui_, {.title = Tr("Groove of 2 mm"),
                            .level = 1,
                            .sheet = sheet_,
                            .review = review_,
                            .next = next,
                            .verified = true,
                            .stored = "The attempt is not saved, because no user is named.",
                            .asks_name = true,
                            .expert_ready = true,
                            .waits_s = std::nullopt});
  }
  void ExpectNothingCut(const char* what) {
    for (const std::string& text : ui_.cut_texts()) ADD_FAILURE() << what << ": does not fit: " << text;
    // Buttons lie within the window, so that they can be clicked.
    for (const auto& [name, box] : ui_.noted()) {
      if (!name.starts_with("practise.")) continue;
      EXPECT_GE(box.left, 0) << what << ": " << name;
      EXPECT_LE(box.right(), 1280) << what << ": " << name;
    }
  }
  void ExpectAllFits() {
    for (const char* student : {"", "Ann"}) {
      ExerciseList list = MakeList(student);
      for (int i = 0; i < 2; ++i) Frame([&] { list.Draw(ui_); });
      ExpectNothingCut("exercises");
      list.Take(KeyDown(Key::kEnter));
      for (int i = 0; i < 2; ++i) Frame([&] { list.Draw(ui_); });
      ExpectNothingCut("levels");
    }
    for (int i = 0; i < 2; ++i) Frame([&] { Result(repeat_); });
    ExpectNothingCut("result");
    for (const char* button : {"practise.step", "practise.watch", "practise.list"}) {
      EXPECT_LE(ui_.noted().at(button).bottom(), 720 - 32) << button;
    }
    double time_s = 1;
    for (int i = 0; i < 2; ++i) Frame([&] { DrawReplay(ui_, pair_, 2, 78, true, time_s, {0, 59, 1280, 629}); });
    ExpectNothingCut("replay");
    EXPECT_LE(ui_.noted().at("practise.result").bottom(), 59 + 629 - 52);
    for (int i = 0; i < 2; ++i) {
      Frame([&] {
        ASSERT_TRUE(BeginPanel(ui_, "left", CalcUiAreas(ui_, true, true).left, true));
        DrawAids(ui_, ListAids(MakeExerciseScene("groove", 1).exercise, true, true));
        EndPanel();
      });
    }
    ExpectNothingCut("aids");
  }

  Ui ui_;
  ScoreSheet sheet_ = MakeGrooveSheet();
  ExerciseReview review_ = MakeReview(sheet_);
  NextStep repeat_{NextStep::Kind::kRepeat, "groove", 1, {"Try this level again.", {}}};
  NextStep next_{NextStep::Kind::kNextLevel, "groove", 2, {"Go on.", {}}};
  ReplayPair pair_ = MakePair();
};

TEST_F(PracticePanel, NothingIsCutOff) {
  SetLanguage("en");
  ExpectAllFits();
}

TEST_F(PracticePanel, NothingIsCutOffInALanguageWithLongerTexts) {
  const test::Folder folder;
  WriteCatalogue(folder.path() + "/kerf/locale/xl/LC_MESSAGES/kerf.mo", MakeLongTexts());
  setenv("XDG_DATA_HOME", folder.path().c_str(), 1);
  SetLanguage("xl");
  EXPECT_STREQ(Tr("made"), "madeee");
  ExpectAllFits();
  SetLanguage("en");
  unsetenv("XDG_DATA_HOME");
}

// In the smallest window with large text, names and figures can be read, and buttons can be clicked.
TEST_F(PracticePanel, SmallWindowWithLargeTextIsUsable) {
  SetLanguage("en");
  ui_.SetSize(640, 480, 1);
  ui_.set_text_size(1.5);
  const auto expect_button = [&](const char* name) {
    ASSERT_TRUE(ui_.noted().contains(name)) << name;
    const UiBox& box = ui_.noted().at(name);
    EXPECT_GE(box.left, 0) << name;
    EXPECT_LE(box.right(), 640) << name;
    EXPECT_LE(box.bottom(), 480 - 32 * 1.5) << name;
  };
  const auto expect_whole = [&](const std::string& text) {
    const std::vector<std::string>& cut = ui_.cut_texts();
    EXPECT_EQ(std::find(cut.begin(), cut.end(), text), cut.end()) << text;
  };
  ExerciseList list = MakeList("Ann");
  for (int i = 0; i < 3; ++i) Frame([&] { list.Draw(ui_); });
  for (const Exercise& exercise : ListExercises()) expect_whole(exercise.title);
  // The list begins with the recommended row, whole, and each row has its scores.
  list = MakeList("Ann", "mandibulotomy");
  Frame([] {});
  for (int i = 0; i < 3; ++i) Frame([&] { list.Draw(ui_); });
  EXPECT_LE(ui_.noted().at("exercise mandibulotomy").bottom(), 480 - 32 * 1.5);
  // A text in a column as wide as a letter is cut to nothing, so the columns have some width.
  EXPECT_GT(ui_.noted().at("exercise groove").width, 400);
  expect_button("practise.recommended");
  // So it does if the text becomes larger while the list is open.
  list = MakeList("Ann", "mandibulotomy");
  ui_.set_text_size(1);
  for (int i = 0; i < 3; ++i) Frame([&] { list.Draw(ui_); });
  ui_.set_text_size(1.5);
  for (int i = 0; i < 4; ++i) Frame([&] { list.Draw(ui_); });
  EXPECT_LE(ui_.noted().at("exercise mandibulotomy").bottom(), 480 - 32 * 1.5);
  list.Take(KeyDown(Key::kEnter));
  for (int i = 0; i < 3; ++i) Frame([&] { list.Draw(ui_); });
  expect_button("practise.start");
  expect_button("practise.back");
  for (int i = 0; i < 3; ++i) Frame([&] { Result(next_); });
  for (const char* button : {"practise.step", "practise.again", "practise.watch", "practise.list"})
    expect_button(button);
  expect_button("practise.reason");
  EXPECT_LE(ui_.noted().at("practise.reason").bottom(), ui_.noted().at("practise.step").top) << "above the buttons";
  for (const ReviewFigure& figure : review_.figures) {
    expect_whole(figure.label);
    if (figure.value) expect_whole(FormatQuantity(*figure.value));
  }
}

// The replay leaves at least half of a small scene to the saws. Its buttons can always be clicked.
TEST_F(PracticePanel, ReplayCoversAtMostHalfOfASmallScene) {
  SetLanguage("en");
  for (const double text_size : {1.0, 1.5}) {
    for (const auto& [width, height] : {std::pair{640, 480}, {800, 600}, {1024, 768}}) {
      ui_.SetSize(width, height, 1);
      ui_.set_text_size(text_size);
      UiBox scene;
      UiBox panel;
      double time_s = 1;
      for (int i = 0; i < 3; ++i) {
        Frame([&] {
          scene = CalcUiAreas(ui_, false, false).scene;
          panel = CalcReplayBox(ui_, pair_, 78, scene);
          DrawReplay(ui_, pair_, 2, 78, true, time_s, scene);
        });
      }
      const std::string what = fmt::format("{} x {}, text {}", width, height, text_size);
      ASSERT_FALSE(panel.empty()) << what;
      EXPECT_LE(panel.height, 0.5 * scene.height) << what;
      EXPECT_GE(panel.top, scene.top) << what;
      EXPECT_LE(panel.bottom(), scene.bottom()) << what;
      for (const std::string& text : ui_.cut_texts()) ADD_FAILURE() << what << ": does not fit: " << text;
      for (const char* button : {"practise.time", "practise.restart", "practise.result"}) {
        ASSERT_TRUE(ui_.noted().contains(button)) << what;
        EXPECT_LE(ui_.noted().at(button).bottom(), panel.bottom()) << what << ": " << button;
        EXPECT_LE(ui_.noted().at(button).right(), panel.right()) << what << ": " << button;
      }
    }
  }
}

TEST_F(PracticePanel, ResultOffersTheNextLevelFirstOnlyIfItIsRecommended) {
  for (int i = 0; i < 2; ++i) Frame([&] { Result(repeat_); });
  EXPECT_GT(ui_.noted().at("practise.next").left, ui_.noted().at("practise.step").left);
  EXPECT_FALSE(ui_.noted().contains("practise.again"));  // is the recommended step
  for (int i = 0; i < 2; ++i) Frame([&] { Result(next_); });
  EXPECT_FALSE(ui_.noted().contains("practise.next"));
  EXPECT_TRUE(ui_.noted().contains("practise.again"));
}

// Wherever the last result was left, the headline of the next one is seen.
TEST_F(PracticePanel, NewResultBeginsAtItsTop) {
  ui_.SetSize(1280, 480, 1);
  const auto draw = [&] { Result(next_); };
  for (int i = 0; i < 3; ++i) Frame(draw);
  const double top = ui_.noted().at("practise.headline").top;
  WindowEvent event;
  event.x = 640;
  event.y = 240;
  event.kind = WindowEvent::Kind::kMouseMove;
  ui_.Take(event);
  Frame(draw);
  event.kind = WindowEvent::Kind::kScroll;
  event.amount = -5;
  ui_.Take(event);
  for (int i = 0; i < 3; ++i) Frame(draw);
  ASSERT_LT(ui_.noted().at("practise.headline").top, top - 50);
  Frame([] {});  // the next attempt
  for (int i = 0; i < 3; ++i) Frame(draw);
  EXPECT_EQ(ui_.noted().at("practise.headline").top, top);
}

// The pointer over the name of a figure shows what it says.
TEST_F(PracticePanel, EveryFigureHasATooltip) {
  ui_.SetSize(1280, 1400, 1);
  const auto draw = [&] { Result(next_); };
  for (int i = 0; i < 2; ++i) Frame(draw);
  Click("practise.more", draw);
  const auto send = [&](WindowEvent::Kind kind, double x, double y, double amount) {
    WindowEvent event;
    event.kind = kind;
    event.x = x;
    event.y = y;
    event.amount = amount;
    ui_.Take(event);
    for (int i = 0; i < 2; ++i) Frame(draw);
    return ui_.CalcFrameHash();
  };
  std::size_t figures = 0;
  for (const auto* list : {&review_.figures, &review_.rest}) {
    for (const ReviewFigure& figure : *list) {
      const std::string item = fmt::format("figure {}", figure.info->key);
      ASSERT_TRUE(ui_.noted().contains(item)) << item;
      // Rows further down are scrolled into view.
      const double bottom = ui_.noted().at("practise.step").top - 40;
      for (int i = 0; i < 40 && ui_.noted().at(item).bottom() > bottom; ++i) {
        send(WindowEvent::Kind::kMouseMove, 640, 700, 0);
        send(WindowEvent::Kind::kScroll, 640, 700, -1);
      }
      const UiBox box = ui_.noted().at(item);
      ASSERT_LE(box.bottom(), bottom) << item;
      const std::uint64_t without = send(WindowEvent::Kind::kMouseMove, 1, 1, 0);
      EXPECT_NE(send(WindowEvent::Kind::kMouseMove, box.left + 3, box.top + 0.5 * box.height, 0), without) << item;
      ++figures;
    }
  }
  EXPECT_GT(figures, 20U);
}

TEST_F(PracticePanel, ClicksInTheResultAreReported) {
  ResultChoice choice = ResultChoice::kNone;
  const auto draw = [&] {
    const ResultChoice now = Result(next_);
    if (now != ResultChoice::kNone) choice = now;
  };
  const std::pair<const char*, ResultChoice> buttons[] = {{"practise.step", ResultChoice::kStep},
                                                          {"practise.again", ResultChoice::kAgain},
                                                          {"practise.watch", ResultChoice::kReplay},
                                                          {"practise.list", ResultChoice::kList}};
  for (int i = 0; i < 2; ++i) Frame(draw);
  for (const auto& [name, wanted] : buttons) {
    choice = ResultChoice::kNone;
    Click(name, draw);
    EXPECT_EQ(choice, wanted) << name;
  }
}

TEST_F(PracticePanel, TextThatIsRefusedKeepsItsDialogOpen) {
  Dialogs dialogs;
  std::optional<std::string> given;
  bool refuses = true;
  dialogs.AskText(ui_, "Your name:", "Ann", [&](const std::optional<std::string>& text) { given = text; });
  dialogs.CheckText([&](const std::string& text) { return refuses ? text + " cannot be stored." : std::string(); });
  const auto draw = [&] {
    dialogs.Draw(ui_);
    dialogs.RunDecided();
  };
  for (int i = 0; i < 2; ++i) Frame(draw);
  EXPECT_FALSE(ui_.noted().contains("dialog.fault"));
  Click("dialog.ok", draw);
  EXPECT_TRUE(dialogs.is_open());
  EXPECT_FALSE(given);
  EXPECT_TRUE(ui_.noted().contains("dialog.fault"));
  refuses = false;
  Click("dialog.ok", draw);
  EXPECT_FALSE(dialogs.is_open());
  EXPECT_EQ(given, "Ann");
}

TEST_F(PracticePanel, KeysAndMouseChooseAnExerciseAndALevel) {
  using Choice = ExerciseList::Choice;
  ExerciseList list = MakeList("");
  // The recommended exercise is selected at first.
  EXPECT_EQ(list.exercise(), "groove");
  EXPECT_EQ(list.Take(KeyDown(Key::kDown)), Choice::kNone);
  EXPECT_EQ(list.exercise(), ListExercises()[1].id);
  list.Take(KeyDown(Key::kUp));
  list.Take(KeyDown(Key::kUp));
  EXPECT_EQ(list.exercise(), ListProcedures().back().id);
  EXPECT_EQ(list.Take(KeyDown(Key::k4)), Choice::kNone);  // opens its levels
  EXPECT_EQ(list.exercise(), ListExercises()[3].id);
  EXPECT_EQ(list.level(), 4);  // recommended: level 3 was passed with 90 points
  EXPECT_EQ(list.Take(KeyDown(Key::k2)), Choice::kStart);
  EXPECT_EQ(list.level(), 2);
  list.Take(KeyDown(Key::kEscape));
  EXPECT_EQ(list.Take(KeyDown(Key::kN)), Choice::kName);

  Choice choice = Choice::kNone;
  const auto draw = [&] {
    const Choice now = list.Draw(ui_);
    if (now != Choice::kNone) choice = now;
  };
  for (int i = 0; i < 2; ++i) Frame(draw);
  Click("exercise follow_line 4", draw);
  EXPECT_EQ(choice, Choice::kStart);
  EXPECT_EQ(list.exercise(), "follow_line");
  EXPECT_EQ(list.level(), 4);
  // A click beside the buttons of a row opens its levels.
  Click("exercise mandibulotomy", draw);
  EXPECT_EQ(list.title(), FindExercise("mandibulotomy").title);
}

TEST_F(PracticePanel, ClickInTheDepthPlotChoosesTheTime) {
  ToolTrack track;
  LoopTick tick;
  for (int i = 0; i <= 500; ++i) {
    tick.time_s = 0.02 * i;
    track.Take(tick);
  }
  pair_.student = track;
  double time_s = 0;
  const auto draw = [&] { DrawReplay(ui_, pair_, 2, 78, true, time_s, {0, 59, 1280, 629}); };
  for (int i = 0; i < 2; ++i) Frame(draw);
  Click("practise.plot", draw);
  EXPECT_NEAR(time_s, 0.5 * pair_.duration_s(), 0.02 * pair_.duration_s());  // a pixel or two of 300
}

}  // namespace
}  // namespace kerf
