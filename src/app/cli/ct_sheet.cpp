#include "app/cli/ct_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <tuple>
#include <utility>

#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "base/core/number_text.h"
#include "bone/import/ct_view.h"
#include "bone/import/hu_check.h"
#include "bone/import/mask_overlay.h"
#include "bone/import/padding.h"
#include "bone/import/patient_frame.h"
#include "kerf/error.h"
#include "view/picture/mm_grid.h"
#include "view/picture/panel_sheet.h"
#include "view/plot/plot.h"

namespace kerf::cli {
namespace {

constexpr std::size_t kMaxSlices = 24;
constexpr int kSpreadSlices = 10;
constexpr Rgb8 kKeepColour{0, 158, 115};
constexpr Rgb8 kDropColour{213, 94, 0};

struct Slice {
  CtAxis axis;
  double at_mm;
};

// Point to mark.
struct SheetPoint {
  Vec3 p_W;
  Rgb8 colour;
  std::string name;
};

Slice ParseSlice(const std::string& text) {
  const std::size_t axis = std::string("xyz").find(text.empty() ? '?' : text[0]);
  const std::optional<double> mm =
      text.size() > 2 && text[1] == '=' ? ParseNumber(text.substr(2)) : std::optional<double>();
  if (axis == std::string::npos || !mm) {
    throw CLI::ValidationError("--slice", fmt::format("'{}' must be x=MM, y=MM or z=MM", text));
  }
  return {static_cast<CtAxis>(axis), *mm};
}

std::vector<Slice> ChooseSlices(const CtSheetOptions& options, const std::vector<SheetPoint>& points,
                                const Box3& box_W) {
  std::vector<Slice> slices;
  for (const std::string& text : options.slices) slices.push_back(ParseSlice(text));
  for (const Slice& slice : slices) {
    const int a = static_cast<int>(slice.axis);
    if (slice.at_mm >= box_W.lower[a] && slice.at_mm <= box_W.upper[a]) continue;
    throw CLI::ValidationError(
        "--slice", fmt::format("{}={:g} is outside the bone, which extends from {} to {}", "xyz"[a], slice.at_mm,
                               FormatLength(box_W.lower[a]), FormatLength(box_W.upper[a])));
  }
  if (slices.empty()) {
    std::vector<double> levels;
    for (const SheetPoint& point : points) levels.push_back(point.p_W.z);
    std::sort(levels.begin(), levels.end());
    levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
    for (int i = 0; levels.empty() && i < kSpreadSlices; ++i) {
      const double z = box_W.lower.z + (i + 0.5) / kSpreadSlices * box_W.size().z;
      slices.push_back({CtAxis::kZ, std::round(z)});
    }
    for (const double z : levels) slices.push_back({CtAxis::kZ, z});
  }
  if (slices.size() > kMaxSlices) {
    throw CLI::ValidationError(
        "--slice", fmt::format("{} slices were given, but at most {} fit in a picture", slices.size(), kMaxSlices));
  }
  return slices;
}

// Returns the view as a panel with labelled axes.
Panel MakePanel(std::string title, CtAxis axis, CtView view) {
  const bool axial = axis == CtAxis::kZ;
  const int across = axis == CtAxis::kX ? 1 : 0;
  Panel panel;
  panel.title = std::move(title);
  panel.image = {view.columns, view.rows, std::move(view.pixels)};
  panel.left_mm = view.left_mm, panel.right_mm = view.right_mm;
  panel.top_mm = view.top_mm, panel.bottom_mm = view.bottom_mm;
  panel.across_name = NamePatientAxis(across);
  panel.down_name = NamePatientAxis(axial ? 1 : 2);
  panel.left_letter = across == 0 ? "R" : "A";
  panel.right_letter = across == 0 ? "L" : "P";
  return panel;
}

// Returns the position of a point in a panel that looks along the axis.
PanelMark MakeMark(const SheetPoint& point, CtAxis axis) {
  const Vec3& p = point.p_W;
  switch (axis) {
    case CtAxis::kX:
      return {p.y, p.z, point.colour, point.name};
    case CtAxis::kY:
      return {p.x, p.z, point.colour, point.name};
    case CtAxis::kZ:
      break;
  }
  return {p.x, p.y, point.colour, point.name};
}

std::vector<SheetPoint> ReadPoints(const CtSheetOptions& options) {
  std::vector<SheetPoint> points;
  for (const auto& [texts, option, colour] :
       {std::tuple(&options.keep, "--keep", kKeepColour), std::tuple(&options.drop, "--drop", kDropColour)}) {
    for (std::size_t i = 0; i < texts->size(); ++i) {
      points.push_back({ParsePoint((*texts)[i], option), colour, fmt::format("{} {}", option + 2, i + 1)});
    }
  }
  return points;
}

constexpr Rgb8 kAddedColour{204, 80, 200};
constexpr Rgb8 kCutOffColour{230, 40, 30};
constexpr Rgb8 kGivenAwayColour{250, 150, 30};
constexpr Rgb8 kOutline{120, 200, 255};

// Tints what a mask selects, adds and cuts off, and draws its outline in the slices along an axis.
std::function<std::optional<Rgb8>(const Vec3&)> MakeTint(const MaskOverlay& overlay, CtAxis axis, double pixel_mm) {
  return [&overlay, axis, pixel_mm](const Vec3& p_W) -> std::optional<Rgb8> {
    const bool is_in_mask = overlay.IsInMask(p_W);
    for (int a = 0; a < 3; ++a) {
      if (a == static_cast<int>(axis)) continue;
      Vec3 beside_W = p_W;
      beside_W[a] += pixel_mm;
      if (overlay.IsInMask(beside_W) != is_in_mask) return kOutline;
    }
    switch (overlay.At(p_W)) {
      case MaskOverlay::What::kKept:
        return kKeepColour;
      case MaskOverlay::What::kAdded:
        return kAddedColour;
      case MaskOverlay::What::kCutOff:
        return kCutOffColour;
      case MaskOverlay::What::kGivenAway:
        return kGivenAwayColour;
      case MaskOverlay::What::kNothing:
        break;
    }
    return std::nullopt;
  };
}

// Converts values that are not HU, and finds the bone's surface in them. A threshold that does not fit is drawn as
// given.
BoneLevel TakeIso(const CtSheetOptions& options, Volume& ct, ImportOptions& import) {
  const double iso = import.isolate.iso_hu;
  BoneLevel level;
  if (!import.iso_auto) level.iso = level.iso_hu = iso;
  try {
    level = TakeAsHu(ct, iso, import.iso_auto, options.input);
  } catch (const Error& e) {
    if (import.iso_auto) throw;
    Say("{}", e.what());
  }
  import.isolate.iso_hu = level.iso_hu;
  return level;
}

// Draws how often the values of a CT occur that are no HU, with the peaks of air and soft tissue and the threshold.
Image DrawHistogram(const ValueHistogram& histogram, const GreyScale& scale, double iso, int width, int height) {
  constexpr double kLeast = 0.001;  // percent; a logarithmic axis has no 0
  PlotSpec plot;
  plot.width = width;
  plot.height = height;
  plot.text_scale = 1.7;
  plot.title = "Grey values of the file, which are not HU";
  plot.x.label = "grey value of the file";
  const double range = histogram.upper - histogram.lower;
  plot.x.lower = histogram.lower - 0.05 * range;  // keeps the first peak off the axis
  plot.x.upper = histogram.upper;
  plot.y.label = "voxels (%)";
  plot.y.log = true;
  plot.y.lower = kLeast;
  plot.y.upper = 100;
  PlotSeries series;
  for (std::size_t bin = 0; bin < histogram.fractions.size(); ++bin) {
    series.x.push_back(histogram.CalcMiddle(bin));
    series.y.push_back(std::max(100 * histogram.fractions[bin], kLeast));
  }
  plot.series.push_back(std::move(series));
  plot.bands.push_back({.x0 = iso, .x1 = histogram.upper, .label = fmt::format("bone, {:.0f} and more", iso)});
  for (const auto& [at, name] : {std::pair(scale.air, "air"), std::pair(scale.soft, "soft tissue")}) {
    plot.lines.push_back({.vertical = true, .at = at, .label = ""});
    plot.notes.push_back({.x = at + 0.01 * range, .y = 30, .text = fmt::format("{} {:.0f}", name, at), .colour = {}});
  }
  return RenderPlot(plot);
}

}  // namespace

void DrawCtSheet(const CtSheetOptions& options) {
  const std::vector<SheetPoint> points = ReadPoints(options);
  for (const std::string& text : options.slices) ParseSlice(text);  // report errors before the CT is read
  if (std::min(options.width, options.height) < kSheetSideRange.lower) {
    throw CLI::ValidationError("--size", fmt::format("a CT is drawn in several pictures; give each side {}",
                                                     ShowRange(kSheetSideRange, "pixels")));
  }
  ImportReport report;
  Volume ct = StoreAlongPatient(ReadCt(options.input, options.import, report));
  ClearPadding(ct);
  ImportOptions import = options.import;
  constexpr int kPlotHeight = 320;
  constexpr std::size_t kBins = 200;
  std::optional<GreyScale> scale = FindGreyScale(ct);
  if (options.height < 3 * kPlotHeight) scale.reset();
  const ValueHistogram histogram = CalcHistogram(ct, kBins, {import.isolate.iso_hu, import.isolate.iso_hu + 1});
  const BoneLevel level = TakeIso(options, ct, import);
  if (!level.warning.empty()) ct.warnings.push_back(level.warning);
  for (const std::string& warning : ct.warnings) Say("{}", warning);
  const std::optional<MaskOverlay> overlay =
      import.isolate.mask ? std::optional<MaskOverlay>(std::in_place, ct, import) : std::nullopt;
  CtViewOptions draw;
  draw.iso_hu = level.iso_hu;
  draw.box_W = FindBoneBox(ct, draw.iso_hu, options.input);
  const std::vector<Slice> slices = ChooseSlices(options, points, draw.box_W);

  SheetSpec sheet;
  sheet.width = options.width;
  sheet.height = options.height - (scale ? kPlotHeight : 0);
  sheet.title =
      options.title.empty() ? std::filesystem::path(options.input).lexically_normal().string() : options.title;
  sheet.caption = fmt::format(
      "Patient coordinates (LPS) in mm: a point is x,y,z. Tinted: bone, {:.0f}{} and more. CT of {} x {} x {} "
      "voxels of {:.3g} x {:.3g} x {:.3g} mm.",
      level.iso, level.is_grey ? " (values are not HU)" : " HU", ct.size[0], ct.size[1], ct.size[2], ct.spacing_mm.x,
      ct.spacing_mm.y, ct.spacing_mm.z);
  if (overlay) {
    sheet.caption = fmt::format(
        "Blue line: mask. Green: kept bone. Tan: other bone. Farther than {:.3g} mm from the line the mask overrides "
        "the CT: magenta, {} added; red, {} cut off (within 10 mm more). Orange: {} in the mask that are not kept.",
        overlay->reach_mm(), FormatVolume(overlay->added_mm3()), FormatVolume(overlay->cut_off_mm3()),
        FormatVolume(overlay->given_away_mm3()));
  }
  // First draw two views of the surface, which show the height of each structure. The slices are drawn in orange.
  const bool whole = options.slices.empty();
  for (const auto& [axis, title] :
       {std::pair(CtAxis::kY, "surface from the front"), std::pair(CtAxis::kX, "surface from the patient's left")}) {
    if (!whole) continue;
    Panel panel = MakePanel(title, axis, DrawCtSurface(ct, axis, draw));
    for (const Slice& slice : slices) panel.levels_mm.push_back(slice.at_mm);
    for (const SheetPoint& point : points) panel.marks.push_back(MakeMark(point, axis));
    sheet.panels.push_back(std::move(panel));
  }
  for (const Slice& slice : slices) {
    constexpr std::array kFrom{"from the left", "from the front", "from the feet"};
    const auto a = static_cast<std::size_t>(slice.axis);
    if (overlay) draw.tint = MakeTint(*overlay, slice.axis, draw.pixel_mm);
    Panel panel = MakePanel(fmt::format("{} = {:g} mm, {}", "xyz"[a], slice.at_mm, kFrom[a]), slice.axis,
                            DrawCtSlice(ct, slice.axis, slice.at_mm, draw));
    // A point within 2 mm counts as being in the slice; that is half of the distance from the point to the bone that
    // the import allows.
    for (const SheetPoint& point : points) {
      if (std::abs(point.p_W[static_cast<int>(a)] - slice.at_mm) <= 2) {
        panel.marks.push_back(MakeMark(point, slice.axis));
      }
    }
    sheet.panels.push_back(std::move(panel));
  }
  Image picture = RenderSheet(sheet);
  if (scale) AppendImage(DrawHistogram(histogram, *scale, level.iso, sheet.width, kPlotHeight), picture);
  WritePng(picture, options.output);
  fmt::print("{}\n", options.output);
}

}  // namespace kerf::cli
