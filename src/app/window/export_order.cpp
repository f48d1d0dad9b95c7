#include "app/window/export_order.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>

#include "app/window/case_sessions.h"
#include "app/window/import_notes.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/plan/assess.h"
#include "view/live/piece_mesh.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// Progress at the end of each part, measured with the jaw of the Visible Human.
constexpr double kBoneReady = 0.02;
constexpr double kAssessed = 0.2;
constexpr double kSplit = 0.3;
constexpr double kStructuresAssessed = 0.4;

/// Moves the pieces to where they were arranged. Returns false if the bone falls apart into other pieces now; these
/// stay where they were cut off.
bool Arrange(PieceSet& pieces, const std::string& json) {
  if (json.empty()) return true;
  try {
    pieces.Restore(json, "the pieces in the window");
  } catch (const Error&) {
    return false;
  }
  return true;
}

std::vector<ExportMeasure> MakeMeasures(const PieceSet& pieces, const std::vector<MeasuredPoints>& measurements) {
  std::vector<ExportMeasure> measures;
  for (const MeasuredPoints& points : measurements) {
    const std::optional<PieceMeasure> now = MeasurePieces(pieces, points);
    if (!now) continue;  // one of its pieces is deleted
    const bool distance = points.size() == 2;
    measures.push_back({.name = fmt::format("{} {}", distance ? "distance" : "angle", measures.size() + 1),
                        .unit = distance ? "mm" : "deg",
                        .value = now->value,
                        .points_W_mm = now->points_W,
                        .pieces = {}});
    for (const PiecePoint& point : points) measures.back().pieces.push_back(point.piece);
  }
  return measures;
}

/// Words for the colours of pieces, in the order of PieceColour().
constexpr std::array kColourWords{Msg("sand"),       Msg("light blue"), Msg("grey"),
                                  Msg("pale green"), Msg("dark blue"),  Msg("brown")};
static_assert(kColourWords.size() == kPieceColours);

/// Returns true for a session in which nothing was done, such as that of a saw that was exchanged at once.
bool IsEmpty(const ProjectSession& session) {
  return session.duration_s && *session.duration_s < 0.5 && session.removed_mm3.value_or(0) <= 0;
}

/// A value of all sessions together; none if it is not known of one of them.
struct SessionRow {
  const char* name;
  const char* unit;
  int decimals;
  std::optional<double> value;
};

/// Adds what the bone's notes say about the CT that it was made of.
void AddCt(const ExportOrder& order, std::vector<ExportFact>& facts) {
  const auto note = [&order](const char* key) { return GetNote(*order.before, key); };
  const ReportLanguage& t = order.language;
  if (!IsFromCt(*order.before)) return;
  std::string voxels = note("import_ct_voxels");
  std::string spacing = note("import_ct_spacing_mm");
  for (std::string* text : {&voxels, &spacing}) {
    for (std::size_t at = 0; (at = text->find(' ', at)) != std::string::npos; at += 3) text->replace(at, 1, " x ");
  }
  const std::string series = note("import_series_uid");
  const std::string date = note("import_study_date");
  facts.push_back({"CT", fmt::format("{}; {}", order.input.empty() ? order.scene.TitleOrName() : order.input,
                                     t.Tr(fmt::format(fmt::runtime(Msg("{} voxels of {} mm")), voxels, spacing)))});
  if (!date.empty()) facts.push_back({Msg("date of the study"), date});
  if (!series.empty()) facts.push_back({Msg("DICOM series"), series});
  const auto translate = [&t](const std::string& text) { return t.Tr(text); };
  if (const std::string error = DescribeSurfaceError(*order.before, translate); !error.empty()) {
    facts.push_back({Msg("error of the surface"), error, note(kSurfaceErrorNote)});
  }
  const std::string notes = DescribeImport(*order.before, translate);
  if (!notes.empty()) facts.push_back({Msg("notes of the import"), notes});
}

}  // namespace

std::string RunExport(ExportOrder& order) {
  const auto report = [&order](double fraction) {
    if (order.progress) order.progress(fraction);
  };
  const Bone after = order.after.get();
  report(kBoneReady);
  const Assessment assessment = AssessCut(order.plan, *order.before, after, CalcCutWidth(MakeTool(order.scene)));
  report(kAssessed);
  PieceSet pieces(after, 1.0);
  const bool arranged = Arrange(pieces, order.pieces_json);
  report(kSplit);
  ExportInput taken;
  taken.language = order.language;
  taken.title = order.title;
  taken.plan = &order.plan;
  taken.assessment = &assessment;
  for (const PlannedPlane& plane : order.plan.planes) {
    taken.cut_states.push_back(CalcCutState(*order.before, after, plane));
  }
  taken.pieces = &pieces;
  for (int i = 0; i < pieces.size() && order.pictures.size() > 1; ++i) {
    taken.piece_colours.push_back(kColourWords[static_cast<std::size_t>(i) % kColourWords.size()]);
  }
  if (arranged) taken.measures = MakeMeasures(pieces, order.measurements);  // otherwise they belong to other pieces
  for (std::size_t i = 0; i < order.pictures.size(); ++i) {
    taken.pictures.push_back({.name = fmt::format("picture_{}", i + 1),
                              .caption = order.pictures[i].first,
                              .png = order.pictures[i].second});
  }
  if (order.sessions.size() > 1) std::erase_if(order.sessions, [](const ProjectSession& one) { return IsEmpty(one); });
  const JoinedSessions joined = JoinSessions(order.sessions);
  taken.hub_in_bone_W = joined.holder.hub_W;
  taken.handpiece_in_bone_W = joined.holder.handpiece_W;
  const SessionRow rows[] = {
      {Msg("time with the saw in bone"), "s", 0, joined.in_bone_s},
      {Msg("time of the session"), "s", 0, joined.duration_s},
      {Msg("largest force on the hand in bone, spindle turning"), "N", 2, joined.turning_force_N},
      {Msg("largest force on the hand in bone, spindle stopped"), "N", 2, joined.stopped_force_N}};
  for (const SessionRow& row : rows) {
    if (row.value) taken.figures.push_back({row.name, row.unit, *row.value});
  }
  if (joined.forces_sN.size() > 1) {
    taken.curves.push_back({.title = Msg("Force on the hand, in bone and in air (pull of a guide)"),
                            .x_label = Msg("time, s"),
                            .y_label = Msg("force, N"),
                            .points = joined.forces_sN});
  }
  for (const ProjectSession& session : order.sessions) {
    taken.sessions.push_back({.saw = session.saw,
                              .duration_s = session.duration_s,
                              .in_bone_s = session.in_bone_s,
                              .turning_force_N = session.turning_force_N,
                              .stopped_force_N = session.stopped_force_N});
  }
  const StructureAssessment structures = AssessStructures(*order.before, after, order.marks);
  taken.structures = &structures;
  report(kStructuresAssessed);
  taken.circumstances = {
      {Msg("date and time"), fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(std::chrono::system_clock::to_time_t(
                                                                  std::chrono::system_clock::now())))},
      {Msg("case"), order.title}};
  AddCt(order, taken.circumstances);
  const ReportLanguage& t = order.language;
  std::string saws;
  for (const std::string& saw : joined.saws) saws += (saws.empty() ? "" : "; ") + t.ShowSaw(saw);
  const std::string bone = IsFromCt(*order.before)                        ? t.Tr("made from the CT")
                           : order.scene.bone.source == BoneSource::kFile ? t.Tr("from a file")
                                                                          : t.Tr("a model of kerf");
  std::vector<ExportFact> rest{{Msg("bone"), bone, order.input},
                               {Msg("saw"), saws.empty() ? "-" : saws},
                               {Msg("spindle"), fmt::format("{:.0f} {}", order.scene.tool.rpm, t.Tr("rpm"))},
                               {Msg("force law"), t.Tr(order.scene.force.info().summary), order.scene.force.name()}};
  for (const SessionRow& row : rows) {
    rest.push_back({row.name, row.value ? fmt::format("{} {}", t.Show(*row.value, row.decimals), row.unit)
                                        : t.Tr("- (not known for the sessions before)")});
  }
  taken.circumstances.insert(taken.circumstances.end(), rest.begin(), rest.end());
  const bool is_made = order.scene.name == "rehearsal";  // by the window, around a bone
  taken.provenance.push_back({Msg("scene"), is_made ? t.Tr(Msg("made for the case")) : order.scene.name});
  taken.provenance.push_back({Msg("tool"), t.Tr(DescribeTool(order.scene.tool.shape))});
  for (const std::string& recording : order.recordings) {
    taken.provenance.push_back({Msg("recording"), std::filesystem::path(recording).filename().string()});
  }
  taken.provenance.push_back({Msg("bone before, hash"), fmt::format("{:016x}", order.before->CalcHash())});
  taken.provenance.push_back({Msg("bone after, hash"), fmt::format("{:016x}", after.CalcHash())});
  taken.provenance.push_back({Msg("voxel"), t.Show(after.voxel_mm(), 3) + " mm"});
  taken.provenance.push_back({Msg("report by"), fmt::format("kerf {} ({})", VersionString(), CommitString())});
  // This many triangles are enough for a printed model; at 0.1 mm voxels, a whole piece without a limit would take 135
  // MB.
  WriteExport(taken, order.folder, {.obj = order.obj, .triangles = 300'000},
              [&report](double fraction) { report(kStructuresAssessed + (1 - kStructuresAssessed) * fraction); });
  return order.folder;
}

}  // namespace kerf
