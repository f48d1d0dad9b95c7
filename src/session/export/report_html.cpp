#include <fmt/format.h>

#include <algorithm>

#include "base/files/html_text.h"
#include "bone/pieces/measure.h"
#include "session/export/contacts.h"
#include "session/export/curve_svg.h"
#include "session/export/html.h"

namespace kerf::export_detail {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1a1a1a; background: #fff; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .25rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; border-bottom: 1px solid #999; }
p { margin: .4rem 0; }
.sum { font-size: 1.05rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: .5rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #ddd; text-align: right; vertical-align: top; }
th[scope=row], thead th:first-child, .text td, .text th { text-align: left; }
th[scope=row] { font-weight: 600; }
thead th { border-bottom: 2px solid #555; font-weight: 600; }
.text td { overflow-wrap: anywhere; }
figure { margin: 1rem 0; }
figure img { max-width: 100%; border: 1px solid #bbb; }
figcaption { font-size: .9rem; color: #444; }
svg { width: 100%; height: auto; }
svg text { font: 13px system-ui, "DejaVu Sans", sans-serif; fill: #1a1a1a; }
svg .grid { stroke: #ddd; } svg .axis { stroke: #333; }
svg .curve { fill: none; stroke: #0072b2; stroke-width: 1.5; }
.note { font-size: .9rem; color: #444; }
@media print { body { margin: 0; max-width: none; } h2 { break-after: avoid; } figure, table { break-inside: avoid; } }
)";

std::string Signed(double value, int decimals) {
  const std::string text = Show(value, decimals);
  return text.empty() || text[0] == '-' || std::stod(text) == 0 ? text : "+" + text;
}

std::string Summarise(const ExportInput& input) {
  std::string out;
  if (input.assessment != nullptr) {
    const Assessment& a = *input.assessment;
    if (!a.planes.empty()) {
      const auto cut = std::count_if(a.planes.begin(), a.planes.end(), [](const PlaneResult& p) { return p.cut; });
      const auto good =
          std::count_if(a.planes.begin(), a.planes.end(), [](const PlaneResult& p) { return p.within_margin; });
      out += fmt::format("{} of {} planned plane{} cut, {} within the margin. ", cut, a.planes.size(),
                         a.planes.size() == 1 ? "" : "s", good);
    }
    out += fmt::format("{} mm\u00b3 of bone removed. ", Show(a.removed_mm3, 1));
  }
  if (input.structures != nullptr) {
    const auto& all = input.structures->structures;
    const auto cut = std::count_if(all.begin(), all.end(), [](const StructureResult& s) { return s.is_cut; });
    if (!all.empty()) {
      out += cut == 0 ? std::string("No marked structure was cut. ")
                      : fmt::format("{} structure{} cut. ", cut, cut == 1 ? " was" : "s were");
    }
  }
  if (input.pieces != nullptr) {
    int count = 0;
    for (int i = 0; i < input.pieces->size(); ++i) count += input.pieces->state(i).deleted ? 0 : 1;
    out += fmt::format("{} piece{}.", count, count == 1 ? "" : "s");
  }
  return out;
}

std::string FormatPlanes(const Assessment& a) {
  std::vector<std::vector<std::string>> rows;
  for (const PlaneResult& p : a.planes) {
    if (!p.cut) {
      rows.push_back(
          {p.planned.name, Show(p.planned.margin_mm, 2), "no kerf found near it", "-", "-", "-", "-", "-", "-"});
      continue;
    }
    rows.push_back({p.planned.name, Show(p.planned.margin_mm, 2), Signed(p.offset_mm, 2), Signed(p.furthest_mm, 2),
                    Show(p.angles.angle_deg, 2), Signed(p.angles.pitch_deg, 2), Signed(p.angles.roll_deg, 2),
                    Show(p.cut->width_mm, 2), p.within_margin ? "yes" : "no"});
  }
  std::string out = "<h2>Planes: planned against achieved</h2>\n<div class=\"scroll\">\n";
  out += Table({"plane", "margin, mm", "offset, mm", "furthest, mm", "angle, \u00b0", "pitch, \u00b0", "roll, \u00b0",
                "kerf, mm", "within margin"},
               rows);
  out +=
      "</div>\n<p class=\"note\">Offset: distance of the kerf's middle from the planned plane, positive on the side of "
      "its normal. Furthest: largest distance of the kerf's corners. Roll: lean with depth; pitch: rotation about the "
      "direction of depth.</p>\n";
  return out;
}

std::string FormatStops(const Assessment& a) {
  std::vector<std::vector<std::string>> rows;
  for (const StopResult& s : a.stops) {
    rows.push_back({s.planned.name, Show(s.planned.depth_mm, 2), s.depth_mm ? Show(*s.depth_mm, 2) : "not reached",
                    s.depth_mm ? Signed(s.over_mm, 2) : "-"});
  }
  return "<h2>Depth stops</h2>\n" + Table({"stop", "planned, mm", "reached, mm", "difference, mm"}, rows);
}

std::string FormatStructures(const StructureAssessment& a) {
  std::vector<std::vector<std::string>> rows;
  const auto add_unknown = [&rows](const char* name) {
    rows.push_back({name, "not marked", "unknown", "unknown", "unknown"});
  };
  if (!a.canal_known) add_unknown("nerve and its canal");
  if (!a.teeth_known) add_unknown("teeth and roots");
  for (const StructureResult& s : a.structures) {
    std::string name = MakeStructureName(s);
    if (s.is_mark) name += fmt::format(" (marked {})", ToString(s.kind));
    std::string place = "no bone was removed";
    if (s.distance_mm) {
      place = s.part == ToothPart::kRoot    ? "root: " + DescribePlace(s.p_W)
              : s.part == ToothPart::kCrown ? "crown: " + DescribePlace(s.p_W)
                                            : DescribePlace(s.p_W);
    }
    rows.push_back({name, s.is_cut ? "CUT" : "spared", s.distance_mm ? Show(*s.distance_mm, 1) : "no cut",
                    Show(s.removed_mm3, 1), place});
  }
  return "<h2>Nerves, teeth and roots</h2>\n<div class=\"scroll\">\n" +
         Table({"structure", "result", "least distance, mm", "removed, mm\u00b3", "place nearest to the cut"}, rows,
               true) +
         "</div>\n<p class=\"note\">Distance: between the removed bone and the structure, accurate to about a voxel. "
         "Place: "
         "in the patient's frame, mm from its origin. Structures that are neither regions of the bone nor marked by "
         "the "
         "user are not known to this report.</p>\n";
}

std::string FormatBone(const Assessment& a) {
  std::vector<std::vector<std::string>> rows{
      {"before", Show(a.before_mm3, 1)}, {"after", Show(a.after_mm3, 1)}, {"removed", Show(a.removed_mm3, 2)}};
  if (a.outside_mm3) rows.push_back({"removed outside the margins", Show(*a.outside_mm3, 2)});
  if (a.too_deep_mm3) rows.push_back({"removed deeper than the stops", Show(*a.too_deep_mm3, 2)});
  return "<h2>Bone</h2>\n" + Table({"", "volume, mm\u00b3"}, rows);
}

std::string FormatPieces(const PieceSet& set, const Prepared& prepared) {
  std::vector<std::vector<std::string>> rows;
  for (const int i : prepared.pieces) {
    const Piece& piece = set.piece(i);
    const Vec3 displacement = set.CalcCentroid(i) - piece.centroid_P;
    rows.push_back({piece.name, Show(piece.volume_mm3, 1), Show(glm::length(displacement), 2),
                    Signed(displacement.x, 2), Signed(displacement.y, 2), Signed(displacement.z, 2),
                    Show(CalcRotationAngle(set.state(i).X_WP), 2), set.state(i).hidden ? "hidden" : "shown"});
  }
  std::string out = "<h2>Pieces</h2>\n<div class=\"scroll\">\n";
  out +=
      Table({"piece", "volume, mm\u00b3", "moved, mm", "left, mm", "back, mm", "up, mm", "turned, \u00b0", ""}, rows);
  out +=
      "</div>\n<p class=\"note\">Moved: displacement of the piece's centre since it was cut off, towards the patient's "
      "left, back and head.</p>\n";
  if (prepared.pairs.empty()) return out;
  rows.clear();
  for (const PairRow& pair : prepared.pairs) {
    const auto show = [&](double Facing::*part, int decimals) {
      return pair.facing ? Show((*pair.facing).*part, decimals) : std::string("-");
    };
    rows.push_back({pair.a, pair.b, Show(pair.overlap_mm3, 2), pair.gap_mm ? Show(*pair.gap_mm, 2) : "far",
                    show(&Facing::area_mm2, 1), show(&Facing::mean_mm, 2), show(&Facing::p95_mm, 2),
                    show(&Facing::contact_mm2, 1)});
  }
  out += "<div class=\"scroll\">\n";
  out += Table({"piece", "and", "overlap, mm\u00b3", "smallest gap, mm", "facing, mm\u00b2", "mean gap, mm",
                "95 % within, mm", "contact, mm\u00b2"},
               rows);
  out +=
      "</div>\n<p class=\"note\">Facing: surface of the first piece with the second within 3 mm in front of it; "
      "contact: closer than 0.2 mm.</p>\n";
  return out;
}

std::string FormatSessionTable(const std::vector<ExportSession>& sessions) {
  std::vector<std::vector<std::string>> rows;
  const auto show = [](const std::optional<double>& value, int decimals) {
    return value ? Show(*value, decimals) : std::string("-");
  };
  for (const ExportSession& session : sessions) {
    rows.push_back({fmt::format("{}", rows.size() + 1), session.saw, show(session.duration_s, 0),
                    show(session.largest_force_N, 2), show(session.removed_mm3, 1)});
  }
  return "<h2>Sessions</h2>\n" +
         Table({"session", "saw", "duration, s", "largest force, N", "removed, mm\u00b3"}, rows) +
         "<p class=\"note\">A new session begins with each change of the saw or the guide, and when a project is "
         "opened. "
         "Removed: by the saw in this session, also if it was undone later.</p>\n";
}

}  // namespace

std::string FormatReportHtml(const ExportInput& input, const Prepared& prepared) {
  const std::string title = input.title.empty() ? "Report of a session" : input.title;
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += fmt::format("<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n", EscapeHtml(title), kStyle);
  out += fmt::format("<h1>{}</h1>\n<p class=\"sum\">{}</p>\n", EscapeHtml(title), EscapeHtml(Summarise(input)));
  for (const std::string& warning : input.recording.warnings) {
    out += fmt::format("<p><b>Warning about the recording: {}</b></p>\n", EscapeHtml(warning));
  }
  if (!input.circumstances.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const ExportFact& fact : input.circumstances) rows.push_back({fact.name, fact.value});
    out += Table({"what", "value"}, rows, true);
  }
  if (input.structures != nullptr) out += FormatStructures(*input.structures);
  if (input.assessment != nullptr) {
    if (!input.assessment->planes.empty()) out += FormatPlanes(*input.assessment);
    if (!input.assessment->stops.empty()) out += FormatStops(*input.assessment);
    out += FormatBone(*input.assessment);
  }
  if (input.pieces != nullptr && input.pieces->size() > 0) out += FormatPieces(*input.pieces, prepared);
  if (!input.measures.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const ExportMeasure& m : input.measures)
      rows.push_back({m.name, Show(m.value, 2), m.unit == "deg" ? "\u00b0" : m.unit});
    out += "<h2>Measured</h2>\n" + Table({"what", "value", "unit"}, rows);
  }
  if (input.sessions.size() > 1) out += FormatSessionTable(input.sessions);
  if (!input.figures.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const ExportFigure& f : input.figures) rows.push_back({f.name, fmt::format("{:.4g}", f.value), f.unit});
    out += "<h2>Session</h2>\n" + Table({"what", "value", "unit"}, rows);
  }
  for (const ExportCurve& curve : input.curves) {
    out += fmt::format("<h2>{}</h2>\n<figure>\n{}</figure>\n", EscapeHtml(curve.title), FormatCurveSvg(curve));
  }
  if (!input.pictures.empty()) out += "<h2>Pictures</h2>\n";
  for (const ExportPicture& picture : input.pictures) {
    out += fmt::format(
        "<figure>\n<img alt=\"{0}\" src=\"data:image/png;base64,{1}\">\n<figcaption>{0}</figcaption>\n</figure>\n",
        EscapeHtml(picture.caption), Base64(picture.png));
  }
  if (!input.provenance.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const ExportFact& fact : input.provenance) rows.push_back({fact.name, fact.value});
    out += "<h2>Origin of this report</h2>\n" + Table({"what", "value"}, rows, true);
  }
  return out + "</main>\n</body>\n</html>\n";
}

}  // namespace kerf::export_detail
