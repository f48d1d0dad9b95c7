// Connected parts of a mask on the CT lattice.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bone/import/volume.h"

namespace kerf {

/// One connected part. Two voxels are connected if they share a face.
struct Component {
  std::size_t voxels = 0;
  double volume_mm3 = 0;
  Vec3 centre_W{0};                                   // centre of mass, LPS, mm
  Box3 box_W;                                         // of the voxels with their full extent, along the patient's axes
  std::array<int, 3> lower{0, 0, 0}, upper{0, 0, 0};  // voxels, both included
};

struct Components {
  std::vector<std::int32_t> labels;  // for each voxel: 0 outside the mask, otherwise 1 + index into list
  std::vector<Component> list;       // largest first
};

/// Finds the connected parts of a mask. `inside` is called once for each voxel, with the voxel's index. `progress`,
/// which is optional, is called with values from 0 to 1 and may throw Cancelled.
Components FindComponents(const Volume& lattice, const std::function<bool(std::size_t)>& inside,
                          const std::function<void(double)>& progress = {});

/// Returns text such as "82.0 cm3, centre (3, -255, 379), box 132 x 104 x 98 mm", for messages.
std::string Describe(const Component& component);

}  // namespace kerf
