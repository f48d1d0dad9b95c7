// OpenVDB with the virtual functions of its trees and grids (reading, writing, printing, counting) declared as extern
// templates. Otherwise every source file that uses a grid would compile them again. The definitions are in OpenVDB's
// library; those that Debian's library lacks are in openvdb_templates.cpp. This header is precompiled and is used only
// with GCC: clang, which builds the fuzz targets, does not accept such declarations of members when the class is named
// by an alias.
#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tools/Count.h>

#if !defined(__clang__)

#define KERF_TREE_OF_LIBRARY(Tree)                                                             \
  extern template openvdb::Index64 openvdb::tools::countActiveVoxels(const Tree&, bool);       \
  extern template openvdb::Index64 openvdb::tools::countInactiveVoxels(const Tree&, bool);     \
  extern template openvdb::Index64 openvdb::tools::countActiveLeafVoxels(const Tree&, bool);   \
  extern template openvdb::Index64 openvdb::tools::countInactiveLeafVoxels(const Tree&, bool); \
  extern template openvdb::Index64 openvdb::tools::countActiveTiles(const Tree&, bool);        \
  extern template openvdb::Index64 openvdb::tools::memUsage(const Tree&, bool);                \
  extern template bool Tree::evalLeafBoundingBox(openvdb::CoordBBox&) const;                   \
  extern template bool Tree::evalActiveVoxelBoundingBox(openvdb::CoordBBox&) const;            \
  extern template bool Tree::evalActiveVoxelDim(openvdb::Coord&) const;                        \
  extern template bool Tree::evalLeafDim(openvdb::Coord&) const;                               \
  extern template void Tree::readTopology(std::istream&, bool);                                \
  extern template void Tree::writeTopology(std::ostream&, bool) const;                         \
  extern template void Tree::readBuffers(std::istream&, bool);                                 \
  extern template void Tree::readBuffers(std::istream&, const openvdb::CoordBBox&, bool);      \
  extern template void Tree::readNonresidentBuffers() const;                                   \
  extern template void Tree::writeBuffers(std::ostream&, bool) const;                          \
  extern template void Tree::print(std::ostream&, int) const;                                  \
  extern template void Tree::clipUnallocatedNodes();                                           \
  extern template openvdb::Index32 Tree::unallocatedLeafCount() const

#define KERF_GRID_OF_LIBRARY(Grid)                                                  \
  KERF_TREE_OF_LIBRARY(Grid::TreeType);                                             \
  extern template void Grid::pruneGrid(float);                                      \
  extern template void Grid::clip(const openvdb::CoordBBox&);                       \
  extern template openvdb::CoordBBox Grid::evalActiveVoxelBoundingBox() const;      \
  extern template openvdb::Coord Grid::evalActiveVoxelDim() const;                  \
  extern template void Grid::setTree(openvdb::TreeBase::Ptr);                       \
  extern template void Grid::newTree();                                             \
  extern template void Grid::readTopology(std::istream&);                           \
  extern template void Grid::writeTopology(std::ostream&) const;                    \
  extern template void Grid::readBuffers(std::istream&);                            \
  extern template void Grid::readBuffers(std::istream&, const openvdb::CoordBBox&); \
  extern template void Grid::readNonresidentBuffers() const;                        \
  extern template void Grid::writeBuffers(std::ostream&) const;                     \
  extern template void Grid::print(std::ostream&, int) const

KERF_GRID_OF_LIBRARY(openvdb::FloatGrid);
KERF_GRID_OF_LIBRARY(openvdb::Int32Grid);
KERF_TREE_OF_LIBRARY(openvdb::BoolTree);
KERF_TREE_OF_LIBRARY(openvdb::MaskTree);

#undef KERF_GRID_OF_LIBRARY
#undef KERF_TREE_OF_LIBRARY

#endif
