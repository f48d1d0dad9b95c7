#include "session/run/write_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "bone/mesh/decimate.h"
#include "bone/mesh/meshfile.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "view/picture/picture.h"

namespace kerf {
namespace {

constexpr const char* kNames[] = {"left", "slice", "right"};

/// Returns the position below which half of the area lies.
double CalcMedian(std::vector<std::pair<double, double>>& mm_and_mm2, double area_mm2) {
  std::sort(mm_and_mm2.begin(), mm_and_mm2.end());
  double sum = 0;
  for (const auto& [mm, mm2] : mm_and_mm2) {
    sum += mm2;
    if (sum >= 0.5 * area_mm2) return mm;
  }
  return 0;
}

/// Checks, before any work is done, that no file would replace the bone's or the plane's file.
void CheckPartsInputsNotOverwritten(const PartsOptions& options) {
  std::vector<std::string> outputs{options.folder + "/parts.json"};
  if (options.picture) outputs.push_back(options.folder + "/parts.png");
  for (const char* name : kNames) {
    for (const auto& [wanted, extension] :
         {std::pair{options.stl, "stl"}, std::pair{options.obj, "obj"}, std::pair{options.vdb, "vdb"}}) {
      if (wanted) outputs.push_back(fmt::format("{}/{}.{}", options.folder, name, extension));
    }
  }
  CheckInputsNotOverwritten({options.bone_file, options.plane_file}, outputs);
}

/// Returns the surface of each part, reduced to `triangles`. Called before anything is written.
std::vector<TriangleMesh> MakeSurfaces(const SlabParts& parts, std::size_t triangles) {
  std::vector<TriangleMesh> surfaces{ExtractSurface(parts.left), parts.slice_surface_W, ExtractSurface(parts.right)};
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (triangles > 0) surfaces[i] = Decimate(surfaces[i], triangles);
    if (surfaces[i].triangles.empty()) {
      throw Error(
          fmt::format("the {} has no surface: it is smaller than a voxel; move the plane, or make the bone again with "
                      "smaller voxels",
                      i == 1 ? "slice" : fmt::format("{} segment", kNames[i])));
    }
  }
  return surfaces;
}

/// Writes the files of a part. `surface`: on entry, the surface to write; on return, the surface as read back.
PartFile WritePart(const Bone& part, const char* name, const PartsOptions& options, const FileBatch& results,
                   TriangleMesh& surface) {
  PartFile file;
  file.name = name;
  file.volume_mm3 = part.CalcVolume();
  file.bounds_W = part.CalcBounds();
  const Pieces pieces = SplitPieces(part, kCrumbFraction * file.volume_mm3);
  file.pieces = pieces.pieces.size();
  file.crumbs = pieces.dust_count;
  file.crumbs_mm3 = pieces.dust_mm3;
  file.voxel_mm = part.voxel_mm();
  std::string written;
  for (const auto& [wanted, extension] : {std::pair{options.stl, "stl"}, std::pair{options.obj, "obj"}}) {
    if (!wanted) continue;
    file.files.insert(file.files.begin(), fmt::format("{}.{}", name, extension));
    written = fmt::format("{}/{}", options.folder, file.files.front());
    WriteMesh(surface, written);
  }
  if (options.vdb) {
    file.files.push_back(fmt::format("{}.vdb", name));
    WriteBone(part, fmt::format("{}/{}", options.folder, file.files.back()));
  }
  if (!written.empty()) surface = ReadMesh(results.Find(written));
  file.triangles = surface.triangles.size();
  file.surface_volume_mm3 = CalcEnclosedVolume(surface);
  file.open_edges = CountOpenEdges(surface);
  return file;
}

Vec3 Across(const Vec3& v, const Vec3& normal) {
  return v - glm::dot(v, normal) * normal;
}

/// Returns a view from outside the bone, next to the slice, so that one of its faces is visible and the parts appear
/// separate.
Camera MakePartsCamera(const Bone& bone, const PartsReport& report) {
  const Vec3& normal = report.plane.normal_W;
  const Box3 slice = report.parts[1].bounds_W;
  Vec3 outward = slice.centre() - bone.CalcBounds().centre();
  outward.z = 0;
  outward = Across(outward, normal);
  if (glm::length(outward) < 1) outward = Across({0, -1, 0}, normal);
  if (glm::length(outward) < 0.1) outward = Across({1, 0, 0}, normal);
  const double front = normal.y > 0 ? -1 : 1;  // from the patient's front rather than from behind
  const Vec3 eye = glm::normalize(outward) + 0.6 * front * normal + Vec3(0, 0, 0.5);
  return {eye, std::abs(glm::normalize(eye).z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, -1, 0), {}, 0};
}

void WritePartsPicture(const Bone& bone, std::vector<TriangleMesh> surfaces, const PartsReport& report,
                       const std::string& path) {
  PictureSpec spec;
  const double apart_mm = std::max(6.0, 0.08 * glm::length(bone.CalcBounds().size()));
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    Shape shape;
    shape.mesh_W = std::move(surfaces[i]);
    for (Vec3& p : shape.mesh_W.points) p += (static_cast<double>(i) - 1) * apart_mm * report.plane.normal_W;
    shape.colour = kPartColours[i];
    spec.shapes.push_back(std::move(shape));
    const double mm3 = report.parts[i].volume_mm3;
    spec.legend.push_back(
        {fmt::format("{}: {}",
                     i == 1   ? "slice"
                     : i == 0 ? "left segment"
                              : "right segment",
                     mm3 < 1000 ? fmt::format("{:.1f} mm³", mm3) : fmt::format("{:.2f} cm³", mm3 / 1000)),
         kPartColours[i]});
  }
  spec.title = fmt::format("{}: cut by a slab of {:g} mm", std::filesystem::path(report.bone).stem().string(),
                           report.thickness_mm);
  spec.caption = fmt::format("the segments drawn {:.0f} mm away from the slice along the plane's normal", apart_mm);
  spec.camera = MakePartsCamera(bone, report);
  WritePicture(spec, path);
}

nlohmann::ordered_json ToJson(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

SliceFaces MeasureSliceFaces(const TriangleMesh& slice_W, const CutPlane& plane) {
  SliceFaces faces;
  std::vector<std::pair<double, double>> left, right;  // position of a triangle's centre along the normal, area
  for (const auto& t : slice_W.triangles) {
    const Vec3& a = slice_W.points[t[0]];
    const Vec3& b = slice_W.points[t[1]];
    const Vec3& c = slice_W.points[t[2]];
    const Vec3 twice = glm::cross(b - a, c - a);
    const double mm2 = 0.5 * glm::length(twice);
    constexpr double kCosDegree = 0.99985;
    const double along = glm::dot(twice, plane.normal_W);
    if (!(std::abs(along) > 2 * mm2 * kCosDegree)) continue;
    const double mm = glm::dot(plane.normal_W, (a + b + c) / 3.0 - plane.p_W);
    (along < 0 ? left : right).emplace_back(mm, mm2);
    (along < 0 ? faces.left_mm2 : faces.right_mm2) += mm2;
  }
  faces.left_mm = CalcMedian(left, faces.left_mm2);
  faces.right_mm = CalcMedian(right, faces.right_mm2);
  return faces;
}

PartsReport CutAndWriteParts(const Bone& bone, const SlabCut& cut, const PartsOptions& options) {
  CheckPartsInputsNotOverwritten(options);
  const auto done = [&options](double fraction) {
    if (options.progress) options.progress(fraction);
  };
  const SlabParts parts = MakeSlabParts(bone, cut);
  done(0.2);
  std::vector<TriangleMesh> surfaces = MakeSurfaces(parts, options.triangles);
  const FolderLock lock(options.folder);
  FileBatch results(options.folder, "parts.json");
  PartsReport report;
  report.bone = options.bone_file;
  report.whole_mm3 = bone.CalcVolume();
  report.plane = cut.plane;
  report.thickness_mm = cut.thickness_mm;
  report.places = parts.places;
  report.cut_places = parts.cut_places;
  report.distance_mm = parts.distance_mm;
  const Bone* bones[] = {&parts.left, &parts.slice, &parts.right};
  for (std::size_t i = 0; i < 3; ++i) {
    report.parts.push_back(WritePart(*bones[i], kNames[i], options, results, surfaces[i]));
    report.sum_mm3 += report.parts[i].volume_mm3;
    done(0.4 + 0.2 * static_cast<double>(i));
  }
  const SliceFaces faces = MeasureSliceFaces(surfaces[1], cut.plane);
  report.measured_thickness_mm = faces.right_mm - faces.left_mm;
  report.section_mm2 = report.parts[1].volume_mm3 / cut.thickness_mm;
  report.left_face_mm2 = faces.left_mm2;
  report.right_face_mm2 = faces.right_mm2;
  if (options.picture) {
    WritePartsPicture(bone, std::move(surfaces), report, options.folder + "/parts.png");
    report.files.emplace_back("parts.png");
  }
  report.files.emplace_back("parts.json");
  WriteTextFile(options.folder + "/parts.json", FormatPartsJson(report));
  results.Commit();
  done(1);
  return report;
}

std::string FormatPartsJson(const PartsReport& report) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["bone"] = report.bone;
  json["plane"] = {{"point_mm", ToJson(report.plane.p_W)}, {"normal", ToJson(report.plane.normal_W)}};
  json["thickness_mm"] = report.thickness_mm;
  json["measured_thickness_mm"] = report.measured_thickness_mm;
  json["section_mm2"] = report.section_mm2;
  json["flat_face_mm2"] = {{"left", report.left_face_mm2}, {"right", report.right_face_mm2}};
  json["places"] = report.places;
  json["cut_places"] = report.cut_places;
  json["point_to_cut_mm"] = report.distance_mm;
  json["whole_mm3"] = report.whole_mm3;
  json["sum_mm3"] = report.sum_mm3;
  json["difference_percent"] = report.CalcDifferencePercent();
  json["parts"] = Json::array();
  for (const PartFile& part : report.parts) {
    json["parts"].push_back({{"name", part.name},
                             {"volume_mm3", part.volume_mm3},
                             {"bounds_lower_mm", ToJson(part.bounds_W.lower)},
                             {"bounds_upper_mm", ToJson(part.bounds_W.upper)},
                             {"pieces", part.pieces},
                             {"crumbs", part.crumbs},
                             {"crumbs_mm3", part.crumbs_mm3},
                             {"voxel_mm", part.voxel_mm},
                             {"triangles", part.triangles},
                             {"surface_volume_mm3", part.surface_volume_mm3},
                             {"closed", part.open_edges == 0},
                             {"open_edges", part.open_edges},
                             {"files", part.files}});
  }
  json["files"] = report.files;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
