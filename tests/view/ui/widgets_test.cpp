// Tests of the elements of panels, of labels in the picture and of translations.
#include "view/ui/widgets.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "view/ui/panels.h"
#include "view/ui/picture_marks.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

TEST(Widgets, ArrowAtTheBorderPointsToASpotOutside) {
  const UiBox box{100, 50, 800, 400};  // its middle is at 500, 250
  const UiArrow right = FindBorderArrow(box, {2000, 250}, 10);
  EXPECT_DOUBLE_EQ(right.tip.x, 890);
  EXPECT_DOUBLE_EQ(right.tip.y, 250);
  EXPECT_DOUBLE_EQ(right.dx, 1);
  const UiArrow down = FindBorderArrow(box, {500, 5000}, 10);
  EXPECT_DOUBLE_EQ(down.tip.x, 500);
  EXPECT_DOUBLE_EQ(down.tip.y, 440);
  EXPECT_DOUBLE_EQ(down.dy, 1);
  // Towards a corner beyond, the nearer border is met first.
  const UiArrow slanted = FindBorderArrow(box, {-500, -750}, 10);
  EXPECT_DOUBLE_EQ(slanted.tip.x, 310);
  EXPECT_DOUBLE_EQ(slanted.tip.y, 60);
}

TEST(Widgets, ScaleBarHasARoundLengthThatFits) {
  for (double mm_per_point = 0.001; mm_per_point < 5; mm_per_point *= 1.37) {
    const ScaleBar bar = CalcScaleBar(mm_per_point, 200);
    EXPECT_LE(bar.points, 200);
    EXPECT_GT(bar.points, 79);  // the next round length is at most 2.5 times as long
    EXPECT_NEAR(bar.mm, bar.points * mm_per_point, 1e-9 * bar.mm);
    const double digits = bar.mm / std::pow(10.0, std::floor(std::log10(bar.mm) + 1e-9));
    EXPECT_TRUE(std::abs(digits - 1) < 1e-6 || std::abs(digits - 2) < 1e-6 || std::abs(digits - 5) < 1e-6) << bar.mm;
  }
}

TEST(Widgets, ScaleBarLiesOverNeitherPanelNorLine) {
  const UiBox scene{262, 59, 1018, 629};
  const UiSize size{180, 34};
  const auto place = [&](const std::vector<UiBox>& others) { return PlaceScaleBar(size, scene, others, 1); };
  const std::optional<UiBox> alone = place({});
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->left, scene.left + 14);
  // Beside a panel at the lower left, and above a line near the whole bottom.
  const UiBox panel{270, 400, 430, 280}, line{250, 630, 1100, 40};
  const std::optional<UiBox> beside = place({panel});
  ASSERT_TRUE(beside);
  EXPECT_GE(beside->left, panel.right());
  const std::optional<UiBox> above = place({line});
  ASSERT_TRUE(above);
  EXPECT_LE(above->bottom(), line.top);
  EXPECT_FALSE(place({scene}));
}

TEST(Widgets, AxisOfTheForcePlotIsRoundAndContainsTheMaximum) {
  for (double force_N = 0.01; force_N < 1e5; force_N *= 1.3) {
    const double top_N = CalcAxisTop(force_N);
    EXPECT_GE(top_N, force_N);
    EXPECT_LE(top_N, std::max(1.0, 2.5 * force_N));
  }
}

TEST(Widgets, LinesEndBetweenWordsButNotBeforeAUnit) {
  Ui ui;
  ui.SetSize(800, 600, 1);
  ui.BeginFrame(0.02);
  const std::vector<std::string> kept{"3.0 mm/s", "11,5 mm", "100 %", "25 s", "13 mm\u00b3", "7500 rpm"};
  std::string text;
  for (const std::string& quantity : kept) text += "a constant feed, " + quantity + ", is wanted; 2 minutes. ";
  text += "a_word_that_is_wider_than_the_line\nlast line";
  for (float width = 60; width < 500; width += 1) {
    const std::string broken = BreakLines(text, width);
    ASSERT_EQ(broken.size(), text.size());
    for (const std::string& quantity : kept) EXPECT_NE(broken.find(quantity), std::string::npos) << broken;
    for (std::size_t i = 0; i < text.size(); ++i) {
      EXPECT_TRUE(broken[i] == text[i] || (text[i] == ' ' && broken[i] == '\n'));
    }
    for (std::size_t from = 0; from < broken.size();) {
      const std::size_t end = std::min(broken.find('\n', from), broken.size());
      const std::string line = broken.substr(from, end - from);
      const bool one_word = line.find_first_of(' ') == std::string::npos;
      const bool quantity = std::count(line.begin(), line.end(), ' ') <= 1;
      EXPECT_TRUE(one_word || quantity || ImGui::CalcTextSize(line.c_str()).x <= width + 1) << line;
      from = end + 1;
    }
  }
  EXPECT_EQ(BreakLines("of 2 minutes", ImGui::CalcTextSize("of 2 m").x), "of 2\nminutes");
  ui.EndFrame();
}

TEST(Widgets, FittedTextIsTheTextOrItsBeginningWithAnEllipsis) {
  Ui ui;
  ui.SetSize(800, 600, 1);
  ui.BeginFrame(0.02);
  const std::string text = "The nerve\xe2\x80\x99s canal is nearer than 2 mm: turn the blade away";
  const float whole = ImGui::CalcTextSize(text.c_str()).x;
  EXPECT_EQ(FitText(text, whole), text);
  for (float width = 30; width < whole; width += 7) {
    const std::string shown = FitText(text, width);
    EXPECT_LE(ImGui::CalcTextSize(shown.c_str()).x, width);
    ASSERT_GE(shown.size(), 3u);
    const std::string beginning = shown.substr(0, shown.size() - 3);  // without the ellipsis of three bytes
    EXPECT_EQ(text.rfind(beginning, 0), 0u) << shown;
  }
  ui.EndFrame();
}

/// Returns whether the second of two clicks is a double click. All events are there at once, and each frame takes one.
bool ClicksTwice(const std::vector<double>& frames_s, int between) {
  Ui ui;
  ui.SetSize(800, 600, 1);
  bool twice = false;
  std::size_t frame = 0;
  const auto draw = [&] {
    ui.BeginFrame(frames_s[std::min(frame++, frames_s.size() - 1)]);
    twice = twice || ImGui::IsMouseDoubleClicked(0);
    ui.EndFrame();
  };
  const auto send = [&](WindowEvent::Kind kind) {
    WindowEvent event;
    event.kind = kind;
    event.x = event.y = 100;
    ui.Take(event);
  };
  send(WindowEvent::Kind::kMouseMove);
  draw();
  for (int click = 0; click < 2; ++click) {
    send(WindowEvent::Kind::kMouseDown);
    draw();
    send(WindowEvent::Kind::kMouseUp);
    draw();
    for (int i = 0; click == 0 && i < between; ++i) draw();
  }
  return twice;
}

TEST(Widgets, DoubleClickDoesNotDependOnTheTimeOfAFrame) {
  for (const double frame_s : {0.01, 0.05, 0.14, 0.2, 0.3, 0.45}) EXPECT_TRUE(ClicksTwice({frame_s}, 0)) << frame_s;
  // Single clicks: 0.4 s and more of quick frames between them, or a window that drew nothing for 0.5 s.
  EXPECT_FALSE(ClicksTwice({0.02}, 20));
  EXPECT_FALSE(ClicksTwice({0.02, 0.02, 0.02, 0.02, 0.02, 0.5, 0.02}, 2));
}

// A busy machine draws frames of any length between the events of a double click.
TEST(Widgets, ClicksThatArriveTogetherAreADoubleClickWhateverTheFrames) {
  for (const std::vector<double>& frames_s :
       {std::vector<double>{0.02, 0.02, 0.5, 0.03, 0.03}, std::vector<double>{0.4, 0.03, 0.03, 0.5, 0.03}}) {
    Ui ui;
    ui.SetSize(800, 600, 1);
    ui.BeginFrame(0.02);
    ui.EndFrame();
    WindowEvent event;
    event.x = event.y = 100;
    for (const WindowEvent::Kind kind :
         {WindowEvent::Kind::kMouseMove, WindowEvent::Kind::kMouseDown, WindowEvent::Kind::kMouseUp,
          WindowEvent::Kind::kMouseDown, WindowEvent::Kind::kMouseUp}) {
      event.kind = kind;
      ui.Take(event);
    }
    bool twice = false;
    for (const double frame_s : frames_s) {
      ui.BeginFrame(frame_s);
      twice = twice || ImGui::IsMouseDoubleClicked(0);
      ui.EndFrame();
    }
    EXPECT_TRUE(twice);
  }
}

/// A panel with two fields for numbers, controlled by keys.
class NumberFields : public ::testing::Test {
 protected:
  NumberFields() {
    ui_.SetSize(800, 600, 1);
    Draw(3);
  }
  void Draw(int frames) {
    for (int i = 0; i < frames; ++i) {
      ui_.BeginFrame(0.02);
      ASSERT_TRUE(BeginPanel(ui_, "left", {0, 0, 300, 300}, true));
      NumberField(ui_, "##a", a_, 2);
      ui_.Note("a");
      NumberField(ui_, "##b", b_, 2);
      EndPanel();
      ui_.EndFrame();
    }
  }
  void Press(Key key, bool shift = false) {
    WindowEvent event;
    event.key = key;
    event.shift = shift;
    for (const WindowEvent::Kind kind : {WindowEvent::Kind::kKeyDown, WindowEvent::Kind::kKeyUp}) {
      event.kind = kind;
      ui_.Take(event);
    }
    Draw(4);
  }
  void Type(const std::string& text) {
    WindowEvent event;
    event.kind = WindowEvent::Kind::kText;
    for (const char c : text) {
      event.character = static_cast<char32_t>(c);
      ui_.Take(event);
    }
    Draw(2);
  }
  void ClickFirst() {
    const UiBox box = ui_.noted().at("a");
    WindowEvent event;
    event.x = box.left + 5;
    event.y = box.top + 5;
    for (const WindowEvent::Kind kind :
         {WindowEvent::Kind::kMouseMove, WindowEvent::Kind::kMouseDown, WindowEvent::Kind::kMouseUp}) {
      event.kind = kind;
      ui_.Take(event);
    }
    Draw(4);
  }

  Ui ui_;
  double a_ = 1;
  double b_ = 2;
};

TEST_F(NumberFields, TabTakesTheNumberAndGoesToTheNextField) {
  ClickFirst();
  ASSERT_TRUE(ui_.takes_text());
  Type("3.5");  // the text was selected, and is replaced
  EXPECT_EQ(a_, 1) << "it is still being typed";
  Press(Key::kTab);
  EXPECT_EQ(a_, 3.5);
  ASSERT_TRUE(ui_.takes_text());
  Type("60");
  Press(Key::kTab, true);
  EXPECT_EQ(b_, 60);
  ASSERT_TRUE(ui_.takes_text());
  Type("7");
  Press(Key::kEnter);
  EXPECT_EQ(a_, 7);
  EXPECT_FALSE(ui_.takes_text());
  EXPECT_EQ(b_, 60);
}

TEST_F(NumberFields, EscapeAndWhatIsNoNumberChangeNothing) {
  ClickFirst();
  Type("3.5");
  ui_.ClosePopups();  // as Escape does
  Draw(2);
  EXPECT_EQ(a_, 1);
  ClickFirst();
  Type("three");
  Press(Key::kEnter);
  EXPECT_EQ(a_, 1);
  ClickFirst();
  Press(Key::kTab);
  EXPECT_EQ(a_, 1);
  EXPECT_EQ(b_, 2);
}

TEST(Labels, OverlapNeitherPanelsNorEachOther) {
  std::mt19937 random(3);
  const auto draw = [&](double lower, double upper) {
    return lower + (upper - lower) * (static_cast<double>(random()) / 4294967296.0);
  };
  const UiBox area{0, 0, 1280, 720};
  const std::vector<UiBox> panels{{0, 0, 240, 700}, {1100, 0, 180, 500}, {400, 10, 500, 40}};
  for (int round = 0; round < 50; ++round) {
    std::vector<UiLabel> labels;
    for (int i = 0; i < 12; ++i) labels.push_back({"label", draw(-20, 1300), draw(-20, 740), {}});
    const std::vector<UiBox> places =
        PlaceLabels(labels, std::vector<UiSize>(labels.size(), {70, 20}), panels, {}, area, 1);
    std::vector<UiBox> seen = panels;
    for (const UiBox& box : places) {
      if (box.empty()) continue;
      EXPECT_GE(box.left, area.left);
      EXPECT_GE(box.top, area.top);
      EXPECT_LE(box.right(), area.right());
      EXPECT_LE(box.bottom(), area.bottom());
      for (const UiBox& other : seen) EXPECT_FALSE(Overlap(box, other));
      seen.push_back(box);
    }
    EXPECT_GT(seen.size(), panels.size() + 6);
  }
}

TEST(Labels, AvoidTheSawIfThereIsSpace) {
  const UiBox saw{600, 300, 120, 120};
  const UiBox area{0, 0, 1280, 720};
  const std::vector<UiLabel> labels{{"12.3 N on your hand", 660, 360, {}}};
  EXPECT_FALSE(Overlap(PlaceLabels(labels, {{150, 20}}, {}, {saw}, area, 1)[0], saw));
  // If the saw covers the whole window, the label is shown all the same.
  EXPECT_FALSE(PlaceLabels(labels, {{150, 20}}, {}, {area}, area, 1)[0].empty());
  // A label that yields is left out instead.
  const std::vector<UiLabel> yielding{{.text = "plane 1", .x = 660, .y = 360, .yields = true}};
  EXPECT_FALSE(PlaceLabels(yielding, {{150, 20}}, {}, {saw}, area, 1)[0].empty());
  EXPECT_TRUE(PlaceLabels(yielding, {{150, 20}}, {}, {area}, area, 1)[0].empty());
}

TEST(Labels, FewAreKeptAroundACut) {
  std::vector<UiLabel> labels;
  for (int i = 0; i < 8; ++i) labels.push_back({.text = std::to_string(i), .x = 600.0 + 10 * i, .y = 300});
  labels.push_back({.text = "far", .x = 1000, .y = 300});
  const std::vector<UiLabel> kept = ThinOutLabels(labels, {600, 300}, 200, 3);
  ASSERT_EQ(kept.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(kept[i].text, std::to_string(i));
  EXPECT_EQ(kept[3].text, "far");
}

// The level must be readable without colour.
TEST(Alarms, RingsAndBordersGrowWithTheLevel) {
  EXPECT_GT(RingRadius(HudLevel::kWarn), 1.3 * RingRadius(HudLevel::kPlain));
  EXPECT_GT(RingRadius(HudLevel::kBad), 1.3 * RingRadius(HudLevel::kWarn));
  EXPECT_EQ(BorderThickness(HudLevel::kPlain), 0);
  EXPECT_GT(BorderThickness(HudLevel::kBad), 2 * BorderThickness(HudLevel::kWarn));
}

TEST(Translate, NumbersAreCorrectlyRoundedAndNeverMinusZero) {
  SetLanguage("en");
  EXPECT_EQ(ShowNumber(std::nan(""), 2), "\xe2\x80\x93");
  EXPECT_EQ(ShowNumber(-0.004, 2), "0.00");
  EXPECT_EQ(ShowNumber(-0.006, 2), "-0.01");
  EXPECT_EQ(ShowNumber(7499.6, 0), "7500");
}

TEST(Translate, NumbersAreReadWithEitherSeparator) {
  EXPECT_EQ(ParseNumber("2.5"), 2.5);
  EXPECT_EQ(ParseNumber(" -2,5 "), -2.5);
  EXPECT_EQ(ParseNumber("60"), 60);
  for (const char* text : {"", " ", "-", "1.2.3", "2 mm", "inf", "nan"}) EXPECT_FALSE(ParseNumber(text)) << text;
}

TEST(Translate, DistanceOfAStructureWithTheBladeInIt) {
  SetLanguage("en");
  EXPECT_EQ(ShowDistance(1.24), "1.2 mm");
  EXPECT_EQ(ShowDistance(0), "0.0 mm");
  EXPECT_EQ(ShowDistance(-0.04), "0.0 mm");  // as shown, it is not cut
  EXPECT_EQ(ShowDistance(-0.7), "blade in it");
}

TEST(Translate, OnlyNamesOfTheProgramAreTranslated) {
  SetLanguage("de");
  EXPECT_EQ(ShowName("plane 1"), "Ebene 1");
  EXPECT_EQ(ShowName("plane 1 mirrored"), "Ebene 1 gespiegelt");
  EXPECT_EQ(ShowName("plane 12 mirrored 2"), "Ebene 12 gespiegelt 2");
  EXPECT_EQ(ShowName("piece 2"), "Segment 2");
  EXPECT_EQ(ShowName("nerve"), "Nerv");
  EXPECT_EQ(ShowName("nerve 3"), "Nerv 3");
  for (const char* name : {"", "7", " 7", "plane1", "my plane 1", "planes", "plane 1 ", "Osteotomie links"}) {
    EXPECT_EQ(ShowName(name), name);
  }
  EXPECT_EQ(ShowName("Osteotomie mirrored"), "Osteotomie gespiegelt");
  SetLanguage("en");
  for (const char* name : {"plane 1 mirrored", "nerve", "piece 2"}) EXPECT_EQ(ShowName(name), name);
}

TEST(Translate, UnknownLanguageGivesEnglish) {
  SetLanguage("xx");
  EXPECT_EQ(CurrentLanguage(), "en");
  EXPECT_STREQ(Tr("Undo"), "Undo");
}

TEST(Translate, GermanIsListedAndTranslatesTextsAndNumbers) {
  bool listed = false;
  for (const Language& language : ListLanguages()) listed = listed || language.name == "Deutsch";
  EXPECT_TRUE(listed);
  SetLanguage("de");
  EXPECT_EQ(CurrentLanguage(), "de");
  EXPECT_STREQ(Tr("Undo"),
               "R\xC3\xBC"
               "ckg\xC3\xA4ngig");
  EXPECT_EQ(ShowNumber(1.25, 2), "1,25");
  SetLanguage("en");
  EXPECT_STREQ(Tr("Undo"), "Undo");
  EXPECT_EQ(ShowNumber(1.25, 2), "1.25");
}

TEST(Translate, EmptyTextStaysEmptyInEveryLanguage) {
  for (const Language& language : ListLanguages()) {
    SetLanguage(language.code);
    EXPECT_STREQ(Tr(""), "") << language.code;
  }
  SetLanguage("en");
}

TEST(Translate, GermanSentenceWithFieldsCanBeFormatted) {
  SetLanguage("de");
  EXPECT_EQ(fmt::format(fmt::runtime(Tr("machine too slow: {:.0f} % of ticks late")), 2.6),
            "Rechner zu langsam: 3 % der Takte verspätet");
  EXPECT_EQ(fmt::format(fmt::runtime(Tr("{}:{:02} min left")), 3, 7), "noch 3:07 min");
  const std::string sentence = fmt::format(
      fmt::runtime(Tr("The running blade was closer than {0} to the nerve canal for {1}. Stop at a depth of {2}.")),
      "1,5 mm", "2,0 s", "6 mm");
  // The sentence exchanges the first two values, so that the words are in the order of German.
  EXPECT_LT(sentence.find("2,0 s"), sentence.find("1,5 mm")) << sentence;
  EXPECT_LT(sentence.find("1,5 mm"), sentence.find("6 mm")) << sentence;
  SetLanguage("en");
}

}  // namespace
}  // namespace kerf
