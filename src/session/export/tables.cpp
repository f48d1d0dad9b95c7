// Measures as CSV and JSON for other programs.
#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/table/table_json.h"
#include "bone/pieces/measure.h"
#include "session/export/contacts.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

Json List(const Vec3& v) {
  return Json::array({v.x, v.y, v.z});
}

Json ListStructures(const StructureAssessment& a) {
  Json list = Json::array();
  for (const StructureResult& s : a.structures) {
    list.push_back({{"name", FormatMessage(NameStructure(s))},
                    {"kind", ToString(s.kind)},
                    {"marked", s.is_mark},
                    {"cut", s.is_cut},
                    {"severed", s.is_severed},
                    {"removed_mm3", s.removed_mm3},
                    {"distance_mm", OrNull(s.distance_mm)},
                    {"nearest_mm", s.distance_mm ? List(s.p_W) : Json()}});
  }
  return list;
}

/// Returns the least distance of the removed bone from a nerve or its canal; null: not known, or nothing was removed.
Json FindNerveDistance(const StructureAssessment& a) {
  std::optional<double> least_mm;
  for (const StructureResult& s : a.structures) {
    if (IsNerve(s.kind) && s.distance_mm) least_mm = std::min(*s.distance_mm, least_mm.value_or(*s.distance_mm));
  }
  return OrNull(least_mm);
}

double CalcMoved(const PieceSet& pieces, int i) {
  return glm::length(pieces.CalcCentroid(i) - pieces.piece(i).centroid_P);
}

double CalcTurned(const PieceSet& pieces, int i) {
  return CalcRotationAngle(pieces.state(i).X_WP);
}

Json ListPieces(const PieceSet& pieces) {
  Json list = Json::array();
  for (int i = 0; i < pieces.size(); ++i) {
    if (pieces.state(i).deleted) continue;
    list.push_back({{"name", pieces.piece(i).name},
                    {"volume_mm3", pieces.piece(i).volume_mm3},
                    {"moved_mm", CalcMoved(pieces, i)},
                    {"turned_deg", CalcTurned(pieces, i)}});
  }
  return list;
}

}  // namespace

const Columns<ExportLine>& ExportColumns() {
  static const Columns<ExportLine> kColumns{
      {"subject", "{}", "plane, stop, structure, piece, pair of pieces, measure, `bone` or `session`",
       &ExportLine::subject},
      {"measure", "{}", "what was measured", &ExportLine::measure},
      {"unit", "{}", "unit of the value", &ExportLine::unit},
      {"value", "{:.6g}", "the value", &ExportLine::value}};
  return kColumns;
}

namespace export_detail {

std::string FormatMeasuresCsv(const ExportInput& input, const Prepared& prepared) {
  std::vector<ExportLine> rows;
  const auto add = [&rows](const std::string& subject, const char* measure, const std::string& unit, double value) {
    rows.push_back({subject, measure, unit, value});
  };
  if (input.assessment != nullptr) {
    const Assessment& a = *input.assessment;
    for (const PlaneResult& p : a.planes) {
      if (!p.cut) continue;
      add(p.planned.name, "offset", "mm", p.offset_mm);
      add(p.planned.name, "furthest", "mm", p.furthest_mm);
      add(p.planned.name, "angle", "deg", p.angles.angle_deg);
      add(p.planned.name, "pitch", "deg", p.angles.pitch_deg);
      add(p.planned.name, "roll", "deg", p.angles.roll_deg);
      add(p.planned.name, "kerf width", "mm", p.cut->width_mm);
      add(p.planned.name, "kerf rms", "mm", p.cut->rms_mm);
    }
    for (const StopResult& s : a.stops) {
      if (!s.depth_mm) continue;
      add(s.planned.name, "depth", "mm", *s.depth_mm);
      add(s.planned.name, "too deep by", "mm", s.over_mm);
    }
    add("bone", "before", "mm3", a.before_mm3);
    add("bone", "after", "mm3", a.after_mm3);
    add("bone", "removed", "mm3", a.removed_mm3);
    if (a.outside_mm3) add("bone", "removed outside the margins", "mm3", *a.outside_mm3);
    if (a.too_deep_mm3) add("bone", "removed deeper than the stops", "mm3", *a.too_deep_mm3);
  }
  if (input.structures != nullptr) {
    for (const StructureResult& structure : input.structures->structures) {
      if (!structure.distance_mm) continue;
      const std::string name = FormatMessage(NameStructure(structure));
      add(name, "least distance from the cut", "mm", *structure.distance_mm);
      add(name, "removed", "mm3", structure.removed_mm3);
    }
  }
  for (const int i : prepared.pieces) {
    const Piece& piece = input.pieces->piece(i);
    add(piece.name, "volume", "mm3", piece.volume_mm3);
    add(piece.name, "moved", "mm", CalcMoved(*input.pieces, i));
    add(piece.name, "turned", "deg", CalcTurned(*input.pieces, i));
  }
  for (const PairRow& pair : prepared.pairs) {
    const std::string subject = fmt::format("{} and {}", pair.a, pair.b);
    add(subject, "overlap", "mm3", pair.overlap_mm3);
    if (pair.gap_mm) add(subject, "least gap", "mm", *pair.gap_mm);
    if (!pair.facing) continue;
    add(subject, "facing area", "mm2", pair.facing->area_mm2);
    add(subject, "mean gap", "mm", pair.facing->mean_mm);
    add(subject, "contact area", "mm2", pair.facing->contact_mm2);
  }
  for (const ExportMeasure& m : input.measures) add(m.name, m.unit == "deg" ? "angle" : "distance", m.unit, m.value);
  for (const ExportFigure& f : input.figures) add("session", f.name.c_str(), f.unit, f.value);
  return FormatCsv(ExportColumns(), rows);
}

}  // namespace export_detail

std::string FormatAssessmentJson(const ExportInput& input) {
  const Assessment& a = *input.assessment;
  const ExportRecording& recording = input.recording;
  Json json;
  if (!recording.state.empty()) {
    json["recording_state"] = recording.state;
    json["warnings"] = recording.warnings;
  }
  json["planes"] = Json::array();
  for (const PlaneResult& p : a.planes) {
    Json plane{{"name", p.planned.name},
               {"planned",
                {{"point_mm", List(p.planned.plane.p_W)},
                 {"normal", List(p.planned.plane.normal_W)},
                 {"margin_mm", p.planned.margin_mm}}}};
    plane["cut"] = nullptr;
    if (!p.cut) plane["reason"] = DescribeNoKerf(p);
    if (p.cut) {
      plane["cut"] = {{"point_mm", List(p.cut->p_W_mm)}, {"normal", List(p.cut->normal_W)},
                      {"width_mm", p.cut->width_mm},     {"rms_mm", p.cut->rms_mm},
                      {"length_mm", p.cut->length_mm},   {"depth_mm", p.cut->depth_mm},
                      {"removed_mm3", p.cut->volume_mm3}};
      plane["offset_mm"] = p.offset_mm;
      plane["furthest_mm"] = p.furthest_mm;
      plane["angle_deg"] = p.angles.angle_deg;
      plane["pitch_deg"] = p.angles.pitch_deg;
      plane["roll_deg"] = p.angles.roll_deg;
      plane["within_margin"] = p.within_margin;
    }
    json["planes"].push_back(plane);
  }
  json["stops"] = Json::array();
  for (const StopResult& s : a.stops) {
    Json stop{{"name", s.planned.name},
              {"point_mm", List(s.planned.p_W_mm)},
              {"direction", List(s.planned.direction_W)},
              {"planned_mm", s.planned.depth_mm}};
    stop["reached_mm"] = OrNull(s.depth_mm);
    stop["too_deep_by_mm"] = s.depth_mm ? Json(s.over_mm) : Json();
    json["stops"].push_back(stop);
  }
  json["before_mm3"] = a.before_mm3;
  json["after_mm3"] = a.after_mm3;
  json["removed_mm3"] = a.removed_mm3;
  json["outside_mm3"] = OrNull(a.outside_mm3);
  json["too_deep_mm3"] = OrNull(a.too_deep_mm3);
  if (input.structures != nullptr) {
    json["structures"] = ListStructures(*input.structures);
    json["nerve_distance_mm"] = FindNerveDistance(*input.structures);
  }
  if (input.pieces != nullptr) json["pieces"] = ListPieces(*input.pieces);
  return DumpJson(json);
}

}  // namespace kerf
