// A .vdb held against the bytes that are there, before OpenVDB is let at it.
#pragma once

#include <istream>
#include <set>
#include <string>

namespace kerf {

/// Throws Error with one sentence unless OpenVDB can read the grids of these names from `in` without asking for more
/// than kMaxVdbMemoryBytes or for what the file doesn't hold. OpenVDB believes each length in the file: it asks for as
/// much memory, and of some writes that many bytes wherever there is room for fewer. Walks header, metadata,
/// transforms, the masks of all nodes and the lengths of all packed values; unpacks nothing. Files of version 222 to
/// 224, grids of float or int32 of the common tree. Then the checksum of a file that carries one (vdb_checksum.h) is
/// held against its bytes, those of unwanted grids too. `path` names the stream in messages; it is left at its
/// beginning. Cost: one reading of the file, and one more for the checksum.
void CheckVdb(std::istream& in, const std::string& path, const std::set<std::string>& wanted);

}  // namespace kerf
