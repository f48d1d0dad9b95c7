#include "removal/edge_leaves.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kSlackLeaves = 1;    // of a leaf's edge
constexpr double kLeastSlack_mm = 1;  // a tool at 5 mm/s moves so far in 200 ticks

/// How many leaves can lie within `out` of a tool of this size: those inside it grown by a leaf's diagonal.
std::size_t BoundLeaves(const EdgeZone& zone, double out_mm, double leaf_mm) {
  const double grown_mm = out_mm + 2 * std::sqrt(3.0) * leaf_mm;
  const double radius_mm = zone.radius_mm + grown_mm;
  const double volume_mm3 = zone.ball ? 4 * kPi / 3 * radius_mm * radius_mm * radius_mm
                                      : kPi * radius_mm * radius_mm * 2 * (zone.half_thickness_mm + grown_mm);
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
    : field_(field), zone_(zone), slack_mm_(std::max(kSlackLeaves * 8 * field.voxel_mm(), kLeastSlack_mm)) {
  const LeafIndex lowest = field.lowest();
  const LeafIndex highest = field.highest();
  const std::size_t in_box = static_cast<std::size_t>(highest.x - lowest.x + 1) *
                             static_cast<std::size_t>(highest.y - lowest.y + 1) *
                             static_cast<std::size_t>(highest.z - lowest.z + 1);
  list_.Reserve(std::min(BoundLeaves(zone, zone.band_mm + slack_mm_, 8 * field.voxel_mm()), in_box));
}

bool EdgeLeaves::Update(const Pose& X_WT, double length_mm, bool inner) {
  if (known_ && (has_inner_ || !inner)) {
    double moved_mm = glm::length(X_WT.p_AB - X_listed_.p_AB);
    if (!zone_.ball) {
      const double turned = glm::length(X_WT.Vector({0, 0, 1}) - X_listed_.Vector({0, 0, 1}));
      moved_mm += turned * (zone_.radius_mm + zone_.half_thickness_mm + zone_.band_mm);
    }
    if (moved_mm + 2 * length_mm + 0.5 * field_.voxel_mm() <= slack_mm_) return false;
  }
  has_inner_ = inner;
  known_ = true;
  X_listed_ = X_WT;
  Find(X_WT);
  return true;
}

void EdgeLeaves::Find(const Pose& X_WT) {
  list_.Clear(X_WT.p_AB);
  const double h = field_.voxel_mm();
  const double leaf_mm = 8 * h;
  const double out_mm = zone_.band_mm + slack_mm_;
  const Vec3 normal = X_WT.Vector({0, 0, 1});

  // The axis along which the tool is thinnest; for each place on the other two, the stretch along it that is near.
  int thin = 2;
  if (!zone_.ball) {
    const Vec3 n = glm::abs(normal);
    thin = n.x > n.y && n.x > n.z ? 0 : (n.y > n.z ? 1 : 2);
  }
  const int a = (thin + 1) % 3;
  const int b = (thin + 2) % 3;
  const LeafIndex low = field_.lowest();
  const LeafIndex high = field_.highest();
  const int lowest[3] = {low.x, low.y, low.z};
  const int highest[3] = {high.x, high.y, high.z};
  const auto leaf_at = [leaf_mm](double p_mm) { return static_cast<int>(std::floor(p_mm / leaf_mm)); };
  const auto reach_mm = [&](int axis) {
    const double flat = zone_.ball ? 1.0 : std::sqrt(std::max(0.0, 1 - normal[axis] * normal[axis]));
    return zone_.radius_mm * flat + out_mm + (zone_.ball ? 0 : zone_.half_thickness_mm * std::abs(normal[axis]));
  };
  const auto first = [&](int axis, double p_mm, double out) { return std::max(lowest[axis], leaf_at(p_mm - out)); };
  const auto last = [&](int axis, double p_mm, double out) { return std::min(highest[axis], leaf_at(p_mm + out)); };
  const Vec3& centre = X_WT.p_AB;
  const double reach_a_mm = reach_mm(a);
  const double reach_b_mm = reach_mm(b);
  const double reach_thin_mm = reach_mm(thin);
  for (int i = first(a, centre[a], reach_a_mm); i <= last(a, centre[a], reach_a_mm); ++i) {
    for (int j = first(b, centre[b], reach_b_mm); j <= last(b, centre[b], reach_b_mm); ++j) {
      double middle_mm = centre[thin];
      double half_mm = reach_thin_mm;
      const double off_a_mm = (i + 0.5) * leaf_mm - centre[a];
      const double off_b_mm = (j + 0.5) * leaf_mm - centre[b];
      if (zone_.ball) {
        const double r_mm = zone_.radius_mm + out_mm + leaf_mm;  // a leaf's column is at most so much nearer
        const double left = r_mm * r_mm - off_a_mm * off_a_mm - off_b_mm * off_b_mm;
        if (left < 0) continue;
        half_mm = std::min(half_mm, std::sqrt(left));
      } else {
        // Where the column through the leaves' middles meets the disc's plane, and how far the slab about it reaches.
        middle_mm -= (normal[a] * off_a_mm + normal[b] * off_b_mm) / normal[thin];
        const double spread_mm = 0.5 * leaf_mm * (std::abs(normal[a]) + std::abs(normal[b]));
        half_mm = (zone_.half_thickness_mm + out_mm + spread_mm) / std::abs(normal[thin]);
        if (!has_inner_) {
          // All of the column so far inside the rim that nothing changes there?
          const double off_thin_mm = middle_mm - centre[thin];
          const double radial_mm = std::sqrt(off_a_mm * off_a_mm + off_b_mm * off_b_mm + off_thin_mm * off_thin_mm);
          const double aslant = std::sqrt(std::max(0.0, 1 - normal[thin] * normal[thin]));
          if (radial_mm + (half_mm + leaf_mm) * aslant + leaf_mm < zone_.radius_mm - zone_.depth_mm - slack_mm_)
            continue;
        }
      }
      for (int k = first(thin, middle_mm, half_mm); k <= last(thin, middle_mm, half_mm); ++k) {
        int index[3];
        index[a] = i;
        index[b] = j;
        index[thin] = k;
        const LeafIndex leaf{index[0], index[1], index[2]};
        if (field_.kind(leaf) == BoneField::LeafKind::kOutside) continue;
        list_.Add(leaf, leaf_mm * Vec3(leaf.x, leaf.y, leaf.z) + 3.5 * h);
      }
    }
  }
  if (has_inner_) return;
  list_.KeepNear(MakeLeafCull(zone_, X_WT, GridInTool(X_WT, h), h, list_.origin_W(), slack_mm_));
}

}  // namespace kerf
