#include "bone/grid/slab_section.h"

#include <algorithm>
#include <limits>
#include <set>
#include <unordered_set>

namespace kerf {
namespace {

using openvdb::Coord;

struct SectionPart {
  PlaneSide side = PlaneSide::kNear;
  std::size_t left_voxels = 0;  // with a distance below 0
  std::size_t right_voxels = 0;
  bool touches_left = false;  // touches bone beyond the reach
  bool touches_right = false;
  bool has_left = false;  // has bone beyond the slice
  bool has_right = false;
  bool in_slab = false;
  double near2 = std::numeric_limits<double>::infinity();  // squared distance to the chosen point, mm^2
};

/// A component near the plane and an adjacent one beyond the reach.
struct Link {
  std::size_t near;
  std::size_t beside;
  bool operator<(const Link& o) const { return near != o.near ? near < o.near : beside < o.beside; }
};

PlaneSide SideOfNode(const LabelledBlock& block, std::uint16_t part, const PlaneDistance& distance, double reach_mm) {
  Coord c = block.origin;
  if (block.leaf) {
    const auto at = std::find(block.part.begin(), block.part.end(), part) - block.part.begin();
    c = block.leaf->offsetToGlobalCoord(static_cast<openvdb::Index>(at));
  }
  return SideOf(distance(c), reach_mm);
}

class Chooser {
 public:
  Chooser(const Labels& labels, const PlaneDistance& distance, double reach_mm, double half_thickness_mm,
          const Vec3& near_W)
      : labels_(labels), distance_(distance), sets_(labels.node_count) {
    Connect(reach_mm);
    Measure(half_thickness_mm, near_W);
  }

  Section Choose() {
    Section section;
    std::vector<std::size_t> shallow;
    for (std::size_t root = 0; root < components_.size(); ++root) {
      const SectionPart& c = components_[root];
      const bool left = c.touches_left || c.has_left;
      const bool right = c.touches_right || c.has_right;
      if (c.touches_left && c.touches_right) {
        places_.push_back(root);
      } else if (left && right && c.in_slab) {
        shallow.push_back(root);
      }
    }
    if (places_.empty() && shallow.empty()) return section;
    const auto is_nearer = [this](std::size_t a, std::size_t b) {
      const double da = components_[a].near2;
      const double db = components_[b].near2;
      return da != db ? da < db : a < b;
    };
    std::sort(places_.begin(), places_.end(), is_nearer);
    std::sort(shallow.begin(), shallow.end(), is_nearer);
    // Surface roughness that just reaches through the slice must not be chosen instead of the intended place, unless
    // the point lies in it.
    const double in_it2 = std::pow(2 * distance_.voxel_mm, 2);
    const bool is_shallow = !shallow.empty() && (places_.empty() || (components_[shallow.front()].near2 <= in_it2 &&
                                                                     is_nearer(shallow.front(), places_.front())));
    const std::size_t first = is_shallow ? shallow.front() : places_.front();
    section.places = places_.size() + (is_shallow ? 1 : 0);
    section.distance_mm = std::sqrt(components_[first].near2);
    cut_.insert(first);
    UnionFind<> whole = JoinUncut();
    for (std::size_t next = FindHolding(whole); next != labels_.node_count; next = FindHolding(whole)) {
      cut_.insert(next);
      whole = JoinUncut();
    }
    section.cut_places = cut_.size();
    section.everywhere = true;
    for (std::size_t root = 0; root < components_.size(); ++root) {
      const bool in_slab = components_[root].side == PlaneSide::kNear && components_[root].in_slab;
      if (in_slab && !cut_.contains(root)) section.everywhere = false;
    }
    AssignFates(whole, section);
    return section;
  }

 private:
  void Connect(double reach_mm) {
    sides_.resize(labels_.node_count);
    for (const LabelledBlock& block : labels_.blocks) {
      for (std::uint16_t part = 0; part < block.part_count; ++part) {
        sides_[block.first_node + part] = SideOfNode(block, part, distance_, reach_mm);
      }
    }
    std::vector<Link> touches;
    ForEachTouch(labels_, [&](std::size_t a, std::size_t b) {
      if (sides_[a] == sides_[b]) {
        sets_.Join(a, b);
        return;
      }
      const Link link = sides_[a] == PlaneSide::kNear ? Link{a, b} : Link{b, a};
      if (touches.empty() || touches.back() < link || link < touches.back()) touches.push_back(link);
    });
    std::set<Link> links;
    for (const Link& link : touches) links.insert({sets_.Find(link.near), sets_.Find(link.beside)});
    links_.assign(links.begin(), links.end());
  }

  void Measure(double half_thickness_mm, const Vec3& near_W) {
    // A thin slice may contain no voxel centre.
    const double slab_mm = std::max(half_thickness_mm, distance_.voxel_mm);
    components_.resize(labels_.node_count);
    for (const LabelledBlock& block : labels_.blocks) {
      if (!block.leaf) {
        const std::size_t root = sets_.Find(block.first_node);
        SectionPart& c = components_[root];
        c.side = sides_[root];
        (c.side == PlaneSide::kLeft ? c.left_voxels : c.right_voxels) += 512;
        continue;
      }
      for (openvdb::Index i = 0; i < 512; ++i) {
        if (block.part[i] == kNoPart) continue;
        const std::size_t root = sets_.Find(block.first_node + block.part[i]);
        SectionPart& c = components_[root];
        c.side = sides_[root];
        const Coord ijk = block.leaf->offsetToGlobalCoord(i);
        const double s = distance_(ijk);
        ++(s < 0 ? c.left_voxels : c.right_voxels);
        c.has_left = c.has_left || s < -half_thickness_mm;
        c.has_right = c.has_right || s > half_thickness_mm;
        if (c.side != PlaneSide::kNear || std::abs(s) > slab_mm) continue;
        c.in_slab = true;
        const Vec3 d = distance_.voxel_mm * Vec3(ijk.x(), ijk.y(), ijk.z()) - near_W;
        c.near2 = std::min(c.near2, d.x * d.x + d.y * d.y + d.z * d.z);
      }
    }
    for (const Link& link : links_) {
      SectionPart& near = components_[link.near];
      (sides_[link.beside] == PlaneSide::kLeft ? near.touches_left : near.touches_right) = true;
    }
  }

  /// Returns the sets of components that remain connected when `cut_` is severed.
  UnionFind<> JoinUncut() const {
    UnionFind<> whole(labels_.node_count);
    for (const Link& link : links_) {
      if (!cut_.contains(link.near)) whole.Join(link.near, link.beside);
    }
    return whole;
  }

  std::unordered_set<std::size_t> FindBeside(UnionFind<>& whole, PlaneSide side) const {
    std::unordered_set<std::size_t> found;
    for (const Link& link : links_) {
      if (cut_.contains(link.near) && sides_[link.beside] == side) found.insert(whole.Find(link.beside));
    }
    return found;
  }

  /// Returns the nearest uncut place in bone that connects the two sides; node_count if there is none.
  std::size_t FindHolding(UnionFind<>& whole) const {
    const auto left = FindBeside(whole, PlaneSide::kLeft);
    const auto right = FindBeside(whole, PlaneSide::kRight);
    for (const std::size_t place : places_) {
      const std::size_t root = whole.Find(place);
      if (!cut_.contains(place) && left.contains(root) && right.contains(root)) return place;
    }
    return labels_.node_count;
  }

  void AssignFates(UnionFind<>& whole, Section& section) {
    const auto left = FindBeside(whole, PlaneSide::kLeft);
    const auto right = FindBeside(whole, PlaneSide::kRight);
    std::vector<std::size_t> left_voxels(labels_.node_count), right_voxels(labels_.node_count);
    for (std::size_t root = 0; root < components_.size(); ++root) {
      left_voxels[whole.Find(root)] += components_[root].left_voxels;
      right_voxels[whole.Find(root)] += components_[root].right_voxels;
    }
    section.fates.resize(labels_.node_count);
    for (std::size_t node = 0; node < labels_.node_count; ++node) {
      const std::size_t root = sets_.Find(node);
      const std::size_t body = whole.Find(root);
      PartFate fate = left_voxels[body] >= right_voxels[body] ? PartFate::kLeft : PartFate::kRight;
      if (left.contains(body)) fate = PartFate::kLeft;
      if (right.contains(body)) fate = PartFate::kRight;
      if (cut_.contains(root)) fate = PartFate::kCut;
      section.fates[node] = fate;
    }
  }

  const Labels& labels_;
  const PlaneDistance& distance_;
  UnionFind<> sets_;
  std::vector<PlaneSide> sides_;         // by node
  std::vector<Link> links_;              // between roots
  std::vector<SectionPart> components_;  // by root; other entries are empty
  std::vector<std::size_t> places_;      // roots of components with bone beyond the reach on both sides, nearest first
  std::unordered_set<std::size_t> cut_;
};

}  // namespace

Section ChooseSection(const Labels& labels, const PlaneDistance& distance, double reach_mm, double half_thickness_mm,
                      const Vec3& near_W) {
  return Chooser(labels, distance, reach_mm, half_thickness_mm, near_W).Choose();
}

}  // namespace kerf
