#include "app/window/exercise_list.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <utility>

#include "app/window/practice_widgets.h"
#include "session/practise/exercises.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

/// Width of a dialog in points below which the table of exercises has no columns of levels.
constexpr float kNarrow = 620;
/// Height in points from which a table scrolls by itself.
constexpr float kLeastTable = 150;

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
  static constexpr std::array<const char*, kLevels> kAids{Msg("all aids"), Msg("no steps and no depth stop"),
                                                          Msg("gauge, blade colour and plane lock"),
                                                          Msg("gauge and plane lock"), Msg("plane lock only")};
  return Tr(kAids[static_cast<std::size_t>(level - 1)]);
}

/// Returns the rule of the trend.
std::string DescribeTrend(const ExerciseRow& row) {
  std::string totals;
  const std::size_t first = row.totals.size() - std::min(row.totals.size(), kMaxTrendAttempts);
  for (std::size_t i = first; i < row.totals.size(); ++i) {
    totals += (totals.empty() ? "" : ", ") + ShowNumber(row.totals[i], 0);
  }
  return fmt::format(
      fmt::runtime(Tr("Points of the last attempts at level {}: {}. The trend is that of the straight line "
                      "through them, from {} points of change on.")),
      row.level, totals, ShowNumber(kTrendPoints, 0));
}

std::string ShowBest(const std::optional<double>& best) {
  return best ? ShowNumber(*best, 0) : "\u2013";
}

/// Returns the best scores of all levels in one line.
std::string ListBest(const ExerciseRow& row) {
  std::string scores;
  for (const std::optional<double>& best : row.best) scores += (scores.empty() ? "" : "   ") + ShowBest(best);
  return fmt::format(fmt::runtime(Tr("Best scores of levels 1 to 5: {}")), scores);
}

/// Returns true if no part of the last item lies outside the visible part of its window.
bool IsWholeItemVisible() {
  const float top = ImGui::GetWindowPos().y;
  return ImGui::GetItemRectMin().y >= top && ImGui::GetItemRectMax().y <= top + ImGui::GetWindowHeight();
}

}  // namespace

ExerciseList::ExerciseList(std::vector<ExerciseRow> rows, std::string student, NextStep next)
    : rows_(std::move(rows)), student_(std::move(student)), next_(std::move(next)) {
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
  // Larger text or a smaller window must not hide the selected row.
  const UiBox size{0, 0, ui.width() / static_cast<double>(s), ui.height() / static_cast<double>(s)};
  if (size.width != drawn_in_.width || size.height != drawn_in_.height) resized_frames_ = 2;
  drawn_in_ = size;
  if (resized_frames_ > 0 && --resized_frames_ == 0) scrolls_ = true;
  BeginLargeDialog(ui, "exercises", 1040, 500);
  ImGui::BeginChild("body");
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
  const bool narrow = ImGui::GetContentRegionAvail().x < kNarrow * s;
  const std::string keys =
      narrow ? Tr("Choose an exercise to see its levels.   Ctrl+Q: quit")
             : Tr("Numbers: the best score of a level.   Up, Down, Enter: choose an exercise   Ctrl+Q: quit");
  ImGui::PushFont(ui.small());
  const float footer = CalcWrappedHeight(keys, ImGui::GetContentRegionAvail().x) + 10 * s;
  ImGui::PopFont();
  // In a narrow window the scores stand below the goal, and a click on an exercise shows its levels; in a low one
  // everything scrolls.
  const bool scrolls = ImGui::GetContentRegionAvail().y - footer > kLeastTable * s;
  ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, {5 * s, 4 * s});
  if (ImGui::BeginTable(
          "exercises", narrow ? 2 : 3 + kLevels,
          ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_BordersInnerH | (scrolls ? ImGuiTableFlags_ScrollY : 0),
          {0, scrolls ? -footer : 0})) {
    if (scrolls) ImGui::TableSetupScrollFreeze(0, 1);
    ImGui::TableSetupColumn("##number", 0, 20 * s);
    ImGui::TableSetupColumn(Tr("Exercise"), ImGuiTableColumnFlags_WidthStretch);
    for (int level = 1; level <= kLevels && !narrow; ++level) {
      const std::string name = fmt::format(fmt::runtime(Tr("Level {}")), level);
      ImGui::TableSetupColumn(name.c_str(), 0, WidthFor({name}, 58 * s));
    }
    if (!narrow) {
      ImGui::TableSetupColumn(
          Tr("Trend"), 0,
          WidthFor({Tr("Trend"), NameOf(Trend::kRising), NameOf(Trend::kSteady), NameOf(Trend::kFalling)}, 80 * s));
    }
    ImGui::TableHeadersRow();
    ui.Note("exercise headings");
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const ExerciseRow& row = rows_[i];
      ImGui::PushID(static_cast<int>(i));
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      // The goal needs two lines at most at the normal size of text.
      const float top_y = ImGui::GetCursorPosY();
      ImGui::TableSetColumnIndex(1);
      const float room = ImGui::GetContentRegionAvail().x;
      const std::string goal = narrow ? Translate(row.goal) + "\n" + ListBest(row) : Translate(row.goal);
      ImGui::PushFont(ui.small());
      const float goal_height = CalcWrappedHeight(goal, room);
      ImGui::PopFont();
      const float height = ImGui::GetTextLineHeightWithSpacing() + goal_height;
      ImGui::TableSetColumnIndex(0);
      const bool selected = i == row_;
      // The pointer is not a second selection.
      ImGui::PushStyleColor(ImGuiCol_HeaderHovered, ToImVec4(ui.colours().selected, selected ? 1 : 0.35));
      const bool clicked = ImGui::Selectable(
          "##row", selected, ImGuiSelectableFlags_SpanAllColumns | ImGuiSelectableFlags_AllowItemOverlap, {0, height});
      ImGui::PopStyleColor();
      if (clicked) OpenLevels(i);
      ui.Note(fmt::format("exercise {}", row.id));
      if (selected && std::exchange(scrolls_, false) && !IsWholeItemVisible()) ImGui::SetScrollHereY();
      ImGui::SetCursorPosY(top_y);
      ImGui::TextDisabled("%d", static_cast<int>(i) + 1);
      ImGui::TableNextColumn();
      ImGui::PushFont(ui.bold());
      FittedText(ui, Tr(row.title.c_str()), room);
      ImGui::PopFont();
      SmallText(ui, goal);
      for (int level = 1; level <= kLevels && !narrow; ++level) {
        ImGui::TableNextColumn();
        const bool next = row.id == next_.exercise && level == next_.level;
        if (next) {
          ImGui::PushStyleColor(ImGuiCol_Button, ToImVec4(ui.colours().accent));
          ImGui::PushStyleColor(ImGuiCol_ButtonHovered, ToImVec4(ui.colours().accent, 0.85));
          ImGui::PushStyleColor(ImGuiCol_ButtonActive, ToImVec4(ui.colours().accent, 0.85));
          ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().panel));
        }
        const std::string best = ShowBest(row.best[static_cast<std::size_t>(level - 1)]);
        if (ImGui::Button(fmt::format("{}##{}", best, level).c_str(), {-1, 0})) {
          row_ = i;
          level_ = level;
          choice = Choice::kStart;
        }
        if (next) ImGui::PopStyleColor(4);
        ui.Note(fmt::format("exercise {} {}", row.id, level));
        Tooltip(ui, fmt::format(fmt::runtime(next ? Tr("Recommended: level {}, {}. Click to start it.")
                                                  : Tr("Level {}, {}. Click to start it.")),
                                level, DescribeLevel(level)));
      }
      if (!narrow) ImGui::TableNextColumn();
      if (narrow) {
        // The levels have their scores.
      } else if (row.trend != Trend::kUnknown) {
        FittedText(ui, NameOf(row.trend), ImGui::GetContentRegionAvail().x);
        Tooltip(ui, DescribeTrend(row));
      } else if (row.totals.size() >= 2) {
        FittedText(ui,
                   fmt::format("{} \u2192 {}", ShowNumber(row.totals[row.totals.size() - 2], 0),
                               ShowNumber(row.totals.back(), 0)),
                   ImGui::GetContentRegionAvail().x);
      } else if (row.attempts > 0) {
        ImGui::TextDisabled("%s", row.attempts == 1
                                      ? Tr("1 attempt")
                                      : fmt::format(fmt::runtime(Tr("{} attempts")), row.attempts).c_str());
      } else if (row.unfinished > 0) {
        ImGui::TextDisabled("%s", fmt::format(fmt::runtime(Tr("{} unfinished")), row.unfinished).c_str());
      }
      ImGui::PopID();
    }
    ImGui::EndTable();
  }
  ImGui::PopStyleVar();
  SmallText(ui, keys);
  ImGui::EndChild();
  ImGui::End();
  return choice;
}

ExerciseList::Choice ExerciseList::DrawLevels(Ui& ui) {
  const float s = ui.scale();
  Choice choice = Choice::kNone;
  const ExerciseRow& row = rows_[row_];
  BeginLargeDialog(ui, "levels", 720, 290);
  const std::string start = fmt::format(fmt::runtime(Tr("Start level {}")), level_);
  const bool narrow = ImGui::GetContentRegionAvail().x < kNarrow * s;
  const float rows = narrow ? 2 : 1;  // of buttons
  ImGui::BeginChild("body", {0, -rows * ImGui::GetFrameHeightWithSpacing() - 4 * s});
  ImGui::PushFont(ui.title());
  WrappedText(Tr(row.title.c_str()));
  ImGui::PopFont();
  WrappedText(Translate(row.goal));
  ImGui::Spacing();
  const int recommended = FindRecommendedLevel(row);
  if (ImGui::BeginTable("levels", 4, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_BordersInnerH)) {
    ImGui::TableSetupColumn("##number", 0, 20 * s);
    ImGui::TableSetupColumn(
        Tr("Level"), 0,
        WidthFor({fmt::format(fmt::runtime(Tr("Level {} (recommended)")), kLevels)}, narrow ? 0 : 180 * s));
    ImGui::TableSetupColumn(Tr("Aids"), ImGuiTableColumnFlags_WidthStretch);
    ImGui::TableSetupColumn(Tr("Best"), 0, 60 * s);
    ImGui::TableHeadersRow();
    for (int level = 1; level <= kLevels; ++level) {
      ImGui::PushID(level);
      ImGui::TableNextRow();
      ImGui::TableSetColumnIndex(2);
      const float height = CalcWrappedHeight(DescribeLevel(level), ImGui::GetContentRegionAvail().x);
      ImGui::TableSetColumnIndex(0);
      if (ImGui::Selectable(fmt::format("{}", level).c_str(), level == level_, ImGuiSelectableFlags_SpanAllColumns,
                            {0, height})) {
        level_ = level;
        choice = Choice::kStart;
      }
      ui.Note(fmt::format("level {}", level));
      ImGui::TableNextColumn();
      FittedText(ui,
                 fmt::format(fmt::runtime(level == recommended ? Tr("Level {} (recommended)") : Tr("Level {}")), level),
                 ImGui::GetContentRegionAvail().x);
      ImGui::TableNextColumn();
      WrappedText(DescribeLevel(level));
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(ShowBest(row.best[static_cast<std::size_t>(level - 1)]).c_str());
      ImGui::PopID();
    }
    ImGui::EndTable();
  }
  ImGui::EndChild();
  ButtonRow buttons(ui);
  if (buttons.Add("practise.start", start, Tr("Enter"))) {
    choice = Choice::kStart;
  }
  if (buttons.Add("practise.back", Tr("Other exercises"), Tr("Esc"))) {
    shows_levels_ = false;
    scrolls_ = true;
  }
  ImGui::End();
  return choice;
}

}  // namespace kerf
