#include "bone/grid/sharp_edges.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>
#include <map>
#include <utility>

namespace kerf {
namespace {

constexpr int kMaxSteps = 8;             // of Newton's method
constexpr double kTolerance_vox = 1e-3;  // of the two fields on an edge
constexpr double kMargin_vox = 0.05;     // by which an edge may pass outside of a cell
constexpr double kLeastAngle = 0.05;     // sine of the angle between two surfaces from which on they form an edge
constexpr double kMaxShift_vox = 1;      // from the middle between two surfaces to their edge
constexpr double kApart = 0.02;          // of its way, by which a vertex moves less than to the place of another one

/// Both fields and their gradients at a point, in voxels.
struct FieldsAt {
  double whole, cut;
  Vec3 n_whole, n_cut;

  FieldsAt(const PhiCorners& corners, const Vec3& f, double voxel_mm)
      : whole(Interpolate(corners.whole, f) / voxel_mm),
        cut(Interpolate(corners.cut, f) / voxel_mm),
        n_whole(InterpolateGradient(corners.whole, f) / voxel_mm),
        n_cut(InterpolateGradient(corners.cut, f) / voxel_mm) {}
};

/// Returns the mean of the places where a field is zero on the edges of a cell, which is the vertex of its dual mesh.
std::optional<Vec3> FindDualVertex(const CellValues<float>& corners) {
  Vec3 sum(0);
  int count = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::size_t step = std::size_t{4} >> axis;
      if ((corner & step) != 0) continue;
      const auto a = static_cast<double>(corners[corner]), b = static_cast<double>(corners[corner | step]);
      if ((a < 0) == (b < 0)) continue;
      Vec3 f(static_cast<double>(corner >> 2 & 1), static_cast<double>(corner >> 1 & 1),
             static_cast<double>(corner & 1));
      f[axis] = a / (a - b);
      sum += f;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

bool IsIn(const Vec3& f, double margin) {
  return glm::all(glm::greaterThan(f, Vec3(-margin))) && glm::all(glm::lessThan(f, Vec3(1 + margin)));
}

}  // namespace

SharpEdges::Vertex SharpEdges::Move(const Vec3& p_vox) const {
  const CellPoint cell = FindCell(p_vox);
  if ((cell.x & 7) < 7 && (cell.y & 7) < 7 && (cell.z & 7) < 7) {
    const PhiParts parts = reader_.At(openvdb::Coord(cell.x & ~7, cell.y & ~7, cell.z & ~7));
    if (parts.cut == reader_.inside()) return {p_vox, Side::kWhole};
    if (parts.whole == reader_.inside()) return {p_vox, Side::kCut};
  }
  const PhiCorners corners = reader_.Corners(cell);
  const auto is_near = [this](const CellValues<float>& v) {
    const auto [least, most] = std::minmax_element(v.begin(), v.end());
    return std::max(static_cast<double>(*least), -static_cast<double>(*most)) < h_;
  };
  if (!is_near(corners.cut)) return {p_vox, Side::kWhole};
  if (!is_near(corners.whole)) return {p_vox, Side::kCut};
  const Vec3 lowest(cell.x, cell.y, cell.z);
  const std::optional<Vec3> of_whole = FindDualVertex(corners.whole), of_cut = FindDualVertex(corners.cut);
  const Vec3 f_whole = of_whole.value_or(cell.f), f_cut = of_cut.value_or(cell.f);
  const FieldsAt at_whole(corners, f_whole, h_), at_cut(corners, f_cut, h_);
  const double whole_level = of_whole ? at_whole.whole : 0;
  const double cut_level = of_cut ? at_cut.cut : 0;
  const std::optional<Vertex> edge = FindEdge(p_vox, whole_level, cut_level);
  if (edge && IsIn(edge->p_vox - lowest, kMargin_vox)) return *edge;
  // The surface whose vertex is not beyond the other one.
  if (of_whole && at_whole.cut - cut_level < kTolerance_vox) {
    return {lowest + f_whole, Side::kWhole, at_whole.n_whole, Vec3(0), whole_level, cut_level};
  }
  if (of_cut && at_cut.whole - whole_level < kTolerance_vox) {
    return {lowest + f_cut, Side::kCut, Vec3(0), at_cut.n_cut, whole_level, cut_level};
  }
  // Both are, because the edge passes just outside of the cell.
  Vec3 f = cell.f;
  Vertex vertex;
  vertex.whole_level = whole_level;
  vertex.cut_level = cut_level;
  for (int step = 0; step < kMaxSteps; ++step) {
    const FieldsAt at(corners, f, h_);
    const double whole = at.whole - whole_level, cut = at.cut - cut_level;
    vertex.side = whole >= cut ? Side::kWhole : Side::kCut;
    vertex.whole_outward = at.n_whole;
    vertex.cut_outward = at.n_cut;
    const Vec3& outward = whole >= cut ? at.n_whole : at.n_cut;
    const double square = glm::dot(outward, outward);
    if (!(square > 0)) break;
    f = glm::clamp(f - std::max(whole, cut) / square * outward, Vec3(0), Vec3(1));
  }
  vertex.p_vox = lowest + f;
  return vertex;
}

/// Returns the point where both fields have their values on the dual meshes that is nearest to a point, except for
/// higher orders.
std::optional<SharpEdges::Vertex> SharpEdges::FindEdge(Vec3 p_vox, double whole_level, double cut_level) const {
  for (int step = 0; step < kMaxSteps; ++step) {
    const CellPoint cell = FindCell(p_vox);
    FieldsAt at(reader_.Corners(cell), cell.f, h_);
    at.whole -= whole_level;
    at.cut -= cut_level;
    if (std::max(std::abs(at.whole), std::abs(at.cut)) < kTolerance_vox) {
      return Vertex{p_vox, Side::kBoth, at.n_whole, at.n_cut, whole_level, cut_level};
    }
    const double aa = glm::dot(at.n_whole, at.n_whole), bb = glm::dot(at.n_cut, at.n_cut);
    const double ab = glm::dot(at.n_whole, at.n_cut);
    const double determinant = aa * bb - ab * ab;
    if (!(determinant > kLeastAngle * kLeastAngle * aa * bb)) return std::nullopt;
    const Vec3 shift = (bb * at.whole - ab * at.cut) * at.n_whole + (aa * at.cut - ab * at.whole) * at.n_cut;
    p_vox -= glm::clamp(shift / determinant, Vec3(-1), Vec3(1));
  }
  return std::nullopt;
}

void SharpEdges::SplitTriangles(std::vector<Vertex>& vertices,
                                std::vector<std::array<std::uint32_t, 3>>& triangles) const {
  using Index = std::uint32_t;
  std::map<std::pair<Index, Index>, std::optional<Index>> between;
  const auto find = [&](Index a, Index b) -> std::optional<Index> {
    if (vertices[a].side == Side::kCut) std::swap(a, b);
    if (vertices[a].side != Side::kWhole || vertices[b].side != Side::kCut) return std::nullopt;
    const auto [found, is_new] = between.try_emplace(std::minmax(a, b));
    if (!is_new) return found->second;
    const Vec3 middle = 0.5 * (vertices[a].p_vox + vertices[b].p_vox);
    const std::optional<Vertex> edge = FindEdge(middle, vertices[a].whole_level, vertices[b].cut_level);
    if (edge && glm::length(edge->p_vox - middle) < kMaxShift_vox) {
      found->second = static_cast<Index>(vertices.size());
      vertices.push_back(*edge);
    }
    return found->second;
  };
  const std::size_t count = triangles.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<Index, 3> t = triangles[i];
    const std::optional<Index> on[3] = {find(t[0], t[1]), find(t[1], t[2]), find(t[2], t[0])};
    for (std::size_t k = 0; k < 3; ++k) {
      // Three corners lie on two surfaces: at most two sides are split.
      const Index a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      const std::optional<Index>&ab = on[k], &bc = on[(k + 1) % 3], &ca = on[(k + 2) % 3];
      if (!ab || bc) continue;
      triangles[i] = {a, *ab, ca ? *ca : c};
      triangles.push_back({*ab, b, c});
      if (ca) triangles.push_back({*ab, c, *ca});
    }
  }
}

void SharpenEdges(const BoneGrids& bone, TriangleMesh& mesh) {
  if (!bone.cut) return;
  const double h = bone.voxel_mm();
  std::vector<SharpEdges::Vertex> vertices(mesh.points.size());
  constexpr std::size_t kAtOnce = 16384;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), kAtOnce), [&](const auto& range) {
    const SharpEdges edges(bone);  // one for each part, as it remembers where it read last
    for (std::size_t i = range.begin(); i != range.end(); ++i) vertices[i] = edges.Move(mesh.points[i] / h);
  });
  // A cell with two parts of the surface has a vertex for each, and two cells may share a point of an edge. If two
  // vertices were moved to one place, the parts would touch there.
  std::multimap<std::array<int, 3>, std::size_t> moved;  // by the cell to which they were moved
  const auto keep_apart = [&](std::size_t i) {
    vertices[i].p_vox += kApart * (mesh.points[i] / h - vertices[i].p_vox);
  };
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3 p_vox = vertices[i].p_vox;
    if (p_vox == mesh.points[i] / h) continue;
    const CellPoint first = FindCell(p_vox - kTolerance_vox), last = FindCell(p_vox + kTolerance_vox);
    for (int x = first.x; x <= last.x; ++x) {
      for (int y = first.y; y <= last.y; ++y) {
        for (int z = first.z; z <= last.z; ++z) {
          const auto [begin, end] = moved.equal_range({x, y, z});
          for (auto other = begin; other != end; ++other) {
            if (glm::length(vertices[other->second].p_vox - p_vox) > kTolerance_vox) continue;
            keep_apart(other->second);
            keep_apart(i);
          }
        }
      }
    }
    const CellPoint cell = FindCell(p_vox);
    moved.insert({{cell.x, cell.y, cell.z}, i});
  }
  SharpEdges(bone).SplitTriangles(vertices, mesh.triangles);
  mesh.points.clear();
  for (const SharpEdges::Vertex& vertex : vertices) mesh.points.push_back(h * vertex.p_vox);
}

}  // namespace kerf
