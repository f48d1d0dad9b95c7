#include "view/live/chunk_mesher.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace kerf {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;

using Corners = std::array<float, 8>;  // bit 2: x, bit 1: y, bit 0: z

struct Edge {
  int from;
  int to;
};
constexpr std::array<Edge, 12> kEdges{
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

float Mix(float a, float b, float t) {
  return a + t * (b - a);
}

float Trilinear(const Corners& v, const std::array<float, 3>& f) {
  const float y0 = Mix(Mix(v[0], v[1], f[2]), Mix(v[2], v[3], f[2]), f[1]);
  const float y1 = Mix(Mix(v[4], v[5], f[2]), Mix(v[6], v[7], f[2]), f[1]);
  return Mix(y0, y1, f[0]);
}

std::array<float, 3> Gradient(const Corners& v, const std::array<float, 3>& f) {
  const float gx = Mix(Mix(v[4] - v[0], v[5] - v[1], f[2]), Mix(v[6] - v[2], v[7] - v[3], f[2]), f[1]);
  const float gy = Mix(Mix(v[2] - v[0], v[3] - v[1], f[2]), Mix(v[6] - v[4], v[7] - v[5], f[2]), f[0]);
  const float gz = Mix(Mix(v[1] - v[0], v[3] - v[2], f[1]), Mix(v[5] - v[4], v[7] - v[6], f[1]), f[0]);
  return {gx, gy, gz};
}

class Mesher {
 public:
  Mesher(const SampleBlock& block, float cut_depth, CellSurface& surface)
      : block_(block), cut_depth_(cut_depth), surface_(surface), n_(block.samples()), m_(block.cells + 2) {}

  void Run(bool skirt) {
    MakeSigns();
    MarkCells();
    // Edges are found by the sample at their lower end, which must be owned by the block.
    for (int x = 2; x < n_ - 2; ++x) {
      for (int y = 2; y < n_ - 2; ++y) {
        const std::uint64_t row = Row(x, y);
        const std::uint64_t own = ((std::uint64_t{1} << (n_ - 4)) - 1) << 2;
        for (int axis = 0; axis < 3; ++axis) {
          const std::uint64_t next = axis == 0 ? Row(x + 1, y) : axis == 1 ? Row(x, y + 1) : row >> 1;
          for (std::uint64_t crossed = (row ^ next) & own; crossed != 0; crossed &= crossed - 1) {
            const int z = std::countr_zero(crossed);
            AddFace(x - 1, y - 1, z - 1, axis, ((row >> z) & 1) != 0, surface_.triangles);
          }
        }
      }
    }
    if (skirt) AddSkirt();
  }

 private:
  static std::size_t At(int i) { return static_cast<std::size_t>(i); }
  std::uint64_t Row(int x, int y) const { return surface_.signs[At(x) * At(n_) + At(y)]; }
  std::size_t CellAt(int x, int y, int z) const { return (At(x) * At(m_) + At(y)) * At(m_) + At(z); }

  std::size_t SampleAt(int x, int y, int z) const { return (At(x) * At(n_) + At(y)) * At(n_) + At(z); }

  // Returns the gradient over two cells; shading with it looks smoother than with that of a single cell.
  std::array<float, 3> WideGradient(const std::vector<float>& values, int x, int y, int z,
                                    const std::array<float, 3>& f) const {
    return {Trilinear(CornersOf(values, x + 1, y, z), f) - Trilinear(CornersOf(values, x - 1, y, z), f),
            Trilinear(CornersOf(values, x, y + 1, z), f) - Trilinear(CornersOf(values, x, y - 1, z), f),
            Trilinear(CornersOf(values, x, y, z + 1), f) - Trilinear(CornersOf(values, x, y, z - 1), f)};
  }

  // Adds the faces around edges in the upper sides of the block, between its last cells and the first ones beyond.
  void AddSkirt() {
    const int last = n_ - 2;
    for (int x = 2; x <= last; ++x) {
      for (int y = 2; y <= last; ++y) {
        const bool side = x == last || y == last;
        for (int z = side ? 2 : last; z <= last; ++z) {
          const bool inside = IsInside(x, y, z);
          if (x < last && inside != IsInside(x + 1, y, z)) AddFace(x - 1, y - 1, z - 1, 0, inside, surface_.skirt);
          if (y < last && inside != IsInside(x, y + 1, z)) AddFace(x - 1, y - 1, z - 1, 1, inside, surface_.skirt);
          if (z < last && inside != IsInside(x, y, z + 1)) AddFace(x - 1, y - 1, z - 1, 2, inside, surface_.skirt);
        }
      }
    }
  }
  bool IsInside(int x, int y, int z) const { return ((Row(x, y) >> z) & 1) != 0; }

  // Sets one bit for each sample of a row along z that is inside.
  void MakeSigns() {
    surface_.signs.resize(At(n_) * At(n_));
    const float* phi = block_.phi.data();
    for (std::uint64_t& row : surface_.signs) {
      row = 0;
      for (int z = 0; z < n_; ++z) row |= std::uint64_t{phi[z] < 0 ? 1u : 0u} << z;
      phi += n_;
    }
  }

  // Marks the cells that the surface crosses as having no vertex yet; the entries of other cells are not used.
  void MarkCells() {
    surface_.vertex_of_cell.resize(At(m_) * At(m_) * At(m_));
    for (int x = 0; x < m_; ++x) {
      for (int y = 0; y < m_; ++y) {
        const std::uint64_t rows[4] = {Row(x + 1, y + 1) >> 1, Row(x + 2, y + 1) >> 1, Row(x + 1, y + 2) >> 1,
                                       Row(x + 2, y + 2) >> 1};
        const std::uint64_t any = rows[0] | rows[1] | rows[2] | rows[3];
        const std::uint64_t all = rows[0] & rows[1] & rows[2] & rows[3];
        const std::uint64_t cells = (std::uint64_t{1} << m_) - 1;
        for (std::uint64_t crossed = (any | any >> 1) & ~(all & all >> 1) & cells; crossed != 0;
             crossed &= crossed - 1) {
          surface_.vertex_of_cell[CellAt(x, y, std::countr_zero(crossed))] = kNone;
        }
      }
    }
  }

  Corners CornersOf(const std::vector<float>& values, int x, int y, int z) const {
    Corners v;
    for (int i = 0; i < 8; ++i) {
      v[At(i)] = values[SampleAt(x + 1 + (i >> 2), y + 1 + ((i >> 1) & 1), z + 1 + (i & 1))];
    }
    return v;
  }

  std::uint32_t VertexOf(int x, int y, int z) {
    std::uint32_t& id = surface_.vertex_of_cell[CellAt(x, y, z)];
    if (id != kNone) return id;
    id = static_cast<std::uint32_t>(surface_.vertices.size());
    const Corners v = CornersOf(block_.phi, x, y, z);
    std::array<float, 3> sum{};
    int count = 0;
    for (const Edge& edge : kEdges) {
      const float a = v[static_cast<std::size_t>(edge.from)];
      const float b = v[static_cast<std::size_t>(edge.to)];
      if ((a < 0) == (b < 0)) continue;
      const float t = a / (a - b);
      for (int i = 0; i < 3; ++i) {
        const int bit = 2 - i;
        const int from = (edge.from >> bit) & 1;
        const int to = (edge.to >> bit) & 1;
        sum[static_cast<std::size_t>(i)] += from == to ? static_cast<float>(from) : t;
      }
      ++count;
    }
    CellVertex vertex{{x - 1, y - 1, z - 1}, sum, {0, 0, 1}, false};
    for (float& f : vertex.within) f /= static_cast<float>(count);
    bool changed = false;
    if (!block_.uncut.empty()) {
      const Corners before = CornersOf(block_.uncut, x, y, z);
      changed = before != v;
      vertex.cut = changed && Trilinear(before, vertex.within) < -cut_depth_;
    }
    // The walls of a kerf may be less than two cells apart, so the gradient there is that of one cell. Next to the
    // kerf, the gradient is that of the original surface. Beyond the last cells, which only skirts reach, there are no
    // samples for the wide gradient.
    const bool last = std::max({x, y, z}) == m_ - 1;
    const std::array<float, 3> g =
        changed || last ? Gradient(v, vertex.within)
                        : WideGradient(block_.uncut.empty() ? block_.phi : block_.uncut, x, y, z, vertex.within);
    const float length = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    if (length > 0) vertex.normal = {g[0] / length, g[1] / length, g[2] / length};
    surface_.vertices.push_back(vertex);
    return id;
  }

  // Adds the face of the four cells around an edge, counter-clockwise seen from the edge's upper end.
  void AddFace(int x, int y, int z, int axis, bool inside_first, std::vector<std::uint32_t>& t) {
    std::array<std::uint32_t, 4> id{};
    constexpr int kRound[4][2] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
    for (std::size_t i = 0; i < 4; ++i) {
      const int u = kRound[i][0];
      const int v = kRound[i][1];
      id[i] = axis == 0 ? VertexOf(x, y - u, z - v) : axis == 1 ? VertexOf(x - v, y, z - u) : VertexOf(x - u, y - v, z);
    }
    if (!inside_first) std::swap(id[1], id[3]);
    // Splits the face along the shorter diagonal.
    if (Distance2(id[0], id[2]) <= Distance2(id[1], id[3])) {
      t.insert(t.end(), {id[0], id[1], id[2], id[0], id[2], id[3]});
    } else {
      t.insert(t.end(), {id[0], id[1], id[3], id[1], id[2], id[3]});
    }
  }

  float Distance2(std::uint32_t a, std::uint32_t b) const {
    const CellVertex& p = surface_.vertices[a];
    const CellVertex& q = surface_.vertices[b];
    float sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const float d = static_cast<float>(p.cell[i] - q.cell[i]) + p.within[i] - q.within[i];
      sum += d * d;
    }
    return sum;
  }

  const SampleBlock& block_;
  float cut_depth_;
  CellSurface& surface_;
  int n_;  // samples along an axis
  int m_;  // cells along an axis, including those before and after; cell i lies between samples i + 1 and i + 2
};

}  // namespace

void CellSurface::Clear() {
  vertices.clear();
  triangles.clear();
  skirt.clear();
}

void MakeCellSurface(const SampleBlock& block, float cut_depth, bool skirt, CellSurface& surface) {
  surface.Clear();
  Mesher(block, cut_depth, surface).Run(skirt);
}

}  // namespace kerf
