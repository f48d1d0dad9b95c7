#include "bone/grid/field.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "bone/grid/cell_fields.h"
#include "bone/grid/grids.h"
#include "bone/grid/leaf_history.h"
#include "bone/grid/lent_leaves.h"
#include "bone/grid/spare_leaves.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

constexpr int kOriginLeaves = 1 << 14;  // the origin of frame F is a multiple of this number of leaves

using kerf::OriginOf;
Coord OriginOf(const LeafIndex& leaf) {
  return OriginOf(std::array{leaf.x, leaf.y, leaf.z});
}
LeafIndex LeafAt(const Coord& ijk) {
  return {ijk.x() >> 3, ijk.y() >> 3, ijk.z() >> 3};
}

/// Calls visit(first leaf, last leaf, value) for each tile whose value is not the background.
template <typename Tree, typename Visit>
void ForEachTile(const Tree& tree, Visit visit) {
  ForEachTileBox(
      tree, [&](const openvdb::CoordBBox& box, auto value) { visit(LeafAt(box.min()), LeafAt(box.max()), value); });
}

template <typename Visit>
void ForEachLeafBetween(const LeafIndex& first, const LeafIndex& last, Visit visit) {
  for (int x = first.x; x <= last.x; ++x) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int z = first.z; z <= last.z; ++z) visit(LeafIndex{x, y, z});
    }
  }
}

LeafIndex operator+(const LeafIndex& a, const LeafIndex& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
LeafIndex operator-(const LeafIndex& a, const LeafIndex& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

/// Returns the first and the last leaf of the box around all leaves of a tree that are not background; {0, 0, 0} and
/// {-1, -1, -1} if there are none.
template <typename Tree>
std::pair<LeafIndex, LeafIndex> FindLeafBox(const Tree& tree) {
  bool any = false;
  LeafIndex first{0, 0, 0};
  LeafIndex last{-1, -1, -1};
  const auto include = [&](const LeafIndex& lower, const LeafIndex& upper) {
    first = any ? LeafIndex{std::min(first.x, lower.x), std::min(first.y, lower.y), std::min(first.z, lower.z)} : lower;
    last = any ? LeafIndex{std::max(last.x, upper.x), std::max(last.y, upper.y), std::max(last.z, upper.z)} : upper;
    any = true;
  };
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) include(LeafAt(leaf->origin()), LeafAt(leaf->origin()));
  ForEachTile(tree, [&](const LeafIndex& lower, const LeafIndex& upper, auto) { include(lower, upper); });
  return {first, last};
}

/// Returns the multiple of kOriginLeaves that is nearest to the middle of a tree's leaves.
LeafIndex FindOrigin(const FloatTree& tree) {
  const auto [first, last] = FindLeafBox(tree);
  const auto nearest = [](int a, int b) {
    return kOriginLeaves * static_cast<int>(std::floor(0.5 * (static_cast<double>(a) + b) / kOriginLeaves + 0.5));
  };
  return {nearest(first.x, last.x), nearest(first.y, last.y), nearest(first.z, last.z)};
}

/// Position of frame F in a grid of another voxel size: whole leaves, and the remainder in voxels.
struct GridOrigin {
  GridOrigin(const Vec3& p_WF_mm, double voxel_mm) {
    const Vec3 p_vox = p_WF_mm / voxel_mm;
    const Vec3 leaves = glm::floor(p_vox / double{kLeafEdge} + 0.5);
    leaf = {static_cast<int>(leaves.x), static_cast<int>(leaves.y), static_cast<int>(leaves.z)};
    rest_vox = p_vox - double{kLeafEdge} * leaves;
  }
  LeafIndex leaf;
  Vec3 rest_vox;
};

/// Table of a grid's leaves, numbered from `origin`, and the shared blocks that represent its tiles, one for each
/// value.
template <typename Tree>
struct TreeTable {
  using Value = typename Tree::ValueType;
  using Block = std::array<Value, BoneField::kLeafVoxels>;

  TreeTable(const Tree& tree, const LeafIndex& origin) : TreeTable(tree, origin, FindLeafBox(tree)) {}
  /// `box`: the first and the last leaf of a box around all leaves of the tree.
  TreeTable(const Tree& tree, const LeafIndex& origin, const std::pair<LeafIndex, LeafIndex>& box) {
    const auto& [first, last] = box;
    table = LeafTable<Value>(first - origin, last - origin, BlockOf(tree.background()));
    ForEachTile(tree, [&](const LeafIndex& lower, const LeafIndex& upper, Value value) {
      const Value* block = BlockOf(value);
      ForEachLeafBetween(lower, upper, [&](const LeafIndex& leaf) { table.Set(table.Find(leaf - origin), block); });
    });
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
      table.Set(table.Find(LeafAt(leaf->origin()) - origin), leaf->buffer().data());
    }
  }

  const Value* BlockOf(Value value) {
    auto [found, is_new] = blocks.try_emplace(value);
    if (is_new) found->second.fill(value);
    return found->second.data();
  }

  LeafTable<Value> table;
  std::map<Value, Block> blocks;
};

/// Calls visit(x, y, z) for the layer of voxels around a leaf's upper sides, which the cells of the leaf reach into.
template <typename Visit>
void ForEachUpperVoxel(const LeafIndex& leaf, Visit visit) {
  const int x = kLeafEdge * leaf.x, y = kLeafEdge * leaf.y, z = kLeafEdge * leaf.z;
  for (int i = 0; i <= kLeafEdge; ++i) {
    for (int j = 0; j <= kLeafEdge; ++j) {
      visit(x + kLeafEdge, y + i, z + j);
      visit(x + i, y + kLeafEdge, z + j);
      visit(x + i, y + j, z + kLeafEdge);
    }
  }
}

/// Returns for each place of a table the region (id 1 to 255) of all cells with their lowest corner in the leaf; 0 if
/// there are several, or none.
std::vector<std::uint8_t> FindUniformLeaves(const LeafTable<int>& table) {
  std::vector<std::uint8_t> region_of(table.size(), 0);
  ForEachLeafBetween(table.lowest(), table.highest(), [&](const LeafIndex& leaf) {
    const std::size_t place = table.Find(leaf);
    const int* values = table.at(place);
    const int region = values[0];
    if (!IsRegion(region)) return;
    bool is_uniform =
        std::all_of(values, values + LeafTable<int>::kLeafVoxels, [region](int value) { return value == region; });
    if (is_uniform) {
      ForEachUpperVoxel(leaf, [&](int x, int y, int z) { is_uniform = is_uniform && table.Get(x, y, z) == region; });
    }
    if (is_uniform) region_of[place] = static_cast<std::uint8_t>(region);
  });
  return region_of;
}

/// Splits the inside tiles into tiles of the size of leaves, so that a leaf can replace one without any other
/// allocation.
void SplitInsideTiles(FloatTree& tree) {
  std::vector<std::pair<LeafIndex, LeafIndex>> large;
  ForEachTile(tree, [&](const LeafIndex& first, const LeafIndex& last, float value) {
    if (value < 0 && !(first == last)) large.emplace_back(first, last);
  });
  for (const auto& [first, last] : large) {
    ForEachLeafBetween(first, last,
                       [&](const LeafIndex& leaf) { tree.addTile(1, OriginOf(leaf), -tree.background(), false); });
  }
}

/// Returns the first and the last leaf of the box around all leaves of a bone, emptied ones included.
std::pair<LeafIndex, LeafIndex> FindLeafBox(const BoneGrids& grids) {
  const auto box = FindLeafBox(grids.phi->tree());
  if (!grids.cut) return box;
  const auto cut = FindLeafBox(grids.cut->tree());
  if (cut.second.x < cut.first.x) return box;
  if (box.second.x < box.first.x) return cut;
  return {{std::min(box.first.x, cut.first.x), std::min(box.first.y, cut.first.y), std::min(box.first.z, cut.first.z)},
          {std::max(box.second.x, cut.second.x), std::max(box.second.y, cut.second.y),
           std::max(box.second.z, cut.second.z)}};
}

/// Splits the inside tiles. Throws kerf::Error, before any change, if the bone's box is too large for a table.
FloatTree& SplitTiles(BoneGrids& grids) {
  const auto [first, last] = FindLeafBox(grids);
  LeafTable<float>::CheckedSize({last.x - first.x + 3, last.y - first.y + 3, last.z - first.z + 3});
  SplitInsideTiles(grids.phi->tree());
  return grids.phi->tree();
}

}  // namespace

struct BoneField::State {
  explicit State(BoneGrids& the_grids)
      : grids(the_grids),
        tree(SplitTiles(grids)),
        lender(FindLender(*grids.phi)),
        origin(FindOrigin(tree)),
        h(grids.voxel_mm()),
        p_WF_mm(h * (double{kLeafEdge} * Vec3(origin.x, origin.y, origin.z))),
        tiles(tree, origin, FindLeafBox(grids)),
        band(tree.background()),
        phi(std::move(tiles.table), tiles.BlockOf(band), tiles.BlockOf(-band)),
        region_h(grids.region_voxel_mm()),
        region_origin(p_WF_mm, region_h),
        region(grids.region->constTree(), region_origin.leaf),
        uniform_regions(FindUniformLeaves(region.table)),
        by_modulus(grids.by_modulus),
        spare(-band) {
    for (const auto& [id, known] : grids.materials.regions()) {
      if (known.tissue != Tissue::kMetal) continue;
      metal[static_cast<std::size_t>(id)] = has_metal = true;
    }
    if (grids.modulus) {
      modulus_h = grids.modulus->voxelSize()[0];
      const GridOrigin modulus_origin(p_WF_mm, modulus_h);
      modulus_rest_vox = modulus_origin.rest_vox;
      modulus = std::make_unique<TreeTable<FloatTree>>(grids.modulus->constTree(), modulus_origin.leaf);
    }
    if (grids.cut) ReadSplits();
    ReserveMarks();
  }

  const LeafTable<float>& table() const { return phi.leaves(); }
  bool IsEmpty(const LeafIndex& leaf) const;
  void ReserveMarks();
  void ReadSplits();
  void StoreSplits();
  std::unique_ptr<FloatLeaf> TakeSpare(const LeafIndex& leaf) { return spare.Take(OriginOf(leaf + origin)); }
  void AddOwn(std::size_t place, std::unique_ptr<FloatLeaf> own);
  void Split(const LeafIndex& leaf, std::size_t place);
  CutValues Mark(const LeafIndex& leaf, std::size_t place);
  CutValues ValuesOf(std::size_t place) const;

  BoneGrids& grids;
  FloatTree& tree;
  const FloatTree* lender;  // owns the leaves that the bone shares with others; null: none
  LeafIndex origin;         // of F in the world; as a point: p_WF_mm
  double h;
  Vec3 p_WF_mm;
  TreeTable<FloatTree> tiles;  // owns the blocks of the tiles
  float band;
  PhiTable phi;
  double region_h;
  GridOrigin region_origin;
  TreeTable<openvdb::Int32Tree> region;
  std::vector<std::uint8_t>
      uniform_regions;  // one per leaf: the region of all cells with their lowest voxel in it, or 0
  std::unique_ptr<TreeTable<FloatTree>> modulus;  // null if no E comes from the CT
  double modulus_h = 1;
  Vec3 modulus_rest_vox{0};
  std::array<bool, 256> by_modulus;
  std::array<bool, 256> metal{};
  bool has_metal = false;
  SpareLeaves spare;  // filled with the inside value
  std::vector<LeafIndex> changed;
  std::vector<LeafIndex> unsettled;
  struct NewSplit {
    std::unique_ptr<FloatLeaf> cut;
    std::unique_ptr<FloatLeaf> whole;         // null: `shared_whole`
    const FloatLeaf* shared_whole = nullptr;  // of the lender
  };
  std::vector<NewSplit> new_splits;  // since the last Settle(): not in the grids yet
  LeafHistory* history = nullptr;
};

/// Enters the leaves with two fields in the table.
void BoneField::State::ReadSplits() {
  const FloatTree& cut = grids.cut->constTree();
  const FloatTree& whole = grids.whole->constTree();
  phi.ReserveSplits(cut.leafCount());
  for (auto leaf = cut.cbeginLeaf(); leaf; ++leaf) {
    const std::size_t place = table().Find(LeafAt(leaf->origin()) - origin);
    const FloatLeaf* of_whole = whole.probeConstLeaf(leaf->origin());
    phi.Split(place, {of_whole->buffer().data(), leaf->buffer().data()});
  }
  ForEachTile(cut, [&](const LeafIndex& leaf, const LeafIndex&, float) {
    phi.flags(table().Find(leaf - origin)) = PhiTable::kCut;
  });
}

/// Makes room for a mark of each leaf with bone, and for two fields of each leaf whose surface was not cut yet. The
/// room is a bound for cuts; where bone is put into air, growing is a slow but correct fallback.
void BoneField::State::ReserveMarks() {
  std::size_t with_bone = 0;
  std::size_t uncut = 0;
  for (std::size_t place = 0; place < table().size(); ++place) {
    const std::uint8_t flags = phi.flags(place);
    if (table().at(place) != phi.outside() || (flags & PhiTable::kCut) != 0) ++with_bone;
    if ((flags & PhiTable::kWhole) != 0) ++uncut;
  }
  changed.reserve(with_bone);
  unsettled.reserve(with_bone);
  new_splits.reserve(uncut);
  phi.ReserveSplits(uncut);
}

/// Gives the grids the new leaves with two fields.
void BoneField::State::StoreSplits() {
  if (new_splits.empty() && !grids.cut) {
    const bool any_cut = std::any_of(unsettled.begin(), unsettled.end(), [this](const LeafIndex& leaf) {
      return (phi.flags(table().Find(leaf)) & PhiTable::kCut) != 0;
    });
    if (!any_cut) return;
  }
  if (!grids.cut) AddPartGrids(grids);
  FloatTree& cut = grids.cut->tree();
  cut.clearAllAccessors();
  grids.whole->tree().clearAllAccessors();
  for (NewSplit& split : new_splits) {
    if (!split.whole) split.whole = std::make_unique<FloatLeaf>(*split.shared_whole);
    // Files store the active values only.
    split.whole->setValuesOn();
    split.cut->setValuesOn();
    grids.whole->tree().addLeaf(split.whole.release());
    cut.addLeaf(split.cut.release());
  }
  new_splits.clear();
  for (const LeafIndex& leaf : unsettled) {
    if ((phi.flags(table().Find(leaf)) & PhiTable::kCut) != 0) cut.addTile(1, OriginOf(leaf + origin), band, true);
  }
}

BoneField::BoneField(Bone& bone, int spare_leaves) : state_(std::make_unique<State>(GridsOf(bone))) {
  Refill(spare_leaves);
}
BoneField::~BoneField() = default;
BoneField::BoneField(BoneField&&) noexcept = default;

double BoneField::voxel_mm() const {
  return state_->h;
}
double BoneField::band_mm() const {
  return static_cast<double>(state_->band);
}
LeafIndex BoneField::origin_leaf() const {
  return state_->origin;
}
LeafIndex BoneField::FromWorld(const std::array<int, 3>& index) const {
  const LeafIndex origin = origin_leaf();
  return {index[0] - origin.x, index[1] - origin.y, index[2] - origin.z};
}
Vec3 BoneField::p_WF_mm() const {
  return state_->p_WF_mm;
}
double BoneField::region_voxel_mm() const {
  return state_->region_h;
}
bool BoneField::by_modulus(int region) const {
  return state_->by_modulus[static_cast<std::size_t>(region)];
}
bool BoneField::is_metal(int region) const {
  return state_->metal[static_cast<std::size_t>(region)];
}
bool BoneField::has_metal() const {
  return state_->has_metal;
}
LeafIndex BoneField::lowest() const {
  return state_->table().lowest();
}
LeafIndex BoneField::highest() const {
  return state_->table().highest();
}

const float* BoneField::Read(const LeafIndex& leaf) const {
  return state_->table().at(state_->table().Find(leaf));
}
BoneField::LeafKind BoneField::kind(const LeafIndex& leaf) const {
  const float* values = Read(leaf);
  if (values == state_->phi.outside()) return LeafKind::kOutside;
  return values == state_->phi.inside() ? LeafKind::kInside : LeafKind::kOwn;
}
const float* BoneField::inside() const {
  return state_->phi.inside();
}
PhiParts BoneField::ReadParts(const LeafIndex& leaf) const {
  return state_->phi.Parts(state_->table().Find(leaf));
}

PhiPair BoneField::SampleParts(const Vec3& p_vox) const {
  return SamplePoint(state_->phi, p_vox);
}
void BoneField::SampleParts(const PointMap& to_vox, const PointList& points, double* whole_mm, double* cut_mm) const {
  SamplePoints(state_->phi, to_vox, points, whole_mm, cut_mm);
}
void BoneField::Sample(const PointMap& to_vox, const PointList& points, double* phi_mm) const {
  SamplePhi(state_->phi, to_vox, points, phi_mm);
}
Vec3 BoneField::SampleGradient(const Vec3& p_vox) const {
  const CellPoint cell = FindCell(p_vox);
  const PhiCorners corners = state_->phi.FindCorners(cell);
  const bool is_whole = Interpolate(corners.whole, cell.f) >= Interpolate(corners.cut, cell.f);
  return InterpolateGradient(is_whole ? corners.whole : corners.cut, cell.f) / state_->h;
}
int BoneField::RegionAt(const Vec3& p_F) const {
  const CellPoint cell = FindCell(p_F / state_->region_h + state_->region_origin.rest_vox + 0.5);
  return state_->region.table.Get(cell.x, cell.y, cell.z);
}
[[gnu::flatten]] BoneField::RegionCell BoneField::FindRegionCell(const Vec3& p_F) const {
  const CellPoint cell = FindCell(p_F / state_->region_h + state_->region_origin.rest_vox);
  return {state_->region.table.Corners(cell), cell.f};
}
void BoneField::InterpolateUniform(const PointMap& to_vox, const PointList& points, const RegionConstants& constants,
                                   std::uint8_t* regions, double* a, double* b) const {
  kerf::InterpolateUniform(state_->region.table.box(), state_->uniform_regions.data(), to_vox,
                           {state_->h, state_->region_h, state_->region_origin.rest_vox}, points, constants, regions, a,
                           b);
}
double BoneField::ModulusAt(const Vec3& p_F) const {
  if (!state_->modulus) return 0;
  const CellPoint cell = FindCell(p_F / state_->modulus_h + state_->modulus_rest_vox);
  return InterpolatePositive(state_->modulus->table.Corners(cell), cell.f);
}

BoneField::CutValues BoneField::State::ValuesOf(std::size_t place) const {
  // The values belong to grids that this field may change.
  const auto writable = [](const float* values) { return const_cast<float*>(values); };
  const std::uint8_t flags = phi.flags(place);
  if (table().at(place) == phi.outside()) return {};
  if ((flags & PhiTable::kCut) != 0) return {writable(table().at(place)), writable(table().at(place)), nullptr};
  if ((flags & PhiTable::kSplit) == 0) return {};
  const PhiParts parts = phi.Parts(place);
  return {writable(parts.cut), writable(table().at(place)), parts.whole};
}

void BoneField::State::AddOwn(std::size_t place, std::unique_ptr<FloatLeaf> own) {
  phi.Set(place, own->buffer().data());
  tree.addLeaf(own.release());  // the nodes above it exist: SplitInsideTiles()
}

/// Gives a leaf with an uncut surface its two fields. The values of a shared leaf become those of `whole`, which never
/// change, where they are; phi gets a leaf of its own.
void BoneField::State::Split(const LeafIndex& leaf, std::size_t place) {
  const float* const whole = table().at(place);
  std::unique_ptr<FloatLeaf> copy = TakeSpare(leaf);
  std::copy_n(whole, kLeafVoxels, copy->buffer().data());
  NewSplit split;
  split.cut = TakeSpare(leaf);
  const FloatLeaf* const lent = lender == nullptr ? nullptr : lender->probeConstLeaf(copy->origin());
  if (lent != nullptr && lent->buffer().data() == whole) {
    split.shared_whole = lent;
    phi.Set(place, copy->buffer().data());
    ReplaceShared(tree, std::move(copy));
  } else {
    split.whole = std::move(copy);
  }
  const FloatLeaf& of_whole = split.whole ? *split.whole : *lent;
  phi.Split(place, {of_whole.buffer().data(), split.cut->buffer().data()});
  new_splits.push_back(std::move(split));
}

/// Marks a leaf as changed, and returns its values.
BoneField::CutValues BoneField::State::Mark(const LeafIndex& leaf, std::size_t place) {
  std::uint8_t& flags = phi.flags(place);
  if (!(flags & PhiTable::kChanged)) changed.push_back(leaf);
  if (!(flags & PhiTable::kUnsettled)) unsettled.push_back(leaf);
  flags |= PhiTable::kChanged | PhiTable::kUnsettled;
  return ValuesOf(place);
}

int BoneField::CountNeededSpares(const LeafIndex& leaf) const {
  switch (kind(leaf)) {
    case LeafKind::kOutside:
    case LeafKind::kInside:
      return 1;
    case LeafKind::kOwn:
      break;
  }
  return (state_->phi.flags(state_->table().Find(leaf)) & PhiTable::kWhole) != 0 ? 2 : 0;
}

BoneField::CutValues BoneField::Write(const LeafIndex& leaf) {
  // Most leaves that are written have been before.
  State& s = *state_;
  const std::size_t place = s.table().Find(leaf);
  const bool needs_old_values = s.history != nullptr && s.history->NeedsOldValues(place);
  if (!needs_old_values && s.ValuesOf(place).cut != nullptr) return s.Mark(leaf, place);
  return kind(leaf) == LeafKind::kOutside ? CutValues{} : Open(leaf);
}

BoneField::CutValues BoneField::Open(const LeafIndex& leaf) {
  State& s = *state_;
  if (s.spare.count() < CountNeededSpares(leaf)) return {};
  const std::size_t place = s.table().Find(leaf);
  const LeafKind is = kind(leaf);
  if (is == LeafKind::kOutside) {
    const LeafIndex low = lowest(), high = highest();
    const bool in_box = leaf.x >= low.x && leaf.y >= low.y && leaf.z >= low.z && leaf.x <= high.x && leaf.y <= high.y &&
                        leaf.z <= high.z;
    // A node that contains a leaf has room for this leaf's neighbours without further allocation.
    if (!in_box ||
        s.tree.probeNode<FloatTree::RootNodeType::ChildNodeType::ChildNodeType>(OriginOf(leaf + s.origin)) == nullptr) {
      return {};
    }
  }
  if (s.history != nullptr && s.history->NeedsOldValues(place)) {
    const float* const cut = s.phi.Parts(place).cut;
    s.history->Note(place, leaf, cut == s.phi.inside() ? nullptr : cut);
  }
  std::uint8_t& flags = s.phi.flags(place);
  if (is != LeafKind::kOwn) {
    std::unique_ptr<FloatLeaf> own = s.TakeSpare(leaf);
    if (is == LeafKind::kOutside) own->buffer().fill(s.band);
    s.AddOwn(place, std::move(own));
    // A split leaf that was emptied still has its two fields.
    if ((flags & PhiTable::kSplit) == 0) flags |= PhiTable::kCut;
  } else if ((flags & PhiTable::kWhole) != 0) {
    s.Split(leaf, place);
  }
  return s.Mark(leaf, place);
}

BoneField::CutValues BoneField::Find(const LeafIndex& leaf) {
  return state_->ValuesOf(state_->table().Find(leaf));
}

bool BoneField::NeedsOldValues(const LeafIndex& leaf) const {
  return state_->history != nullptr && state_->history->NeedsOldValues(state_->table().Find(leaf));
}

bool BoneField::Swap(const LeafIndex& leaf, float* values) {
  LeafHistory* const history = std::exchange(state_->history, nullptr);
  const CutValues own = Open(leaf);
  state_->history = history;
  if (own.cut == nullptr) return false;
  std::swap_ranges(own.cut, own.cut + kLeafVoxels, values);
  SetPhi(own);
  return true;
}

void BoneField::SetPhi(const CutValues& values) {
  if (values.whole == nullptr) return;
  for (int i = 0; i < kLeafVoxels; ++i) values.phi[i] = std::max(values.whole[i], values.cut[i]);
}

std::span<const LeafIndex> BoneField::changed() const {
  return state_->changed;
}
ChangedLeaf BoneField::ReadChanged(int i) const {
  const LeafIndex& leaf = changed()[static_cast<std::size_t>(i)];
  const LeafIndex origin = origin_leaf();
  return {{origin.x + leaf.x, origin.y + leaf.y, origin.z + leaf.z}, Read(leaf), ReadParts(leaf).cut};
}
void BoneField::ClearChanged(int first) {
  std::vector<LeafIndex>& changed = state_->changed;
  const auto end = changed.begin() + first;
  for (auto leaf = changed.begin(); leaf != end; ++leaf) {
    state_->phi.flags(state_->table().Find(*leaf)) &= static_cast<std::uint8_t>(~PhiTable::kChanged);
  }
  // The last ones take their places.
  const auto moved = std::max(end, changed.end() - first);
  std::copy(moved, changed.end(), changed.begin());
  changed.resize(changed.size() - static_cast<std::size_t>(first));
}
int BoneField::spare_leaves() const {
  return state_->spare.count();
}

void BoneField::set_history(LeafHistory* history) {
  state_->history = history;
}
std::size_t BoneField::place_count() const {
  return state_->table().size();
}
std::size_t BoneField::PlaceOf(const LeafIndex& leaf) const {
  return state_->table().Find(leaf);
}

void BoneField::Refill(int spare_leaves) {
  state_->spare.Refill(spare_leaves);
}
void BoneField::Supply(int spare_leaves) {
  state_->spare.Supply(spare_leaves);
}

/// Returns whether all of the leaf's own values are outside and no cell whose lowest corner lies in the leaf contains
/// bone.
bool BoneField::State::IsEmpty(const LeafIndex& leaf) const {
  const float* own = table().at(table().Find(leaf));
  if (std::any_of(own, own + kLeafVoxels, [this](float value) { return value < band; })) return false;
  // The cells at the upper sides may contain bone between voxels that are all outside.
  CellFields cells(h, static_cast<double>(band));
  cells.Load([&](int x, int y, int z) { return phi.Parts(table().Find(leaf + LeafIndex{x, y, z})); });
  for (int i = 0; i < kLeafVoxels; ++i) {
    if (cells.CalcFraction(i >> 6, i >> 3 & 7, i & 7) != 0) return false;
  }
  return true;
}

void BoneField::Settle() {
  State& s = *state_;
  s.tree.clearAllAccessors();
  s.StoreSplits();
  for (const LeafIndex& index : s.unsettled) {
    const std::size_t place = s.table().Find(index);
    s.phi.flags(place) &= static_cast<std::uint8_t>(~PhiTable::kUnsettled);
    FloatLeaf* leaf = s.tree.probeLeaf(OriginOf(index + s.origin));
    for (openvdb::Index i = 0; i < FloatLeaf::SIZE; ++i) {
      leaf->setActiveState(i, std::abs(leaf->getValue(i)) < s.band);
    }
    if (!s.IsEmpty(index)) continue;
    std::unique_ptr<FloatLeaf> emptied(s.tree.stealNode<FloatLeaf>(leaf->origin(), s.band, false));
    s.spare.Return(std::move(emptied));
    s.phi.Set(place, s.phi.outside());
  }
  s.unsettled.clear();
}

std::size_t BoneField::CalcMemoryBytes() const {
  const State& s = *state_;
  std::size_t bytes = s.phi.CalcMemoryBytes() + s.region.table.CalcMemoryBytes() + s.uniform_regions.capacity();
  if (s.modulus) bytes += s.modulus->table.CalcMemoryBytes();
  bytes += (s.changed.capacity() + s.unsettled.capacity()) * sizeof(LeafIndex);
  bytes += s.new_splits.capacity() * sizeof(s.new_splits[0]);
  bytes += 2 * s.new_splits.size() * (sizeof(FloatLeaf) + kLeafVoxels * sizeof(float));
  return bytes + s.spare.CalcMemoryBytes();
}

std::int64_t CountSparesForAll(const Bone& bone) {
  const BoneGrids& grids = GridsOf(bone);
  const FloatTree& tree = grids.phi->constTree();
  std::int64_t count = 2 * static_cast<std::int64_t>(tree.leafCount());
  if (grids.cut) {
    // Leaves that were split before, or whose phi is that of the cut; those that were emptied are not in the tree.
    const auto cut = grids.cut->getConstAccessor();
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
      if (cut.probeConstLeaf(leaf->origin()) != nullptr || cut.getValue(leaf->origin()) > 0) count -= 2;
    }
  }
  ForEachTile(tree, [&](const LeafIndex& first, const LeafIndex& last, float value) {
    if (!(value < 0)) return;
    count += std::int64_t{last.x - first.x + 1} * (last.y - first.y + 1) * (last.z - first.z + 1);
  });
  return count;
}

}  // namespace kerf
