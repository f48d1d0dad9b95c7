#include "view/picture/colours.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <map>

namespace kerf {
namespace {

// Okabe and Ito's colours without black, lightened so that shading stays visible on them.
constexpr std::array<Rgb8, 7> kPalette{
    {{230, 159, 0}, {86, 180, 233}, {0, 158, 115}, {240, 228, 66}, {0, 114, 178}, {213, 94, 0}, {204, 121, 167}}};

Rgb8 Mix(const Rgb8& a, const Rgb8& b, double fraction_of_b) {
  Rgb8 mixed{};
  for (std::size_t i = 0; i < 3; ++i) mixed[i] = static_cast<std::uint8_t>(a[i] + fraction_of_b * (b[i] - a[i]) + 0.5);
  return mixed;
}

// Computes unit normals of the points, weighted by the areas of their triangles.
std::vector<Vec3> CalcPointNormals(const TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.points.size(), Vec3{0});
  for (const auto& t : mesh.triangles) {
    const Vec3 n = glm::cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]);
    for (const auto id : t) normals[id] += n;
  }
  for (Vec3& n : normals) {
    const double length = glm::length(n);
    if (length > 0) n /= length;
  }
  return normals;
}

std::string LegendText(const Region& region, ColourBy by) {
  if (by == ColourBy::kTissue) return ToString(region.tissue);
  return fmt::format("{} {}, {:.3g} GPa", region.id, region.name, region.E_MPa / 1000);
}

}  // namespace

Rgb8 TissueColour(Tissue tissue) {
  switch (tissue) {
    case Tissue::kCortical:
      return kBoneColour;
    case Tissue::kCancellous:
      return {217, 112, 62};
    case Tissue::kTooth:
      return {250, 250, 246};
    case Tissue::kCanal:
      return {150, 40, 110};
    case Tissue::kMetal:
      return {126, 140, 158};
    case Tissue::kLesion:
      return {0, 130, 95};
    case Tissue::kOther:
      break;
  }
  return {170, 170, 170};
}

Rgb8 RegionColour(int region_id) {
  if (region_id <= 0) return {170, 170, 170};
  const Rgb8 base = kPalette[static_cast<std::size_t>(region_id) % kPalette.size()];
  // The hues repeat every seven ids: plain, dark, light, pale.
  switch (region_id / static_cast<int>(kPalette.size()) % 4) {
    case 0:
      return Mix(base, {255, 255, 255}, 0.15);
    case 1:
      return Mix(base, {0, 0, 0}, 0.3);
    case 2:
      return Mix(base, {255, 255, 255}, 0.5);
    default:
      return Mix(base, {255, 255, 255}, 0.75);
  }
}

Rgb8 RegionColour(const Region& region) {
  return region.tissue == Tissue::kCortical ? RegionColour(region.id) : TissueColour(region.tissue);
}

SurfaceColours CalcSurfaceColours(const Bone& bone, const TriangleMesh& mesh_W, ColourBy by) {
  SurfaceColours colours;
  if (by == ColourBy::kPlain) {
    colours.points.assign(mesh_W.points.size(), kBoneColour);
    return colours;
  }
  // Half a voxel below the surface is certainly inside. If there is no material there, up to two voxels are tried.
  const double step_mm = 0.5 * std::max(bone.voxel_mm(), bone.region_voxel_mm());
  const std::vector<Vec3> normals = CalcPointNormals(mesh_W);
  std::map<int, std::size_t> counts;
  std::vector<int> ids(mesh_W.points.size(), 0);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (int step = 1; step <= 4 && ids[i] == 0; ++step)
      ids[i] = bone.RegionAt(mesh_W.points[i] - step * step_mm * normals[i]);
    ++counts[ids[i]];
  }
  const auto colour_of = [&](int id) {
    if (!bone.materials().Contains(id)) return TissueColour(Tissue::kOther);
    return by == ColourBy::kRegion ? RegionColour(bone.materials().At(id))
                                   : TissueColour(bone.materials().At(id).tissue);
  };
  colours.points.reserve(ids.size());
  for (const int id : ids) colours.points.push_back(colour_of(id));

  struct Line {
    LegendEntry entry;
    std::size_t count;
  };
  std::vector<Line> lines;
  for (const auto& [id, count] : counts) {
    const std::string text = bone.materials().Contains(id) ? LegendText(bone.materials().At(id), by) : "no material";
    const auto same =
        std::find_if(lines.begin(), lines.end(), [&](const Line& line) { return line.entry.text == text; });
    if (same == lines.end())
      lines.push_back({{text, colour_of(id)}, count});
    else
      same->count += count;
  }
  // Regions stay sorted by id.
  if (by == ColourBy::kTissue)
    std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.count > b.count; });
  for (const Line& line : lines) {
    if (line.count * 1000 >= ids.size()) colours.legend.push_back(line.entry);
  }
  return colours;
}

}  // namespace kerf
