#include "app/window/export_order.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "kerf/error.h"
#include "kerf/version.h"
#include "session/plan/assess.h"

namespace kerf {
namespace {

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

}  // namespace

std::string RunExport(ExportOrder& order) {
  const Bone after = order.after.get();
  const Assessment assessment = AssessCut(order.plan, *order.before, after, CalcBladeWidth(MakeTool(order.scene)));
  PieceSet pieces(after, 1.0);
  const bool arranged = Arrange(pieces, order.pieces_json);
  ExportInput taken;
  taken.title = order.scene.TitleOrName();
  taken.plan = &order.plan;
  taken.assessment = &assessment;
  taken.pieces = &pieces;
  if (arranged) taken.measures = order.measures;  // otherwise they belong to other pieces
  for (std::size_t i = 0; i < order.pictures.size(); ++i) {
    taken.pictures.push_back({.name = fmt::format("picture_{}", i + 1),
                              .caption = order.pictures[i].first,
                              .png = order.pictures[i].second});
  }
  double largest_N = 0;
  ExportCurve curve{.title = "Force on the hand", .x_label = "time, s", .y_label = "force, N", .points = {}};
  for (const PlotPoint& p : order.forces) {
    curve.points.emplace_back(p.time_s, p.force_N);
    largest_N = std::max(largest_N, p.force_N);
  }
  const double duration_s = curve.points.empty() ? 0 : curve.points.back().first;
  if (curve.points.size() > 1) {
    taken.figures = {{"duration", "s", curve.points.back().first}, {"largest force on the hand", "N", largest_N}};
    taken.curves.push_back(std::move(curve));
  }
  const StructureAssessment structures = AssessStructures(*order.before, after, order.marks);
  taken.structures = &structures;
  taken.circumstances = {
      {"date and time", fmt::format("{:%Y-%m-%d %H:%M}", fmt::localtime(std::chrono::system_clock::to_time_t(
                                                             std::chrono::system_clock::now())))},
      {"case", order.scene.TitleOrName()},
      {"bone", order.scene.bone.source == BoneSource::kFile ? order.scene.bone.file : "a model of kerf"},
      {"saw", order.saw_name.empty() ? DescribeTool(order.scene.tool)
                                     : fmt::format("{}: {}", order.saw_name, DescribeTool(order.scene.tool))},
      {"spindle", fmt::format("{:.0f} rpm", order.scene.tool.rpm)},
      {"force law", order.scene.force.name()}};
  if (duration_s > 0) taken.circumstances.push_back({"duration", fmt::format("{:.0f} s", duration_s)});
  taken.provenance.push_back({"scene", order.scene.name});
  taken.provenance.push_back({"tool", DescribeTool(order.scene.tool)});
  for (const std::string& recording : order.recordings) {
    taken.provenance.push_back({"recording", std::filesystem::path(recording).filename().string()});
  }
  taken.provenance.push_back({"bone before, hash", fmt::format("{:016x}", order.before->CalcHash())});
  taken.provenance.push_back({"bone after, hash", fmt::format("{:016x}", after.CalcHash())});
  taken.provenance.push_back({"voxel", fmt::format("{:g} mm", after.voxel_mm())});
  taken.provenance.push_back({"report by", fmt::format("kerf {} ({})", VersionString(), CommitString())});
  // This many triangles are enough for a printed model; at 0.1 mm voxels, a whole piece without a limit would take 135
  // MB.
  WriteExport(taken, order.folder, {.obj = order.obj, .triangles = 300'000});
  return order.folder;
}

}  // namespace kerf
