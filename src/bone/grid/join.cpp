#include "bone/grid/join.h"

#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "bone/grid/parts_reader.h"
#include "bone/grid/set_leaf.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr float kReach_vox = 2.9f;  // from the piece to the voxels on which its volume depends; see CellFields

/// Gives the bone the cut that the piece has, in the piece and next to it. Other bone stays as it is: it may have been
/// cut since.
void Join(const Bone& piece, Bone& bone) {
  const BoneGrids& grids = GridsOf(piece);
  const PartsReader reader(grids);
  const auto phi = grids.phi->getConstAccessor();
  const float reach_mm = std::min(kReach_vox * static_cast<float>(piece.voxel_mm()), grids.phi->background());
  ForEachBlock(grids.phi->tree(), [&](const openvdb::Coord& origin) {
    const auto* const leaf = phi.probeConstLeaf(origin);
    const float* const piece_cut = reader.At(origin).cut;
    const PartsReader now(GridsOf(bone));
    const PhiParts parts = now.At(origin);
    const float band = grids.phi->background();
    if (std::all_of(parts.whole, parts.whole + 512, [band](float value) { return value >= band; })) return;
    std::array<float, 512> cut;
    for (openvdb::Index i = 0; i < 512; ++i) {
      const float distance_mm = leaf != nullptr ? leaf->getValue(i) : phi.getValue(origin);
      const bool is_other_bone = distance_mm >= 0 && piece_cut[i] < 0 && parts.whole[i] < 0;
      cut[i] = distance_mm < reach_mm && !is_other_bone ? std::min(parts.cut[i], piece_cut[i]) : parts.cut[i];
    }
    SetCut(bone, {origin.x() >> 3, origin.y() >> 3, origin.z() >> 3}, cut);
  });
}

}  // namespace

Bone JoinBones(const Bone& bone, const std::vector<const Bone*>& pieces) {
  Bone joined = bone;
  for (const Bone* piece : pieces) {
    if (piece->empty()) continue;
    if (std::abs(piece->voxel_mm() - bone.voxel_mm()) > 1e-9 * bone.voxel_mm()) {
      throw Error("a piece has a different voxel size from the bone that it was cut from");
    }
    Join(*piece, joined);
  }
  openvdb::FloatGrid& phi = *GridsOf(joined).phi;
  openvdb::tools::pruneLevelSet(phi.tree(), phi.background(), -phi.background());
  return joined;
}

}  // namespace kerf
