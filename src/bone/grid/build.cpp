#include "bone/grid/build.h"

#include <fmt/format.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/Prune.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "base/core/byte_text.h"
#include "bone/grid/build_progress.h"
#include "bone/grid/build_times.h"
#include "bone/grid/fill_voids.h"
#include "bone/grid/grids.h"
#include "bone/grid/solid_regions.h"
#include "bone/grid/solve_distances.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

constexpr int kCoarseEdge = 64;                  // edge of the blocks that are classified first, before leaf-sized ones
constexpr float kOutsideValue = 1;               // of a field of which only the sign counts
constexpr double kMaxBoxVoxels = 68719476736.0;  // 2^36
constexpr double kMaxIndex = 1 << 30;            // of a voxel
constexpr double kMaxMeshIndex = 1 << 17;        // a float still resolves a hundredth of a voxel here

/// Returns half the diagonal of a block of `edge` voxels, between the centres of its corner voxels, plus the band
/// around it.
double BallRadius(int edge, double h, int band_voxels) {
  return 0.5 * std::sqrt(3.0) * (edge - 1) * h + (band_voxels + 1) * h;
}

Vec3 BlockCentre(const Coord& origin, int edge, double h) {
  return h * (Vec3(origin.x(), origin.y(), origin.z()) + 0.5 * (edge - 1));
}

struct Blocks {
  std::vector<Coord> inside;  // leaf-sized
  std::vector<Coord> mixed;
};

// Maximum memory per block while a bone is made, bytes. An inside block needs an entry in the lists; a mixed block
// needs a leaf of the level set, one of the regions, and another one while a distance is computed. Measured with blocks
// of 60 to 240 mm at 0.2 mm voxels.
constexpr double kBytesOfInside = 100;
constexpr double kBytesOfMixed = 7000;

[[noreturn]] void RefuseMemory(double bytes, const BuildOptions& options) {
  const auto [needed, there] = FormatBytePair(bytes, options.max_bytes);
  throw Error(fmt::format(
      "a bone of this size with voxels of {:.3g} mm needs more than {} of memory and {} are free; use larger voxels",
      options.voxel_mm, needed, there));
}

/// Returns a function that reports the progress of a part as progress of the whole, from `from` to `to`.
std::function<void(double)> PartOf(const std::function<void(double)>& progress, double from, double to) {
  if (!progress) return {};
  return [&progress, from, to](double fraction) { progress(from + (to - from) * fraction); };
}

/// `sorted`: progress at the end.
Blocks SortBlocks(const SolidField& solid, const Box3& box, const BuildOptions& options, double sorted) {
  const double h = options.voxel_mm;
  const int band_voxels = options.band_voxels;
  const Coord first = FloorToBlock(box.lower / h, kCoarseEdge);
  const Coord last = FloorToBlock(box.upper / h, kCoarseEdge);
  std::vector<Coord> coarse;
  const double halves = solid.has_mirror() ? 2 : 1;
  for (int x = solid.has_mirror() ? 0 : first.x(); x <= last.x(); x += kCoarseEdge) {
    for (int y = first.y(); y <= last.y(); y += kCoarseEdge) {
      for (int z = first.z(); z <= last.z(); z += kCoarseEdge) coarse.emplace_back(x, y, z);
    }
  }
  std::vector<Blocks> found(coarse.size());
  std::atomic<double> bytes{0};
  Progress progress(options.progress, 0, sorted, coarse.size());
  tbb::parallel_for(std::size_t{0}, coarse.size(), [&](std::size_t n) {
    progress.Done(1);
    const BlockClass whole =
        solid.classify(BlockCentre(coarse[n], kCoarseEdge, h), BallRadius(kCoarseEdge, h, band_voxels));
    if (whole == BlockClass::kOutside) return;
    for (int x = 0; x < kCoarseEdge; x += kLeafEdge) {
      for (int y = 0; y < kCoarseEdge; y += kLeafEdge) {
        for (int z = 0; z < kCoarseEdge; z += kLeafEdge) {
          const Coord origin = coarse[n].offsetBy(x, y, z);
          const BlockClass part = whole == BlockClass::kInside ? whole
                                                               : solid.classify(BlockCentre(origin, kLeafEdge, h),
                                                                                BallRadius(kLeafEdge, h, band_voxels));
          if (part == BlockClass::kInside) found[n].inside.push_back(origin);
          if (part == BlockClass::kMixed) found[n].mixed.push_back(origin);
        }
      }
    }
    const double here = kBytesOfInside * static_cast<double>(found[n].inside.size()) +
                        kBytesOfMixed * static_cast<double>(found[n].mixed.size());
    if (const double now = halves * (bytes.fetch_add(here) + here); now > options.max_bytes) RefuseMemory(now, options);
  });
  Blocks all;
  for (const Blocks& part : found) {
    all.inside.insert(all.inside.end(), part.inside.begin(), part.inside.end());
    all.mixed.insert(all.mixed.end(), part.mixed.begin(), part.mixed.end());
  }
  return all;
}

/// Evaluates a field at the voxels of a leaf, part by part. In a part that is certainly inside or outside, with the
/// voxels beside it, only the sign is set, because a field that is not a distance counts only near its zero level.
class LeafEvaluation {
 public:
  LeafEvaluation(const SolidField& solid, double h, FloatLeaf& leaf) : solid_(solid), h_(h), leaf_(leaf) {}

  void Run() {
    if (!solid_.leaf_values) {
      Evaluate({0, 0, 0}, kLeafEdge);
      return;
    }
    const Coord& first = leaf_.origin();
    LeafValues values;
    solid_.leaf_values({{first.x(), first.y(), first.z()}, h_}, values);
    std::copy(values.begin(), values.end(), leaf_.buffer().data());
  }

 private:
  void Evaluate(const Coord& first, int edge) {
    if (edge > 1 && edge < kLeafEdge && !solid_.is_distance) {
      // To the farthest of the voxels and their neighbours, and some more, because a field may be a little steeper than
      // the one who classifies it knows: an interpolated level set is.
      const double along = 0.5 * (edge - 1) + 1, across = 0.5 * (edge - 1);
      const double radius_mm = h_ * (std::sqrt(along * along + 2 * across * across) + kSlackVoxels);
      const BlockClass whole = solid_.classify(BlockCentre(leaf_.origin() + first, edge, h_), radius_mm);
      if (whole != BlockClass::kMixed) {
        const float value = whole == BlockClass::kInside ? -kOutsideValue : kOutsideValue;
        ForEach(first, edge, 1, [&](const Coord& ijk) { leaf_.setValueOnly(FloatLeaf::coordToOffset(ijk), value); });
        return;
      }
    }
    if (edge > kLeastPart && !solid_.is_distance) {
      ForEach(first, edge, edge / 2, [&](const Coord& part) { Evaluate(part, edge / 2); });
      return;
    }
    ForEach(first, edge, 1, [&](const Coord& local) {
      const Coord ijk = leaf_.origin() + local;
      const double value = solid_.value(h_ * Vec3(ijk.x(), ijk.y(), ijk.z()));
      leaf_.setValueOnly(FloatLeaf::coordToOffset(local), static_cast<float>(value));
    });
  }
  template <typename Visit>
  static void ForEach(const Coord& first, int edge, int step, Visit&& visit) {
    for (int x = 0; x < edge; x += step) {
      for (int y = 0; y < edge; y += step) {
        for (int z = 0; z < edge; z += step) visit(first.offsetBy(x, y, z));
      }
    }
  }

  static constexpr int kLeastPart = 2;
  static constexpr double kSlackVoxels = 0.5;

  const SolidField& solid_;
  double h_;
  FloatLeaf& leaf_;
};

/// Evaluates the field at the voxels of a block, all of which are active.
std::unique_ptr<FloatLeaf> EvaluateBlock(const SolidField& solid, const Coord& block, double h) {
  auto leaf = std::make_unique<FloatLeaf>(block, 0.0f, true);
  if (solid.near) {
    const SolidField near = solid.near(BlockCentre(block, kLeafEdge, h), BallRadius(kLeafEdge, h, 0));
    LeafEvaluation(near, h, *leaf).Run();
  } else {
    LeafEvaluation(solid, h, *leaf).Run();
  }
  return leaf;
}

void AddInsideTiles(FloatTree& tree, const std::vector<Coord>& blocks, float value) {
  for (const Coord& origin : blocks) tree.addTile(1, origin, value, false);
}

/// Evaluates a distance in the mixed blocks.
void EvaluateDistance(const SolidField& solid, const std::vector<Coord>& blocks, double h, Progress& progress,
                      FloatTree& tree) {
  std::vector<std::unique_ptr<FloatLeaf>> leaves(blocks.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 16), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n, progress.Done(1)) {
      leaves[n] = EvaluateBlock(solid, blocks[n], h);
    }
  });
  for (auto& leaf : leaves) tree.addLeaf(leaf.release());
}

bool HasOneSign(const FloatLeaf& leaf) {
  const float* const values = leaf.buffer().data();
  return std::all_of(values, values + FloatLeaf::SIZE,
                     [first = values[0]](float value) { return (value < 0) == (first < 0); });
}

/// Evaluates a field of which only the sign and the zero level count. Only blocks with a change of sign, and those
/// around them, become leaves of `field`; the others become tiles if they are inside, and are added to `blocks.inside`.
void EvaluateField(const SolidField& solid, Blocks& blocks, double h, Progress& progress, FloatTree& field) {
  const std::vector<Coord>& mixed = blocks.mixed;
  std::vector<std::unique_ptr<FloatLeaf>> leaves(mixed.size());
  std::vector<std::uint8_t> is_inside(mixed.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mixed.size(), 16), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n, progress.Done(1)) {
      auto leaf = EvaluateBlock(solid, mixed[n], h);
      is_inside[n] = leaf->getValue(0) < 0 ? 1 : 0;
      if (!HasOneSign(*leaf)) leaves[n] = std::move(leaf);
    }
  });
  AddInsideTiles(field, blocks.inside, -kOutsideValue);
  std::vector<std::size_t> uniform;
  for (std::size_t n = 0; n < mixed.size(); ++n) {
    if (leaves[n]) {
      field.addLeaf(leaves[n].release());
      continue;
    }
    uniform.push_back(n);
    if (is_inside[n] != 0) field.addTile(1, mixed[n], -kOutsideValue, false);
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, uniform.size(), 64), [&](const auto& range) {
    const openvdb::tree::ValueAccessor<const FloatTree> around(field);
    for (std::size_t u = range.begin(); u < range.end(); ++u) {
      const std::size_t n = uniform[u];
      for (int side = 0; side < 27; ++side) {
        const Coord beside =
            mixed[n].offsetBy(kLeafEdge * (side / 9 - 1), kLeafEdge * (side / 3 % 3 - 1), kLeafEdge * (side % 3 - 1));
        if (solid.has_mirror() && beside.x() < 0) continue;  // mirrors blocks that are looked at
        if (around.probeConstLeaf(beside) == nullptr && (around.getValue(beside) < 0) == (is_inside[n] != 0)) continue;
        leaves[n] = EvaluateBlock(solid, mixed[n], h);
        break;
      }
    }
  });
  for (const std::size_t n : uniform) {
    if (leaves[n]) {
      field.addLeaf(leaves[n].release());
    } else if (is_inside[n] != 0) {
      blocks.inside.push_back(mixed[n]);
    }
  }
}

/// Adds to a field, and to its inside blocks, the half with x < 0, of which nothing is there yet: the other one
/// mirrored. As EvaluateField() makes it, the field has leaves on both sides of each change of sign.
void AddMirroredHalf(FloatTree& field, std::vector<Coord>& inside) {
  std::vector<Coord> blocks;
  for (auto leaf = field.cbeginLeaf(); leaf; ++leaf) {
    // Its voxel 0 lies at -x in one block, the others in the block before.
    const Coord& first = leaf->origin();
    blocks.emplace_back(-first.x() - kLeafEdge, first.y(), first.z());
    if (first.x() > 0) blocks.emplace_back(-first.x(), first.y(), first.z());
  }
  std::sort(blocks.begin(), blocks.end());
  blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
  std::vector<std::unique_ptr<FloatLeaf>> leaves(blocks.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 64), [&](const auto& range) {
    const openvdb::tree::ValueAccessor<const FloatTree> other(field);
    constexpr int kLayer = kLeafEdge * kLeafEdge;
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      leaves[n] = std::make_unique<FloatLeaf>(blocks[n], 0.0f, true);
      for (int x = 0; x < kLeafEdge; ++x) {
        const Coord from(-blocks[n].x() - x, blocks[n].y(), blocks[n].z());
        float* const to = leaves[n]->buffer().data() + x * kLayer;
        if (const FloatLeaf* const leaf = other.probeConstLeaf(from)) {
          std::copy_n(leaf->buffer().data() + (from.x() - leaf->origin().x()) * kLayer, kLayer, to);
        } else {
          std::fill_n(to, kLayer, other.getValue(from));
        }
      }
    }
  });
  for (auto& leaf : leaves) field.addLeaf(leaf.release());
  std::vector<Coord> mirrored;
  for (const Coord& block : inside) {
    const Coord place(-block.x() - kLeafEdge, block.y(), block.z());
    if (!std::binary_search(blocks.begin(), blocks.end(), place)) mirrored.push_back(place);
  }
  AddInsideTiles(field, mirrored, -kOutsideValue);
  inside.insert(inside.end(), mirrored.begin(), mirrored.end());
}

void CheckBox(const Box3& box, const BuildOptions& options) {
  const double voxel_mm = options.voxel_mm;
  CheckParameters(options, "bone");
  const Vec3 count = box.size() / voxel_mm;
  if (!(count.x * count.y * count.z <= kMaxBoxVoxels)) {
    throw Error(
        fmt::format("{:.0f} x {:.0f} x {:.0f} mm at {:.3g} mm voxels is more than 2^36 voxels; use larger voxels",
                    box.size().x, box.size().y, box.size().z, voxel_mm));
  }
  const Vec3 furthest = glm::max(glm::abs(box.lower), glm::abs(box.upper));
  const double max_vox = std::max({furthest.x, furthest.y, furthest.z}) / voxel_mm;
  if (!IsInWorld(box.centre()) || !(max_vox < kMaxIndex)) {
    throw Error(fmt::format("the bone extends more than {} mm from the world's origin", kWorldReach_mm));
  }
}

/// Returns the area of a mesh, mm^2. Throws kerf::Error unless it is closed and within range.
double CheckMesh(const TriangleMesh& mesh, const BuildOptions& options) {
  if (const std::size_t open_edges = CountOpenEdges(mesh); open_edges != 0) {
    throw Error(
        fmt::format("the surface is not closed: {} of its edges do not join exactly two triangles", open_edges));
  }
  Box3 box;
  for (const Vec3& p : mesh.points) box.Include(p);
  CheckBox(box, options);
  double area_mm2 = 0;
  for (const auto& t : mesh.triangles) {
    area_mm2 +=
        0.5 * glm::length(glm::cross(mesh.points[t[1]] - mesh.points[t[0]], mesh.points[t[2]] - mesh.points[t[0]]));
  }
  return area_mm2;
}

/// Crossings of a closed surface with the lines of voxels along z. Points are in voxels.
class ColumnCrossings {
 public:
  explicit ColumnCrossings(const TriangleMesh& mesh, double voxel_mm) {
    Box3 box;
    for (const Vec3& p : mesh.points) box.Include(p / voxel_mm);
    for (int a = 0; a < 2; ++a) {
      first_[a] = static_cast<int>(std::floor(box.lower[a]));
      size_[a] = static_cast<std::size_t>(std::ceil(box.upper[a]) - first_[a]) + 1;
    }
    begin_.assign(size_[0] * size_[1] + 1, 0);
    for (const bool counts : {true, false}) {
      for (const auto& t : mesh.triangles) {
        ForColumns(mesh, voxel_mm, t, [&](std::size_t column, double z, int sign) {
          if (counts) {
            ++begin_[column + 1];
          } else {
            crossings_[next_[column]++] = {static_cast<float>(z), sign};
          }
        });
      }
      if (!counts) break;
      for (std::size_t n = 1; n < begin_.size(); ++n) begin_[n] += begin_[n - 1];
      crossings_.resize(begin_.back());
      next_ = begin_;
    }
    for (std::size_t n = 0; n + 1 < begin_.size(); ++n) {
      std::sort(crossings_.begin() + static_cast<std::ptrdiff_t>(begin_[n]),
                crossings_.begin() + static_cast<std::ptrdiff_t>(begin_[n + 1]),
                [](const Crossing& a, const Crossing& b) { return a.z < b.z; });
    }
  }
  /// Returns the length of the columns that are outside by their crossings and inside by `grid`, in voxels.
  double CountClosedVoxels(const openvdb::FloatGrid& grid) const {
    const auto values = grid.getConstAccessor();
    double closed = 0;
    for (std::size_t column = 0; column + 1 < begin_.size(); ++column) {
      int turns = 0;
      for (std::size_t n = begin_[column]; n + 1 < begin_[column + 1]; ++n) {
        turns += crossings_[n].sign;
        const auto from = static_cast<double>(crossings_[n].z), to = static_cast<double>(crossings_[n + 1].z);
        if (turns != 0 || to - from < 2) continue;
        const Coord middle(first_[0] + static_cast<int>(column / size_[1]),
                           first_[1] + static_cast<int>(column % size_[1]),
                           static_cast<int>(std::floor((from + to) / 2)));
        if (values.getValue(middle) < 0) closed += to - from;
      }
    }
    return closed;
  }
  /// Returns how often the surface winds around a voxel: 0 outside.
  int CountTurns(const Coord& ijk) const {
    const int x = ijk.x() - first_[0], y = ijk.y() - first_[1];
    if (x < 0 || y < 0 || static_cast<std::size_t>(x) >= size_[0] || static_cast<std::size_t>(y) >= size_[1]) return 0;
    const std::size_t column = static_cast<std::size_t>(x) * size_[1] + static_cast<std::size_t>(y);
    int turns = 0;
    for (std::size_t n = begin_[column]; n < begin_[column + 1]; ++n) {
      if (static_cast<double>(crossings_[n].z) < ijk.z()) turns += crossings_[n].sign;
    }
    return turns;
  }

 private:
  struct Crossing {
    float z;
    int sign;
  };

  /// Returns on which side of the line from a to b the column lies, 1 or -1; 0 if the line is a point. A column on the
  /// line counts as moved a little along x, and less along y, so that it lies in one of the triangles beside it.
  static int FindSide(const Vec3& a, const Vec3& b, double x, double y, double& twice_area) {
    twice_area = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    for (const double side : {twice_area, a.y - b.y, b.x - a.x}) {
      if (side != 0) return side > 0 ? 1 : -1;
    }
    return 0;
  }

  template <typename Visit>
  void ForColumns(const TriangleMesh& mesh, double voxel_mm, const std::array<std::uint32_t, 3>& t,
                  Visit&& visit) const {
    const std::array<Vec3, 3> p = {mesh.points[t[0]] / voxel_mm, mesh.points[t[1]] / voxel_mm,
                                   mesh.points[t[2]] / voxel_mm};
    const auto [x0, x1] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    for (int x = static_cast<int>(std::floor(x0)); x <= static_cast<int>(std::ceil(x1)); ++x) {
      for (int y = static_cast<int>(std::floor(y0)); y <= static_cast<int>(std::ceil(y1)); ++y) {
        int sides = 0;
        double sum = 0, z = 0;
        for (std::size_t e = 0; e < 3; ++e) {
          const std::size_t b = (e + 1) % 3;
          const bool swapped = t[e] > t[b];  // the two triangles of an edge compute the same
          double area = 0;
          const int side = FindSide(p[swapped ? b : e], p[swapped ? e : b], x, y, area);
          sides += swapped ? -side : side;
          sum += swapped ? -area : area;
          z += (swapped ? -area : area) * p[(e + 2) % 3].z;
        }
        if (std::abs(sides) != 3) continue;
        const double at = sum != 0 ? z / sum : (p[0].z + p[1].z + p[2].z) / 3;
        visit(static_cast<std::size_t>(x - first_[0]) * size_[1] + static_cast<std::size_t>(y - first_[1]), at,
              sides > 0 ? -1 : 1);
      }
    }
  }

  std::array<int, 2> first_{};
  std::array<std::size_t, 2> size_{};
  std::vector<std::size_t> begin_, next_;  // of each column
  std::vector<Crossing> crossings_;
};

/// Returns the volume that a closed surface encloses, as a level set.
openvdb::FloatGrid::Ptr Voxelise(const TriangleMesh& mesh, const BuildOptions& options,
                                 const openvdb::math::Transform& transform) {
  std::vector<openvdb::Vec3s> points(mesh.points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p_vox = mesh.points[i] / options.voxel_mm;
    if (const double farthest = std::max({std::abs(p_vox.x), std::abs(p_vox.y), std::abs(p_vox.z)});
        !(farthest <= kMaxMeshIndex)) {
      throw Error(
          fmt::format("the surface reaches {:.0f} mm from the world's origin; with voxels of {:.3g} mm it may "
                      "reach at most {:.0f} mm: move it closer",
                      farthest * options.voxel_mm, options.voxel_mm, kMaxMeshIndex * options.voxel_mm));
    }
    points[i] = openvdb::Vec3s(static_cast<float>(p_vox.x), static_cast<float>(p_vox.y), static_cast<float>(p_vox.z));
  }
  std::vector<openvdb::Vec3I> triangles(mesh.triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    triangles[i] = openvdb::Vec3I(t[0], t[1], t[2]);
  }
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3s, openvdb::Vec3I> adapter(points, triangles);
  // The adapter's points are in index space; distances are in world units.
  auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      adapter, transform, static_cast<float>(options.band_voxels), static_cast<float>(options.band_voxels));
  // OpenVDB finds the outside by a flood. It does not pass a mouth that is narrower than a voxel, and what lies behind
  // it is taken for inside. Then the sign is found by counting, for which all distances are needed.
  constexpr double kLeastPocket_mm3 = 0.05;
  const ColumnCrossings crossings(mesh, options.voxel_mm);
  const double closed_vox = crossings.CountClosedVoxels(*grid);
  if (closed_vox * std::pow(options.voxel_mm, 3) < kLeastPocket_mm3) return grid;
  grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(adapter, transform, static_cast<float>(options.band_voxels),
                                                          static_cast<float>(options.band_voxels),
                                                          openvdb::tools::UNSIGNED_DISTANCE_FIELD);
  openvdb::tree::LeafManager<FloatTree> leaves(grid->tree());
  leaves.foreach ([&crossings](FloatLeaf& leaf, std::size_t) {
    for (auto voxel = leaf.beginValueOn(); voxel; ++voxel) {
      if (crossings.CountTurns(voxel.getCoord()) != 0) voxel.setValue(-*voxel);
    }
  });
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

/// Replaces the leaves without active voxels, each of which has one sign, by tiles. Adds those that are inside to
/// `inside`.
void DropInactiveLeaves(FloatTree& field, std::vector<Coord>& inside) {
  std::vector<std::pair<Coord, float>> dropped;
  for (auto leaf = field.cbeginLeaf(); leaf; ++leaf) {
    if (leaf->isEmpty()) dropped.emplace_back(leaf->origin(), leaf->getValue(0) < 0 ? -kOutsideValue : kOutsideValue);
  }
  for (const auto& [origin, value] : dropped) {
    field.addTile(1, origin, value, false);
    if (value < 0) inside.push_back(origin);
  }
}

}  // namespace

void FinishLevelSet(openvdb::FloatGrid& grid) {
  const float band = grid.background();
  openvdb::tree::LeafManager<FloatTree> leaves(grid.tree());
  leaves.foreach ([band](FloatLeaf& leaf, std::size_t) {
    for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
      const float value = std::clamp(leaf.getValue(i), -band, band);
      leaf.setValueOnly(i, value);
      leaf.setActiveState(i, std::abs(value) < band);
    }
  });
  openvdb::tools::pruneLevelSet(grid.tree(), band, -band);
}

std::function<BlockClass(const Vec3&, double)> ClassifyByDistance(std::function<double(const Vec3&)> value) {
  return [value = std::move(value)](const Vec3& centre, double radius_mm) {
    const double d = value(centre);
    if (d > radius_mm) return BlockClass::kOutside;
    return d < -radius_mm ? BlockClass::kInside : BlockClass::kMixed;
  };
}

BuildTimes EstimateBuildTimes(double voxel_mm, double region_voxel_mm, bool by_leaves) {
  const double finer = 0.2 / voxel_mm;
  // Between the number of voxels in the bone (power 3) and near its surface (power 2).
  return {.values_s = by_leaves ? 0.17 * std::pow(finer, 2.5) : 2.7 * std::pow(finer, 2.7),
          .voids_s = 0.34 * std::pow(finer, 2.2),
          .distances_s = 0.75 * std::pow(finer, 2.0),
          .regions_s = 2.3 * std::pow(0.2 / region_voxel_mm, 2.6)};
}

namespace {

/// Progress at the end of the parts of MakeBone(), 0 to 1.
struct BuildMarks {
  double sorted = 0.05;
  double evaluated = 0.7;
  double filled = 0.71;
  double solved = 0.75;
};

BuildMarks MakeMarks(const SolidField& solid, const BuildOptions& options) {
  BuildMarks marks;
  if (solid.is_distance) return marks;
  const BuildTimes times = EstimateBuildTimes(options.voxel_mm, options.region_voxel_mm, solid.leaf_values != nullptr);
  marks.sorted = 0.02;
  marks.evaluated = marks.sorted + (1 - marks.sorted) * times.values_s / times.total_s();
  marks.filled = marks.evaluated + (1 - marks.sorted) * times.voids_s / times.total_s();
  marks.solved = marks.filled + (1 - marks.sorted) * times.distances_s / times.total_s();
  return marks;
}

}  // namespace

Bone MakeBone(const SolidField& solid, const Box3& box, const BuildOptions& options, MaterialTable materials) {
  const double h = options.voxel_mm;
  const BuildMarks marks = MakeMarks(solid, options);
  const auto report = [&options](double fraction) {
    if (options.progress) options.progress(fraction);
  };
  CheckBox(box, options);
  Bone bone;
  BoneGrids& grids = GridsOf(bone);
  grids.phi = MakePhiGrid(h, options.band_voxels);
  grids.materials = std::move(materials);

  Blocks blocks = SortBlocks(solid, box, options, marks.sorted);
  report(marks.sorted);
  Progress progress(options.progress, marks.sorted, marks.evaluated, blocks.mixed.size());
  const float band = grids.phi->background();
  if (solid.is_distance) {
    EvaluateDistance(solid, blocks.mixed, h, progress, grids.phi->tree());
    AddInsideTiles(grids.phi->tree(), blocks.inside, -band);
  } else {
    // Only the sign and the zero level of the field are used; its magnitude is arbitrary.
    FloatTree field(kOutsideValue);
    EvaluateField(solid, blocks, h, progress, field);
    if (solid.has_mirror()) AddMirroredHalf(field, blocks.inside);
    report(marks.evaluated);
    if (options.fill_voids != nullptr) *options.fill_voids = FillVoids(field, h, blocks.inside);
    // The cost of solving is proportional to the number of active voxels, and most of a mixed block is beyond the band.
    // A voxel in the band gets its distance only from voxels that are nearer to the surface.
    KeepNearSurface(field, options.band_voxels + 1);
    DropInactiveLeaves(field, blocks.inside);
    report(marks.filled);
    if (!SolveDistances(field, static_cast<float>(h)))
      throw Error("the bone is empty: no point within the box is inside it");
    std::vector<FloatLeaf*> solved;
    field.stealNodes(solved);
    FloatTree& tree = grids.phi->tree();
    for (FloatLeaf* leaf : solved) tree.addLeaf(leaf);
    AddInsideTiles(tree, blocks.inside, -band);
  }
  FinishLevelSet(*grids.phi);
  if (bone.empty()) throw Error("the bone is empty: no point within the box is inside it");
  report(marks.solved);
  const auto region_report = PartOf(options.progress, marks.solved, 1);
  if (solid.leaf_regions) {
    SetSolidRegions(bone, solid, options.region_voxel_mm, region_report);
  } else {
    SetRegions(bone, solid.region, options.region_voxel_mm, region_report);
  }
  report(1);
  return bone;
}

Bone MakeBoneFromMesh(std::span<const TriangleMesh> layers, const std::function<int(const Vec3&)>& region,
                      const BuildOptions& options, MaterialTable materials) {
  if (layers.empty() || layers.front().triangles.empty()) throw Error("the surface has no triangles");
  double area_mm2 = 0;
  for (const TriangleMesh& mesh : layers) area_mm2 += CheckMesh(mesh, options);
  // A plane with its band passes through at most three leaves for each of its leaf-sized squares.
  const double leaf_mm = kLeafEdge * options.voxel_mm;
  const double bytes = kBytesOfMixed * 3 * area_mm2 / (leaf_mm * leaf_mm);
  if (bytes > options.max_bytes) RefuseMemory(bytes, options);
  Bone bone;
  BoneGrids& grids = GridsOf(bone);
  grids.phi = MakePhiGrid(options.voxel_mm, options.band_voxels);
  grids.materials = std::move(materials);
  const auto grid = Voxelise(layers.front(), options, grids.phi->transform());
  for (std::size_t n = 1; n < layers.size(); ++n) {
    const auto layer = Voxelise(layers[n], options, grids.phi->transform());
    if (n % 2 == 1) {
      openvdb::tools::csgDifference(*grid, *layer);
    } else {
      openvdb::tools::csgUnion(*grid, *layer);
    }
  }
  grids.phi->setTree(grid->treePtr());
  FinishLevelSet(*grids.phi);
  if (bone.empty()) throw Error("the surface encloses nothing at this voxel size");
  if (options.progress) options.progress(0.75);
  SetRegions(bone, region, options.region_voxel_mm, PartOf(options.progress, 0.75, 1));
  if (options.progress) options.progress(1.0);
  return bone;
}

Bone MakeBoneFromMesh(const TriangleMesh& mesh, const std::function<int(const Vec3&)>& region,
                      const BuildOptions& options, MaterialTable materials) {
  return MakeBoneFromMesh(std::span(&mesh, 1), region, options, std::move(materials));
}

void RoundDistances(Bone& bone, int precision_bits) {
  if (precision_bits >= 24) return;
  // Veltkamp's splitting, as in removal.
  const float splitter = static_cast<float>(1 << (24 - precision_bits)) + 1;
  const BoneGrids& grids = GridsOf(bone);
  for (const openvdb::FloatGrid::Ptr& grid : {grids.phi, grids.whole, grids.cut}) {
    if (!grid) continue;
    openvdb::tree::LeafManager<FloatTree> leaves(grid->tree());
    leaves.foreach ([splitter](FloatLeaf& leaf, std::size_t) {
      for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
        const float value = leaf.getValue(i);
        const float split = value * splitter;
        leaf.setValueOnly(i, split - (split - value));
      }
    });
  }
}

}  // namespace kerf
