// Fewer triangles for the same shape.
#pragma once

#include "kerf/geometry.h"

namespace kerf {

/// At most `triangles` triangles (at least 4): edges are drawn together one by one, the one of least quadric error
/// first [Garland and Heckbert 1997], and never where that would tear, pinch or fold the surface. So a closed surface
/// stays closed and of the same genus, and more triangles are left when no further edge may go. A mesh that has no more
/// already is returned as it is. VTK's quadric decimation is not used: it needs minutes and gigabytes on the flat faces
/// of a block, where all errors are equal. Throws Error when `triangles` is below 4. 600,000 triangles to 5,000: about
/// 3 s and 0.5 GB.
TriangleMesh Decimate(const TriangleMesh& mesh, std::size_t triangles);

}  // namespace kerf
