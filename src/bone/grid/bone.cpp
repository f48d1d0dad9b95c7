#include "kerf/bone.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <glm/vector_relational.hpp>
#include <mutex>

#include "base/core/hash.h"
#include "bone/grid/cell_block.h"
#include "bone/grid/cell_volume.h"
#include "bone/grid/grids.h"
#include "bone/grid/parts_reader.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;
using RegionTree = openvdb::Int32Tree;

void InitializeOpenVdbOnce() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

std::vector<const FloatLeaf*> Leaves(const FloatTree& tree) {
  std::vector<const FloatLeaf*> leaves;
  tree.getNodes(leaves);
  return leaves;
}

/// Calls visit(cell, fraction) for the cells of a bone tile that are not entirely bone. A level set has no such cells,
/// because its tiles lie far from the surface, but a cut that ran out of memory ends at a tile.
template <typename Visit>
void ForEachCutCell(const PartsReader& reader, const openvdb::CoordBBox& tile, double voxel_mm, double band_mm,
                    Visit visit) {
  CellFields fields(voxel_mm, band_mm);
  const openvdb::Coord last = tile.max().offsetBy(-7);
  for (int x = tile.min().x(); x <= last.x(); x += 8) {
    for (int y = tile.min().y(); y <= last.y(); y += 8) {
      // Only the uppermost cells extend beyond the tile.
      const bool outermost = x == last.x() || y == last.y();
      for (int z = outermost ? tile.min().z() : last.z(); z <= last.z(); z += 8) {
        reader.Load(openvdb::Coord(x, y, z), fields);
        for (int i = 0; i < 512; ++i) {
          const openvdb::Coord cell(x + i / 64, y + i / 8 % 8, z + i % 8);
          const double fraction = fields.CalcFraction(i / 64, i / 8 % 8, i % 8);
          if (fraction < 1) visit(cell, fraction);
        }
      }
    }
  }
}

/// Cells in a row along an axis whose middles have the same nearest region voxel.
struct CellRun {
  int region_index, count;
};
std::vector<CellRun> FindRuns(int first, int last, double voxel_mm, double region_voxel_mm) {
  std::vector<CellRun> runs;
  for (int i = first; i <= last; ++i) {
    const int index = NearestIndex(voxel_mm * (i + 0.5), region_voxel_mm);
    if (runs.empty() || runs.back().region_index != index) runs.push_back({index, 0});
    ++runs.back().count;
  }
  return runs;
}

/// Adds the number of the cells of a tile to the sums of their regions.
template <typename Accessor>
void AddTileCells(const openvdb::CoordBBox& tile, double voxel_mm, double region_voxel_mm, const Accessor& regions,
                  std::array<double, 256>& sums) {
  std::array<std::vector<CellRun>, 3> runs;
  for (int a = 0; a < 3; ++a) {
    runs[static_cast<std::size_t>(a)] = FindRuns(tile.min()[a], tile.max()[a], voxel_mm, region_voxel_mm);
  }
  for (const CellRun& x : runs[0]) {
    for (const CellRun& y : runs[1]) {
      for (const CellRun& z : runs[2]) {
        const int id = regions.getValue({x.region_index, y.region_index, z.region_index});
        sums[static_cast<std::size_t>(std::clamp(id, 0, 255))] += static_cast<double>(x.count) * y.count * z.count;
      }
    }
  }
}

/// Calls visit(x, y, z, fraction) for the cells of a leaf that are at least partly bone, z fastest.
template <typename Visit>
void ForEachFraction(const CellFields& fields, Visit&& visit) {
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        if (const double fraction = fields.CalcFraction(x, y, z); fraction != 0) visit(x, y, z, fraction);
      }
    }
  }
}

/// The same for a leaf around which nothing was cut.
template <typename Visit>
void ForEachFraction(const CellBlock& phi, Visit&& visit) {
  constexpr int kEdge = CellBlock::kEdge;
  std::array<unsigned, kEdge * kEdge> inside;  // bit z of row kEdge x + y
  for (std::size_t row = 0; row < inside.size(); ++row) {
    const float* const values = phi.data() + kEdge * row;
    inside[row] = 0;
    for (int z = 0; z < kEdge; ++z) inside[row] |= (values[z] < 0 ? 1U : 0U) << z;
  }
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      const unsigned* const row = inside.data() + kEdge * x + y;
      const unsigned any = row[0] | row[1] | row[kEdge] | row[kEdge + 1];
      const unsigned all = row[0] & row[1] & row[kEdge] & row[kEdge + 1];
      const unsigned entirely = all & all >> 1;
      for (unsigned cells = (any | any >> 1) & 0xFFU; cells != 0; cells &= cells - 1) {
        const int z = std::countr_zero(cells);
        visit(x, y, z, (entirely >> z & 1U) != 0 ? 1 : CalcCellFraction(phi.Corners(x, y, z)));
      }
    }
  }
}

/// Returns the sums of the cells' fractions of bone over all leaves and tiles, by region if `by_region`; in units of
/// one cell.
std::array<double, 256> SumFractions(const BoneGrids& grids, bool by_region) {
  const FloatTree& tree = grids.phi->tree();
  const std::vector<const FloatLeaf*> leaves = Leaves(tree);
  const double h = grids.voxel_mm();
  const auto band = static_cast<double>(grids.phi->background());
  const double region_h = grids.region_voxel_mm();
  using Sums = std::array<double, 256>;
  const auto region_of = [&](const auto& accessor, const openvdb::Coord& ijk) {
    const Vec3 centre = h * (Vec3(ijk.x(), ijk.y(), ijk.z()) + 0.5);
    return static_cast<std::size_t>(std::clamp(accessor.getValue(NearestVoxel(centre, region_h)), 0, 255));
  };
  // Deterministic: the ranges are the same for any number of threads.
  Sums sums = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, leaves.size(), 64), Sums{},
      [&](const tbb::blocked_range<std::size_t>& range, Sums part) {
        const PartsReader reader(grids);
        openvdb::tree::ValueAccessor<const RegionTree> regions(grids.region->constTree());
        CellFields fields(h, band);
        CellBlock phi;
        for (std::size_t n = range.begin(); n < range.end(); ++n) {
          const openvdb::Coord origin = leaves[n]->origin();
          const auto add = [&](int x, int y, int z, double fraction) {
            part[by_region ? region_of(regions, origin.offsetBy(x, y, z)) : 0] += fraction;
          };
          if (reader.IsCutAround(origin)) {
            reader.Load(origin, fields);
            ForEachFraction(fields, add);
          } else {
            phi.Load(reader.phi(), origin);
            ForEachFraction(phi, add);
          }
        }
        return part;
      },
      [](Sums a, const Sums& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
        return a;
      });
  // A tile of the narrow-band level set is far from the surface: all or nearly all of its cells are entirely bone.
  const PartsReader reader(grids);
  openvdb::tree::ValueAccessor<const RegionTree> regions(grids.region->constTree());
  ForEachTileBox(tree, [&](const openvdb::CoordBBox& box, float value) {
    if (value >= 0) return;
    ForEachCutCell(reader, box, h, band, [&](const openvdb::Coord& cell, double fraction) {
      sums[by_region ? region_of(regions, cell) : 0] -= 1 - fraction;
    });
    if (!by_region) {
      sums[0] += static_cast<double>(box.volume());
      return;
    }
    AddTileCells(box, h, region_h, regions, sums);
  });
  return sums;
}

/// Returns the weighted mean of a property of the regions around a point; 0 if there are none.
template <typename OfRegion>
double InterpolateMaterial(const BoneGrids& grids, const Vec3& p_W, OfRegion of_region) {
  double sum = 0;
  double weights = 0;
  ForEachRegionAround(grids.region->constTree(), p_W / grids.region_voxel_mm(), [&](int id, double weight) {
    sum += weight * of_region(id);
    weights += weight;
  });
  return weights > 0 ? sum / weights : 0;
}

}  // namespace

openvdb::FloatGrid::Ptr MakePhiGrid(double voxel_mm, int band_voxels) {
  InitializeOpenVdbOnce();
  auto grid = openvdb::FloatGrid::create(static_cast<float>(band_voxels * voxel_mm));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel_mm));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("phi");
  return grid;
}

openvdb::Int32Grid::Ptr MakeRegionGrid(double voxel_mm) {
  InitializeOpenVdbOnce();
  auto grid = openvdb::Int32Grid::create(0);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel_mm));
  grid->setName("region");
  return grid;
}

void AddPartGrids(BoneGrids& grids) {
  const auto make = [&](const char* name) {
    openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(-grids.phi->background());
    grid->setTransform(grids.phi->transform().copy());
    grid->setName(name);
    return grid;
  };
  grids.whole = make("whole");
  grids.cut = make("cut");
}

openvdb::FloatGrid::Ptr MakeHuGrid(double voxel_mm) {
  InitializeOpenVdbOnce();
  auto grid = openvdb::FloatGrid::create(-1000.0f);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel_mm));
  grid->setName("hu");
  return grid;
}

Bone::Bone() : grids_(std::make_unique<Grids>()) {
  grids_->phi = MakePhiGrid(0.2);
  grids_->region = MakeRegionGrid(0.2);
}
Bone::~Bone() = default;
Bone::Bone(Bone&&) noexcept = default;
Bone& Bone::operator=(Bone&&) noexcept = default;

Bone::Bone(const Bone& other) : grids_(std::make_unique<Grids>(*other.grids_)) {
  // The other grids are shared: they are never changed in place.
  grids_->phi = other.grids_->phi->deepCopy();
  if (grids_->cut) {
    grids_->whole = other.grids_->whole->deepCopy();
    grids_->cut = other.grids_->cut->deepCopy();
  }
}

Bone& Bone::operator=(const Bone& other) {
  if (this != &other) *this = Bone(other);
  return *this;
}

double Bone::voxel_mm() const {
  return grids_->voxel_mm();
}
double Bone::region_voxel_mm() const {
  return grids_->region_voxel_mm();
}
double Bone::band_mm() const {
  return std::round(static_cast<double>(grids_->phi->background()) / voxel_mm()) * voxel_mm();
}
const MaterialTable& Bone::materials() const {
  return grids_->materials;
}
void Bone::set_materials(MaterialTable table) {
  grids_->materials = std::move(table);
  grids_->stored_materials.reset();
}
void Bone::OverrideMaterials(MaterialTable table) {
  if (!grids_->stored_materials) grids_->stored_materials = std::move(grids_->materials);
  grids_->materials = std::move(table);
}
bool Bone::has_hu() const {
  return grids_->hu != nullptr;
}
double Bone::hu_voxel_mm() const {
  return grids_->hu ? grids_->hu->voxelSize()[0] : 0;
}
const std::map<std::string, std::string>& Bone::notes() const {
  return grids_->notes;
}
void Bone::set_note(const std::string& key, const std::string& value) {
  grids_->notes[key] = value;
}

double Bone::SignedDistance(const Vec3& p_W) const {
  return PartsReader(*grids_).Sample(p_W / voxel_mm());
}

int Bone::RegionAt(const Vec3& p_W) const {
  return grids_->region->tree().getValue(NearestVoxel(p_W, region_voxel_mm()));
}

double Bone::ModulusAt(const Vec3& p_W) const {
  const auto& regions = grids_->materials.regions();
  const double by_ct = grids_->modulus ? SampleModulus(grids_->modulus->constTree(), p_W / hu_voxel_mm()) : 0;
  return InterpolateMaterial(*grids_, p_W, [&](int id) {
    if (by_ct > 0 && grids_->by_modulus[id]) return by_ct;
    const auto found = regions.find(id);
    return found == regions.end() ? 0 : found->second.E_MPa;
  });
}

double Bone::PoissonRatioAt(const Vec3& p_W) const {
  const auto& regions = grids_->materials.regions();
  return InterpolateMaterial(*grids_, p_W, [&](int id) {
    const auto found = regions.find(id);
    return found == regions.end() ? 0 : found->second.nu;
  });
}

bool Bone::empty() const {
  for (const FloatLeaf* leaf : Leaves(grids_->phi->tree())) {
    const float* values = leaf->buffer().data();
    if (std::any_of(values, values + FloatLeaf::SIZE, [](float v) { return v < 0; })) return false;
  }
  return true;
}

double Bone::CalcVolume() const {
  const double h = voxel_mm();
  return SumFractions(*grids_, false)[0] * h * h * h;
}

std::map<int, double> Bone::CalcRegionVolumes() const {
  const double h = voxel_mm();
  const std::array<double, 256> sums = SumFractions(*grids_, true);
  std::map<int, double> volumes;
  for (std::size_t id = 0; id < sums.size(); ++id) {
    if (sums[id] > 0) volumes[static_cast<int>(id)] = sums[id] * h * h * h;
  }
  return volumes;
}

Box3 Bone::CalcBounds() const {
  // The surface crosses the edges between an inside voxel and an outside neighbour. The outermost crossings bound it.
  const std::vector<const FloatLeaf*> leaves = Leaves(grids_->phi->tree());
  openvdb::tree::ValueAccessor<const FloatTree> accessor(grids_->phi->constTree());
  Box3 box_vox;
  const auto include = [&](const FloatLeaf& leaf) {
    const auto to_vec = [](const openvdb::Coord& ijk) { return Vec3(ijk.x(), ijk.y(), ijk.z()); };
    const Vec3 lowest = to_vec(leaf.origin().offsetBy(-1)), highest = to_vec(leaf.origin().offsetBy(FloatLeaf::DIM));
    if (glm::all(glm::lessThanEqual(box_vox.lower, lowest)) && glm::all(glm::lessThanEqual(highest, box_vox.upper))) {
      return;  // so are its crossings
    }
    for (auto it = leaf.cbeginValueOn(); it; ++it) {
      if (*it >= 0) continue;
      const openvdb::Coord ijk = it.getCoord();
      const double inside = static_cast<double>(*it);
      for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
          openvdb::Coord next = ijk;
          next[axis] += side;
          const double outside = static_cast<double>(accessor.getValue(next));
          if (outside < 0) continue;
          Vec3 p = to_vec(ijk);
          p[axis] += side * inside / (inside - outside);
          box_vox.Include(p);
        }
      }
    }
  };
  // A few leaves first, so that most others are within their box.
  constexpr std::size_t kStep = 16;
  for (std::size_t n = 0; n < leaves.size(); n += kStep) include(*leaves[n]);
  for (const FloatLeaf* leaf : leaves) include(*leaf);
  return {voxel_mm() * box_vox.lower, voxel_mm() * box_vox.upper};
}

std::uint64_t Bone::CountActiveVoxels() const {
  return grids_->phi->activeVoxelCount();
}

std::uint64_t Bone::CalcMemoryBytes() const {
  std::uint64_t bytes = grids_->phi->memUsage() + grids_->region->memUsage();
  for (const auto& grid : {grids_->hu, grids_->modulus, grids_->whole, grids_->cut})
    bytes += grid ? grid->memUsage() : 0;
  return bytes;
}

std::uint64_t Bone::CalcHash() const {
  const float band = grids_->phi->background();
  std::uint64_t hash = MixHash(std::bit_cast<std::uint64_t>(voxel_mm()));
  // The key of a voxel is MixHash(mix_xy(x, y) + mix_z(z)).
  const auto mix_xy = [](int x, int y) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) << 32 | static_cast<std::uint32_t>(y);
  };
  const auto mix_z = [](int z) { return MixHash(static_cast<std::uint32_t>(z)); };
  const auto key = [&](const openvdb::Coord& c) { return MixHash(mix_xy(c.x(), c.y()) + mix_z(c.z())); };
  // Returns the sum of hash_of(n, get_key) over the voxels n of a leaf.
  const auto sum_voxels = [&](const openvdb::Coord& origin, auto&& hash_of) {
    std::array<std::uint64_t, kLeafEdge> of_z;
    for (int z = 0; z < kLeafEdge; ++z) of_z[static_cast<std::size_t>(z)] = mix_z(origin.z() + z);
    std::uint64_t sum = 0;
    openvdb::Index n = 0;
    for (int x = 0; x < kLeafEdge; ++x) {
      for (int y = 0; y < kLeafEdge; ++y) {
        const std::uint64_t of_xy = mix_xy(origin.x() + x, origin.y() + y);
        for (const std::uint64_t z : of_z) sum += hash_of(n++, [=] { return MixHash(of_xy + z); });
      }
    }
    return sum;
  };
  // A sum, which does not depend on the order.
  const auto add_leaves = [&hash](const auto& leaves, auto&& hash_of) {
    hash += tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, leaves.size(), 256), std::uint64_t{0},
        [&](const tbb::blocked_range<std::size_t>& range, std::uint64_t sum) {
          for (std::size_t n = range.begin(); n < range.end(); ++n) sum += hash_of(*leaves[n]);
          return sum;
        },
        std::plus<>());
  };
  add_leaves(Leaves(grids_->phi->tree()), [&](const FloatLeaf& leaf) {
    const float* const values = leaf.buffer().data();
    return sum_voxels(leaf.origin(), [&](openvdb::Index n, auto&& get_key) -> std::uint64_t {
      if (std::abs(values[n]) >= band) return 0;
      const float value = values[n] + 0.0f;  // -0 and +0 are the same surface
      return MixHash(get_key() ^ std::bit_cast<std::uint32_t>(value));
    });
  });
  const auto hash_region = [&key](const openvdb::CoordBBox& box, int id) {
    return MixHash(key(box.min()) + 3 * key(box.max()) + static_cast<std::uint64_t>(id));
  };
  using RegionLeaf = openvdb::Int32Tree::LeafNodeType;
  std::vector<const RegionLeaf*> region_leaves;
  grids_->region->tree().getNodes(region_leaves);
  add_leaves(region_leaves, [&](const RegionLeaf& leaf) {
    const int* const ids = leaf.buffer().data();
    return sum_voxels(leaf.origin(), [&](openvdb::Index n, auto&& get_key) -> std::uint64_t {
      return leaf.isValueOn(n) ? MixHash(4 * get_key() + static_cast<std::uint64_t>(ids[n])) : 0;
    });
  });
  auto tile = grids_->region->tree().cbeginValueOn();
  tile.setMaxDepth(openvdb::Int32Tree::ValueOnCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    hash += hash_region(box, *tile);
  }
  return hash;
}

std::uint64_t Bone::CalcMaterialHash() const {
  std::uint64_t hash = 0;
  const auto mix = [&hash](double x) { hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(x)); };
  for (const auto& [id, region] : grids_->materials.regions()) {
    mix(id);
    mix(region.E_MPa);
    mix(region.nu);
    mix(grids_->by_modulus[static_cast<std::size_t>(id)] ? 1 : 0);
  }
  if (grids_->modulus == nullptr) return hash;
  for (auto it = grids_->modulus->tree().cbeginValueOn(); it; ++it) mix(static_cast<double>(*it));
  return hash;
}

}  // namespace kerf
