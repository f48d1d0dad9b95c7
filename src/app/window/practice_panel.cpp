#include "app/window/practice_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "session/practise/exercises.h"
#include "session/score/cut_picture.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

// Pictures are drawn on white in both themes, because their colours are made for it.
constexpr Rgb8 kPaper{255, 255, 255};
constexpr Rgb8 kInk{26, 29, 36};
constexpr Rgb8 kBoneLine{140, 140, 140};

/// Pause in a depth curve from which its line is interrupted.
constexpr double kGap_s = 0.1;

constexpr ImGuiWindowFlags kDialog = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                     ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse |
                                     ImGuiWindowFlags_NoNav;

/// Returns the decimal separator of the language.
std::string PointOfLanguage() {
  const std::string point = Tr("decimal separator");
  return point.size() == 1 ? point : ".";
}

HudLevel HudLevelOf(ReviewLevel level) {
  return level == ReviewLevel::kGood   ? HudLevel::kGood
         : level == ReviewLevel::kWarn ? HudLevel::kWarn
         : level == ReviewLevel::kBad  ? HudLevel::kBad
                                       : HudLevel::kPlain;
}

/// Begins a dialog in the middle of the window, at most as large as the space between the bars. The size is in points.
void BeginLargeDialog(Ui& ui, const char* name, float width, float height) {
  const float s = ui.scale();
  const UiBox scene = CalcUiAreas(ui, false, false).scene;
  const ImVec2 size{std::min(width * s, static_cast<float>(scene.width) - 12 * s),
                    std::min(height * s, static_cast<float>(scene.height) - 8 * s)};
  ImGui::SetNextWindowPos(
      {std::floor(static_cast<float>(scene.left) + 0.5F * (static_cast<float>(scene.width) - size.x)),
       std::floor(static_cast<float>(scene.top) + 0.5F * (static_cast<float>(scene.height) - size.y))});
  ImGui::SetNextWindowSize(size);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {18 * s, 12 * s});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 4 * s);
  ImGui::Begin(name, nullptr, kDialog);
  ImGui::PopStyleVar(2);
}

void WrappedText(const std::string& text) {
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
}

void SmallText(Ui& ui, const std::string& text) {
  ImGui::PushFont(ui.small());
  ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().faint));
  WrappedText(text);
  ImGui::PopStyleColor();
  ImGui::PopFont();
}

void MarkedText(Ui& ui, HudLevel level, const std::string& text) {
  LevelMark(ui, level);
  ImGui::SameLine();
  WrappedText(text);
}

/// Returns the width of a column of a table in which all texts fit, at least `least` pixels.
float WidthFor(std::initializer_list<std::string> texts, float least) {
  for (const std::string& text : texts) least = std::max(least, ImGui::CalcTextSize(text.c_str()).x + 1);
  return least;
}

/// Adds buttons from left to right, in as many lines as they need. The first one is the default.
class ButtonRow {
 public:
  explicit ButtonRow(Ui& ui) : ui_(ui), right_(ImGui::GetCursorScreenPos().x + ImGui::GetContentRegionAvail().x) {}

  /// `note`: name for Ui::Note(); `keys`: shown behind the text. Returns true if it was clicked.
  bool Add(const char* note, const std::string& text, const std::string& keys) {
    const std::string label = keys.empty() ? text : fmt::format("{} ({})", text, keys);
    const bool first = std::exchange(first_, false);
    const float width = ImGui::CalcTextSize(label.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
    if (!first && ImGui::GetItemRectMax().x + ImGui::GetStyle().ItemSpacing.x + width <= right_) ImGui::SameLine();
    if (first) {
      ImGui::PushStyleColor(ImGuiCol_Button, ToImVec4(ui_.colours().accent));
      ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ToImVec4(ui_.colours().accent, 0.85));
      ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui_.colours().panel));
    }
    const bool clicked = ImGui::Button(fmt::format("{}##{}", label, note).c_str());
    if (first) ImGui::PopStyleColor(3);
    ui_.Note(note);
    return clicked;
  }

 private:
  Ui& ui_;
  float right_;
  bool first_ = true;
};

/// Draws a line through the points with dashes and gaps of equal lengths.
void AddDashes(ImDrawList& list, const std::vector<ImVec2>& points, ImU32 colour, float width, float dash) {
  float at = 0;  // length of the line so far, within a dash and the following gap
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const ImVec2 a = points[i];
    const ImVec2 b = points[i + 1];
    const float length = std::hypot(b.x - a.x, b.y - a.y);
    float from = 0;
    while (from < length) {
      const bool drawn = at < dash;
      const float step = std::min((drawn ? dash : 2 * dash) - at, length - from);
      const auto point = [&](float l) {
        return ImVec2{a.x + (b.x - a.x) * l / length, a.y + (b.y - a.y) * l / length};
      };
      if (drawn) list.AddLine(point(from), point(from + step), colour, width);
      from += step;
      at += step;
      if (at >= 2 * dash - 1e-3F) at = 0;
      // Rounding must not leave a step without length.
      if (step < 1e-3F) from += 1e-3F;
    }
  }
}

enum class Stroke { kSolid, kDashed };

void AddStroke(ImDrawList& list, const std::vector<ImVec2>& points, Stroke stroke, const Rgb8& colour, float width) {
  if (points.size() < 2) return;
  if (stroke == Stroke::kDashed) return AddDashes(list, points, ToImU32(colour), width, 3.5F * width);
  list.AddPolyline(points.data(), static_cast<int>(points.size()), ToImU32(colour), 0, width);
}

/// Adds the entry of a legend: a piece of the line, and its name.
void LegendEntryItem(Ui& ui, Stroke stroke, const Rgb8& colour, float width, const std::string& name) {
  const float s = ui.scale();
  const float height = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  // On white, as in the picture.
  list.AddRectFilled(at, {at.x + 34 * s, at.y + height}, ToImU32(kPaper));
  AddStroke(list, {{at.x + 3 * s, at.y + 0.5F * height}, {at.x + 31 * s, at.y + 0.5F * height}}, stroke, colour, width);
  ImGui::Dummy({34 * s, height});
  ImGui::SameLine();
  ImGui::TextUnformatted(name.c_str());
}

// ---- the picture of the cut

/// Draws one view of the cut, of the given size in pixels, with a scale bar.
void DrawCutView(Ui& ui, const CutView& view, const std::string& title, double scale_bar_mm, float width,
                 float height) {
  const float s = ui.scale();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  ImGui::BeginGroup();
  FittedText(ui, title, width);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 end{corner.x + width, corner.y + height};
  list.AddRectFilled(corner, end, ToImU32(kPaper));
  list.AddRect(corner, end, ToImU32(ui.colours().edge));
  const float bar_room = 24 * s;
  const double scale =
      std::min(static_cast<double>(width - 12 * s) / std::max(1e-6, view.right_mm - view.left_mm),
               static_cast<double>(height - bar_room - 6 * s) / std::max(1e-6, view.top_mm - view.bottom_mm));
  const double middle_x = 0.5 * (view.left_mm + view.right_mm);
  const double middle_y = 0.5 * (view.bottom_mm + view.top_mm);
  const auto draw = [&](const PictureLine& line, Stroke stroke, const Rgb8& colour, float thickness) {
    std::vector<ImVec2> points;
    points.reserve(line.size());
    for (const PicturePoint& p : line) {
      points.push_back({corner.x + 0.5F * width + static_cast<float>(scale * (p.x_mm - middle_x)),
                        corner.y + 0.5F * (height - bar_room) - static_cast<float>(scale * (p.y_mm - middle_y))});
    }
    AddStroke(list, points, stroke, colour, thickness * s);
  };
  list.PushClipRect(corner, end, true);
  for (const PictureLine& line : view.bone) draw(line, Stroke::kSolid, kBoneLine, 1.5F);
  draw(view.line, Stroke::kSolid, kInk, 1);
  for (const PictureLine& line : view.made) draw(line, Stroke::kSolid, kMadeColour, 2);
  for (const PictureLine& line : view.wanted) draw(line, Stroke::kDashed, kWantedColour, 2);
  const auto bar = static_cast<float>(scale * scale_bar_mm);
  const float y = end.y - 9 * s;
  const float left = corner.x + 8 * s;
  list.AddLine({left, y}, {left + bar, y}, ToImU32(kInk), 2 * s);
  for (const float x : {left, left + bar}) list.AddLine({x, y - 4 * s}, {x, y + 4 * s}, ToImU32(kInk), 2 * s);
  const std::string length = FormatQuantity({scale_bar_mm, scale_bar_mm < 1 ? 1 : 0, "mm"}, PointOfLanguage());
  list.AddText({left + bar + 6 * s, y - 0.5F * ImGui::GetTextLineHeight()}, ToImU32(kInk), length.c_str());
  list.PopClipRect();
  ImGui::Dummy({width, height});
  ImGui::EndGroup();
}

void DrawCutPicture(Ui& ui, const CutPicture& picture) {
  const float s = ui.scale();
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  const float width = std::floor(0.5F * (ImGui::GetContentRegionAvail().x - gap));
  const float height = 150 * s;
  DrawCutView(ui, picture.above, Tr("From above"), picture.scale_bar_mm, width, height);
  ui.Note("practise.above");
  ImGui::SameLine();
  DrawCutView(ui, picture.side, Tr("From the side"), picture.scale_bar_mm, width, height);
  ui.Note("practise.side");
  LegendEntryItem(ui, Stroke::kDashed, kWantedColour, 2 * s, Tr("wanted"));
  ImGui::SameLine(0, 22 * s);
  LegendEntryItem(ui, Stroke::kSolid, kMadeColour, 2 * s, Tr("made"));
  ImGui::SameLine(0, 22 * s);
  LegendEntryItem(ui, Stroke::kSolid, kBoneLine, 1.5F * s, Tr("bone"));
  ImGui::SameLine(0, 22 * s);
  LegendEntryItem(ui, Stroke::kSolid, kInk, s, Tr("line to follow"));
}

// ---- figures

void DrawFigures(Ui& ui, const char* id, const std::vector<ReviewFigure>& figures) {
  if (figures.empty() || !ImGui::BeginTable(id, 5, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) return;
  const float s = ui.scale();
  ImGui::TableSetupColumn("##mark", 0, ImGui::GetTextLineHeight() + 4 * s);
  ImGui::TableSetupColumn(Tr("Figure"), ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn(Tr("Value"), 0, WidthFor({Tr("Value")}, 130 * s));
  ImGui::TableSetupColumn(Tr("Goal"), 0, WidthFor({Tr("Goal")}, 150 * s));
  ImGui::TableSetupColumn(Tr("Points lost"), 0, WidthFor({Tr("Points lost")}, 120 * s));
  ImGui::TableHeadersRow();
  for (const ReviewFigure& figure : figures) {
    ImGui::TableNextColumn();
    LevelMark(ui, HudLevelOf(figure.level));
    ImGui::TableNextColumn();
    FittedText(ui, Tr(figure.label), ImGui::GetContentRegionAvail().x);
    if (figure.info != nullptr) Tooltip(ui, Tr(figure.info->formula));
    ImGui::TableNextColumn();
    ImGui::PushFont(ui.bold());
    FittedText(ui, figure.value ? FormatQuantity(*figure.value, PointOfLanguage()) : "\u2013",
               ImGui::GetContentRegionAvail().x);
    ImGui::PopFont();
    ImGui::TableNextColumn();
    if (figure.goal) FittedText(ui, FormatGoal(figure, PointOfLanguage()), ImGui::GetContentRegionAvail().x);
    ImGui::TableNextColumn();
    if (figure.lost && *figure.lost >= 0.5) ImGui::TextUnformatted(ShowNumber(*figure.lost, 0).c_str());
  }
  ImGui::EndTable();
}

const char* NameOf(Trend trend) {
  switch (trend) {
    case Trend::kRising:
      return Tr("\u2191 rising");
    case Trend::kSteady:
      return Tr("\u2192 steady");
    case Trend::kFalling:
      return Tr("\u2193 falling");
    case Trend::kUnknown:
      break;
  }
  return "";
}

/// Returns the aids of a level, in words.
const char* DescribeLevel(int level) {
  static constexpr std::array<const char*, kLevels> kAids{
      Msg("all aids"), Msg("no depth stop"), Msg("gauge and blade colour"), Msg("gauge only"), Msg("no aids")};
  return Tr(kAids[static_cast<std::size_t>(level - 1)]);
}

std::string ShowBest(const std::optional<double>& best) {
  return best ? ShowNumber(*best, 0) : "\u2013";
}

}  // namespace

std::string Translate(const Message& message) {
  Message translated = message;
  for (auto& value : translated.values) {
    if (auto* text = std::get_if<std::string>(&value)) *text = std::string(Tr(text->c_str()));
  }
  return FormatMessage(translated, Tr(message.text), PointOfLanguage());
}

// ---- the exercises

ExerciseList::ExerciseList(std::vector<ExerciseRow> rows, std::string student)
    : rows_(std::move(rows)), student_(std::move(student)), next_(FindNextStep(rows_)) {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (rows_[i].id == next_.exercise) row_ = i;
  }
}

std::string ExerciseList::title() const {
  if (shows_levels_) return rows_[row_].title;
  return student_.empty() ? std::string(Tr("Exercises, easy to hard"))
                          : fmt::format(fmt::runtime(Tr("Exercises of {}, easy to hard")), student_);
}

int ExerciseList::FindRecommendedLevel(const ExerciseRow& row) const {
  return row.next.exercise == row.id ? row.next.level : 0;
}

void ExerciseList::OpenLevels(std::size_t row) {
  row_ = row;
  level_ = std::max(1, FindRecommendedLevel(rows_[row]));
  shows_levels_ = true;
}

ExerciseList::Choice ExerciseList::Take(const WindowEvent& event) {
  if (event.kind != WindowEvent::Kind::kKeyDown) return Choice::kNone;
  const auto count = shows_levels_ ? kLevels : static_cast<int>(rows_.size());
  const auto step = [&](int by) {
    if (shows_levels_) {
      level_ = (level_ - 1 + by + count) % count + 1;
    } else {
      row_ = static_cast<std::size_t>((static_cast<int>(row_) + by + count) % count);
      scrolls_ = true;
    }
    return Choice::kNone;
  };
  switch (event.key) {
    case Key::kUp:
      return step(-1);
    case Key::kDown:
      return step(1);
    case Key::kEscape:
      shows_levels_ = false;
      scrolls_ = true;
      return Choice::kNone;
    case Key::kEnter:
      if (event.repeat) return Choice::kNone;
      if (shows_levels_) return Choice::kStart;
      OpenLevels(row_);
      return Choice::kNone;
    case Key::kN:
      return shows_levels_ || event.repeat ? Choice::kNone : Choice::kName;
    default:
      break;
  }
  const int digit = static_cast<int>(event.key) - static_cast<int>(Key::k0);
  if (digit < 1 || digit > std::min(9, count) || event.repeat) return Choice::kNone;
  if (!shows_levels_) {
    OpenLevels(static_cast<std::size_t>(digit - 1));
    return Choice::kNone;
  }
  level_ = digit;
  return Choice::kStart;
}

ExerciseList::Choice ExerciseList::Draw(Ui& ui) {
  return shows_levels_ ? DrawLevels(ui) : DrawExercises(ui);
}

ExerciseList::Choice ExerciseList::DrawExercises(Ui& ui) {
  const float s = ui.scale();
  Choice choice = Choice::kNone;
  BeginLargeDialog(ui, "exercises", 1040, 500);
  ImGui::PushFont(ui.title());
  FittedText(ui, title(), ImGui::GetContentRegionAvail().x);
  ImGui::PopFont();
  ButtonRow top(ui);
  if (student_.empty()) {
    MarkedText(
        ui, HudLevel::kWarn,
        Tr("No name was entered, so attempts are not stored. Enter your name here, or start with --student NAME."));
  }
  const ExerciseRow& recommended =
      *std::find_if(rows_.begin(), rows_.end(), [&](const ExerciseRow& r) { return r.id == next_.exercise; });
  if (top.Add("practise.recommended",
              fmt::format(fmt::runtime(Tr("Start \"{}\", level {}")), Tr(recommended.title.c_str()), next_.level),
              "")) {
    row_ = static_cast<std::size_t>(&recommended - rows_.data());
    level_ = next_.level;
    choice = Choice::kStart;
  }
  if (top.Add("practise.name", student_.empty() ? Tr("Enter your name") : Tr("Another student"), "N")) {
    choice = Choice::kName;
  }
  SmallText(ui, fmt::format(fmt::runtime(Tr("Recommended: {}")), Translate(next_.reason)));
  ImGui::Spacing();
  const float footer = ImGui::GetTextLineHeightWithSpacing() + 4 * s;
  ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {5 * s, 4 * s});
  if (ImGui::BeginTable("exercises", 3 + kLevels,
                        ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_ScrollY,
                        {0, -footer})) {
    ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("##number", 0, 20 * s);
    ImGui::TableSetupColumn(Tr("Exercise"), ImGuiTableColumnFlags_WidthStretch);
    for (int level = 1; level <= kLevels; ++level) {
      const std::string name = fmt::format(fmt::runtime(Tr("Level {}")), level);
      ImGui::TableSetupColumn(name.c_str(), 0, WidthFor({name}, 58 * s));
    }
    ImGui::TableSetupColumn(
        Tr("Trend"), 0,
        WidthFor({Tr("Trend"), NameOf(Trend::kRising), NameOf(Trend::kSteady), NameOf(Trend::kFalling)}, 80 * s));
    ImGui::TableHeadersRow();
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const ExerciseRow& row = rows_[i];
      ImGui::PushID(static_cast<int>(i));
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      // The goal needs two lines at most at the normal size of text.
      const float top_y = ImGui::GetCursorPosY();
      ImGui::TableSetColumnIndex(1);
      const float room = ImGui::GetContentRegionAvail().x;
      const std::string goal = Translate(row.goal);
      ImGui::PushFont(ui.small());
      const float goal_height = ImGui::CalcTextSize(goal.c_str(), nullptr, false, room).y;
      ImGui::PopFont();
      const float height = ImGui::GetTextLineHeightWithSpacing() + goal_height;
      ImGui::TableSetColumnIndex(0);
      const bool selected = i == row_;
      if (ImGui::Selectable("##row", selected,
                            ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowItemOverlap, {0, height})) {
        OpenLevels(i);
      }
      ui.Note(fmt::format("exercise {}", row.id));
      if (selected && std::exchange(scrolls_, false)) ImGui::SetScrollHereY();
      ImGui::SetCursorPosY(top_y);
      ImGui::TextDisabled("%d", static_cast<int>(i) + 1);
      ImGui::TableNextColumn();
      ImGui::PushFont(ui.bold());
      FittedText(ui, Tr(row.title.c_str()), room);
      ImGui::PopFont();
      SmallText(ui, goal);
      for (int level = 1; level <= kLevels; ++level) {
        ImGui::TableNextColumn();
        const bool next = row.id == next_.exercise && level == next_.level;
        if (next) {
          ImGui::PushStyleColor(ImGuiCol_Button, ToImVec4(ui.colours().accent));
          ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().panel));
        }
        const std::string best = ShowBest(row.best[static_cast<std::size_t>(level - 1)]);
        if (ImGui::Button(fmt::format("{}##{}", best, level).c_str(), {-1, 0})) {
          row_ = i;
          level_ = level;
          choice = Choice::kStart;
        }
        if (next) ImGui::PopStyleColor(2);
        ui.Note(fmt::format("exercise {} {}", row.id, level));
        Tooltip(ui, fmt::format(fmt::runtime(next ? Tr("Recommended: level {}, {}. Click to start it.")
                                                  : Tr("Level {}, {}. Click to start it.")),
                                level, DescribeLevel(level)));
      }
      ImGui::TableNextColumn();
      if (row.trend != Trend::kUnknown) {
        FittedText(ui, NameOf(row.trend), ImGui::GetContentRegionAvail().x);
      } else if (row.attempts > 0) {
        ImGui::TextDisabled("%s", fmt::format(fmt::runtime(Tr("{} tried")), row.attempts).c_str());
      }
      ImGui::PopID();
    }
    ImGui::EndTable();
  }
  ImGui::PopStyleVar();
  SmallText(ui, Tr("Numbers: the best score of a level.   Up, Down, Enter: choose an exercise   Ctrl+Q: quit"));
  ImGui::End();
  return choice;
}

ExerciseList::Choice ExerciseList::DrawLevels(Ui& ui) {
  const float s = ui.scale();
  Choice choice = Choice::kNone;
  const ExerciseRow& row = rows_[row_];
  BeginLargeDialog(ui, "levels", 640, 270);
  ImGui::PushFont(ui.title());
  WrappedText(Tr(row.title.c_str()));
  ImGui::PopFont();
  WrappedText(Translate(row.goal));
  ImGui::Spacing();
  const int recommended = FindRecommendedLevel(row);
  if (ImGui::BeginTable("levels", 4, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_BordersInnerH)) {
    ImGui::TableSetupColumn("##number", 0, 20 * s);
    ImGui::TableSetupColumn(Tr("Level"), 0,
                            WidthFor({fmt::format(fmt::runtime(Tr("Level {} (recommended)")), kLevels)}, 180 * s));
    ImGui::TableSetupColumn(Tr("Aids"), ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableSetupColumn(Tr("Best"), 0, 60 * s);
    ImGui::TableHeadersRow();
    for (int level = 1; level <= kLevels; ++level) {
      ImGui::PushID(level);
      ImGui::TableNextColumn();
      if (ImGui::Selectable(fmt::format("{}", level).c_str(), level == level_, ImGuiSelectableFlags_SpanAllColumns)) {
        level_ = level;
        choice = Choice::kStart;
      }
      ui.Note(fmt::format("level {}", level));
      ImGui::TableNextColumn();
      FittedText(ui,
                 fmt::format(fmt::runtime(level == recommended ? Tr("Level {} (recommended)") : Tr("Level {}")), level),
                 ImGui::GetContentRegionAvail().x);
      ImGui::TableNextColumn();
      FittedText(ui, DescribeLevel(level), ImGui::GetContentRegionAvail().x);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(ShowBest(row.best[static_cast<std::size_t>(level - 1)]).c_str());
      ImGui::PopID();
    }
    ImGui::EndTable();
  }
  ImGui::Spacing();
  ButtonRow buttons(ui);
  if (buttons.Add("practise.start", fmt::format(fmt::runtime(Tr("Start level {}")), level_), Tr("Enter"))) {
    choice = Choice::kStart;
  }
  if (buttons.Add("practise.back", Tr("Other exercises"), Tr("Esc"))) {
    shows_levels_ = false;
    scrolls_ = true;
  }
  ImGui::End();
  return choice;
}

// ---- while cutting

void DrawAids(Ui& ui, const std::vector<Aid>& aids) {
  if (!BeginSection(ui, Tr("Aids"))) return;
  const float s = ui.scale();
  bool any = false;
  for (const Aid& aid : aids) {
    if (!aid.on) continue;
    any = true;
    const float height = ImGui::GetTextLineHeight();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddCircleFilled({at.x + 0.5F * height, at.y + 0.5F * height}, 5 * s,
                                                ToImU32(ui.colours().accent));
    ImGui::Dummy({height, height});
    ImGui::SameLine();
    WrappedText(Tr(aid.name));
    Tooltip(ui, Tr(aid.what));
  }
  if (!any) WrappedText(Tr("This level has no aids."));
  ImGui::Spacing();
}

// ---- the result

namespace {

/// Returns the label of the button for the recommended step.
std::string NameOf(const NextStep& next) {
  switch (next.kind) {
    case NextStep::Kind::kFirst:
    case NextStep::Kind::kRepeat:
      return Tr("Try again");
    case NextStep::Kind::kNextLevel:
    case NextStep::Kind::kPreviousLevel:
      return fmt::format(fmt::runtime(Tr("Go on with level {}")), next.level);
    case NextStep::Kind::kNextExercise:
      return Tr("Next exercise");
    case NextStep::Kind::kFinished:
      break;
  }
  return Tr("List of exercises");
}

ResultChoice DrawResultButtons(Ui& ui, const ResultContents& contents) {
  using Kind = NextStep::Kind;
  ResultChoice choice = ResultChoice::kNone;
  const Kind kind = contents.next.kind;
  const bool repeats = kind == Kind::kFirst || kind == Kind::kRepeat;
  ButtonRow buttons(ui);
  const auto add = [&](const char* note, ResultChoice what, const std::string& text, const std::string& keys) {
    if (buttons.Add(note, text, keys)) choice = what;
  };
  add("practise.step", ResultChoice::kStep, NameOf(contents.next), Tr("Enter"));
  if (!repeats) add("practise.again", ResultChoice::kAgain, Tr("Try again"), "A");
  // After a low score, the next level comes after the recommended step.
  if (kind != Kind::kNextLevel && contents.level < kLevels) {
    add("practise.next", ResultChoice::kNextLevel, Tr("Next level"), "N");
  }
  add("practise.watch", ResultChoice::kReplay, Tr("Watch beside the expert"), "W");
  Tooltip(ui, contents.expert_ready ? Tr("Shows your saw and that of the synthetic expert at the same time")
                                    : Tr("The expert's attempt is still being computed"));
  if (kind != Kind::kFinished) add("practise.list", ResultChoice::kList, Tr("Other exercises"), Tr("Esc"));
  return choice;
}

}  // namespace

ResultChoice DrawResult(Ui& ui, const ResultContents& contents) {
  const float s = ui.scale();
  BeginLargeDialog(ui, "result", 1000, 640);
  // The buttons and their reason are always visible; what is above them scrolls if it needs more space.
  const float bottom = 2 * ImGui::GetFrameHeightWithSpacing() + ImGui::GetTextLineHeightWithSpacing() + 8 * s;
  ImGui::BeginChild("body", {0, -bottom});
  ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().accent));
  ImGui::PushFont(ui.title());
  WrappedText(Translate(contents.review.headline));
  ImGui::PopFont();
  ImGui::PopStyleColor();
  ui.Note("practise.headline");
  if (contents.review.praise) MarkedText(ui, HudLevel::kGood, Translate(*contents.review.praise));
  ImGui::PushFont(ui.bold());
  WrappedText(contents.sheet.total
                  ? fmt::format(fmt::runtime(Tr("{}, level {}: {} of 100 points")), contents.title, contents.level,
                                ShowNumber(*contents.sheet.total, 0))
                  : fmt::format(fmt::runtime(Tr("{}, level {}: no score")), contents.title, contents.level));
  ImGui::PopFont();
  if (contents.sheet.picture) DrawCutPicture(ui, *contents.sheet.picture);
  ImGui::Spacing();
  DrawFigures(ui, "figures", contents.review.figures);
  if (!contents.review.rest.empty()) {
    const bool open = BeginSection(ui, Tr("More figures"), false);
    ui.Note("practise.more");
    if (open) DrawFigures(ui, "rest", contents.review.rest);
  }
  ImGui::Spacing();
  ResultChoice choice = ResultChoice::kNone;
  if (contents.verified) {
    MarkedText(ui, *contents.verified ? HudLevel::kGood : HudLevel::kBad,
               *contents.verified
                   ? Tr("Verified: a replay of the recording gives the same score.")
                   : Tr("The replay of the recording gives another score: compare it with 'kerf score'"));
    ui.Note("practise.verified");
  } else if (contents.verification_failed) {
    MarkedText(ui, HudLevel::kWarn, Tr("The score could not be verified by a replay of the recording."));
  } else {
    MarkedText(ui, HudLevel::kPlain, Tr("The recording is being replayed to verify the score."));
  }
  MarkedText(ui, contents.asks_name ? HudLevel::kWarn : HudLevel::kPlain, contents.stored);
  if (contents.asks_name) {
    if (ImGui::Button(fmt::format("{}##name", Tr("Enter your name")).c_str())) choice = ResultChoice::kName;
    ui.Note("practise.name");
  }
  ImGui::EndChild();

  ImGui::Separator();
  WrappedText(Translate(contents.next.reason));
  const ResultChoice clicked = DrawResultButtons(ui, contents);
  ImGui::End();
  return clicked != ResultChoice::kNone ? clicked : choice;
}

// ---- the replay

ReplayChoice DrawReplay(Ui& ui, const ReplayPair& pair, double goal_mm, double& time_s, const UiBox& scene) {
  const float s = ui.scale();
  ReplayChoice choice = ReplayChoice::kNone;
  const float width = std::min(430 * s, static_cast<float>(scene.width) - 16 * s);
  const float height = 236 * s;
  const float above = 52 * s;  // room for messages at the bottom
  if (width < 200 * s || static_cast<float>(scene.height) < height + above + 8 * s) return choice;
  ImGui::SetNextWindowPos(
      {static_cast<float>(scene.left) + 8 * s, static_cast<float>(scene.bottom()) - height - above});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin("replay", nullptr, kDialog | ImGuiWindowFlags_NoFocusOnAppearing);

  // Values at the time that is shown.
  const auto value = [&](const std::vector<DepthPoint>& depths) {
    const auto at = std::lower_bound(depths.begin(), depths.end(), time_s,
                                     [](const DepthPoint& p, double t) { return p.time_s < t; });
    return at != depths.end() && at->time_s < time_s + kGap_s
               ? FormatQuantity({at->depth_mm, 1, "mm"}, PointOfLanguage())
               : std::string("\u2013");
  };
  ImGui::PushFont(ui.bold());
  FittedText(ui, Tr("Depth over time (mm)"), ImGui::GetContentRegionAvail().x);
  ImGui::PopFont();
  LegendEntryItem(ui, Stroke::kSolid, kMadeColour, 2 * s,
                  fmt::format(fmt::runtime(Tr("you: {}")), value(pair.student_depth)));
  ImGui::SameLine(0, 18 * s);
  LegendEntryItem(ui, Stroke::kDashed, kWantedColour, 2 * s,
                  fmt::format(fmt::runtime(Tr("expert: {}")), value(pair.expert_depth)));

  double deepest_mm = 1.15 * goal_mm;
  for (const auto* depths : {&pair.student_depth, &pair.expert_depth}) {
    for (const DepthPoint& p : *depths) deepest_mm = std::max(deepest_mm, p.depth_mm + 0.2);
  }
  const double top_mm = -0.15 * deepest_mm;
  const double duration_s = std::max(1e-6, pair.duration_s());
  const float line = ImGui::GetTextLineHeight();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float axis = ImGui::CalcTextSize("00.0").x + 6 * s;
  const ImVec2 from{corner.x + axis, corner.y + 2 * s};
  const ImVec2 to{corner.x + ImGui::GetContentRegionAvail().x, corner.y + 118 * s};
  const auto x_of = [&](double t) {
    return from.x + (to.x - from.x) * static_cast<float>(std::clamp(t / duration_s, 0.0, 1.0));
  };
  const auto y_of = [&](double depth) {
    return from.y +
           (to.y - from.y) * static_cast<float>(std::clamp((depth - top_mm) / (deepest_mm - top_mm), 0.0, 1.0));
  };
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(from, to, ToImU32(kPaper));
  const auto level = [&](double depth, Stroke stroke, const std::string& text) {
    AddStroke(list, {{from.x, y_of(depth)}, {to.x, y_of(depth)}}, stroke, kBoneLine, s);
    list.AddText({from.x - 6 * s - ImGui::CalcTextSize(text.c_str()).x, y_of(depth) - 0.5F * line},
                 ToImU32(ui.colours().text), text.c_str());
  };
  level(0, Stroke::kSolid, "0");
  level(goal_mm, Stroke::kDashed, ShowNumber(goal_mm, 1));
  const auto curve = [&](const std::vector<DepthPoint>& depths, Stroke stroke, const Rgb8& colour) {
    std::vector<ImVec2> points;
    double last_s = 0;
    for (const DepthPoint& p : depths) {
      if (!points.empty() && p.time_s > last_s + kGap_s) {
        AddStroke(list, points, stroke, colour, 2 * s);
        points.clear();
      }
      last_s = p.time_s;
      // One point per pixel is enough.
      const ImVec2 at{x_of(p.time_s), y_of(p.depth_mm)};
      if (points.empty() || at.x >= points.back().x + 1) points.push_back(at);
    }
    AddStroke(list, points, stroke, colour, 2 * s);
  };
  curve(pair.student_depth, Stroke::kSolid, kMadeColour);
  curve(pair.expert_depth, Stroke::kDashed, kWantedColour);
  list.AddLine({x_of(time_s), from.y}, {x_of(time_s), to.y}, ToImU32(kInk), 1.5F * s);
  list.AddRect(from, to, ToImU32(ui.colours().edge));
  ImGui::SetCursorScreenPos(from);
  ImGui::InvisibleButton("plot", {to.x - from.x, to.y - from.y});
  ui.Note("practise.plot");
  if (ImGui::IsItemActive()) {
    const double share = static_cast<double>((ImGui::GetIO().MousePos.x - from.x) / (to.x - from.x));
    time_s = duration_s * std::clamp(share, 0.0, 1.0);
  }
  Tooltip(ui, Tr("Click or drag to choose the time. The dashed grey line is the wanted depth."));
  const std::string now =
      fmt::format(fmt::runtime(Tr("{} s of {} s")), ShowNumber(time_s, 0), ShowNumber(duration_s, 0));
  ImGui::SetCursorScreenPos({from.x, to.y + 3 * s});
  ImGui::TextUnformatted(now.c_str());
  ImGui::Spacing();
  ButtonRow buttons(ui);
  if (buttons.Add("practise.restart", Tr("From the beginning"), Tr("Enter"))) choice = ReplayChoice::kRestart;
  if (buttons.Add("practise.result", Tr("Back to the result"), Tr("Esc"))) choice = ReplayChoice::kBack;
  ImGui::End();
  return choice;
}

}  // namespace kerf
