#include "bone/import/closed_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <unordered_map>

#include "base/core/number_text.h"
#include "bone/import/shells.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// Gaps up to this width are not closed, but are detected for the error message.
constexpr double kWideGap_mm = 0.1;

using Triangle = std::array<std::uint32_t, 3>;

struct Cell {
  double x, y, z;  // integers, of any size
  bool operator==(const Cell&) const = default;
};
struct CellHash {
  std::size_t operator()(const Cell& c) const {
    std::uint64_t h = 0;
    for (const double i : {c.x, c.y, c.z}) {
      h = (h ^ std::bit_cast<std::uint64_t>(i + 0.0)) * 0x9e3779b97f4a7c15u;  // + 0.0: -0 is 0
      h ^= h >> 29;
    }
    return h;
  }
};

/// Merges each point into the first point that is nearer than `distance_mm`. Returns the number of points removed.
std::size_t Weld(TriangleMesh& mesh, double distance_mm) {
  std::unordered_map<Cell, std::vector<std::uint32_t>, CellHash> kept;
  std::vector<std::uint32_t> id_of(mesh.points.size());
  TriangleMesh welded;
  for (std::size_t n = 0; n < mesh.points.size(); ++n) {
    const Vec3& p = mesh.points[n];
    const Cell cell{std::floor(p.x / distance_mm), std::floor(p.y / distance_mm), std::floor(p.z / distance_mm)};
    const auto same = [&]() -> const std::uint32_t* {
      for (int beside = 0; beside < 27; ++beside) {
        const auto found = kept.find({cell.x + beside / 9 - 1, cell.y + beside / 3 % 3 - 1, cell.z + beside % 3 - 1});
        if (found == kept.end()) continue;
        for (const std::uint32_t& id : found->second) {
          if (glm::length(welded.points[id] - p) < distance_mm) return &id;
        }
      }
      return nullptr;
    };
    if (const std::uint32_t* id = same()) {
      id_of[n] = *id;
      continue;
    }
    id_of[n] = static_cast<std::uint32_t>(welded.points.size());
    kept[cell].push_back(id_of[n]);
    welded.points.push_back(p);
  }
  for (const Triangle& t : mesh.triangles) {
    const Triangle now{id_of[t[0]], id_of[t[1]], id_of[t[2]]};
    if (now[0] != now[1] && now[1] != now[2] && now[2] != now[0]) welded.triangles.push_back(now);
  }
  const std::size_t gone = mesh.points.size() - welded.points.size();
  mesh = std::move(welded);
  return gone;
}

/// Keeps only one of the triangles that have the same three corners. Returns the number removed.
std::size_t RemoveDuplicateTriangles(TriangleMesh& mesh) {
  std::vector<std::pair<Triangle, std::uint32_t>> all(mesh.triangles.size());
  for (std::size_t n = 0; n < all.size(); ++n) {
    all[n] = {mesh.triangles[n], static_cast<std::uint32_t>(n)};
    std::sort(all[n].first.begin(), all[n].first.end());
  }
  std::sort(all.begin(), all.end());
  std::vector<bool> gone(all.size(), false);
  for (std::size_t n = 1; n < all.size(); ++n) gone[all[n].second] = all[n].first == all[n - 1].first;
  std::size_t n = 0;
  return std::erase_if(mesh.triangles, [&](const Triangle&) { return gone[n++]; });
}

/// Returns whether all points lie in one plane.
bool IsFlat(const TriangleMesh& mesh) {
  constexpr double kFlat = 1e-6;  // of the size
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  Vec3 largest(0);  // normal of the triangle with the largest area, of twice that length
  Vec3 corner(0);
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = mesh.points[t[0]];
    const Vec3 normal = glm::cross(mesh.points[t[1]] - a, mesh.points[t[2]] - a);
    if (glm::length(normal) > glm::length(largest)) largest = normal, corner = a;
  }
  if (!(glm::length(largest) > 0)) return true;
  const Vec3 normal = glm::normalize(largest);
  const double tolerance = kFlat * glm::length(box.size());
  return std::all_of(mesh.points.begin(), mesh.points.end(),
                     [&](const Vec3& p) { return std::abs(glm::dot(p - corner, normal)) <= tolerance; });
}

[[noreturn]] void RefuseOpen(const TriangleMesh& mesh, const EdgeCounts& edges, const std::string& path) {
  if (IsFlat(mesh)) throw Error(fmt::format("{}: the surface is flat, so it encloses no volume", path));
  TriangleMesh wide = mesh;
  if (Weld(wide, kWideGap_mm) > 0 && CountEdges(wide).open == 0) {
    throw Error(fmt::format(
        "{}: the surface is not closed: {} to one triangle only, because the triangles are not joined: corners that "
        "should coincide lie up to {} mm apart, and kerf welds points nearer than {} mm; weld them in a mesh program",
        path, FormatCount(edges.open, "edge belongs", "of its edges belong"), kWideGap_mm, kWeld_mm));
  }
  throw Error(
      fmt::format("{}: the surface is not closed: {} to one triangle only, which is the rim of a hole or of a "
                  "gap wider than {} mm; close the holes in a mesh program",
                  path, FormatCount(edges.open, "edge belongs", "of its edges belong"), kWeld_mm));
}

/// Welds points, removes duplicates, and orients all triangles consistently.
std::vector<Shell> Repair(TriangleMesh& mesh, std::vector<std::string>& repairs, const std::string& path) {
  EdgeCounts edges = CountEdges(mesh);
  if (edges.open > 0) {
    if (const std::size_t welded = Weld(mesh, kWeld_mm); welded > 0) {
      repairs.push_back(fmt::format("{} nearer than {} mm to another point and {} welded to it",
                                    FormatCount(welded, "point lay", "points lay"), kWeld_mm,
                                    welded == 1 ? "was" : "were"));
      edges = CountEdges(mesh);
    }
  }
  if (edges.crowded > 0) {
    if (const std::size_t duplicates = RemoveDuplicateTriangles(mesh); duplicates > 0) {
      repairs.push_back(fmt::format("{} in the file more than once and {} left out",
                                    FormatCount(duplicates, "triangle was", "triangles were"),
                                    duplicates == 1 ? "was" : "were"));
      edges = CountEdges(mesh);
    }
  }
  if (edges.open > 0) RefuseOpen(mesh, edges, path);
  if (edges.crowded > 0) {
    throw Error(
        fmt::format("{}: {} to more than two triangles: parts touch along edges, or inner walls meet the "
                    "surface; separate or remove them in a mesh program",
                    path, FormatCount(edges.crowded, "edge of the surface belongs", "edges of the surface belong")));
  }
  std::size_t flipped = 0;
  std::vector<Shell> shells = OrientShells(mesh, flipped, path);
  if (flipped > 0) {
    repairs.push_back(fmt::format("{} opposite to most of {} shell and {} flipped",
                                  FormatCount(flipped, "triangle faced", "triangles faced"),
                                  flipped == 1 ? "its" : "their", flipped == 1 ? "was" : "were"));
  }
  return shells;
}

/// Returns one mesh for each layer; the triangles keep their order.
std::vector<TriangleMesh> Separate(const TriangleMesh& mesh, const std::vector<Shell>& shells,
                                   const std::vector<std::size_t>& layer_of, std::size_t layers) {
  std::vector<TriangleMesh> result(layers);
  std::vector<std::size_t> layer(mesh.triangles.size());
  for (std::size_t n = 0; n < shells.size(); ++n) {
    for (const std::uint32_t t : shells[n].triangles) layer[t] = layer_of[n];
  }
  for (std::size_t t = 0; t < layer.size(); ++t) result[layer[t]].triangles.push_back(mesh.triangles[t]);
  for (TriangleMesh& part : result) {
    part.points = mesh.points;
    DropUnusedPoints(part);
  }
  return result;
}

std::string Describe(const SurfaceReport& r, bool hollow_inner_shells) {
  std::string text = FormatCount(r.shells, "shell", "shells");
  if (r.hollow_shells > 0) {
    text += fmt::format("; {} left hollow ({} in all), because {}",
                        FormatCount(r.hollow_shells, "inner shell", "inner shells"), FormatVolume(r.hollow_mm3),
                        hollow_inner_shells    ? "of --no-fill"
                        : r.hollow_shells == 1 ? "it faces inward"
                                               : "they face inward");
  }
  if (r.inner_solid_shells > 0 && !hollow_inner_shells) {
    const bool one = r.inner_solid_shells == 1;
    text += fmt::format("; {} filled, because {} outward (--no-fill leaves {} hollow)",
                        FormatCount(r.inner_solid_shells, "inner shell", "inner shells"),
                        one ? "it faces" : "they face", one ? "it" : "them");
  }
  return text;
}

}  // namespace

ClosedSurface CloseSurface(TriangleMesh mesh, bool hollow_inner_shells, const std::string& path) {
  ClosedSurface result;
  SurfaceReport& report = result.report;
  std::vector<Shell> shells = Repair(mesh, report.repairs, path);
  FindContainers(mesh, shells);
  report.triangles = mesh.triangles.size();
  report.shells = shells.size();
  // Starts with the largest shell, so that the container of a shell is assigned to a layer before the shell itself.
  std::vector<std::size_t> layer(shells.size(), 0);
  std::size_t layers = 1;
  for (std::size_t n = 0; n < shells.size(); ++n) {
    const Shell& shell = shells[n];
    if (shell.container < 0) continue;
    const auto container = static_cast<std::size_t>(shell.container);
    const bool opposite = (shell.volume_mm3 < 0) != (shells[container].volume_mm3 < 0);
    layer[n] = layer[container] + (opposite || hollow_inner_shells ? 1 : 0);
    layers = std::max(layers, layer[n] + 1);
    const bool is_hollow = layer[n] % 2 == 1;
    if (layer[n] != layer[container]) {
      report.hollow_shells += is_hollow ? 1 : 0;
      report.hollow_mm3 += (is_hollow ? 1 : -1) * std::abs(shell.volume_mm3);
    } else if (!is_hollow) {
      ++report.inner_solid_shells;
    }
  }
  report.how = Describe(report, hollow_inner_shells);
  result.layers = Separate(mesh, shells, layer, layers);
  return result;
}

}  // namespace kerf
