#include "app/window/scan_check.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "bone/import/patient_frame.h"
#include "view/ui/imgui_colours.h"
#include "view/ui/translate.h"
#include "view/ui/widgets.h"

namespace kerf {
namespace {

// Reasons of NotHu, UnclearSeries and UnclearUnit, for the translation.
[[maybe_unused]] constexpr std::array kQuestionReasons{
    Msg("this is a CT without its offset: air lies near 0 and soft tissue near {}, but in HU they lie at -1000 and 0 "
        "to 80"),
    Msg("these values are not HU: air lies near {}, soft tissue near {}, bone from about {}"),
    Msg("the bone's surface was taken at {}, and the values were converted to approximate HU by air and soft tissue, "
        "so that cortical bone and teeth are only roughly distinguished and CT numbers do not give moduli"),
    Msg("the folder contains {} CT series"),
    Msg("the CT slices are of {} patients"),
    Msg("no series is stated to be a CT"),
    Msg("the series has the modality {}, not CT"),
    Msg("(not given)"),
    Msg("the series is stored as secondary captures, that is, as pictures that another program made"),
    Msg("the largest side of the surface is {}, which may be a piece of {} mm or a {} of {} cm"),
    Msg("the largest side of the surface is {}, which is unlikely for a bone in mm"),
    Msg("skull"),
    Msg("pelvis"),
    Msg("long bone"),
    Msg("long thin bone"),
    Msg("long bone of a child")};

constexpr std::size_t kBins = 110;
constexpr Rgb8 kBone{255, 140, 40};  // as bone is tinted in the slices

}  // namespace

ScanCheck::ScanCheck(std::shared_ptr<const Volume> ct, const std::optional<AssumedPlacing>& placing,
                     const std::optional<NotHu>& values)
    : ct_(std::move(ct)), shown_(ct_), placing_(placing), values_(values) {
  if (!values_) return;
  value_ = values_->proposed_iso();
  histogram_ = CalcHistogram(*ct_, kBins, {value_ - 1, value_ + 1});
}

std::string ScanCheck::frame() const {
  glm::dmat3 turn(1);
  for (int a = 0; a < 3; ++a) turn[a][a] = swapped_[static_cast<std::size_t>(a)] ? -1 : 1;
  return placing_ ? FrameName(turn) : "";
}

double ScanCheck::spacing_z_mm() const {
  return spacing_mm_ > 0 || !placing_ || lacks_spacing() ? spacing_mm_ : placing_->spacing_mm.value_or(0);
}

double ScanCheck::CalcIsoHu() const {
  return values_ ? values_->scale().ToHu(value_) : IsolateOptions{}.iso_hu;
}

CtGreys ScanCheck::CalcGreys(bool converted) const {
  if (!values_) return {};
  const double middle = 0.5 * (histogram_.lower + histogram_.upper), width = histogram_.upper - histogram_.lower;
  if (!converted) return {middle, width, value_};
  const GreyScale& scale = values_->scale();
  return {scale.ToHu(middle), width / scale.CalcScale(), CalcIsoHu()};
}

/// Places the slices that are shown as the user says. The middle of the scan stays where it is.
void ScanCheck::Place() {
  auto shown = std::make_shared<Volume>(*ct_);
  if (spacing_mm_ > 0) shown->spacing_mm[placing_->axis] = spacing_mm_;
  const Vec3 middle_W = CalcScanBox(*shown).centre();
  glm::dmat3 turn(1);
  for (int a = 0; a < 3; ++a) turn[a][a] = swapped_[static_cast<std::size_t>(a)] ? -1 : 1;
  shown->origin_W = middle_W + turn * (shown->origin_W - middle_W);
  shown->axes_W = turn * shown->axes_W;
  shown_ = std::move(shown);
}

bool ScanCheck::DrawSpacing(Ui& ui) {
  std::string text = is_answered() ? ShowNumber(spacing_z_mm(), 3) : "";
  ImGui::SetNextItemWidth(80 * ui.scale());
  const bool edited = TextField(ui, fmt::format("{}##spacing", Tr("mm between the slices")).c_str(), text);
  ui.Note("placing.spacing");
  if (!is_answered() || !lacks_spacing()) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled("%s", lacks_spacing()
                                  ? Tr("not stated in the file; shown as that of the pixels until you give it")
                                  : fmt::format(fmt::runtime(Tr("assumed by {}")), placing_->spacing_from).c_str());
    ImGui::PopTextWrapPos();
  }
  const std::optional<double> given_mm = edited ? ParseNumber(text) : std::nullopt;
  if (given_mm) spacing_mm_ = kSliceSpacingRange_mm.Clamp(*given_mm);
  return given_mm.has_value();
}

/// Asks where the slices lie.
void ScanCheck::DrawPlacing(Ui& ui, CtPreview& slices) {
  ImGui::PushFont(ui.bold());
  WrappedText(Tr("Do the slices lie like this?"));
  ImGui::PopFont();
  WrappedText(
      placing_->has_orientation
          ? Tr("The file does not state where its slices lie. Look at the coronal and the sagittal slices: are their "
               "size and order right?")
          : Tr("The file states neither where its slices lie nor how the patient lies. Look at the slices: is the size "
               "right, the head up, the face at A? Compare left and right with the patient."));
  ImGui::Spacing();
  bool changed = placing_->spacing_mm && DrawSpacing(ui);
  const std::array names{Tr("Swap left and right"), Tr("Swap front and back"), Tr("Swap head and feet")};
  for (std::size_t a = 0; a < swapped_.size(); ++a) {
    const bool along = placing_->axis == static_cast<int>(a);
    if (placing_->has_orientation && !along) continue;
    if (ImGui::Checkbox(placing_->has_orientation ? Tr("Reverse the order of the slices") : names[a], &swapped_[a])) {
      changed = true;
    }
    ui.Note(fmt::format("placing.swap {}", a + 1));
  }
  if (!placing_->has_orientation) {
    ImGui::PushTextWrapPos(0);
    ImGui::TextDisabled("%s", Tr("One swap mirrors the scan, two turn it."));
    ImGui::PopTextWrapPos();
  }
  if (changed) {
    Place();
    slices.Follow(shown_);
  }
  ImGui::Spacing();
}

/// Asks from which value on it is bone.
void ScanCheck::DrawThreshold(Ui& ui, CtPreview& slices) {
  ImGui::PushFont(ui.bold());
  WrappedText(Tr("From which value on is it bone?"));
  ImGui::PopFont();
  WrappedText(
      Tr("What counts as bone is tinted in the slices. Move the threshold until all bone is tinted, and as little else "
         "as possible. Turn the wheel over a slice to scroll. Then press Import."));
  ImGui::Spacing();
  const float width = ImGui::GetContentRegionAvail().x;
  DrawHistogram(ui, width);
  ui.Note("threshold.histogram");
  auto value = static_cast<float>(value_);
  ImGui::SetNextItemWidth(width);
  if (ImGui::SliderFloat("##value", &value, static_cast<float>(histogram_.lower), static_cast<float>(histogram_.upper),
                         "%.0f")) {
    value_ = std::round(static_cast<double>(value));
    slices.Tint(value_);
  }
  ui.Note("threshold.value");
  ImGui::Spacing();
}

/// Draws how often the values occur, with the peaks of air and soft tissue and the threshold, each named in a line of
/// its own.
void ScanCheck::DrawHistogram(Ui& ui, float width) const {
  constexpr double kDecades = 4;  // of the fractions, from the top of the plot to its bottom
  const float s = ui.scale();
  const float line = ImGui::GetTextLineHeight();
  const float top = 3 * line, high = 60 * s;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const double most = std::max(1e-9, *std::max_element(histogram_.fractions.begin(), histogram_.fractions.end()));
  const double range = histogram_.upper - histogram_.lower;
  const auto x = [&](double value) {
    return at.x + width * static_cast<float>(std::clamp((value - histogram_.lower) / range, 0.0, 1.0));
  };
  const ImU32 faint = ImGui::GetColorU32(ImGuiCol_TextDisabled);
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const double height = 1 + std::log10(std::max(1e-9, histogram_.fractions[bin] / most)) / kDecades;
    if (height <= 0) continue;
    const double value = histogram_.CalcMiddle(bin), half = 0.5 * range / kBins;
    list.AddRectFilled({x(value - half), at.y + top + high * static_cast<float>(1 - height)},
                       {x(value + half), at.y + top + high}, value >= value_ ? ToImU32(kBone) : faint);
  }
  list.AddLine({at.x, at.y + top + high}, {at.x + width, at.y + top + high}, faint);
  const GreyScale& scale = values_->scale();
  float row = at.y;
  const auto mark = [&](double value, const std::string& text, ImU32 colour) {
    list.AddLine({x(value), row + line}, {x(value), at.y + top + high}, colour, 1.5F * s);
    const float wide = ImGui::CalcTextSize(text.c_str()).x;
    const float left = std::clamp(x(value) - 0.5F * wide, at.x, std::max(at.x, at.x + width - wide));
    list.AddRectFilled({left, row}, {left + wide, row + line}, ImGui::GetColorU32(ImGuiCol_WindowBg));
    list.AddText({left, row}, colour, text.c_str());
    row += line;
  };
  const ImU32 plain = ImGui::GetColorU32(ImGuiCol_Text);
  mark(scale.air, fmt::format("{} {:.0f}", Tr("air"), scale.air), plain);
  mark(scale.soft, fmt::format("{} {:.0f}", Tr("soft tissue"), scale.soft), plain);
  mark(value_, fmt::format(fmt::runtime(Tr("bone from {}")), fmt::format("{:.0f}", value_)), plain);
  const auto below = [&](const std::string& text, float align) {
    const float wide = ImGui::CalcTextSize(text.c_str()).x;
    list.AddText({at.x + align * (width - wide), at.y + top + high + 2 * s}, faint, text.c_str());
  };
  below(fmt::format("{:.0f}", histogram_.lower), 0);
  below(Tr("grey value of the file"), 0.5F);
  below(fmt::format("{:.0f}", histogram_.upper), 1);
  ImGui::Dummy({width, top + high + line + 2 * s});
  Tooltip(ui, Tr("How many voxels have each value, on a logarithmic scale."));
}

ScanCheck::Answer ScanCheck::Draw(Ui& ui, const UiBox& scene, const UiBox& column, CtPreview& slices) {
  slices.Draw(ui, column, shown_);
  if (!BeginPanel(ui, "scan", scene, true)) return Answer::kNone;
  const float s = ui.scale();
  Answer answer = Answer::kNone;
  ImGui::BeginGroup();
  const float buttons = ImGui::GetFrameHeightWithSpacing() + ImGui::GetTextLineHeightWithSpacing();
  ImGui::BeginChild("questions", {std::min(330 * s, 0.42F * ImGui::GetContentRegionAvail().x), -buttons});
  if (placing_) DrawPlacing(ui, slices);
  if (values_) DrawThreshold(ui, slices);
  ImGui::PushTextWrapPos(0);
  if (values_) {
    std::string why = TrMade(values_->why());
    why[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(why[0])));
    ImGui::TextDisabled("%s.", why.c_str());
  }
  for (const std::string& warning : ct_->warnings) {
    if (placing_ && (warning.ends_with("with --frame") || warning.ends_with("with --spacing-z")))
      continue;  // asked above
    LevelMark(ui, HudLevel::kWarn);
    ImGui::SameLine();
    ImGui::TextUnformatted(TrMade(warning).c_str());
  }
  ImGui::PopTextWrapPos();
  ImGui::EndChild();
  ImGui::BeginDisabled(!is_answered());
  if (ImGui::Button(Tr("Import"))) answer = Answer::kImport;
  ImGui::EndDisabled();
  ui.Note("scan.import");
  ImGui::SameLine();
  if (ImGui::Button(Tr("Cancel"))) answer = Answer::kCancel;
  ui.Note("scan.cancel");
  ImGui::TextDisabled("%s", takes_enter()   ? Tr("Enter: import   Esc: cancel")
                            : is_answered() ? Tr("Esc: cancel")
                                            : Tr("First give the distance between the slices."));
  ImGui::EndGroup();
  ImGui::SameLine();
  ImGui::BeginGroup();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  slices.DrawLarge(ui, room.x, room.y, shown_, {});
  ImGui::EndGroup();
  EndPanel();
  return answer;
}

void ScanCheck::Describe(nlohmann::json& state) const {
  state["scan"] = {{"asks", asks_}, {"frame", frame()}};
  if (placing_) state["scan"]["spacing_mm"] = spacing_z_mm();
  if (values_) state["scan"]["threshold"] = value_;
}

}  // namespace kerf
