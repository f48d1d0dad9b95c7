// Leaves of phi that belong to another tree, the lender, because several bones share them (see shared_leaves.h).
#pragma once

#include <memory>

#include "bone/grid/grids.h"

namespace kerf {

/// Returns the tree that owns the shared leaves of a grid; null if it shares none. Tick-safe.
const openvdb::FloatTree* FindLender(const openvdb::FloatGrid& phi);

/// Puts a leaf into a tree in place of a shared one of the same origin, which stays as it is. Tick-safe.
void ReplaceShared(openvdb::FloatTree& tree, std::unique_ptr<openvdb::FloatTree::LeafNodeType> own);

/// Returns the leaf of phi at an origin, for writing: a copy of it if it was shared, a new one if there was none.
openvdb::FloatTree::LeafNodeType& OwnLeaf(openvdb::FloatGrid& phi, const openvdb::Coord& origin);

}  // namespace kerf
