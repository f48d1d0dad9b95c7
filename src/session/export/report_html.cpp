#include <fmt/format.h>

#include <algorithm>

#include "base/files/html_text.h"
#include "bone/pieces/measure.h"
#include "session/export/contacts.h"
#include "session/export/curve_svg.h"
#include "session/export/html.h"
#include "session/plan/edit_plane.h"

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
.technical { font-size: .8rem; color: #555; margin-left: .6em; }
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

std::string Signed(const ReportLanguage& t, double value, int decimals) {
  const std::string text = t.Show(value, decimals);
  const bool zero = text.find_first_of("123456789") == std::string::npos;
  return text.empty() || text[0] == '-' || zero ? text : "+" + text;
}

template <typename... Values>
std::string Fill(const std::string& text, const Values&... values) {
  return fmt::format(fmt::runtime(text), values...);
}

std::string Note(const std::string& text) {
  return "<p class=\"note\">" + EscapeHtml(text) + "</p>\n";
}

/// Says from where places are measured.
std::string DescribeOrigin(const ReportLanguage& t) {
  return t.Tr(ExplainPlaces());
}

std::string Heading(const std::string& text) {
  return "<h2>" + EscapeHtml(text) + "</h2>\n";
}

std::string Scrolling(const std::string& table) {
  return "<div class=\"scroll\">\n" + table + "</div>\n";
}

std::string Summarise(const ExportInput& input) {
  const ReportLanguage& t = input.language;
  std::string out;
  const auto add = [&out](const std::string& sentence) { out += (out.empty() ? "" : " ") + sentence; };
  if (input.assessment != nullptr) {
    const Assessment& a = *input.assessment;
    if (!a.planes.empty()) {
      const auto cut = std::count_if(a.planes.begin(), a.planes.end(), [](const PlaneResult& p) { return p.cut; });
      const auto good =
          std::count_if(a.planes.begin(), a.planes.end(), [](const PlaneResult& p) { return p.within_margin; });
      add(Fill(a.planes.size() == 1 ? t.Tr("{0} of {1} planned plane cut, {2} within the margin.")
                                    : t.Tr("{0} of {1} planned planes cut, {2} within the margin."),
               cut, a.planes.size(), good));
      for (std::size_t i = 0; i < input.cut_states.size(); ++i) {
        const CutState& state = input.cut_states[i];
        if (!a.planes[i].cut || state.bridges.empty()) continue;
        add(Fill(t.Tr("{0} is cut by {1} % of its area and still holds by {2} mm²."),
                 t.ShowName(a.planes[i].planned.name), t.Show(100 * state.fraction(), 0), t.Show(state.left_mm2, 1)));
      }
    }
    add(Fill(t.Tr("{} of bone removed."), t.ShowVolume(a.removed_mm3)));
  }
  if (input.structures != nullptr) {
    const auto& all = input.structures->structures;
    const auto cut = std::count_if(all.begin(), all.end(), [](const StructureResult& s) { return s.is_cut; });
    if (!all.empty()) {
      add(cut == 0   ? t.Tr("No marked structure was cut.")
          : cut == 1 ? t.Tr("1 structure was cut.")
                     : Fill(t.Tr("{} structures were cut."), cut));
    }
  }
  if (input.pieces != nullptr) {
    int count = 0;
    for (int i = 0; i < input.pieces->size(); ++i) count += input.pieces->state(i).deleted ? 0 : 1;
    add(count == 1 ? t.Tr("1 piece.") : Fill(t.Tr("{} pieces."), count));
  }
  return out;
}

/// Returns what was inside the bone although it has no room there in theatre, one paragraph each.
std::string FormatHolder(const ExportInput& input) {
  const ReportLanguage& t = input.language;
  std::string out;
  const auto add = [&](const std::optional<Vec3>& p_W, const std::string& sentence) {
    if (!p_W) return;
    out += fmt::format("<p><b>{}</b></p>\n", EscapeHtml(Fill(sentence, t.Show(DescribePlace(*p_W)))));
  };
  add(input.hub_in_bone_W, t.Tr("To check: during the cut, the hub of the blade was inside the bone (first at {}). In "
                                "theatre it stops the blade: cut the rest from another side."));
  add(input.handpiece_in_bone_W, t.Tr("To check: during the cut, the handpiece was inside the bone (first at {}). In "
                                      "theatre it has no room there."));
  return out;
}

std::string FormatPlanes(const ReportLanguage& t, const Assessment& a, const std::vector<CutState>& states) {
  TableRows rows;
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    const PlaneResult& p = a.planes[i];
    const std::string name = t.ShowName(p.planned.name);
    const std::string cut = i < states.size() ? t.Show(100 * states[i].fraction(), 0) : "-";
    const std::string left = i < states.size() ? t.Show(states[i].left_mm2, 1) : "-";
    if (!p.cut) {
      rows.push_back({name, cut, left, t.Show(p.planned.margin_mm, 2), t.Tr("no kerf found near it"), "-", "-", "-",
                      "-", "-", "-"});
      continue;
    }
    rows.push_back({name, cut, left, t.Show(p.planned.margin_mm, 2), Signed(t, p.offset_mm, 2),
                    Signed(t, p.furthest_mm, 2), t.Show(p.angles.angle_deg, 2), Signed(t, p.angles.pitch_deg, 2),
                    Signed(t, p.angles.roll_deg, 2), t.Show(p.cut->width_mm, 2),
                    p.within_margin ? t.Tr("yes") : t.Tr("no")});
  }
  return Heading(t.Tr("Planes: planned against achieved")) +
         Scrolling(
             Table({t.Tr("plane"), t.Tr("cut, %"), t.Tr("still holds, mm²"), t.Tr("margin, mm"), t.Tr("offset, mm"),
                    t.Tr("largest distance, mm"), t.Tr("angle, °"), t.Tr("turned on the surface, °"),
                    t.Tr("leaning with depth, °"), t.Tr("kerf, mm"), t.Tr("within margin")},
                   rows)) +
         Note(t.Tr("Cut: part of the plane's area in the bone. Offset: distance of the kerf's middle from the planned "
                   "plane, positive on the side of its normal. Largest distance: of the "
                   "kerf's corners. Turned on the surface: the line of the cut is turned there (pitch). Leaning with "
                   "depth: the deeper the cut, the further it departs from the plane (roll). Margin: the distance that "
                   "is still good; it can be changed with each plane."));
}

std::string FormatAngles(const ReportLanguage& t, const Assessment& a) {
  TableRows rows;
  for (const PlaneResult& p : a.planes) {
    const PatientAngles angles = CalcPatientAngles(p.planned);
    const Vec3& p_W = p.planned.plane.p_W;
    rows.push_back({t.ShowName(p.planned.name), t.Show(angles.sagittal_deg, 1), t.Show(angles.coronal_deg, 1),
                    t.Show(angles.axial_deg, 1), t.Show(DescribePlace(p_W))});
  }
  return Heading(t.Tr("Planned planes in the patient")) +
         Scrolling(Table({t.Tr("plane"), t.Tr("to sagittal, °"), t.Tr("to coronal, °"), t.Tr("to axial, °"),
                          t.Tr("middle of the plane")},
                         rows)) +
         Note(t.Tr("Angles between the planned plane and the patient's planes.") + " " + DescribeOrigin(t));
}

std::string FormatStops(const ReportLanguage& t, const Assessment& a) {
  TableRows rows;
  for (const StopResult& s : a.stops) {
    rows.push_back({t.ShowName(s.planned.name), t.Show(s.planned.depth_mm, 2),
                    s.depth_mm ? t.Show(*s.depth_mm, 2) : t.Tr("not reached"),
                    s.depth_mm ? Signed(t, s.over_mm, 2) : "-"});
  }
  return Heading(t.Tr("Depth stops")) +
         Table({t.Tr("stop"), t.Tr("planned, mm"), t.Tr("reached, mm"), t.Tr("difference, mm")}, rows);
}

/// The terms are those of the window.
std::string DescribeResult(const ReportLanguage& t, const StructureResult& s) {
  const bool nerve = IsNerve(s.kind);
  if (s.is_severed) return nerve ? t.Tr("severed") : t.Tr("cut through");
  if (s.is_cut) return nerve ? t.Tr("injured") : t.Tr("cut");
  return t.Tr("spared");
}

std::string FormatStructures(const ReportLanguage& t, const StructureAssessment& a) {
  TableRows rows;
  const auto add_unknown = [&](const std::string& name) {
    rows.push_back({name, t.Tr("not marked"), t.Tr("unknown"), t.Tr("unknown"), t.Tr("unknown")});
  };
  if (!a.canal_known) add_unknown(t.Tr("nerve and its canal"));
  if (!a.teeth_known) add_unknown(t.Tr("teeth and roots"));
  for (const StructureResult& s : a.structures) {
    std::string name = t.Show(NameStructure(s));
    if (s.is_mark) name = Fill(t.Tr("{0} (marked {1})"), name, t.ShowName(std::string(ToString(s.kind))));
    std::string place = t.Tr("no bone was removed");
    if (s.distance_mm) {
      place = t.Show(DescribePlace(s.p_W));
      if (s.part == ToothPart::kRoot) place = Fill(t.Tr("root: {}"), place);
      if (s.part == ToothPart::kCrown) place = Fill(t.Tr("crown: {}"), place);
    }
    rows.push_back({name, DescribeResult(t, s), s.distance_mm ? t.Show(*s.distance_mm, 1) : t.Tr("no cut"),
                    t.Show(s.removed_mm3, 1), place});
  }
  return Heading(t.Tr("Nerves, teeth and roots")) +
         Scrolling(Table({t.Tr("structure"), t.Tr("result"), t.Tr("least distance, mm"), t.Tr("removed, mm³"),
                          t.Tr("place nearest to the cut")},
                         rows, true)) +
         Note(t.Tr("Distance: between the removed bone and the structure, accurate to about a voxel. Severed, cut "
                   "through: what is left of the structure no longer connects its two ends. The least distance from a "
                   "lesion is the resection margin. Structures that are neither "
                   "regions of the bone nor marked by the user are not known to this report.") +
              " " + DescribeOrigin(t));
}

std::string FormatBone(const ReportLanguage& t, const Assessment& a) {
  TableRows rows{{t.Tr("before"), t.ShowVolume(a.before_mm3)},
                 {t.Tr("after"), t.ShowVolume(a.after_mm3)},
                 {t.Tr("removed"), t.ShowVolume(a.removed_mm3)}};
  if (a.outside_mm3) rows.push_back({t.Tr("removed outside the margins"), t.ShowVolume(*a.outside_mm3)});
  if (a.too_deep_mm3) rows.push_back({t.Tr("removed deeper than the stops"), t.ShowVolume(*a.too_deep_mm3)});
  return Heading(t.Tr("Bone")) + Table({"", t.Tr("volume")}, rows);
}

std::string FormatPieces(const ReportLanguage& t, const PieceSet& set, const std::vector<std::string>& colours,
                         const Prepared& prepared) {
  TableRows rows;
  for (const int i : prepared.pieces) {
    const auto number = static_cast<std::size_t>(i);
    const Piece& piece = set.piece(i);
    const Vec3 displacement = set.CalcCentroid(i) - piece.centroid_P;
    const double moved_mm = glm::length(displacement);
    rows.push_back(
        {t.ShowName(piece.name), number < colours.size() ? t.Tr(colours[number]) : "-", t.ShowVolume(piece.volume_mm3),
         t.Show(moved_mm, 2), moved_mm < 0.05 ? std::string("-") : t.Show(DescribePlace(displacement)),
         t.Show(CalcRotationAngle(set.state(i).X_WP), 2), set.state(i).hidden ? t.Tr("hidden") : t.Tr("shown")});
  }
  std::string out = Heading(t.Tr("Pieces")) +
                    Scrolling(Table({t.Tr("piece"), t.Tr("colour in the pictures"), t.Tr("volume"), t.Tr("moved, mm"),
                                     t.Tr("moved towards"), t.Tr("turned, °"), ""},
                                    rows)) +
                    Note(t.Tr("Moved: displacement of the piece's centre since it was cut off. Left, right, front and "
                              "back are the patient's."));
  if (prepared.pairs.empty()) return out;
  rows.clear();
  for (const PairRow& pair : prepared.pairs) {
    const auto show = [&](double Facing::*part, int decimals) {
      return pair.facing ? t.Show((*pair.facing).*part, decimals) : std::string("-");
    };
    rows.push_back({t.ShowName(pair.a), t.ShowName(pair.b), t.ShowVolume(pair.overlap_mm3),
                    pair.gap_mm ? t.Show(*pair.gap_mm, 2) : t.Tr("far"), show(&Facing::area_mm2, 1),
                    show(&Facing::mean_mm, 2), show(&Facing::p95_mm, 2), show(&Facing::contact_mm2, 1)});
  }
  return out +
         Scrolling(
             Table({t.Tr("piece"), t.Tr("and"), t.Tr("overlap"), t.Tr("smallest gap, mm"), t.Tr("near the other, mm²"),
                    t.Tr("mean gap, mm"), t.Tr("95 % within, mm"), t.Tr("contact, mm²")},
                   rows)) +
         Note(t.Tr("Near the other: surface of the first piece that has the second one within 3 mm in front of it, and "
                   "its gaps; contact: closer than 0.2 mm."));
}

std::string FormatSessionTable(const ReportLanguage& t, const std::vector<ExportSession>& sessions) {
  TableRows rows;
  const auto show = [&t](const std::optional<double>& value, int decimals) {
    return value ? t.Show(*value, decimals) : std::string("-");
  };
  for (const ExportSession& session : sessions) {
    rows.push_back({fmt::format("{}", rows.size() + 1), t.ShowSaw(session.saw), show(session.in_bone_s, 0),
                    show(session.duration_s, 0), show(session.turning_force_N, 2), show(session.stopped_force_N, 2)});
  }
  return Heading(t.Tr("Sessions")) +
         Scrolling(Table({t.Tr("session"), t.Tr("saw"), t.Tr("in bone, s"), t.Tr("in all, s"),
                          t.Tr("largest force in bone, spindle turning, N"), t.Tr("spindle stopped, N")},
                         rows)) +
         Note(t.Tr("A new session begins with each change of the saw or the guide, and when a project is opened. In "
                   "bone: while the saw touches bone; the force then includes the pull of a guide."));
}

/// Returns the values that the circumstances do not have.
std::string FormatFigures(const ExportInput& input) {
  const ReportLanguage& t = input.language;
  TableRows rows;
  for (const ExportFigure& f : input.figures) {
    const auto has_name = [&f](const ExportFact& fact) { return fact.name == f.name; };
    if (std::any_of(input.circumstances.begin(), input.circumstances.end(), has_name)) continue;
    std::string value = fmt::format("{:.4g}", f.value);
    if (const std::size_t dot = value.find('.'); dot != std::string::npos) value.replace(dot, 1, t.point);
    rows.push_back({t.Tr(f.name), value, f.unit});
  }
  if (rows.empty()) return "";
  return Heading(t.Tr("Session")) + Table({t.Tr("what"), t.Tr("value"), t.Tr("unit")}, rows);
}

std::string FormatMeasures(const ReportLanguage& t, const std::vector<ExportMeasure>& measures) {
  TableRows rows;
  for (const ExportMeasure& m : measures) {
    std::string pieces;
    for (const std::string& piece : m.pieces) {
      pieces += (pieces.empty() ? "" : " \u2013 ") + t.ShowName(piece);
    }
    rows.push_back(
        {t.ShowName(m.name), pieces.empty() ? "-" : pieces, t.Show(m.value, 2), m.unit == "deg" ? "\u00b0" : m.unit});
  }
  return Heading(t.Tr("Measured")) +
         Table({t.Tr("what"), t.Tr("between points on"), t.Tr("value"), t.Tr("unit")}, rows);
}

/// Returns a table of names, which are translated, and values.
std::string FormatFacts(const ReportLanguage& t, const std::vector<ExportFact>& facts) {
  TableRows rows;
  for (const ExportFact& fact : facts) rows.push_back({{t.Tr(fact.name)}, {fact.value, fact.technical}});
  return Table({t.Tr("what"), t.Tr("value")}, rows, true);
}

}  // namespace

std::string FormatReportHtml(const ExportInput& input, const Prepared& prepared) {
  const ReportLanguage& t = input.language;
  const std::string title = input.title.empty() ? t.Tr("Report of a session") : input.title;
  std::string out =
      fmt::format("<!DOCTYPE html>\n<html lang=\"{}\">\n<head>\n<meta charset=\"utf-8\">\n", EscapeHtml(t.code));
  out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out += fmt::format("<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n", EscapeHtml(title), kStyle);
  out += fmt::format("<h1>{}</h1>\n<p class=\"sum\">{}</p>\n", EscapeHtml(title), EscapeHtml(Summarise(input)));
  out += FormatHolder(input);
  out += Note(t.Tr("For research and teaching; not a medical device."));
  for (const std::string& warning : input.recording.warnings) {
    out += fmt::format("<p><b>{}</b></p>\n", EscapeHtml(Fill(t.Tr("Warning about the recording: {}"), warning)));
  }
  if (!input.circumstances.empty()) out += FormatFacts(t, input.circumstances);
  if (input.structures != nullptr) out += FormatStructures(t, *input.structures);
  if (input.assessment != nullptr) {
    if (!input.assessment->planes.empty()) {
      out += FormatPlanes(t, *input.assessment, input.cut_states) + FormatAngles(t, *input.assessment);
    }
    if (!input.assessment->stops.empty()) out += FormatStops(t, *input.assessment);
    out += FormatBone(t, *input.assessment);
  }
  if (input.pieces != nullptr && input.pieces->size() > 0)
    out += FormatPieces(t, *input.pieces, input.piece_colours, prepared);
  if (!input.measures.empty()) out += FormatMeasures(t, input.measures);
  if (input.sessions.size() > 1) out += FormatSessionTable(t, input.sessions);
  out += FormatFigures(input);
  for (const ExportCurve& curve : input.curves) {
    out += Heading(t.Tr(curve.title)) + fmt::format("<figure>\n{}</figure>\n", FormatCurveSvg(curve, t));
  }
  if (!input.pictures.empty()) out += Heading(t.Tr("Pictures"));
  for (const ExportPicture& picture : input.pictures) {
    out += fmt::format(
        "<figure>\n<img alt=\"{0}\" src=\"data:image/png;base64,{1}\">\n<figcaption>{0}</figcaption>\n</figure>\n",
        EscapeHtml(t.Tr(picture.caption)), Base64(picture.png));
  }
  if (!input.provenance.empty()) out += Heading(t.Tr("Origin of this report")) + FormatFacts(t, input.provenance);
  return out + "</main>\n</body>\n</html>\n";
}

}  // namespace kerf::export_detail
