// What a cut has done to the structures of a bone, followed while the bone changes.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "bone/grid/removed.h"
#include "kerf/bone.h"
#include "session/marks/mark.h"
#include "session/marks/mark_tube.h"
#include "session/marks/region_parts.h"
#include "session/marks/removed_sum.h"
#include "session/marks/structure_body.h"
#include "session/marks/structures.h"

namespace kerf {

/// Gives the same volumes and places as AssessStructures(), but only of structures that are cut. A change costs as much
/// as its leaves. Bone that is restored is no longer removed.
class InjuryFinder {
 public:
  using Leaf = std::array<int, 3>;  // along each axis the voxel's index divided by 8, rounded down

  /// The structures of the bone before the cuts.
  explicit InjuryFinder(std::shared_ptr<const Bone> before);

  /// Sets the user's marks.
  void SetMarks(const std::vector<Mark>& marks);
  /// Call after leaves have changed, with all of them. `now`: the bone after that.
  void Change(const Bone& now, const std::vector<Leaf>& leaves);
  /// Returns the structures that are cut, in this order: canals, teeth, lesions, marks. The distance is 0, and the part
  /// of a tooth is not determined.
  std::vector<StructureResult> Find(const Bone& now);
  /// Returns what was removed at the places for which `counts` is true, in the same order. Call after Find().
  std::vector<StructureResult> FindAt(const std::function<bool(const Vec3& p_W)>& counts) const;

 private:
  struct Structure {
    StructureResult description;
    std::map<Leaf, RemovedSum> sums{};      // by leaf; without those from which nothing was removed
    std::unique_ptr<StructureBody> body{};  // once it is cut
    bool changed = false;                   // since is_severed was determined
  };
  struct Tissues {
    RegionParts parts;
    std::array<bool, 256> regions;
    std::vector<Structure> structures;
  };
  struct MarkedStructure {
    Mark mark;
    MarkTube tube;
    Structure structure;
  };
  StructureResult SumAt(const Structure& structure, const std::function<bool(const RemovedCell& cell)>& counts) const;
  void UpdateMark(const Leaf& leaf, const std::vector<RemovedCell>& cells, MarkedStructure& marked) const;
  static void SetSum(const Leaf& leaf, const RemovedSum& sum, Structure& structure);

  std::shared_ptr<const Bone> before_;
  double mid_x_mm_;
  std::vector<Tissues> tissues_;
  std::vector<MarkedStructure> marks_;
  std::map<Leaf, std::vector<RemovedCell>> removed_;  // by the leaf of their lowest corner
};

}  // namespace kerf
