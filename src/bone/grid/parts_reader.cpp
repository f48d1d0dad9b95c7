#include "bone/grid/parts_reader.h"

#include <algorithm>
#include <memory>

namespace kerf {

using openvdb::Coord;

PartsReader::PartsReader(const BoneGrids& grids) : phi_(grids.phi->getConstAccessor()) {
  outside_.fill(grids.phi->background());
  inside_.fill(-grids.phi->background());
  if (!grids.cut) return;
  whole_.emplace(grids.whole->getConstAccessor());
  cut_.emplace(grids.cut->getConstAccessor());
}

PhiParts PartsReader::At(const Coord& origin) const {
  bool is_cut = false;
  if (cut_) {
    if (const auto* cut = cut_->probeConstLeaf(origin)) {
      return {whole_->probeConstLeaf(origin)->buffer().data(), cut->buffer().data()};
    }
    is_cut = cut_->getValue(origin) > 0;  // the tile of a leaf whose phi is that of the cut
  }
  const auto* leaf = phi_.probeConstLeaf(origin);
  if (leaf == nullptr) {
    if (phi_.getValue(origin) < 0) return {inside_.data(), inside_.data()};
    return {is_cut ? inside_.data() : outside_.data(), outside_.data()};
  }
  const float* const phi = leaf->buffer().data();
  return is_cut ? PhiParts{inside_.data(), phi} : PhiParts{phi, inside_.data()};
}

PhiCorners PartsReader::Corners(const CellPoint& cell) const {
  Coord last = Coord::max();
  PhiParts parts;
  return FindPhiCorners(cell, outside_[0], [&](int x, int y, int z) {
    const Coord origin = Coord(x, y, z) & ~7;
    if (origin != last) parts = At(origin);
    last = origin;
    return parts;
  });
}

double PartsReader::Sample(const Vec3& p_vox) const {
  const CellPoint cell = FindCell(p_vox);
  if (!cut_) return Interpolate(GetCorners(phi_, cell), cell.f);
  const PhiCorners corners = Corners(cell);
  return std::max(Interpolate(corners.whole, cell.f), Interpolate(corners.cut, cell.f));
}

void PartsReader::Load(const Coord& origin, CellFields& fields) const {
  fields.Load([&](int x, int y, int z) { return At(origin.offsetBy(8 * x, 8 * y, 8 * z)); });
}

bool PartsReader::IsCutAround(const Coord& origin) const {
  if (!cut_) return false;
  for (int i = 0; i < 27; ++i) {
    const PhiParts parts = At(origin.offsetBy(8 * (i / 9 - 1), 8 * (i / 3 % 3 - 1), 8 * (i % 3 - 1)));
    if (parts.cut != inside_.data() && parts.cut != parts.whole) return true;
  }
  return false;
}

namespace {

/// Returns whether a voxel or one of its 26 neighbours is inside.
bool IsBeside(const openvdb::FloatGrid::ConstAccessor& phi, const Coord& ijk) {
  for (int i = 0; i < 27; ++i) {
    if (phi.getValue(ijk.offsetBy(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1)) < 0) return true;
  }
  return false;
}

}  // namespace

void CopyParts(const BoneGrids& bone, BoneGrids& piece) {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  piece.whole = piece.cut = nullptr;
  if (!bone.cut) return;
  AddPartGrids(piece);
  const auto phi = piece.phi->getConstAccessor();
  const auto phi_of_bone = bone.phi->getConstAccessor();
  const auto whole = bone.whole->getConstAccessor();
  const auto cut = bone.cut->getConstAccessor();
  const float band = bone.phi->background();
  // Other bone is taken out of the whole bone, so that the cut keeps the values on which volumes beside it depend.
  for (auto leaf = piece.phi->tree().cbeginLeaf(); leaf; ++leaf) {
    const Coord origin = leaf->origin();
    const Leaf* const cut_of_bone = cut.probeConstLeaf(origin);
    if (cut_of_bone == nullptr && !(cut.getValue(origin) > 0)) continue;
    const Leaf* const was = phi_of_bone.probeConstLeaf(origin);
    if (was == nullptr) {
      // Nothing is left in it: its phi is that of the cut, or of both fields, which it still has.
      if (cut_of_bone == nullptr) {
        piece.cut->tree().addTile(1, origin, band, true);
      } else {
        piece.whole->tree().addLeaf(new Leaf(*whole.probeConstLeaf(origin)));
        piece.cut->tree().addLeaf(new Leaf(*cut_of_bone));
      }
      continue;
    }
    if (cut_of_bone == nullptr && leaf->buffer() == was->buffer()) {
      piece.cut->tree().addTile(1, origin, band, true);
      continue;
    }
    std::unique_ptr<Leaf> own;
    if (cut_of_bone != nullptr) {
      // Away from the piece the whole bone is air: otherwise slivers would remain between the voxels of other bone and
      // those above its surface.
      own = std::make_unique<Leaf>(*whole.probeConstLeaf(origin));
      for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
        if (!IsBeside(phi, leaf->offsetToGlobalCoord(i))) own->setValueOnly(i, leaf->getValue(i));
      }
    } else {
      own = std::make_unique<Leaf>(origin, -band, true);
    }
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
      if (leaf->getValue(i) != was->getValue(i)) own->setValueOnly(i, band);
    }
    piece.whole->tree().addLeaf(own.release());
    auto own_cut = std::make_unique<Leaf>(cut_of_bone != nullptr ? *cut_of_bone : *was);
    own_cut->setValuesOn();
    piece.cut->tree().addLeaf(own_cut.release());
  }
}

}  // namespace kerf
