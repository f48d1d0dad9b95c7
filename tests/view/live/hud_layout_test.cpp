// Tests that panels are inside the window, text is inside its panel, and nothing overlaps.
#include "view/live/hud_layout.h"

#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <algorithm>

#include "support/view_scene.h"
#include "view/live/hud_draw.h"

namespace kerf {
namespace {

struct WindowSize {
  double width;
  double height;
};
// Sizes are in points: 2560 x 1440 pixels of a display with twice the density are 1280 x 720 points.
constexpr WindowSize kSizes[] = {{1280, 720}, {1920, 1080}, {2560, 1440}, {1024, 768}, {1366, 700}, {800, 600},
                                 {640, 480},  {3840, 1100}, {400, 900},   {320, 240},  {90, 60}};

// Returns one of many combinations of contents, selected by the bits of `which`.
HudState MakeState(unsigned which) {
  HudState hud = test::MakeFullHud();
  if ((which & 1u) != 0) hud.gauge.reset();
  if ((which & 2u) != 0) hud.pieces.clear();
  if ((which & 4u) != 0) {
    for (int i = 0; i < 34; ++i) hud.legend.push_back({"region " + std::to_string(i) + " of the mandible", {}});
  }
  if ((which & 8u) != 0) {
    hud.banner = HudBanner{HudBanner::Kind::kWarning,
                           "The nerve's canal is nearer than 2 mm: the blade is to be turned away or drawn back before "
                           "the cut goes on",
                           "Enter: go on    Esc: stop"};
  }
  if ((which & 16u) != 0) {
    hud.show_values = false;
    hud.show_plot = false;
  }
  if ((which & 32u) != 0) hud.pieces.resize(40, {"piece", "1 mm3", {}, false, false});
  return hud;
}

std::vector<HudState> MakeModals() {
  std::vector<HudState> all(4, test::MakeFullHud());
  all[0].show_help = true;
  all[0].help = test::MakeHelp();
  HudMenu menu;
  menu.title = "Exercises";
  for (int i = 0; i < 30; ++i)
    menu.rows.push_back({"Groove of a given depth " + std::to_string(i), "best 82, level 2"});
  menu.selected = 17;
  menu.footer = "Up and down choose, Enter begins, Esc goes back";
  all[1].menu = menu;
  all[2].result = test::MakeResult();
  all[3].progress = HudProgress{"Loading body_osteotomy.toml", "meshing the surface of the bone", 0.42};
  return all;
}

void ExpectApart(const HudLayout& layout, const std::string& what) {
  const auto panels = layout.Panels();
  for (std::size_t i = 0; i < panels.size(); ++i) {
    EXPECT_GE(panels[i].left, 0) << what;
    EXPECT_GE(panels[i].top, 0) << what;
    EXPECT_LE(panels[i].right(), layout.width) << what;
    EXPECT_LE(panels[i].bottom(), layout.height) << what;
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(Overlap(panels[i], panels[j])) << what << " " << i << " " << j;
  }
}

TEST(HudLayout, PanelsNeverOverlapOrLeaveTheWindow) {
  for (const WindowSize& size : kSizes) {
    for (unsigned which = 0; which < 64; ++which) {
      for (const int slices : {0, 3}) {
        for (const bool orientation : {false, true}) {
          const HudLayout layout =
              CalcHudLayout(size.width, size.height, MakeState(which), {slices, orientation, true});
          ExpectApart(layout, std::to_string(size.width) + " x " + std::to_string(size.height) + ", state " +
                                  std::to_string(which));
        }
      }
    }
    for (const HudState& modal : MakeModals()) ExpectApart(CalcHudLayout(size.width, size.height, modal, {}), "modal");
  }
}

TEST(HudLayout, AllPanelsFitAtTheMinimumSupportedSize) {
  HudState hud = MakeState(4u | 8u);
  const HudLayout layout = CalcHudLayout(1280, 720, hud, {3, true, true});
  for (const FlatBox* box : {&layout.values, &layout.plot, &layout.gauge, &layout.pieces, &layout.banner,
                             &layout.legend, &layout.orientation, &layout.scale_bar, &layout.status}) {
    EXPECT_FALSE(box->empty());
  }
  EXPECT_EQ(layout.slices.size(), 3u);
  EXPECT_EQ(layout.piece_rows, 3u);
  EXPECT_GE(layout.legend_rows, 15u);
  // Most of the window is left for the view of the bone.
  EXPECT_GT(layout.scene.width * layout.scene.height, 0.6 * 1280 * 720);
}

// Returns the boxes of the texts in a list, from the computed widths.
std::vector<FlatBox> WordBoxes(const DrawList& list) {
  std::vector<FlatBox> boxes;
  for (const FlatText& text : list.texts()) {
    const double width = CalcTextWidth(text.text, text.size, text.bold);
    const double shift = text.align == Align::kRight ? width : text.align == Align::kCentre ? 0.5 * width : 0;
    boxes.push_back({text.x - shift, text.y, width, 1.0 * text.size});
  }
  return boxes;
}

void ExpectLegible(const DrawList& list, const HudLayout& layout, const std::string& what) {
  const std::vector<FlatBox> words = WordBoxes(list);
  const auto panels = layout.Panels();
  for (std::size_t i = 0; i < words.size(); ++i) {
    const FlatBox& w = words[i];
    const bool inside = std::any_of(panels.begin(), panels.end(), [&](const FlatBox& p) {
      return w.left >= p.left && w.right() <= p.right() + 1 && w.top >= p.top && w.bottom() <= p.bottom();
    });
    EXPECT_TRUE(inside) << what << ": " << list.texts()[i].text;
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(Overlap(w, words[j])) << what << ": " << list.texts()[i].text << " / " << list.texts()[j].text;
    }
  }
}

TEST(HudDraw, TextStaysInItsPanelWithoutOverlap) {
  for (const WindowSize& size : kSizes) {
    for (unsigned which = 0; which < 64; ++which) {
      const HudState state = MakeState(which);
      const HudLayout layout = CalcHudLayout(size.width, size.height, state, {});
      DrawList list;
      DrawHud(state, layout, {}, {}, ScaleBar{50, 120}, list);
      ExpectLegible(list, layout, std::to_string(size.width) + ", state " + std::to_string(which));
    }
    for (const HudState& state : MakeModals()) {
      const HudLayout layout = CalcHudLayout(size.width, size.height, state, {});
      DrawList list;
      DrawHud(state, layout, {}, {}, std::nullopt, list);
      ExpectLegible(list, layout, std::to_string(size.width) + ", modal");
    }
  }
}

TEST(HudDraw, SceneLabelsDoNotOverlapPanelsOrEachOther) {
  const HudState state = MakeState(4);
  const HudLayout layout = CalcHudLayout(1280, 720, state, {3, true, true});
  std::vector<SceneLabel> labels;
  for (int i = 0; i < 60; ++i) labels.push_back({"plane " + std::to_string(i), 40.0 * (i % 32), 14.0 * i, {}});
  DrawList with, without;
  DrawHud(state, layout, {}, labels, std::nullopt, with);
  DrawHud(state, layout, {}, {}, std::nullopt, without);
  std::vector<FlatBox> seen = layout.Panels();
  std::size_t shown = 0;
  const auto words = WordBoxes(with);
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (with.texts()[i].text.rfind("plane ", 0) != 0) continue;
    for (const FlatBox& other : seen) EXPECT_FALSE(Overlap(words[i], other));
    seen.push_back(words[i]);
    ++shown;
  }
  EXPECT_GT(shown, 20u);
  EXPECT_EQ(with.texts().size(), without.texts().size() + shown);
}

TEST(HudDraw, ForceNoteIsCompleteBelowThePlotIfThereIsSpace) {
  HudState state = test::MakeFullHud();
  state.pieces.clear();
  const auto words_of = [&] {
    DrawList list;
    DrawHud(state, CalcHudLayout(1280, 720, state, {}), {}, {}, std::nullopt, list);
    std::string words;
    for (const auto& text : list.texts()) words += text.text + " ";
    return words;
  };
  EXPECT_NE(words_of().find(state.force_note), std::string::npos) << words_of();
  const double with = CalcHudLayout(1280, 720, state, {}).plot.height;
  state.force_note.clear();
  EXPECT_EQ(CalcHudLayout(1280, 720, state, {}).plot.height, kPlotHeight);
  EXPECT_GT(with, kPlotHeight);
}

TEST(HudDraw, NumbersAreShortAndCorrectlyRounded) {
  EXPECT_EQ(FormatHudNumber(std::nullopt, 2), "-");
  EXPECT_EQ(FormatHudNumber(std::nan(""), 2), "-");
  EXPECT_EQ(FormatHudNumber(-0.004, 2), "0.00");
  EXPECT_EQ(FormatHudNumber(-0.006, 2), "-0.01");
  EXPECT_EQ(FormatHudNumber(7499.6, 0), "7500");
}

TEST(HudDraw, ScaleBarHasARoundLengthThatFits) {
  for (double mm_per_point = 0.001; mm_per_point < 5; mm_per_point *= 1.37) {
    const ScaleBar bar = CalcScaleBar(mm_per_point, 200);
    EXPECT_LE(bar.points, 200);
    EXPECT_GT(bar.points, 79);  // the next round length is at most 2.5 times as long
    EXPECT_NEAR(bar.mm, bar.points * mm_per_point, 1e-9 * bar.mm);
    const double digits = bar.mm / std::pow(10.0, std::floor(std::log10(bar.mm) + 1e-9));
    EXPECT_TRUE(std::abs(digits - 1) < 1e-6 || std::abs(digits - 2) < 1e-6 || std::abs(digits - 5) < 1e-6) << bar.mm;
  }
}

TEST(HudText, ComputedWidthsMatchDrawnWidths) {
  const std::vector<std::string> words{"Angle to plan", "12 angle upper facial, 20.3 GPa", "checkpoint \"before\" made",
                                       "WWWW mmmm iiii llll", "0123456789.-+ (%)"};
  for (const std::string& text : words) {
    for (const bool bold : {false, true}) {
      for (const int size : {13, 15, 20, 26, 30, 40}) {
        const vtkNew<vtkTextProperty> property;
        property->SetFontFamilyToArial();
        property->SetFontSize(size);
        property->SetBold(bold ? 1 : 0);
        int box[4] = {0, 0, 0, 0};
        vtkTextRenderer::GetInstance()->GetBoundingBox(property, vtkStdString(text), box, 72);
        // Letters are placed on whole pixels: up to half a pixel each, in both directions.
        const double drawn = box[1] - box[0] + 1;
        EXPECT_NEAR(CalcTextWidth(text, size, bold), drawn, 0.05 * drawn + 2) << text << " " << size << bold;
      }
    }
  }
}

TEST(HudText, CutTextFitsAndWrappedTextKeepsEveryWord) {
  const std::string text = "The nerve\xe2\x80\x99s canal is nearer than 2 mm: turn the blade away";
  for (double width = 60; width < 500; width += 13) {
    EXPECT_LE(CalcTextWidth(CutText(text, 15, true, width), 15, true), width);
    std::string joined;
    for (const std::string& line : WrapText(text, 15, true, width)) {
      EXPECT_LE(CalcTextWidth(line, 15, true), width);
      joined += joined.empty() ? line : " " + line;
    }
    if (width > 100) {
      EXPECT_EQ(joined, text);
    }
  }
}

TEST(HudRows, SelectedRowIsAlwaysVisibleAndFoundUnderTheMouse) {
  HudMenu menu;
  menu.rows.resize(50);
  const FlatBox modal{100, 50, 600, 400};
  for (menu.selected = 0; menu.selected < 50; ++menu.selected) {
    const MenuRows rows = PlaceMenuRows(menu, modal);
    ASSERT_GT(rows.rows.size(), 5u);
    EXPECT_LE(rows.first, static_cast<std::size_t>(menu.selected));
    EXPECT_GT(rows.first + rows.rows.size(), static_cast<std::size_t>(menu.selected));
    EXPECT_LE(rows.rows.back().bottom(), modal.bottom());
  }
}

}  // namespace
}  // namespace kerf
