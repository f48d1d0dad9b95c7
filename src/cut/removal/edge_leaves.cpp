#include "cut/removal/edge_leaves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace kerf {
namespace {

constexpr double kSlackLeaves = 1;           // slack, in edge lengths of a leaf
constexpr double kFractionBeforeNext = 0.7;  // fraction of the slack used up when the next list is begun
constexpr int kRowsAtOnce = 2;               // rows of the next list that are searched in a step
constexpr double kMinSlack_mm = 1;           // minimum slack; a tool at 5 mm/s moves 1 mm in 200 ticks

/// Returns a bound on the number of leaves within `out_mm` of a tool: those inside the tool grown by two leaf
/// diagonals.
std::size_t BoundLeaves(const EdgeZone& zone, double out_mm, double leaf_mm) {
  const double grown_mm = out_mm + 2 * std::sqrt(3.0) * leaf_mm;
  const double radius_mm = zone.radius_mm + grown_mm;
  const double volume_mm3 = zone.is_cylinder()
                                ? std::numbers::pi * radius_mm * radius_mm * 2 * (zone.half_thickness_mm + grown_mm)
                                : 4 * std::numbers::pi / 3 * radius_mm * radius_mm * radius_mm;
  return static_cast<std::size_t>(volume_mm3 / (leaf_mm * leaf_mm * leaf_mm)) + 1;
}

}  // namespace

void LeafList::Reserve(std::size_t leaves) {
  leaves_.reserve(leaves);
  near_.resize(leaves / 64 + 1);
  for (Floats* floats : {&x_, &y_, &z_}) floats->blocks.resize(leaves / 16 + 1);
}

void LeafList::Clear(const Vec3& origin_W) {
  origin_W_ = origin_W;
  leaves_.clear();
}

void LeafList::Add(const LeafIndex& leaf, const Vec3& middle_W) {
  const std::size_t i = leaves_.size();
  if (i == leaves_.capacity()) Reserve(2 * i + 1);  // the reserve is a bound; growing is a slow but correct fallback
  const Vec3 p = middle_W - origin_W_;
  leaves_.push_back(leaf);
  x_[i] = static_cast<float>(p.x);
  y_[i] = static_cast<float>(p.y);
  z_[i] = static_cast<float>(p.z);
}

void LeafList::KeepNear(const LeafCull& cull) {
  std::size_t kept = 0;
  const auto keep = [&](std::size_t i) {
    leaves_[kept] = leaves_[i];
    for (Floats* floats : {&x_, &y_, &z_}) (*floats)[kept] = (*floats)[i];
    ++kept;
  };
  FindLeaves(cull, {x_.data(), y_.data(), z_.data()}, static_cast<int>(leaves_.size()), near_.data());
  for (std::size_t word = 0; 64 * word < leaves_.size(); ++word) {
    for (std::uint64_t bits = near_[word]; bits != 0; bits &= bits - 1) {
      keep(64 * word + static_cast<std::size_t>(std::countr_zero(bits)));
    }
  }
  leaves_.resize(kept);
}

std::size_t LeafList::CalcMemoryBytes() const {
  return leaves_.capacity() * sizeof(LeafIndex) + 3 * x_.blocks.capacity() * sizeof(Sixteen) +
         near_.capacity() * sizeof(std::uint64_t);
}

EdgeLeaves::EdgeLeaves(const BoneField& field, const EdgeZone& zone)
    : field_(field), zone_(zone), slack_mm_(std::max(kSlackLeaves * 8 * field.voxel_mm(), kMinSlack_mm)) {
  const LeafIndex lowest = field.lowest();
  const LeafIndex highest = field.highest();
  const std::size_t in_box = static_cast<std::size_t>(highest.x - lowest.x + 1) *
                             static_cast<std::size_t>(highest.y - lowest.y + 1) *
                             static_cast<std::size_t>(highest.z - lowest.z + 1);
  for (Search* search : {&now_, &next_}) {
    search->list.Reserve(std::min(BoundLeaves(zone, zone.outside_mm + slack_mm_, 8 * field.voxel_mm()), in_box));
  }
}

/// Returns true if a list is valid for a step that ends at X_WT, within the given fraction of its slack.
bool EdgeLeaves::Covers(const Search& search, const Pose& X_WT, double length_mm, bool inner, double fraction) const {
  if (!search.begun || (inner && !search.inner)) return false;
  return zone_.BoundTravel(search.X_WT, X_WT) + 2 * length_mm + 0.5 * field_.voxel_mm() <= fraction * slack_mm_;
}

bool EdgeLeaves::Update(const Pose& X_WT, double length_mm, bool inner) {
  const bool good = Covers(now_, X_WT, length_mm, inner, 1);
  now_.inner_requested = now_.inner_requested || inner;
  if (good && !next_.begun) {
    if (Covers(now_, X_WT, length_mm, inner, kFractionBeforeNext)) return false;
    Begin(X_WT, now_.inner_requested, next_);
  }
  if (!Covers(next_, X_WT, length_mm, inner, good ? 1 : kFractionBeforeNext)) Begin(X_WT, inner, next_);
  if (!Advance(next_, good ? kRowsAtOnce : std::numeric_limits<int>::max())) return false;
  std::swap(now_, next_);
  next_.begun = false;
  return true;
}

void EdgeLeaves::Begin(const Pose& X_WT, bool inner, Search& search) const {
  search.begun = true;
  search.inner = inner;
  search.inner_requested = false;
  search.X_WT = X_WT;
  search.list.Clear(X_WT.p_AB);
  // The axis along which a blade is thinnest, or which is nearest to the spindle's. For each position on the other two
  // axes, the near leaves form a range along it.
  search.thin = 2;
  if (zone_.is_cylinder()) {
    const Vec3 n = glm::abs(X_WT.Vector({0, 0, 1}));
    search.thin = n.x > n.y && n.x > n.z ? 0 : (n.y > n.z ? 1 : 2);
  }
  search.row = Stretch(search, (search.thin + 1) % 3).first;
}

/// Returns the range of leaves along one of the grid's axes that the tool may reach.
std::pair<int, int> EdgeLeaves::Stretch(const Search& search, int axis) const {
  const Vec3 normal = search.X_WT.Vector({0, 0, 1});
  const double out_mm = zone_.outside_mm + slack_mm_;
  const double flat = zone_.is_cylinder() ? std::sqrt(std::max(0.0, 1 - normal[axis] * normal[axis])) : 1.0;
  const double reach_mm =
      zone_.radius_mm * flat + out_mm + (zone_.is_cylinder() ? zone_.half_thickness_mm * std::abs(normal[axis]) : 0);
  return Clip(axis, search.X_WT.p_AB[axis], reach_mm);
}

/// Returns the range of leaves of the bone's box along one axis from middle - half to middle + half.
std::pair<int, int> EdgeLeaves::Clip(int axis, double middle_mm, double half_mm) const {
  const LeafIndex low = field_.lowest();
  const LeafIndex high = field_.highest();
  const int lowest[3] = {low.x, low.y, low.z};
  const int highest[3] = {high.x, high.y, high.z};
  const auto leaf_at = [this](double p_mm) {
    return static_cast<int>(std::floor(std::clamp(p_mm / (8 * field_.voxel_mm()), -1e9, 1e9)));
  };
  return {std::max(lowest[axis], leaf_at(middle_mm - half_mm)), std::min(highest[axis], leaf_at(middle_mm + half_mm))};
}

/// Continues the search by at most `rows` rows of columns. Returns true when the list is complete.
bool EdgeLeaves::Advance(Search& search, int rows) const {
  const int last = Stretch(search, (search.thin + 1) % 3).second;
  for (; search.row <= last; ++search.row) {
    if (rows-- == 0) return false;
    AddRow(search, search.row);
  }
  if (search.inner && zone_.outline.empty()) return true;
  const double h = field_.voxel_mm();
  const Pose& X_WT = search.X_WT;
  EdgeZone zone = zone_;
  if (search.inner) zone.depth_mm = std::numeric_limits<double>::infinity();
  search.list.KeepNear(MakeLeafCull(zone, X_WT, GridInTool(X_WT, h), h, search.list.origin_W(), slack_mm_));
  return true;
}

void EdgeLeaves::AddRow(Search& search, int i) const {
  const double h = field_.voxel_mm();
  const double leaf_mm = 8 * h;
  const double out_mm = zone_.outside_mm + slack_mm_;
  const Vec3& centre = search.X_WT.p_AB;
  const Vec3 normal = search.X_WT.Vector({0, 0, 1});
  const int thin = search.thin;
  const int a = (thin + 1) % 3;
  const int b = (thin + 2) % 3;
  const auto [first_j, last_j] = Stretch(search, b);
  const double aslant = zone_.is_cylinder() ? std::sqrt(std::max(0.0, 1 - normal[thin] * normal[thin])) : 0;
  for (int j = first_j; j <= last_j; ++j) {
    double middle_mm = centre[thin];
    double half_mm = zone_.radius_mm + out_mm;
    const double off_a_mm = (i + 0.5) * leaf_mm - centre[a];
    const double off_b_mm = (j + 0.5) * leaf_mm - centre[b];
    const double off2 = off_a_mm * off_a_mm + off_b_mm * off_b_mm;
    if (!zone_.is_cylinder()) {
      const double r_mm = zone_.radius_mm + out_mm + leaf_mm;  // a leaf's column is nearer by at most a leaf
      if (off2 > r_mm * r_mm) continue;
      half_mm = std::min(half_mm, std::sqrt(r_mm * r_mm - off2));
    } else {
      // Intersection of the column through the leaves' middles with the disc's plane, and the extent of the slab there.
      const double off_thin_mm = -(normal[a] * off_a_mm + normal[b] * off_b_mm) / normal[thin];
      const double spread_mm = 0.5 * leaf_mm * (std::abs(normal[a]) + std::abs(normal[b]));
      middle_mm += off_thin_mm;
      half_mm = (zone_.half_thickness_mm + out_mm + spread_mm) / std::abs(normal[thin]);
      // Skip a column that is entirely so far outside or inside the rim that nothing changes in it.
      const double radial_mm = std::sqrt(off2 + off_thin_mm * off_thin_mm);
      const double reach_mm = (half_mm + leaf_mm) * aslant + leaf_mm;
      if (radial_mm - reach_mm > zone_.radius_mm + out_mm) continue;
      if (!search.inner && zone_.outline.empty() &&
          radial_mm + reach_mm < zone_.radius_mm - zone_.depth_mm - slack_mm_) {
        continue;
      }
    }
    const auto [first_k, last_k] = Clip(thin, middle_mm, half_mm);
    for (int k = first_k; k <= last_k; ++k) {
      int index[3];
      index[a] = i;
      index[b] = j;
      index[thin] = k;
      const LeafIndex leaf{index[0], index[1], index[2]};
      if (field_.kind(leaf) == BoneField::LeafKind::kOutside) continue;
      search.list.Add(leaf, leaf_mm * Vec3(leaf.x, leaf.y, leaf.z) + 3.5 * h);
    }
  }
}

}  // namespace kerf
