// Finding the mandible in a CT and parting it from what it touches.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bone/import/components.h"
#include "bone/import/volume.h"

namespace kerf {

struct IsolateOptions {
  double iso_hu = 300;               // bone is what is above it
  bool isolate = true;               // false: all bone, whatever it is
  bool check_shape = true;           // refuse what does not look like a mandible
  double smallest_piece_mm3 = 1000;  // without isolation: pieces below are left out
  std::vector<Vec3> keep_W, drop_W;  // points in the bone wanted and in bone not wanted, LPS mm
};

/// Which voxels belong to the bone wanted. The lattice is a crop of the CT, one to a few voxels larger than the bone.
struct Isolation {
  Volume ct;                       // cropped
  std::vector<std::uint8_t> keep;  // of each voxel of ct: 1 the bone wanted and the soft tissue next to it, 0 elsewhere
  std::vector<std::uint8_t> bone;  // 1 where keep and HU >= iso: one connected piece when isolated
  double iso_volume_mm3 = 0;       // of `bone`: no filling, by counting voxels
  double contact_mm2 = 0;          // area over which it touched other bone
  std::size_t dropped_pieces = 0;  // small separate bits on the wanted side that were left out
  double dropped_mm3 = 0;
  std::string how;              // in words, for the provenance
  bool mandible = false;        // the shape is that of one
  std::string shape_objection;  // why not, in words
  bool cut_by_scan = false;     // bone reaches the edge of the scan
  double marker_hu = 0;         // automatic: threshold above which the mandible stood apart; else 0
};

/// Automatic: the lowest threshold at which one component looks like a mandible gives it and all other large components
/// as markers; a marker-controlled watershed grows them back to `iso_hu`. With keep and drop points these are the
/// markers. Throws Error that says what was found (components, volumes, centres) and how to steer when the mandible
/// can't be told from the rest. `progress` 0 to 1, may be empty.
Isolation Isolate(const Volume& ct, const IsolateOptions& options, const std::function<void(double)>& progress);

}  // namespace kerf
