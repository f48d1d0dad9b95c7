// Fewer triangles for the same shape.
#pragma once

#include "kerf/geometry.h"

namespace kerf {

/// At most about `triangles` triangles (at least 4), chosen by quadric error so that the shape and the volume are kept
/// [Garland and Heckbert 1997; volume preserving after Lindstrom and Turk 1998]. A closed surface stays closed. A mesh
/// that has no more triangles already is returned as it is. Throws Error when `triangles` is below 4.
TriangleMesh Decimate(const TriangleMesh& mesh, std::size_t triangles);

}  // namespace kerf
