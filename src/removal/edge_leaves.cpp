#include "removal/edge_leaves.h"

#include <limits>

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

EdgeLeaves::EdgeLeaves(const BoneField& field, const EdgeZone& zone, bool all)
    : field_(field),
      edge_zone_(zone),
      whole_zone_(zone),
      all_(all),
      slack_mm_(std::max(kSlackLeaves * 8 * field.voxel_mm(), kLeastSlack_mm)) {
  whole_zone_.depth_mm = std::numeric_limits<double>::infinity();
  const LeafIndex lowest = field.lowest();
  const LeafIndex highest = field.highest();
  const std::size_t in_box = static_cast<std::size_t>(highest.x - lowest.x + 1) *
                             static_cast<std::size_t>(highest.y - lowest.y + 1) *
                             static_cast<std::size_t>(highest.z - lowest.z + 1);
  const std::size_t bound = std::min(BoundLeaves(zone, zone.band_mm + slack_mm_, 8 * field.voxel_mm()), in_box);
  edge_.reserve(bound);
  if (all) inner_.reserve(bound);
}

bool EdgeLeaves::Update(const Pose& X_WT, double length_mm) {
  if (known_) {
    double moved_mm = glm::length(X_WT.p_AB - X_listed_.p_AB);
    if (!edge_zone_.ball) {
      const double turned = glm::length(X_WT.Vector({0, 0, 1}) - X_listed_.Vector({0, 0, 1}));
      moved_mm += turned * (edge_zone_.radius_mm + edge_zone_.half_thickness_mm + edge_zone_.band_mm);
    }
    if (moved_mm + 2 * length_mm + 0.5 * field_.voxel_mm() <= slack_mm_) return false;
  }
  Find(X_WT);
  X_listed_ = X_WT;
  known_ = true;
  return true;
}

void EdgeLeaves::Find(const Pose& X_WT) {
  edge_.clear();
  inner_.clear();
  const double h = field_.voxel_mm();
  const double leaf_mm = 8 * h;
  const double out_mm = edge_zone_.band_mm + slack_mm_;
  const LeafPlaces places(X_WT, h);
  const Vec3 normal = X_WT.Vector({0, 0, 1});

  // The axis along which the tool is thinnest; for each place on the other two, the stretch along it that is near.
  int thin = 2;
  if (!edge_zone_.ball) {
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
    const double flat = edge_zone_.ball ? 1.0 : std::sqrt(std::max(0.0, 1 - normal[axis] * normal[axis]));
    return edge_zone_.radius_mm * flat + out_mm +
           (edge_zone_.ball ? 0 : edge_zone_.half_thickness_mm * std::abs(normal[axis]));
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
      if (edge_zone_.ball) {
        const double r_mm = edge_zone_.radius_mm + out_mm + leaf_mm;  // a leaf's column is at most so much nearer
        const double left = r_mm * r_mm - off_a_mm * off_a_mm - off_b_mm * off_b_mm;
        if (left < 0) continue;
        half_mm = std::min(half_mm, std::sqrt(left));
      } else {
        // Where the column through the leaves' middles meets the disc's plane, and how far the slab about it reaches.
        middle_mm -= (normal[a] * off_a_mm + normal[b] * off_b_mm) / normal[thin];
        const double spread_mm = 0.5 * leaf_mm * (std::abs(normal[a]) + std::abs(normal[b]));
        half_mm = (edge_zone_.half_thickness_mm + out_mm + spread_mm) / std::abs(normal[thin]);
      }
      for (int k = first(thin, middle_mm, half_mm); k <= last(thin, middle_mm, half_mm); ++k) {
        int index[3];
        index[a] = i;
        index[b] = j;
        index[thin] = k;
        const LeafIndex leaf{index[0], index[1], index[2]};
        if (field_.kind(leaf) == BoneField::LeafKind::kOutside) continue;
        const Vec3 middle_T = places.Middle(leaf);
        if (places.IsNear(edge_zone_, middle_T, slack_mm_)) {
          edge_.push_back(leaf);
        } else if (all_ && places.IsNear(whole_zone_, middle_T, slack_mm_)) {
          inner_.push_back(leaf);
        }
      }
    }
  }
}

}  // namespace kerf
