// Check of a .vdb file against its actual bytes, before OpenVDB reads it.
#pragma once

#include <istream>
#include <set>
#include <string>

namespace kerf {

/// Checks that OpenVDB can read the grids with the names `wanted` from `in` without needing more memory than
/// kMaxVdbMemoryBytes or more data than the file holds. Throws kerf::Error with one sentence otherwise. The check is
/// needed because OpenVDB trusts each length in the file: it allocates that much memory, and sometimes writes that
/// number of bytes into a smaller buffer. Traverses the header, metadata, transforms, the masks of all nodes and the
/// lengths of all packed values, without unpacking. Supports file versions 222 to 224 and grids of float or int32 with
/// the common tree. If the file carries a checksum (vdb_checksum.h), all its bytes, including those of unwanted grids,
/// are checked against it. `path` names the stream in messages; the stream is left at its beginning. Cost: reads the
/// file once, or twice if there is a checksum.
void CheckVdb(std::istream& in, const std::string& path, const std::set<std::string>& wanted);

}  // namespace kerf
