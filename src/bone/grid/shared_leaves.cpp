#include "bone/grid/shared_leaves.h"

#include <memory>
#include <utility>
#include <vector>

#include "bone/grid/lent_leaves.h"

namespace kerf {
namespace {

using SharedTree = openvdb::FloatTree;
using SharedLeaf = SharedTree::LeafNodeType;

/// Destroys a tree, but not the leaves that it shares: they belong to the lender.
struct DeleteBorrower {
  std::shared_ptr<const SharedTree> lender;

  void operator()(SharedTree* tree) const {
    std::vector<const SharedLeaf*> leaves;
    std::as_const(*tree).getNodes(leaves);
    for (const SharedLeaf* leaf : leaves) {
      if (lender->probeConstLeaf(leaf->origin()) != leaf) continue;
      tree->stealNode<SharedLeaf>(leaf->origin(), tree->background(), false);
    }
    delete tree;
  }
};

/// Returns a copy of a grid that shares the leaves of `lender`, except those for which is_own(origin) returns true.
template <typename IsOwn>
openvdb::FloatGrid::Ptr CopyGridSharing(const openvdb::FloatGrid& from, std::shared_ptr<const SharedTree> lender,
                                        IsOwn is_own) {
  const SharedTree& tree = from.constTree();
  const SharedTree& lent = *lender;
  const SharedTree::Ptr made(new SharedTree(tree.background()), DeleteBorrower{std::move(lender)});
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(SharedTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (*tile == tree.background() && !tile.isValueOn()) continue;
    made->addTile(tile.getLevel(), tile.getCoord(), *tile, tile.isValueOn());
  }
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const SharedLeaf* const shared = lent.probeConstLeaf(leaf->origin());
    const bool shares = shared == leaf.getLeaf() && !is_own(leaf->origin());
    // The tree takes pointers to leaves that may be changed, but those that it shares are not.
    made->addLeaf(shares ? const_cast<SharedLeaf*>(shared) : new SharedLeaf(*leaf));
  }
  auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(from.copyGridWithNewTree());
  grid->setTree(made);
  return grid;
}

const DeleteBorrower* FindBorrower(const openvdb::FloatGrid& phi) {
  return std::get_deleter<DeleteBorrower>(phi.constTreePtr());
}

}  // namespace

void ShareLeaves(Bone& bone) {
  BoneGrids& grids = GridsOf(bone);
  if (FindBorrower(*grids.phi) != nullptr) return;
  grids.phi = CopyGridSharing(*grids.phi, grids.phi->constTreePtr(), [&](const openvdb::Coord& origin) {
    return grids.cut &&
           (grids.cut->constTree().probeConstLeaf(origin) != nullptr || grids.cut->constTree().getValue(origin) > 0);
  });
}

Bone CopySharing(const Bone& bone) {
  const BoneGrids& from = GridsOf(bone);
  const DeleteBorrower* const borrower = FindBorrower(*from.phi);
  if (borrower == nullptr) return bone;
  Bone copy;
  BoneGrids& grids = GridsOf(copy);
  grids = from;
  grids.phi = CopyGridSharing(*from.phi, borrower->lender, [](const openvdb::Coord&) { return false; });
  if (from.cut) {
    grids.whole = from.whole->deepCopy();
    grids.cut = from.cut->deepCopy();
  }
  return copy;
}

std::uint64_t CalcOwnBytes(const Bone& bone) {
  const openvdb::FloatGrid& phi = *GridsOf(bone).phi;
  std::uint64_t bytes = bone.CalcMemoryBytes();
  const DeleteBorrower* const borrower = FindBorrower(phi);
  if (borrower == nullptr) return bytes;
  for (auto leaf = phi.constTree().cbeginLeaf(); leaf; ++leaf) {
    if (borrower->lender->probeConstLeaf(leaf->origin()) == leaf.getLeaf()) bytes -= leaf->memUsage();
  }
  return bytes;
}

const openvdb::FloatTree* FindLender(const openvdb::FloatGrid& phi) {
  const DeleteBorrower* const borrower = FindBorrower(phi);
  return borrower == nullptr ? nullptr : borrower->lender.get();
}

void ReplaceShared(openvdb::FloatTree& tree, std::unique_ptr<SharedLeaf> own) {
  tree.stealNode<SharedLeaf>(own->origin(), tree.background(), false);
  tree.addLeaf(own.release());
}

openvdb::FloatTree::LeafNodeType& OwnLeaf(openvdb::FloatGrid& phi, const openvdb::Coord& origin) {
  SharedTree& tree = phi.tree();
  const SharedTree* const lender = FindLender(phi);
  const SharedLeaf* const leaf = lender == nullptr ? nullptr : tree.probeConstLeaf(origin);
  if (leaf != nullptr && leaf == lender->probeConstLeaf(origin)) {
    ReplaceShared(tree, std::make_unique<SharedLeaf>(*leaf));
  }
  return *tree.touchLeaf(origin);
}

}  // namespace kerf
