#include "bone/grid/openvdb_templates.h"

// These functions are inlined in Debian's library, and therefore not exported by it.
template openvdb::Index64 openvdb::tools::countActiveTiles(const openvdb::FloatTree&, bool);
template openvdb::Index64 openvdb::tools::countActiveTiles(const openvdb::Int32Tree&, bool);
template openvdb::Index64 openvdb::tools::countActiveTiles(const openvdb::BoolTree&, bool);
template openvdb::Index64 openvdb::tools::countActiveTiles(const openvdb::MaskTree&, bool);
template openvdb::Index64 openvdb::tools::countInactiveVoxels(const openvdb::FloatTree&, bool);
template openvdb::Index64 openvdb::tools::countInactiveVoxels(const openvdb::Int32Tree&, bool);
template openvdb::Index64 openvdb::tools::countInactiveVoxels(const openvdb::BoolTree&, bool);
template openvdb::Index64 openvdb::tools::countInactiveVoxels(const openvdb::MaskTree&, bool);
