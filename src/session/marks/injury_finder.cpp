#include "session/marks/injury_finder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace kerf {

InjuryFinder::InjuryFinder(std::shared_ptr<const Bone> before)
    : before_(std::move(before)), mid_x_mm_(before_->empty() ? 0.0 : before_->CalcBounds().centre().x) {
  for (const Tissue tissue : {Tissue::kCanal, Tissue::kTooth, Tissue::kLesion}) {
    Tissues all{.parts = RegionParts(*before_, tissue, mid_x_mm_),
                .regions = FindRegionsOf(*before_, tissue),
                .structures = {}};
    for (const StructureResult& part : all.parts.structures()) all.structures.push_back({.description = part});
    tissues_.push_back(std::move(all));
  }
}

/// Sets what was removed from a structure in one leaf.
void InjuryFinder::SetSum(const Leaf& leaf, const RemovedSum& sum, Structure& structure) {
  if (sum.is_empty()) {
    if (structure.sums.erase(leaf) == 0) return;
  } else {
    structure.sums[leaf] = sum;
  }
  structure.changed = true;
}

void InjuryFinder::UpdateMark(const Leaf& leaf, const std::vector<RemovedCell>& cells, MarkedStructure& marked) const {
  RemovedSum sum;
  const double h = before_->voxel_mm();
  const Vec3 lower = 8 * h * Vec3(leaf[0], leaf[1], leaf[2]);
  // Most leaves are far from the mark.
  const double reach_mm = 0.5 * 9 * h * std::sqrt(3.0);
  if (!cells.empty() && marked.tube.Find(lower + Vec3(0.5 * 9 * h)).distance_mm <= reach_mm) {
    for (const RemovedCell& cell : cells) {
      if (!(cell.mm3 > 0)) continue;
      const MarkTube::Nearest nearest = marked.tube.Find(cell.p_W);
      if (nearest.distance_mm <= 0) sum.Add(cell.mm3, nearest.p_W);
    }
  }
  SetSum(leaf, sum, marked.structure);
}

void InjuryFinder::Change(const Bone& now, const std::vector<Leaf>& leaves) {
  // A cell whose lowest corner is in one leaf may have other corners in the next leaves.
  std::set<Leaf> with_cells;
  for (const Leaf& leaf : leaves) {
    for (const Leaf& other : FindCellLeaves(leaf)) with_cells.insert(other);
  }
  for (const Leaf& leaf : with_cells) {
    std::vector<RemovedCell> cells = FindRemovedInLeaf(*before_, now, leaf);
    if (cells.empty() && !removed_.contains(leaf)) continue;
    for (Tissues& tissue : tissues_) {
      std::vector<RemovedSum> sums(tissue.structures.size());
      for (const RemovedCell& cell : cells) {
        if (const int part = FindPartOf(cell, *before_, tissue.parts, tissue.regions); part >= 0) {
          sums[static_cast<std::size_t>(part)].Add(cell);
        }
      }
      for (std::size_t i = 0; i < sums.size(); ++i) SetSum(leaf, sums[i], tissue.structures[i]);
    }
    for (MarkedStructure& marked : marks_) UpdateMark(leaf, cells, marked);
    if (cells.empty()) {
      removed_.erase(leaf);
    } else {
      removed_[leaf] = std::move(cells);
    }
  }
}

void InjuryFinder::SetMarks(const std::vector<Mark>& marks) {
  std::vector<MarkedStructure> next;
  for (const Mark& mark : marks) {
    if (mark.points_W.empty()) continue;
    const auto same =
        std::find_if(marks_.begin(), marks_.end(), [&](const MarkedStructure& m) { return m.mark == mark; });
    if (same != marks_.end()) {
      next.push_back(std::move(*same));
      marks_.erase(same);
      continue;
    }
    MarkTube tube(mark);
    StructureResult description = DescribeMark(mark, tube, mid_x_mm_);
    next.push_back({.mark = mark, .tube = std::move(tube), .structure = {.description = std::move(description)}});
    for (const auto& [leaf, cells] : removed_) UpdateMark(leaf, cells, next.back());
  }
  marks_ = std::move(next);
}

std::vector<StructureResult> InjuryFinder::Find(const Bone& now) {
  std::vector<StructureResult> found;
  const auto take = [&](Structure& structure, const auto& make_body) {
    StructureResult& result = structure.description;
    if (std::exchange(structure.changed, false)) {
      RemovedSum sum;
      for (const auto& [leaf, part] : structure.sums) sum.Add(part);
      sum.Fill(before_->voxel_mm(), result);
      if (result.is_cut && !structure.body) structure.body = make_body();
      result.is_severed = result.is_cut && structure.body->IsSevered(now);
    }
    if (result.is_cut) found.push_back(result);
  };
  for (Tissues& tissue : tissues_) {
    for (std::size_t i = 0; i < tissue.structures.size(); ++i) {
      take(tissue.structures[i],
           [&] { return std::make_unique<StructureBody>(*before_, tissue.parts, static_cast<int>(i)); });
    }
  }
  for (MarkedStructure& marked : marks_) {
    take(marked.structure, [&] { return std::make_unique<StructureBody>(*before_, marked.tube); });
  }
  return found;
}

StructureResult InjuryFinder::SumAt(const Structure& structure,
                                    const std::function<bool(const RemovedCell& cell)>& counts) const {
  RemovedSum sum;
  for (const auto& [leaf, part] : structure.sums) {
    for (const RemovedCell& cell : removed_.at(leaf)) {
      if (cell.mm3 > 0 && counts(cell)) sum.Add(cell);
    }
  }
  StructureResult result = structure.description;
  sum.Fill(before_->voxel_mm(), result);
  return result;
}

std::vector<StructureResult> InjuryFinder::FindAt(const std::function<bool(const Vec3& p_W)>& counts) const {
  std::vector<StructureResult> found;
  const auto take = [&](const Structure& structure, const auto& contains) {
    if (!structure.description.is_cut) return;
    StructureResult result =
        SumAt(structure, [&](const RemovedCell& cell) { return contains(cell) && counts(cell.p_W); });
    if (result.is_cut) found.push_back(std::move(result));
  };
  for (const Tissues& tissue : tissues_) {
    for (std::size_t i = 0; i < tissue.structures.size(); ++i) {
      take(tissue.structures[i], [&](const RemovedCell& cell) {
        return FindPartOf(cell, *before_, tissue.parts, tissue.regions) == static_cast<int>(i);
      });
    }
  }
  for (const MarkedStructure& marked : marks_) {
    take(marked.structure, [&](const RemovedCell& cell) { return marked.tube.Find(cell.p_W).distance_mm <= 0; });
  }
  return found;
}

}  // namespace kerf
