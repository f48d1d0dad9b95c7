#include "bone/pieces/overlap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/grid/cell_volume.h"
#include "bone/grid/parts_reader.h"

namespace kerf {
namespace {

constexpr double kSlackVoxels = 0.3;  // distances are accurate to a fifth of a voxel
constexpr int kBlock = 2;             // voxels, a quarter of a leaf; half its diagonal, 1.7, is within the band
constexpr int kCells = 2;             // cells per voxel edge
constexpr int kFine = 4;              // subdivisions per cell edge, where both surfaces are in the cell
constexpr double kBend = 0.1;         // fraction of a cell by which a surface may bend
constexpr double kFaces = 0.7071;     // cosine of the greatest angle at which surfaces face each other
constexpr std::size_t kStrides[] = {4096, 64, 1};  // few points first: a small minimum makes the rest faster

Box3 Transform(const Box3& box, const Pose& X) {
  Box3 out;
  if (box.empty()) return out;
  for (int i = 0; i < 8; ++i) {
    out.Include(X.Point(
        {i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y, i & 4 ? box.upper.z : box.lower.z}));
  }
  return out;
}

Pose Compose(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.R_AB * X_BC.R_AB, X_AB.Point(X_BC.p_AB)};
}

/// Samples both distances at points in a's frame.
class PairSampler {
 public:
  PairSampler(const Bone& a, const Bone& b, const Pose& X_BA)
      : a_(GridsOf(a)), b_(GridsOf(b)), per_a_(1 / a.voxel_mm()), per_b_(1 / b.voxel_mm()), X_BA_(X_BA) {}

  std::array<double, 2> operator()(const Vec3& p_A) {
    return {a_.Sample(per_a_ * p_A), b_.Sample(per_b_ * X_BA_.Point(p_A))};
  }

 private:
  PartsReader a_;
  PartsReader b_;
  double per_a_;
  double per_b_;
  Pose X_BA_;
};

/// Returns whether the grid has no leaf and no bone within a ball, by the leaves in the box around it.
bool IsFarFrom(openvdb::FloatGrid::ConstAccessor& values, const Vec3& p, double radius, double voxel_mm) {
  const auto down = [&](double x) { return static_cast<int>(std::floor(x / voxel_mm)) & ~7; };
  openvdb::Coord at;
  for (at.x() = down(p.x - radius); at.x() * voxel_mm <= p.x + radius; at.x() += 8) {
    for (at.y() = down(p.y - radius); at.y() * voxel_mm <= p.y + radius; at.y() += 8) {
      for (at.z() = down(p.z - radius); at.z() * voxel_mm <= p.z + radius; at.z() += 8) {
        if (values.probeConstLeaf(at) != nullptr || values.getValue(at) < 0) return false;
      }
    }
  }
  return true;
}

/// The distances to both surfaces at the corners of N x N x N cells.
template <int N>
class Lattice {
 public:
  void Fill(PairSampler& sample, const Vec3& corner, double edge) {
    for (int x = 0; x <= N; ++x) {
      for (int y = 0; y <= N; ++y) {
        for (int z = 0; z <= N; ++z) {
          const auto v = sample(corner + edge * Vec3(x, y, z));
          const std::size_t i = Place(x, y, z);
          for (std::size_t k = 0; k < 2; ++k) at_[k][i] = v[k];
          larger_[i] = static_cast<float>(std::max(v[0], v[1]));
        }
      }
    }
  }
  std::array<float, 8> Larger(int x, int y, int z) const { return Corners(larger_, x, y, z); }
  /// Returns whether both surfaces pass through the cell, or come so near that they may bend into it.
  bool HasBoth(int x, int y, int z, double edge) const {
    for (const auto& one : at_) {
      const std::array<double, 8> v = Corners(one, x, y, z);
      const auto [lowest, highest] = std::minmax_element(v.begin(), v.end());
      if (*lowest > kBend * edge || *highest < -kBend * edge) return false;
    }
    return true;
  }

 private:
  static constexpr std::size_t Place(int x, int y, int z) {
    constexpr std::size_t kEdge = N + 1;
    const auto at = [](int i) { return static_cast<std::size_t>(i); };
    return (at(x) * kEdge + at(y)) * kEdge + at(z);
  }
  template <typename T>
  static std::array<T, 8> Corners(const std::array<T, (N + 1) * (N + 1) * (N + 1)>& v, int x, int y, int z) {
    std::array<T, 8> out;
    for (int i = 0; i < 8; ++i) {
      out[static_cast<std::size_t>(i)] = v[Place(x + ((i >> 2) & 1), y + ((i >> 1) & 1), z + (i & 1))];
    }
    return out;
  }
  std::array<std::array<double, (N + 1) * (N + 1) * (N + 1)>, 2> at_{};
  std::array<float, (N + 1) * (N + 1) * (N + 1)> larger_{};
};

template <int N>
double SumFractions(const Lattice<N>& lattice) {
  double sum = 0;
  for (int x = 0; x < N; ++x) {
    for (int y = 0; y < N; ++y) {
      for (int z = 0; z < N; ++z) sum += CalcCellFraction(lattice.Larger(x, y, z));
    }
  }
  return sum;
}

/// Returns the overlap in a block of kBlock voxels, mm^3; cells with both surfaces are divided further.
double CalcInBlock(PairSampler& sample, const Vec3& corner, double cell) {
  constexpr int kN = kBlock * kCells;
  Lattice<kN> lattice;
  lattice.Fill(sample, corner, cell);
  Lattice<kFine> fine;
  double sum = 0;
  for (int x = 0; x < kN; ++x) {
    for (int y = 0; y < kN; ++y) {
      for (int z = 0; z < kN; ++z) {
        if (!lattice.HasBoth(x, y, z, cell)) {
          sum += CalcCellFraction(lattice.Larger(x, y, z));
          continue;
        }
        fine.Fill(sample, corner + cell * Vec3(x, y, z), cell / kFine);
        sum += SumFractions(fine) / (kFine * kFine * kFine);
      }
    }
  }
  return sum * cell * cell * cell;
}

/// Returns the area that belongs to each point: a third of the area of its triangles.
std::vector<double> CalcPointAreas(const TriangleMesh& mesh, std::vector<Vec3>& normals) {
  std::vector<double> areas(mesh.points.size(), 0);
  normals.assign(mesh.points.size(), Vec3(0));
  for (const auto& t : mesh.triangles) {
    const Vec3 n = 0.5 * glm::cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]);
    for (const std::uint32_t i : t) {
      areas[i] += glm::length(n) / 3;
      normals[i] += n;
    }
  }
  return areas;
}

/// Finds the minimum distance from the points of `from` to the surface `to`; keeps the previous one if it is smaller.
void FindMinDistance(const SurfaceWithTree& from, const SurfaceWithTree& to, const Pose& X_to_from, double& min_mm,
                     Vec3& p_from, Vec3& p_to) {
  const Box3& box = to.tree->bounds();
  const auto ask = [&](const Vec3& p) {
    const Vec3 at = X_to_from.Point(p);
    if (glm::length(at - glm::clamp(at, box.lower, box.upper)) >= min_mm) return;
    const auto nearest = to.tree->FindNearest(at, min_mm);
    if (!nearest || nearest->distance_mm >= min_mm) return;
    min_mm = nearest->distance_mm;
    p_from = p;
    p_to = nearest->p;
  };
  const std::vector<Vec3>& points = from.mesh->points;
  for (const std::size_t stride : kStrides) {
    for (std::size_t i = 0; i < points.size(); i += stride) ask(points[i]);
  }
}

}  // namespace

double CalcOverlap(const Bone& a, const Pose& X_WA, const Bone& b, const Pose& X_WB) {
  return CalcOverlap({&a, a.CalcBounds()}, X_WA, {&b, b.CalcBounds()}, X_WB);
}

double CalcOverlap(const BoneWithBounds& bone_a, const Pose& X_WA, const BoneWithBounds& bone_b, const Pose& X_WB) {
  const Bone& a = *bone_a.bone;
  const Bone& b = *bone_b.bone;
  if (bone_a.bounds.empty() || bone_b.bounds.empty()) return 0;
  // The finer of the two bones defines the cells.
  if (b.voxel_mm() < a.voxel_mm()) return CalcOverlap(bone_b, X_WB, bone_a, X_WA);
  const Pose X_AB = Compose(X_WA.Inverse(), X_WB);
  const double h = a.voxel_mm();
  Box3 box = Transform(bone_b.bounds.Grown(b.voxel_mm()), X_AB);
  const Box3 own = bone_a.bounds.Grown(h);
  box.lower = glm::max(box.lower, own.lower);
  box.upper = glm::min(box.upper, own.upper);
  if (box.empty()) return 0;

  PairSampler sample(a, b, X_AB.Inverse());
  const double edge = kBlock * h;
  const double cell = h / kCells;
  const double reach = 0.5 * std::sqrt(3.0) * edge;
  const double slack[2] = {kSlackVoxels * a.voxel_mm(), kSlackVoxels * b.voxel_mm()};
  const int leaf = openvdb::FloatTree::LeafNodeType::DIM;
  auto own_values = GridsOf(a).phi->getConstAccessor();
  auto other_values = GridsOf(b).phi->getConstAccessor();
  const Pose X_BA = X_AB.Inverse();
  const auto first = [&](double lower) { return static_cast<int>(std::floor(lower / (leaf * h))) * leaf; };
  double mm3 = 0;
  openvdb::Coord at;
  for (at.x() = first(box.lower.x); at.x() * h <= box.upper.x; at.x() += leaf) {
    for (at.y() = first(box.lower.y); at.y() * h <= box.upper.y; at.y() += leaf) {
      for (at.z() = first(box.lower.z); at.z() * h <= box.upper.z; at.z() += leaf) {
        // Skips most leaves: those without bone of `a` and those far from `b`.
        if (own_values.probeConstLeaf(at) == nullptr && own_values.getValue(at) >= 0) continue;
        const Vec3 corner = h * Vec3(at.x(), at.y(), at.z());
        if (IsFarFrom(other_values, X_BA.Point(corner + Vec3(0.5 * leaf * h)), 0.5 * std::sqrt(3.0) * leaf * h,
                      b.voxel_mm())) {
          continue;
        }
        for (int x = 0; x < leaf; x += kBlock) {
          for (int y = 0; y < leaf; y += kBlock) {
            for (int z = 0; z < leaf; z += kBlock) {
              const Vec3 p = corner + h * Vec3(x, y, z);
              const auto v = sample(p + Vec3(0.5 * edge));
              bool out = false;
              bool in = true;
              for (std::size_t k = 0; k < 2; ++k) {
                // The default band is wide enough for this; with a narrower one no block can be classified.
                const double sure = reach + slack[k];
                out = out || v[k] >= sure;
                in = in && v[k] <= -sure;
              }
              if (!out) mm3 += in ? edge * edge * edge : CalcInBlock(sample, p, cell);
            }
          }
        }
      }
    }
  }
  return mm3;
}

std::optional<Gap> CalcGap(const SurfaceWithTree& a, const Pose& X_WA, const SurfaceWithTree& b, const Pose& X_WB,
                           double limit_mm) {
  double min_mm = limit_mm;
  Vec3 p_A(0);
  Vec3 p_B(0);
  FindMinDistance(a, b, Compose(X_WB.Inverse(), X_WA), min_mm, p_A, p_B);
  FindMinDistance(b, a, Compose(X_WA.Inverse(), X_WB), min_mm, p_B, p_A);
  if (!(min_mm < limit_mm)) return {};
  return Gap{.gap_mm = min_mm, .p_WA_mm = X_WA.Point(p_A), .p_WB_mm = X_WB.Point(p_B)};
}

Facing CalcFacing(const SurfaceWithTree& a, const Pose& X_WA, const SurfaceWithTree& b, const Pose& X_WB,
                  double reach_mm, double contact_mm) {
  const Pose X_BA = Compose(X_WB.Inverse(), X_WA);
  const Box3& box = b.tree->bounds();
  std::vector<Vec3> normals;
  const std::vector<double> areas = CalcPointAreas(*a.mesh, normals);
  struct Part {
    double gap;
    double area;
  };
  std::vector<Part> parts;
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const Vec3 at = X_BA.Point(a.mesh->points[i]);
    if (glm::length(at - glm::clamp(at, box.lower, box.upper)) >= reach_mm) continue;
    const auto nearest = b.tree->FindNearest(at, reach_mm);
    if (!nearest) continue;
    const Vec3 n = X_BA.Vector(normals[i]);
    const Vec3 to_nearest = nearest->p - at;
    const bool faces = glm::dot(to_nearest, n) >= kFaces * glm::length(n) * glm::length(to_nearest);
    if (faces) parts.push_back({nearest->distance_mm, areas[i]});
  }
  Facing out;
  if (parts.empty()) return out;
  std::sort(parts.begin(), parts.end(), [](const Part& p, const Part& q) { return p.gap < q.gap; });
  for (const Part& p : parts) {
    out.area_mm2 += p.area;
    out.mean_mm += p.area * p.gap;
    if (p.gap < contact_mm) out.contact_mm2 += p.area;
  }
  if (out.area_mm2 > 0) out.mean_mm /= out.area_mm2;
  double sum = 0;
  for (const Part& p : parts) {
    sum += p.area;
    out.p95_mm = p.gap;
    if (sum >= 0.95 * out.area_mm2) break;
  }
  return out;
}

}  // namespace kerf
