#include "session/run/run_slab_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "bone/grid/slab_parts.h"
#include "bone/vdb/bonefile.h"
#include "cut/force/measured.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "kerf/version.h"
#include "session/run/make_bone.h"
#include "session/run/results_folder.h"
#include "session/run/run_pictures.h"
#include "session/run/run_warnings.h"
#include "session/run/summary_json.h"
#include "session/run/write_parts.h"
#include "session/run/write_pieces.h"
#include "view/picture/colours.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

/// Returns the displacement of the slice along the direction at the end of the run.
double SliceTravel(const SlabSummary& summary) {
  return std::max(0.0, summary.end.depth_mm + 0.5 * (summary.end.left_mm + summary.end.right_mm));
}

Shape Moved(TriangleMesh mesh, Rgb8 colour, const Vec3& by_W) {
  for (Vec3& p : mesh.points) p += by_W;
  Shape shape;
  shape.mesh_W = std::move(mesh);
  shape.colour = colour;
  return shape;
}

/// Draws the three bodies at their final positions.
PictureSpec MakeSlabPicture(const Scene& scene, const SlabParts& parts, const SlabSummary& summary,
                            const SlabParams& params, const Pose& X_WT_last) {
  const std::string name = scene.TitleOrName();
  PictureSpec spec;
  spec.title = name + ": the slice at the end";
  const bool patient = scene.bone.source == BoneSource::kFile || scene.bone.source == BoneSource::kMandible;
  spec.orientation = patient ? Orientation::kPatient : Orientation::kAxes;
  const Vec3 d = params.direction_W;
  spec.shapes.push_back(Moved(ExtractSurface(parts.left), kPartColours[0], summary.end.left_mm * d));
  spec.shapes.push_back(Moved(parts.slice_surface_W, kPartColours[1], SliceTravel(summary) * d));
  spec.shapes.push_back(Moved(ExtractSurface(parts.right), kPartColours[2], summary.end.right_mm * d));
  spec.tools.push_back({params.saw, X_WT_last, 1});
  spec.legend = {{"left segment", kPartColours[0]}, {"slice", kPartColours[1]}, {"right segment", kPartColours[2]}};
  const Vec3 normal = X_WT_last.Vector({0, 0, 1});
  const Vec3 across = glm::cross(normal, d);
  const Vec3 up(0, 0, 1);
  spec.camera = {0.8 * normal + across + 0.4 * up, up, {}, 0};
  spec.fit_to_tool = false;
  spec.caption = summary.end.free ? fmt::format("the slice came free after {:.1f} mm, at {:.2f} s",
                                                summary.profile.end_mm, summary.free_at_s.value_or(0))
                                  : fmt::format("the slice was moved {:.1f} mm of the {:.1f} mm that free it",
                                                SliceTravel(summary), summary.profile.end_mm);
  return spec;
}

bool NeedsParts(const Scene& scene) {
  return scene.output.pieces || scene.output.bone || scene.output.pictures;
}

/// Writes the parts that the scene requests, as .vdb and as STL.
void WriteSlabParts(const Scene& scene, const SlabParts& parts, const std::string& folder,
                    const std::function<void(double)>& progress, SlabSummary& summary) {
  const std::pair<const char*, const Bone*> named[] = {
      {"left", &parts.left}, {"slice", &parts.slice}, {"right", &parts.right}};
  for (const auto& [name, part] : named) {
    summary.parts.push_back({name, part->CalcVolume(), part->CalcBounds(), "", 0});
    if (scene.output.bone) {
      WriteBone(*part, fmt::format("{}/{}.vdb", folder, name));
      summary.files.push_back(fmt::format("{}.vdb", name));
    }
    if (scene.output.pieces) {
      SlabPartSummary& written = summary.parts.back();
      written.file = fmt::format("{}.stl", name);
      written.triangles = WriteReduced(part == &parts.slice ? parts.slice_surface_W : ExtractSurface(*part),
                                       summary.surface_error_mm, folder + "/" + written.file);
      summary.files.push_back(written.file);
    }
    progress(static_cast<double>(summary.parts.size()) / 3);
  }
}

PlotSpec MakeSlabForcePlot(const Scene& scene, const SlabParams& params, const SlabRun& run,
                           const MaterialTable& materials) {
  const std::string& name = scene.TitleOrName();
  PlotSpec plot = MakeForcePlot(run.ticks, materials, name, MakeTool(scene));
  plot.title = name + ": force on the hand, slab mode, law " + std::string(ToString(params.reading));
  plot.x.label = "depth of the blade below the first bone (mm)";
  plot.caption = "bands: the region at that depth";
  return plot;
}

}  // namespace

void SummarizeSlabRun(const Scene& scene, const SlabParams& params, const SlabRun& run, SlabSummary& summary) {
  summary.force = SummarizeForces(run.ticks, scene.simulation.rate_hz);
  summary.end = run.states.back();
  summary.profile = run.profile;
  summary.ticks = run.ticks.size();
  const Path path = MakePath(scene);
  for (std::size_t i = 0; i < run.ticks.size(); ++i) {
    summary.ticks_with_status += run.ticks[i].out.status != kTickOk ? 1 : 0;
    if (run.states[i].free && !summary.free_at_s) summary.free_at_s = run.ticks[i].time_s;
    const std::size_t segment = run.ticks[i].segment;
    if (i > 0 && segment == run.ticks[i - 1].segment) continue;
    // A stroke that begins deeper than the previous one has cut begins inside the bone.
    const Vec3 start_W = path.CalcPose(segment, path.segments()[segment].start_s).p_AB;
    const double cut_mm = i > 0 ? run.states[i - 1].deepest_mm : 0;
    summary.starts_in_bone =
        summary.starts_in_bone || CalcBladeDepth(run.profile, params, start_W) > cut_mm + kInBone_mm;
  }
  summary.simulated_s = run.ticks.back().time_s;
  summary.ticks_wall_s = run.wall_s;
  summary.times = run.times;
  summary.memory_bytes = run.memory_bytes;
}

SlabSummary RunSlabScene(const Scene& scene, const std::string& folder, const RunProgress& progress,
                         const RunSession& session, double surface_error_mm) {
  const auto stage = [&](const char* name) {
    return [&progress, name](double fraction) {
      if (progress) progress(name, fraction);
    };
  };
  const CutPlane plane = MakeSlabPlane(scene);  // an inconsistent scene fails before anything is made
  const SlabParams params = MakeSlabParams(scene);
  MakeFolder(folder);
  const std::vector<std::string> earlier = ReadEarlierResults(folder);
  SlabSummary summary;
  const Bone bone = MakeSceneBone(scene, stage("making the bone"), &summary.material);
  RunTape tape(session, scene, RecordedKind::kSlab, bone);
  const SlabRun run = RunSlab(scene, MakeSlabProfile(scene, bone), stage("cutting"), tape.tape());
  tape.Finish(bone.CalcHash());
  if (run.ticks.empty()) throw Error("the recording contains no tick up to that time");
  summary.materials = bone.materials();
  summary.voxel_mm = bone.voxel_mm();
  summary.surface_error_mm = surface_error_mm;
  SummarizeSlabRun(scene, params, run, summary);
  if (session.replay != nullptr) summary.warnings = session.replay->FindWarnings();
  for (const std::string& warning : FindSlabRunWarnings(scene, summary)) summary.warnings.push_back(warning);
  const bool drawn = AreDrawn(scene, summary.warnings);

  FileBatch results(folder, "summary.json");
  const auto write_text = [&](const std::string& name, const std::string& text) {
    WriteTextFile(folder + "/" + name, text);
    summary.files.push_back(name);
  };
  write_text("scene.toml", ResolvedToml(scene));
  write_text("forces.csv", FormatForceLog(run.ticks, scene.output.forces_every_ticks));
  write_text("slab.csv", FormatSlabLog(run, scene.output.forces_every_ticks));
  if (NeedsParts(scene)) {
    stage("cutting the bone into its three parts")(0);
    // Pass a point of the path inside the bone, in case the plane intersects the bone elsewhere too.
    const double middle_mm = run.profile.entry_mm + 0.5 * run.profile.end_mm - glm::dot(plane.p_W, params.direction_W);
    const SlabParts parts =
        MakeSlabParts(bone, {plane, params.saw.thickness_mm, false, plane.p_W + middle_mm * params.direction_W});
    WriteSlabParts(scene, parts, folder, stage("cutting the bone into its three parts"), summary);
    if (drawn) {
      stage("drawing the pictures")(0);
      WritePicture(MakeSlabPicture(scene, parts, summary, params, run.ticks.back().X_WT), folder + "/slab.png");
      summary.files.emplace_back("slab.png");
    }
  }
  const bool touched =
      std::any_of(run.ticks.begin(), run.ticks.end(), [](const TickRecord& t) { return t.out.engaged_teeth > 0; });
  if (drawn && touched) {
    WritePlot(MakeSlabForcePlot(scene, params, run, bone.materials()), folder + "/force.png");
    summary.files.emplace_back("force.png");
  }
  summary.files.emplace_back("summary.json");
  WriteTextFile(folder + "/summary.json", FormatSlabSummaryJson(scene, summary));
  results.Commit(earlier);
  return summary;
}

std::string DescribeSlabLaw(const Scene& scene) {
  ForceLaw paper("hertz_constant_bite");
  paper.Set("contact_share_of_pitch", scene.slab.params.contact_share_of_pitch);
  const char* several =
      scene.slab.params.reading == PaperReading::kAsComputed ? "; as computed, each of n teeth has n^2 times that" : "";
  return fmt::format("one tooth alone has the force of {}: {}{}", paper.name(),
                     DescribeAccuracy(paper, MakeTool(scene)), several);
}

std::string FormatSlabSummaryJson(const Scene& scene, const SlabSummary& s) {
  ordered_json json;
  json["kerf"] = {{"version", VersionString()}, {"commit", CommitString()}, {"compiler", CompilerString()}};
  json["scene"] = scene.name;
  json["mode"] = "slab";
  json["material"] = MaterialJson(scene, s.material);
  ordered_json layers = ordered_json::array();
  for (const SlabProfile::Layer& layer : s.profile.layers) {
    layers.push_back(
        {{"top_mm", layer.top_mm}, {"region", layer.region}, {"E_GPa", layer.E_MPa / 1000}, {"nu", layer.nu}});
  }
  json["slab"] = {{"law", ToString(scene.slab.params.reading)},
                  {"thickness_mm", CalcThickness(scene.tool.shape)},
                  {"entry_mm", s.profile.entry_mm},
                  {"length_mm", s.profile.end_mm},
                  {"deepest_mm", s.end.deepest_mm},
                  {"free", s.end.free},
                  {"free_at_s", s.free_at_s ? ordered_json(*s.free_at_s) : ordered_json(nullptr)},
                  {"slice_mm3_by_profile", s.profile.slice_mm3},
                  {"left_mm", s.end.left_mm},
                  {"right_mm", s.end.right_mm},
                  {"layers", layers}};
  json["force"] = ForceJson(std::string(ToString(scene.slab.params.reading)), s.force);
  json["force"]["accuracy"] = DescribeSlabLaw(scene);
  json["energy_mJ"] = {{"hand_work", s.end.hand_work_mJ}, {"kinetic", s.end.kinetic_mJ},
                       {"elastic", s.end.elastic_mJ},     {"friction", s.end.friction_mJ},
                       {"cutting", s.end.cutting_mJ},     {"damping", s.end.damping_mJ},
                       {"released", s.end.released_mJ},   {"numerical", s.end.numerical_mJ}};
  json["parts"] = ordered_json::array();
  for (const SlabPartSummary& part : s.parts) {
    json["parts"].push_back({{"name", part.name}, {"volume_mm3", part.volume_mm3}, {"bounds", BoxJson(part.bounds_W)}});
    if (!part.file.empty()) json["parts"].back().update({{"file", part.file}, {"triangles", part.triangles}});
  }
  if (HaveFiles(s.parts)) json["surface_error_mm"] = s.surface_error_mm;
  json["ticks"] = TicksJson(s);
  json["tick_memory_bytes"] = s.memory_bytes;
  json["starts_in_bone"] = s.starts_in_bone;
  json["warnings"] = s.warnings;
  json["files"] = s.files;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
