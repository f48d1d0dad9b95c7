#include "app/window/practice_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/window/cut_panel.h"
#include "app/window/injury_texts.h"
#include "app/window/practice_widgets.h"
#include "session/practise/exercises.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/panels.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

/// Pause in a depth curve from which its line is interrupted.
constexpr double kGap_s = 0.1;

/// Line below a table of figures.
struct FigureSum {
  std::string text;
  int lost_points = 0;
};

void DrawFigures(Ui& ui, const char* id, const std::vector<ReviewFigure>& figures,
                 const std::vector<FigureSum>& sums = {}) {
  if (figures.empty() || !ImGui::BeginTable(id, 5, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg)) return;
  const float s = ui.scale();
  // In a narrow window, the columns of numbers are as narrow as their texts.
  const float share = ImGui::GetContentRegionAvail().x < 620 * s ? 0 : s;
  float value_width = WidthFor({Tr("Value")}, 130 * share);
  float goal_width = WidthFor({Tr("Goal")}, 150 * share);
  ImGui::PushFont(ui.bold());
  for (const ReviewFigure& figure : figures) {
    if (figure.value) value_width = WidthFor({FormatQuantity(*figure.value, PointOfLanguage())}, value_width);
    goal_width = WidthFor({FormatGoal(figure, PointOfLanguage())}, goal_width);
  }
  ImGui::PopFont();
  ImGui::TableSetupColumn("##mark", 0, ImGui::GetTextLineHeight() + 4 * s);
  ImGui::TableSetupColumn(Tr("Figure"), ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn(Tr("Value"), 0, value_width);
  ImGui::TableSetupColumn(Tr("Goal"), 0, goal_width);
  ImGui::TableSetupColumn(Tr("Points lost"), 0, WidthFor({Tr("Points lost"), Tr("not scored")}, 120 * share));
  ImGui::TableHeadersRow();
  for (const ReviewFigure& figure : figures) {
    ImGui::TableNextColumn();
    LevelMark(ui, HudLevelOf(figure.level));
    ImGui::TableNextColumn();
    FittedText(ui, Tr(figure.label), ImGui::GetContentRegionAvail().x);
    ui.Note(fmt::format("figure {}", figure.info->key));
    Tooltip(ui, Tr(MeaningOf(*figure.info)));
    ImGui::TableNextColumn();
    ImGui::PushFont(ui.bold());
    FittedText(ui, figure.value ? FormatQuantity(*figure.value, PointOfLanguage()) : "\u2013",
               ImGui::GetContentRegionAvail().x);
    ImGui::PopFont();
    ImGui::TableNextColumn();
    if (figure.goal) FittedText(ui, FormatGoal(figure, PointOfLanguage()), ImGui::GetContentRegionAvail().x);
    ImGui::TableNextColumn();
    if (figure.lost_points > 0) {
      ImGui::TextUnformatted(fmt::format("{}", figure.lost_points).c_str());
    } else if (figure.goal && !figure.scored) {
      FittedText(ui, Tr("not scored"), ImGui::GetContentRegionAvail().x);
    }
  }
  for (const auto& [text, lost_points] : sums) {
    ImGui::TableNextRow();
    ImGui::TableSetColumnIndex(1);
    FittedText(ui, text, ImGui::GetContentRegionAvail().x);
    ImGui::TableSetColumnIndex(4);
    ImGui::PushFont(ui.bold());
    ImGui::TextUnformatted(fmt::format("{}", lost_points).c_str());
    ImGui::PopFont();
  }
  ImGui::EndTable();
}

/// Returns the lines below the figures of a graded attempt, so that the lost points add up.
std::vector<FigureSum> SumLosses(const ExerciseReview& review) {
  int shown = 0;
  int others = 0;
  for (const ReviewFigure& figure : review.figures) shown += figure.lost_points;
  for (const ReviewFigure& figure : review.rest) others += figure.lost_points;
  std::vector<FigureSum> sums;
  if (others > 0) sums.push_back({Tr("More figures, below"), others});
  sums.push_back({Tr("Lost in total"), shown + others});
  return sums;
}

}  // namespace

// ---- while cutting

void DrawCrossed(Ui& ui, const PlanesReport& report) {
  const auto draw = [&](const char* title, const char* note, const std::vector<StructureResult>& injuries) {
    if (injuries.empty() || !BeginSection(ui, title)) return;
    if (*note != '\0') SmallText(ui, note);
    for (const StructureResult& injury : injuries) SmallText(ui, DescribeInjury(injury));
    ImGui::Spacing();
  };
  draw(Tr("Injured outside the plan"), "", report.beside);
  draw(Tr("Crossed by the plan"), Tr("Not scored:"), report.injuries);
}

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
      return fmt::format(fmt::runtime(Tr("Start level {}")), next.level);
    case NextStep::Kind::kRepeat:
      return fmt::format(fmt::runtime(Tr("Try level {} again")), next.level);
    case NextStep::Kind::kNextLevel:
    case NextStep::Kind::kPreviousLevel:
      return fmt::format(fmt::runtime(Tr("Go on with level {}")), next.level);
    case NextStep::Kind::kNextExercise:
      return fmt::format(fmt::runtime(Tr("Start \"{}\", level {}")), Tr(FindExercise(next.exercise).title.c_str()),
                         next.level);
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
  // The buttons and their reason are always visible; what is above them scrolls if it needs more space. In a low window
  // the reason is in small letters. The height of the buttons' lines is that of the last frame.
  const bool low = ImGui::GetContentRegionAvail().y < 400 * s;
  float& buttons_height =
      *ImGui::GetStateStorage()->GetFloatRef(ImGui::GetID("buttons"), ImGui::GetFrameHeightWithSpacing());
  // While the replay is awaited, its progress takes the place of the reason.
  const std::string reason =
      contents.waits_s
          ? fmt::format(fmt::runtime(Tr("The expert's attempt is being computed, since {} s. The replay then begins.")),
                        ShowNumber(*contents.waits_s, 0))
          : Translate(contents.next.reason);
  const auto draw_reason = [&] {
    if (low) ImGui::PushFont(ui.small());
    WrappedText(reason);
    ui.Note("practise.reason");
    if (low) ImGui::PopFont();
  };
  if (low) ImGui::PushFont(ui.small());
  const float reason_height =
      CalcWrappedHeight(reason, ImGui::GetContentRegionAvail().x) + ImGui::GetStyle().ItemSpacing.y;
  if (low) ImGui::PopFont();
  const float bottom = buttons_height + reason_height + 12 * s;
  // A result begins at its top, wherever the last one was left.
  const bool appears = ImGui::IsWindowAppearing();
  // Clear of the scroll bar.
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {6 * s, 0});
  ImGui::BeginChild("body", {0, -bottom}, false, ImGuiWindowFlags_AlwaysUseWindowPadding);
  ImGui::PopStyleVar();
  if (appears) ImGui::SetScrollY(0);
  ImGui::PushStyleColor(ImGuiCol_Text, ToImVec4(ui.colours().accent));
  ImGui::PushFont(ui.title());
  const ExerciseReview& review = contents.review;
  WrappedText((review.passed ? Translate(*review.passed) + " " : "") + Translate(review.headline));
  ImGui::PopFont();
  ImGui::PopStyleColor();
  ui.Note("practise.headline");
  if (contents.review.praise) MarkedText(ui, HudLevel::kGood, Translate(*contents.review.praise));
  for (const Message& note : contents.review.notes) MarkedText(ui, HudLevel::kWarn, Translate(note));
  if (!contents.holder.empty()) MarkedText(ui, HudLevel::kWarn, contents.holder);
  for (const Message& line : contents.review.crossed) MarkedText(ui, HudLevel::kPlain, Translate(line));
  if (contents.review.nerve) MarkedText(ui, HudLevel::kPlain, Translate(*contents.review.nerve));
  ImGui::PushFont(ui.bold());
  WrappedText(contents.sheet.total
                  ? fmt::format(fmt::runtime(Tr("{}, level {}: {} of 100 points")), contents.title, contents.level,
                                ShowNumber(*contents.sheet.total, 0))
                  : fmt::format(fmt::runtime(Tr("{}, level {}: no score")), contents.title, contents.level));
  ImGui::PopFont();
  if (contents.sheet.picture) DrawCutPicture(ui, *contents.sheet.picture);
  ImGui::Spacing();
  DrawFigures(ui, "figures", contents.review.figures,
              contents.sheet.total ? SumLosses(contents.review) : std::vector<FigureSum>{});
  if (contents.sheet.total) {
    SmallText(ui,
              Tr("Tick: costs no points. Triangle: costs points. Cross: costs more than half of the figure's points. "
                 "The mark of a figure that is not scored only says whether its goal was met."));
    SmallText(
        ui, Tr("Depth and place have no tolerance: the greater a deviation, the more points it costs. Points are whole "
               "numbers, so that the smallest deviations may cost none."));
  }
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
                   ? contents.sheet.total ? Tr("Verified: a replay of the recording gives the same score.")
                                          : Tr("Verified: a replay of the recording gives the same figures.")
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
  draw_reason();
  const float buttons_top = ImGui::GetCursorPosY();
  const ResultChoice clicked = DrawResultButtons(ui, contents);
  buttons_height = ImGui::GetCursorPosY() - buttons_top;
  ImGui::End();
  return clicked != ResultChoice::kNone ? clicked : choice;
}

// ---- the replay

namespace {

/// Layout of the replay's window.
struct ReplayLayout {
  UiBox box;
  bool full = true;        // with a title and an explanation
  float plot_height = 0;   // 0: without the plot
  bool names_keys = true;  // the buttons name their keys
  std::string counted;     // the explanation
};

/// Returns the explanation of what is shown: the replay leaves out what came before and after the cut.
std::string DescribeCounted(const ReplayPair& pair, double counted_s) {
  return fmt::format(
      fmt::runtime(Tr("Your attempt took {0} s: time counts from the first movement of the saw, or the start of the "
                      "spindle, to the end. Only the time from just before to just after the cut is shown: yours took "
                      "{1} s, the expert's {2} s.")),
      ShowNumber(counted_s, 0), ShowNumber(pair.student.duration_s(), 0), ShowNumber(pair.expert.duration_s(), 0));
}

ReplayLayout LayOutReplay(const Ui& ui, const ReplayPair& pair, double counted_s, const UiBox& scene) {
  constexpr float kPlot = 118;      // points
  constexpr float kLeastPlot = 40;  // below this height, curves can't be read
  const float s = ui.scale();
  const auto scene_height = static_cast<float>(scene.height);
  ReplayLayout layout;
  layout.counted = DescribeCounted(pair, counted_s);
  const float width = std::min(520 * s, static_cast<float>(scene.width) - 16 * s);
  // Without the names of their keys if they do not fit side by side; what then does not fit needs another line.
  const ImGuiStyle& style = ImGui::GetStyle();
  const auto fits = [&](const std::string& labels) {
    return ImGui::CalcTextSize(labels.c_str()).x + 6 * style.FramePadding.x + 2 * style.ItemSpacing.x +
               2 * style.WindowPadding.x <=
           width;
  };
  const std::string labels = fmt::format("{}{}{}", Tr("From the beginning"), Tr("Go on"), Tr("Back to the result"));
  layout.names_keys = fits(fmt::format("{} ({}) ({}) ({})", labels, Tr("Enter"), Tr("Space"), Tr("Esc")));
  const float buttons = (fits(labels) ? 1 : 2) * ImGui::GetFrameHeightWithSpacing();
  const float slider = ImGui::GetFrameHeightWithSpacing();
  ImGui::PushFont(ui.small());
  const float counted_height = CalcWrappedHeight(layout.counted, width - 16 * s) + 4 * s;
  ImGui::PopFont();
  float above_edge = 52 * s;  // room for messages at the bottom
  layout.plot_height = kPlot * s;
  float height = 190 * s + slider + counted_height + buttons;
  // It covers at most half of the scene, in which the saws are seen.
  if (height > 0.5F * scene_height) {
    layout.full = false;
    above_edge = 8 * s;
    const float least = 2 * style.WindowPadding.y + ImGui::GetTextLineHeightWithSpacing() + slider + buttons;
    layout.plot_height = std::min(kPlot * s, 0.44F * scene_height - least);
    if (layout.plot_height < kLeastPlot * s) layout.plot_height = 0;
    height = least + (layout.plot_height > 0 ? layout.plot_height + 2 * style.ItemSpacing.y : 0);
  }
  if (width < 200 * s || scene_height < height + above_edge + 8 * s) return layout;
  layout.box = {scene.left + static_cast<double>(8 * s), scene.bottom() - static_cast<double>(height + above_edge),
                width, height};
  return layout;
}

}  // namespace

UiBox CalcReplayBox(const Ui& ui, const ReplayPair& pair, double counted_s, const UiBox& scene) {
  return LayOutReplay(ui, pair, counted_s, scene).box;
}

ReplayChoice DrawReplay(Ui& ui, const ReplayPair& pair, double goal_mm, double counted_s, bool runs, double& time_s,
                        const UiBox& scene) {
  const float s = ui.scale();
  ReplayChoice choice = ReplayChoice::kNone;
  const ReplayLayout layout = LayOutReplay(ui, pair, counted_s, scene);
  if (layout.box.empty()) return choice;
  ImGui::SetNextWindowPos({static_cast<float>(layout.box.left), static_cast<float>(layout.box.top)});
  ImGui::SetNextWindowSize({static_cast<float>(layout.box.width), static_cast<float>(layout.box.height)});
  ImGui::Begin("replay", nullptr, kPracticeDialog | ImGuiWindowFlags_NoFocusOnAppearing);

  // Values at the time that is shown.
  const auto value = [&](const std::vector<DepthPoint>& depths) {
    const auto at = std::lower_bound(depths.begin(), depths.end(), time_s,
                                     [](const DepthPoint& p, double t) { return p.time_s < t; });
    return at != depths.end() && at->time_s < time_s + kGap_s
               ? FormatQuantity({at->depth_mm, 1, "mm"}, PointOfLanguage())
               : std::string("\u2013");
  };
  if (layout.full) {
    ImGui::PushFont(ui.bold());
    FittedText(ui, Tr("Depth over time (mm)"), ImGui::GetContentRegionAvail().x);
    ImGui::PopFont();
  }
  LegendEntryItem(ui, Stroke::kSolid, kMadeColour, 2 * s,
                  fmt::format(fmt::runtime(Tr("you: {}")), value(pair.student_depth)));
  ImGui::SameLine(0, 18 * s);
  LegendEntryItem(ui, Stroke::kDashed, kWantedColour, 2 * s,
                  fmt::format(fmt::runtime(Tr("expert: {}")), value(pair.expert_depth)));

  const double duration_s = std::max(1e-6, pair.duration_s());
  const std::string now =
      fmt::format(fmt::runtime(Tr("{} s of {} s")), ShowNumber(time_s, 0), ShowNumber(duration_s, 0));
  // The slider's handle is as far from its ends; it stands below the plot's line.
  const float handle = 2 + 0.5F * ImGui::GetStyle().GrabMinSize;
  float axis = 0;
  if (layout.plot_height > 0) {
    double deepest_mm = 1.15 * goal_mm;
    for (const auto* depths : {&pair.student_depth, &pair.expert_depth}) {
      for (const DepthPoint& p : *depths) deepest_mm = std::max(deepest_mm, p.depth_mm + 0.2);
    }
    const double top_mm = -0.15 * deepest_mm;
    const float line = ImGui::GetTextLineHeight();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const std::string goal = FormatQuantity({goal_mm, 1, "mm"}, PointOfLanguage());
    axis = ImGui::CalcTextSize(goal.c_str()).x + 6 * s;
    const ImVec2 from{corner.x + axis, corner.y + 2 * s};
    const ImVec2 to{corner.x + ImGui::GetContentRegionAvail().x - handle, corner.y + layout.plot_height};
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
    level(0, Stroke::kSolid, y_of(goal_mm) - y_of(0) >= line ? "0" : "");  // not over the other one
    level(goal_mm, Stroke::kDashed, goal);
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
    ImGui::SetCursorScreenPos({corner.x, to.y + ImGui::GetStyle().ItemSpacing.y});
  }
  if (axis > 0) ImGui::SetCursorPosX(ImGui::GetCursorPosX() + axis - handle);
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
  auto slider_s = static_cast<float>(time_s);
  if (ImGui::SliderFloat("##time", &slider_s, 0, static_cast<float>(duration_s), now.c_str(),
                         ImGuiSliderFlags_NoInput)) {
    time_s = static_cast<double>(slider_s);
  }
  ui.Note("practise.time");
  if (layout.full) {
    SmallText(ui, layout.counted);
    ui.Note("practise.counted");
  }
  ImGui::Spacing();
  ButtonRow buttons(ui);
  const auto add = [&](const char* note, const char* text, const char* key, ReplayChoice what) {
    if (buttons.Add(note, text, layout.names_keys ? key : "")) choice = what;
  };
  add("practise.restart", Tr("From the beginning"), Tr("Enter"), ReplayChoice::kRestart);
  add("practise.pause", runs ? Tr("Pause") : Tr("Go on"), Tr("Space"), ReplayChoice::kPause);
  add("practise.result", Tr("Back to the result"), Tr("Esc"), ReplayChoice::kBack);
  ImGui::End();
  return choice;
}

}  // namespace kerf
