// Isolation of the mandible in a CT from the bone that it touches.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bone/import/components.h"
#include "bone/import/mask.h"
#include "bone/import/volume.h"
#include "kerf/error.h"

namespace kerf {

/// The wanted bone could not be distinguished from other bone. Points in both, or other points, can help.
class NotIsolated : public Error {
 public:
  /// `what`: for a terminal, with options of kerf import. `why`: the reason alone, in words. `largest_W`: box around
  /// the largest piece of bone, LPS, mm.
  NotIsolated(const std::string& what, std::string why, const Box3& largest_W)
      : Error(what), why_(std::move(why)), largest_W_(largest_W) {}
  const std::string& why() const { return why_; }
  const Box3& largest_W() const { return largest_W_; }

 private:
  std::string why_;
  Box3 largest_W_;
};

struct IsolateOptions {
  double iso_hu = 300;                   // voxels above this are bone
  bool isolate = true;                   // if false, all bone is kept
  bool check_shape = true;               // reject bone that does not look like a mandible
  double smallest_piece_mm3 = 1000;      // without isolation: smaller pieces are dropped
  std::vector<Vec3> keep_W, drop_W;      // points in wanted and in unwanted bone, LPS, mm
  std::shared_ptr<const BoneMask> mask;  // selects the bone; its shape is then not checked
  double mask_reach_mm = 0;  // what is farther inside the mask is wanted, and bone farther outside is not; in between
                             // the CT decides, but for bone that the mask names; 0: CalcDefaultReach()
};

/// How a mask selected the bone.
struct MaskUse {
  double reach_mm = 0;
  double wanted_mm3 = 0;                 // of the mask, on the CT's lattice
  double outside_scan = 0;               // fraction of the mask that lies outside the scan
  double in_bone = 0;                    // fraction of the mask in the scan that is bone by its HU
  std::vector<std::uint8_t> cut_off;     // 1 for bone joined to the wanted bone, farther than reach_mm outside the mask
                                         // and in no segment of other bone, up to 10 mm beyond the reach
  std::vector<std::uint8_t> certain;     // 1 farther than reach_mm inside the mask
  std::vector<std::uint8_t> named;       // kKeep and kDrop for bone that the mask names and that is no marker
  std::vector<std::uint8_t> given_away;  // 1 for bone of the mask that is not in the result: it went to other bone, or
                                         // is a crumb
  double given_away_mm = 0;              // its greatest distance from the result
  MaskSamples samples;
};

/// The voxels of the wanted bone. The lattice is a crop of the CT, one to a few voxels larger than the bone; in a fine
/// scan, one of larger voxels, each the mean of a block of the scan's.
struct Isolation {
  Volume ct;    // cropped
  Volume scan;  // the scan's own voxels around the bone, if those of ct are larger; otherwise empty
  std::array<int, 3> step{1, 1, 1};   // voxels of the scan along the edges of a voxel of ct
  std::array<int, 3> first{0, 0, 0};  // voxel of ct in which the first voxel of scan lies, at its lower corner
  std::vector<std::uint8_t> keep;     // for each voxel of ct: 1 for wanted bone and the soft tissue next to it, 0
                                      // elsewhere
  std::vector<std::uint8_t> bone;     // 1 where keep and HU >= iso
  std::size_t pieces = 0;             // connected ones of `bone` if isolated: one, or all large ones that a mask names
  double iso_volume_mm3 = 0;          // of `bone`: sum of its voxels, without filling
  double contact_mm2 = 0;             // area in contact with other bone
  std::size_t dropped_pieces = 0;     // small separate pieces on the wanted side that were removed
  double dropped_mm3 = 0;
  std::string how;              // description in words, for the provenance
  bool mandible = false;        // true if the bone has the shape of a mandible
  Vec3 up_W{0, 0, 1};           // towards the top of the head, if it has
  std::string shape_objection;  // reason if it does not, in words
  double cut_mm2 = 0;           // area in contact with the edge of the scan (scan_edge.h)
  double marker_hu = 0;         // automatic isolation: threshold above which the mandible is a separate piece;
                                // otherwise 0
  std::optional<MaskUse> mask;  // if a mask was used

  /// The scan's own voxels around the bone.
  const Volume& fine() const { return scan.count() == 0 ? ct : scan; }
  /// Returns the index in ct, keep and bone for a voxel of fine().
  std::size_t Find(int i, int j, int k) const {
    return ct.Index(first[0] + i / step[0], first[1] + j / step[1], first[2] + k / step[2]);
  }
};

/// Isolates the mandible. The automatic method finds the lowest threshold at which exactly one component looks like a
/// mandible. This component and all other large ones become markers, and a marker-controlled watershed grows them back
/// to `iso_hu`. If both keep and drop points are given, these are the markers. With a mask, what lies farther inside
/// it than the reach is marked as wanted and the bone farther outside it as unwanted; where the mask is thinner than
/// twice the reach, its middle half is wanted. In between the watershed decides, but what the mask names is given back
/// to its side, except with points of the other one, or where the mask's voxels leave it unclear. A scan of voxels
/// finer than 0.35 mm is isolated on larger ones. Throws kerf::Error if the mandible cannot be distinguished from other
/// bone (NotIsolated); the message lists the components found (volumes, centres) and explains how to select one.
/// `progress`, which is optional, is called with values from 0 to 1.
Isolation Isolate(const Volume& ct, const IsolateOptions& options, const std::function<void(double)>& progress);

/// Returns whether there is bone above `iso_hu` near the point, so that it can be in `keep_W` or `drop_W`.
bool IsNearBone(const Volume& ct, double iso_hu, const Vec3& p_W);

}  // namespace kerf
