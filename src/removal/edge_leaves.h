// The leaves near the tool's edge, found anew only when the tool has moved some way.
#pragma once

#include <vector>

#include "bone/field.h"
#include "removal/sweep.h"

namespace kerf {

/// Neighbour lists with slack, as Verlet's of molecules: a list of all leaves within `slack` of the zone about the edge
/// stays good until the tool has moved by that much.
class EdgeLeaves {
 public:
  /// `zone`: what the edge changes at most. `all`: keep those inside the edge too. Allocates.
  EdgeLeaves(const BoneField& field, const EdgeZone& zone, bool all);

  /// Makes the lists good for a step to X_WT over `length_mm` <= slack_mm() / 4. True when they were found anew.
  /// Tick-safe.
  bool Update(const Pose& X_WT, double length_mm);
  double slack_mm() const { return slack_mm_; }
  /// Those that hold bone, or did when the list was made.
  const std::vector<LeafIndex>& edge() const { return edge_; }
  /// Further inside the tool; empty unless `all`.
  const std::vector<LeafIndex>& inner() const { return inner_; }
  std::size_t CalcMemoryBytes() const { return (edge_.capacity() + inner_.capacity()) * sizeof(LeafIndex); }

 private:
  void Find(const Pose& X_WT);

  const BoneField& field_;
  EdgeZone edge_zone_;
  EdgeZone whole_zone_;
  bool all_;
  double slack_mm_;
  bool known_ = false;
  Pose X_listed_;
  std::vector<LeafIndex> edge_;
  std::vector<LeafIndex> inner_;
};

}  // namespace kerf
