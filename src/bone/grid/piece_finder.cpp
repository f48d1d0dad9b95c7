#include "bone/grid/piece_finder.h"

#include <algorithm>
#include <bit>
#include <map>
#include <utility>

#include "bone/grid/grids.h"
#include "bone/grid/labels.h"

namespace kerf {
namespace {

using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using Index3 = std::array<int, 3>;

constexpr int kNone = -1;

/// Returns the part of `mask` that is connected to its lowest voxel.
LeafMask FirstPart(const LeafMask& mask) {
  LeafMask part{};
  for (std::size_t x = 0; x < 8; ++x) {
    if (mask[x] == 0) continue;
    part[x] = mask[x] & (~mask[x] + 1);
    break;
  }
  Flood(mask, part);
  return part;
}

/// Returns whether a voxel of `low` and a voxel of `high`, in the next leaf along `axis`, share a face.
bool Touch(const LeafMask& low, const LeafMask& high, int axis) {
  if (axis == 0) return (low[7] & high[0]) != 0;
  std::uint64_t any = 0;
  for (std::size_t x = 0; x < 8; ++x) {
    any |= axis == 1 ? (low[x] >> 56) & (high[x] & 0xff) : (low[x] >> 7) & high[x] & kLowZ;
  }
  return any != 0;
}

/// Connected voxels of one leaf.
struct Part {
  LeafMask voxels{};
  int id = 0;  // of the piece that it belonged to; 0: dust, or not known yet
  std::uint16_t count = 0;
  std::array<std::uint8_t, 3> low{}, high{};

  void Measure() {
    count = 0;
    low = {7, 7, 7};
    high = {0, 0, 0};
    std::uint64_t all = 0;
    for (std::size_t x = 0; x < 8; ++x) {
      if (voxels[x] == 0) continue;
      count = static_cast<std::uint16_t>(count + std::popcount(voxels[x]));
      all |= voxels[x];
      low[0] = std::min(low[0], static_cast<std::uint8_t>(x));
      high[0] = static_cast<std::uint8_t>(x);
    }
    low[1] = static_cast<std::uint8_t>(std::countr_zero(all) / 8);
    high[1] = static_cast<std::uint8_t>(7 - std::countl_zero(all) / 8);
    std::uint64_t z = all | all >> 32;
    z |= z >> 16;
    z = (z | z >> 8) & 0xff;
    low[2] = static_cast<std::uint8_t>(std::countr_zero(z));
    high[2] = static_cast<std::uint8_t>(std::bit_width(z) - 1);
  }
};

struct Leaf {
  Index3 index{};
  Part first;               // count 0: no bone left
  std::vector<Part> more;   // further parts, if the leaf has fallen apart
  std::uint8_t links = 0;   // bit `axis`: this leaf and the next have one part each, and these touch
  std::array<int, 3> next;  // the next leaf along each axis; kNone: none
};

/// A set of connected parts.
struct Component {
  int was = 0;  // lowest id among its parts
  std::size_t voxels = 0;
  Index3 low{}, high{};  // voxels
  int id = 0;
};

}  // namespace

const FoundPiece* FoundPieces::At(int id) const {
  const auto at = std::find_if(pieces.begin(), pieces.end(), [&](const FoundPiece& p) { return p.id == id; });
  return at == pieces.end() ? nullptr : &*at;
}

struct PieceFinder::State {
  double h;
  double dust_mm3;
  openvdb::Int32Grid::Ptr region;  // shared with the bone
  Index3 lowest{}, count{};
  std::vector<int> table;  // of the leaves' box: index in `leaves`, or kNone
  std::vector<Leaf> leaves;
  bool changed = false;
  int last_id = 0;
  FoundPieces found;
  // Kept between calls to avoid allocation.
  UnionFind<std::uint32_t> sets;
  std::vector<std::uint32_t> first_more;  // for each leaf: node of its second part
  std::vector<std::uint32_t> component_of;

  int Find(const Index3& index) const {
    std::size_t place = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int at = index[axis] - lowest[axis];
      if (at < 0 || at >= count[axis]) return kNone;
      place = place * static_cast<std::size_t>(count[axis]) + static_cast<std::size_t>(at);
    }
    return table[place];
  }
  Leaf& At(int slot) { return leaves[static_cast<std::size_t>(slot)]; }

  void Build(const FloatTree& tree);
  void Split(Leaf& leaf, const LeafMask& mask) const;
  void Link(Leaf& leaf, int axis);

  template <typename Visit>
  void ForEachPart(Visit&& visit) {
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (leaves[i].first.count == 0) continue;
      visit(static_cast<std::uint32_t>(i), leaves[i], leaves[i].first);
      for (std::size_t k = 0; k < leaves[i].more.size(); ++k) {
        visit(first_more[i] + static_cast<std::uint32_t>(k), leaves[i], leaves[i].more[k]);
      }
    }
  }
  void JoinAll();
  std::vector<Component> Gather();
  void AssignIds(std::vector<Component>& components);
};

void PieceFinder::State::Build(const FloatTree& tree) {
  std::vector<std::pair<Index3, LeafMask>> blocks;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const LeafMask mask = MaskOf(leaf->buffer().data());
    const Coord at = leaf->origin();
    if (!kerf::IsEmpty(mask)) blocks.push_back({{at.x() >> 3, at.y() >> 3, at.z() >> 3}, mask});
  }
  LeafMask full;
  full.fill(~std::uint64_t{0});
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    if (*tile >= 0 || !tile.getBoundingBox(box)) continue;
    for (int x = box.min().x() >> 3; x <= box.max().x() >> 3; ++x) {
      for (int y = box.min().y() >> 3; y <= box.max().y() >> 3; ++y) {
        for (int z = box.min().z() >> 3; z <= box.max().z() >> 3; ++z) blocks.push_back({{x, y, z}, full});
      }
    }
  }
  // Sorted by position, so that neighbours lie near each other and the result does not depend on the tree's history.
  std::sort(blocks.begin(), blocks.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (blocks.empty()) return;
  Index3 highest = lowest = blocks.front().first;
  for (const auto& [index, mask] : blocks) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], index[axis]);
      highest[axis] = std::max(highest[axis], index[axis]);
    }
  }
  std::size_t places = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    count[axis] = highest[axis] - lowest[axis] + 1;
    places *= static_cast<std::size_t>(count[axis]);
  }
  table.assign(places, kNone);
  leaves.resize(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    leaves[i].index = blocks[i].first;
    std::size_t place = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place = place * static_cast<std::size_t>(count[axis]) +
              static_cast<std::size_t>(leaves[i].index[axis] - lowest[axis]);
    }
    table[place] = static_cast<int>(i);
    Split(leaves[i], blocks[i].second);
  }
  for (Leaf& leaf : leaves) {
    for (int axis = 0; axis < 3; ++axis) {
      Index3 index = leaf.index;
      ++index[static_cast<std::size_t>(axis)];
      leaf.next[static_cast<std::size_t>(axis)] = Find(index);
    }
  }
  for (Leaf& leaf : leaves) {
    for (int axis = 0; axis < 3; ++axis) Link(leaf, axis);
  }
}

/// Finds the leaf's parts. Each gets the id of an earlier part that it overlaps, because cutting never joins parts.
/// Where undo restores bone between two parts, the lower id is kept.
void PieceFinder::State::Split(Leaf& leaf, const LeafMask& mask) const {
  std::vector<Part> before(std::move(leaf.more));
  if (leaf.first.count > 0) before.push_back(leaf.first);
  leaf.first = {};
  leaf.more.clear();
  LeafMask left = mask;
  while (!kerf::IsEmpty(left)) {
    Part part;
    part.voxels = FirstPart(left);
    for (std::size_t x = 0; x < 8; ++x) left[x] &= ~part.voxels[x];
    part.Measure();
    for (const Part& old : before) {
      bool shared = false;
      for (std::size_t x = 0; x < 8; ++x) shared = shared || (old.voxels[x] & part.voxels[x]) != 0;
      if (shared && old.id != 0) part.id = part.id == 0 ? old.id : std::min(part.id, old.id);
    }
    if (leaf.first.count == 0) {
      leaf.first = part;
    } else {
      leaf.more.push_back(part);
    }
  }
}

void PieceFinder::State::Link(Leaf& leaf, int axis) {
  const auto bit = static_cast<std::uint8_t>(1 << axis);
  leaf.links = static_cast<std::uint8_t>(leaf.links & ~bit);
  const int next = leaf.next[static_cast<std::size_t>(axis)];
  if (next == kNone || leaf.first.count == 0 || !leaf.more.empty()) return;
  const Leaf& other = At(next);
  if (other.first.count == 0 || !other.more.empty()) return;
  if (Touch(leaf.first.voxels, other.first.voxels, axis)) leaf.links = static_cast<std::uint8_t>(leaf.links | bit);
}

void PieceFinder::State::JoinAll() {
  first_more.resize(leaves.size());
  auto nodes = static_cast<std::uint32_t>(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    first_more[i] = nodes;
    nodes += static_cast<std::uint32_t>(leaves[i].more.size());
  }
  sets.Reset(nodes);
  const auto part = [](const Leaf& leaf, std::size_t k) -> const Part& {
    return k == 0 ? leaf.first : leaf.more[k - 1];
  };
  const auto node = [this](std::size_t slot, std::size_t k) {
    return static_cast<std::uint32_t>(k == 0 ? slot : first_more[slot] + k - 1);
  };
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Leaf& leaf = leaves[i];
    if (leaf.first.count == 0) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const int next = leaf.next[static_cast<std::size_t>(axis)];
      if (next == kNone) continue;
      const auto n = static_cast<std::size_t>(next);
      if ((leaf.links >> axis & 1) != 0) {
        sets.Join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(n));
        continue;
      }
      const Leaf& other = leaves[n];
      if (other.first.count == 0 || (leaf.more.empty() && other.more.empty())) continue;
      for (std::size_t a = 0; a <= leaf.more.size(); ++a) {
        for (std::size_t b = 0; b <= other.more.size(); ++b) {
          if (Touch(part(leaf, a).voxels, part(other, b).voxels, axis)) sets.Join(node(i, a), node(n, b));
        }
      }
    }
  }
}

/// Returns the components in the order of their first leaves; sets `component_of` for each part.
std::vector<Component> PieceFinder::State::Gather() {
  constexpr std::uint32_t kUnknown = 0xffffffff;
  component_of.assign(sets.size(), kUnknown);
  std::vector<Component> components;
  ForEachPart([&](std::uint32_t node, const Leaf& leaf, const Part& part) {
    const std::uint32_t root = sets.Find(node);
    if (component_of[root] == kUnknown) {
      component_of[root] = static_cast<std::uint32_t>(components.size());
      components.push_back({part.id, 0, {1 << 30, 1 << 30, 1 << 30}, {-(1 << 30), -(1 << 30), -(1 << 30)}, 0});
    }
    component_of[node] = component_of[root];
    Component& c = components[component_of[root]];
    if (part.id != 0) c.was = c.was == 0 ? part.id : std::min(c.was, part.id);
    c.voxels += part.count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      c.low[axis] = std::min(c.low[axis], 8 * leaf.index[axis] + part.low[axis]);
      c.high[axis] = std::max(c.high[axis], 8 * leaf.index[axis] + part.high[axis]);
    }
  });
  return components;
}

/// Assigns ids. Among components that were one piece, the largest keeps its id.
void PieceFinder::State::AssignIds(std::vector<Component>& components) {
  std::vector<Component*> order;
  for (Component& c : components) order.push_back(&c);
  std::stable_sort(order.begin(), order.end(),
                   [](const Component* a, const Component* b) { return a->voxels > b->voxels; });
  const bool at_start = last_id == 0;
  const double voxel_mm3 = h * h * h;
  std::map<int, bool> taken;
  found = {};
  for (Component* c : order) {
    const double mm3 = static_cast<double>(c->voxels) * voxel_mm3;
    if (mm3 < dust_mm3) {
      ++found.dust_count;
      found.dust_mm3 += mm3;
      continue;
    }
    FoundPiece piece;
    const bool keeps = c->was != 0 && !std::exchange(taken[c->was], true);
    piece.id = c->id = keeps ? c->was : ++last_id;
    piece.from = keeps ? 0 : c->was;
    piece.voxels = c->voxels;
    piece.volume_mm3 = mm3;
    const Vec3 low(c->low[0], c->low[1], c->low[2]), high(c->high[0], c->high[1], c->high[2]);
    piece.bounds_W = {h * (low - 0.5), h * (high + 0.5)};
    // A component without a former id was restored by undo: it gets an id, but is not reported in came_off.
    if (!keeps && c->was != 0 && !at_start) found.came_off.push_back(piece);
    found.pieces.push_back(piece);
  }
}

PieceFinder::PieceFinder(const Bone& bone, double dust_mm3) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.h = bone.voxel_mm();
  s.dust_mm3 = dust_mm3;
  s.region = GridsOf(bone).region;
  s.Build(GridsOf(bone).phi->tree());
  s.changed = true;
  Find();
}
PieceFinder::~PieceFinder() = default;
PieceFinder::PieceFinder(PieceFinder&&) noexcept = default;
PieceFinder& PieceFinder::operator=(PieceFinder&&) noexcept = default;

bool PieceFinder::Change(const std::array<int, 3>& index, std::span<const float, 512> values) {
  State& s = *state_;
  const int slot = s.Find(index);
  if (slot == kNone) return false;  // no bone there at the start, and none since
  Leaf& leaf = s.At(slot);
  LeafMask before = leaf.first.voxels;
  for (const Part& part : leaf.more) {
    for (std::size_t x = 0; x < 8; ++x) before[x] |= part.voxels[x];
  }
  const LeafMask now = MaskOf(values.data());
  if (now == before) return false;
  s.Split(leaf, now);
  for (int axis = 0; axis < 3; ++axis) {
    s.Link(leaf, axis);
    Index3 below = index;
    --below[static_cast<std::size_t>(axis)];
    const int lower = s.Find(below);
    if (lower != kNone) s.Link(s.At(lower), axis);
  }
  return s.changed = true;
}

bool PieceFinder::changed() const {
  return state_->changed;
}

const FoundPieces& PieceFinder::Find() {
  State& s = *state_;
  s.found.came_off.clear();
  if (!std::exchange(s.changed, false)) return s.found;
  s.JoinAll();
  std::vector<Component> components = s.Gather();
  // `from` of a piece is set when the piece separates, and never changes.
  const std::vector<FoundPiece> before = s.found.pieces;
  s.AssignIds(components);
  for (FoundPiece& piece : s.found.pieces) {
    for (const FoundPiece& old : before) {
      if (old.id == piece.id) piece.from = old.from;
    }
  }
  s.ForEachPart([&](std::uint32_t node, Leaf&, Part& part) { part.id = components[s.component_of[node]].id; });
  return s.found;
}

const FoundPieces& PieceFinder::found() const {
  return state_->found;
}

int PieceFinder::FindMainRegion(int id) const {
  std::map<int, std::size_t> votes;
  const auto accessor = state_->region->getConstAccessor();
  const double to_region = state_->h / state_->region->voxelSize()[0];
  ForEachLeaf(id, [&](const Index3& leaf, const LeafMask& voxels) {
    std::size_t count = 0;
    for (const std::uint64_t word : voxels) count += static_cast<std::size_t>(std::popcount(word));
    // The middle voxel of the part represents all of it.
    std::size_t left = count / 2;
    for (std::size_t x = 0; x < 8; ++x) {
      std::uint64_t word = voxels[x];
      const auto here = static_cast<std::size_t>(std::popcount(word));
      if (left >= here) {
        left -= here;
        continue;
      }
      for (; left > 0; --left) word &= word - 1;
      const int bit = std::countr_zero(word);
      const Vec3 p = to_region * Vec3(8 * leaf[0] + static_cast<int>(x), 8 * leaf[1] + bit / 8, 8 * leaf[2] + bit % 8);
      const int region = accessor.getValue(NearestVoxel(p, 1));
      if (region > 0) votes[region] += count;
      return;
    }
  });
  int best = 0;
  std::size_t max_count = 0;
  for (const auto& [region, count] : votes) {
    if (count > max_count) best = region;
    max_count = std::max(max_count, count);
  }
  return best;
}

void PieceFinder::ForEachLeaf(int id,
                              const std::function<void(const std::array<int, 3>&, const LeafMask&)>& visit) const {
  for (const Leaf& leaf : state_->leaves) {
    if (leaf.first.count > 0 && leaf.first.id == id) visit(leaf.index, leaf.first.voxels);
    for (const Part& part : leaf.more) {
      if (part.id == id) visit(leaf.index, part.voxels);
    }
  }
}

double PieceFinder::dust_mm3() const {
  return state_->dust_mm3;
}

std::size_t PieceFinder::CalcMemoryBytes() const {
  const State& s = *state_;
  std::size_t bytes = sizeof(State) + s.table.capacity() * sizeof(int) + s.leaves.capacity() * sizeof(Leaf);
  for (const Leaf& leaf : s.leaves) bytes += leaf.more.capacity() * sizeof(Part);
  bytes += s.sets.CalcMemoryBytes() + (s.first_more.capacity() + s.component_of.capacity()) * sizeof(std::uint32_t);
  return bytes;
}

}  // namespace kerf
