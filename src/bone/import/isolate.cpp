#include "bone/import/isolate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "bone/import/blocks.h"
#include "bone/import/isolate_mask.h"
#include "bone/import/mandible_likeness.h"
#include "bone/import/scan_edge.h"
#include "bone/import/watershed.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr double kThresholdStep_HU = 50;
constexpr int kThresholdSteps = 12;       // above iso; beyond it thin cortex disappears and markers would break into
                                          // crumbs
constexpr double kMarkerPiece_mm3 = 300;  // other bone of at least this volume cannot be a crumb of the mandible
constexpr double kCandidate_mm3 = 8000;
constexpr int kAirMargin = 4;        // voxels of air beyond the scan, so that bone cut by its edge has a surface there
constexpr double kPartial_HU = 150;  // voxels this far below iso are certainly soft tissue
constexpr double kSeedRadius_mm = 1.5;
constexpr double kSnap_mm = 4;  // maximum distance of a point from the bone
constexpr int kRim = 3;         // voxels of soft tissue that are assigned with the bone

using Progress = std::function<void(double)>;

std::string Text(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", p.x, p.y, p.z);
}

std::string ListComponents(const Components& all, double smallest_mm3) {
  std::string text;
  std::size_t shown = 0;
  for (const Component& c : all.list) {
    if (c.volume_mm3 < smallest_mm3 || shown == 6) break;
    text += fmt::format("\n  {}. {}", ++shown, Describe(c));
  }
  return text;
}

// Throws NotIsolated with a list of all bone and an explanation of how to select part of it. `advice`: added to the
// reason for a terminal.
[[noreturn]] void Refuse(const std::string& why, const Components& at_iso, double iso_hu,
                         const std::string& advice = "") {
  throw NotIsolated(
      fmt::format("{}{}.\nBone above {:.0f} HU, by connected pieces (patient coordinates LPS, mm):{}\nSelect it with "
                  "points in the bone: --keep x,y,z in the mandible and --drop x,y,z in bone that touches it (upper "
                  "teeth, skull), each as often as needed, or --keep-markups and --drop-markups with point lists from "
                  "3D Slicer. Read the coordinates off the slices that 'kerf picture INPUT --axes -o ct.png' draws; "
                  "--no-isolate imports all bone",
                  why, advice, iso_hu, ListComponents(at_iso, 500)),
      why, at_iso.list.front().box_W);
}

std::array<int, 3> RoundToVoxel(const Volume& ct, const Vec3& p_W) {
  const Vec3 p_V = ct.VoxelFromWorld(p_W);
  return {static_cast<int>(std::lround(p_V.x)), static_cast<int>(std::lround(p_V.y)),
          static_cast<int>(std::lround(p_V.z))};
}

// Returns the bone voxel nearest to a point of the scan; none if there is none nearby.
std::optional<std::array<int, 3>> FindBoneNear(const Volume& ct, double iso_hu, const Vec3& p_W) {
  const std::array<int, 3> at = RoundToVoxel(ct, p_W);
  std::optional<std::array<int, 3>> best;
  double best_mm = kSnap_mm;
  std::array<int, 3> reach{};
  for (int a = 0; a < 3; ++a) reach[a] = static_cast<int>(std::ceil(kSnap_mm / ct.spacing_mm[a]));
  for (int k = at[2] - reach[2]; k <= at[2] + reach[2]; ++k) {
    for (int j = at[1] - reach[1]; j <= at[1] + reach[1]; ++j) {
      for (int i = at[0] - reach[0]; i <= at[0] + reach[0]; ++i) {
        if (!ct.Contains({i, j, k}) || ct.hu[ct.Index(i, j, k)] < iso_hu) continue;
        const double d = glm::length(ct.WorldFromVoxel({i, j, k}) - p_W);
        if (d < best_mm) {
          best_mm = d;
          best = {i, j, k};
        }
      }
    }
  }
  return best;
}

}  // namespace

Volume CropAround(const Volume& ct, const std::array<int, 3>& lower, const std::array<int, 3>& upper,
                  double margin_mm) {
  std::array<int, 3> lo{}, hi{};
  for (int a = 0; a < 3; ++a) {
    const int margin = std::max(kAirMargin, static_cast<int>(std::ceil(margin_mm / ct.spacing_mm[a])));
    lo[a] = std::max(lower[a] - margin, -kAirMargin);
    hi[a] = std::min(upper[a] + margin, ct.size[a] - 1 + kAirMargin);
  }
  return Crop(ct, lo, hi);
}

std::array<int, 3> Snap(const Volume& ct, double iso_hu, const Vec3& p_W, const char* option) {
  if (!ct.Contains(RoundToVoxel(ct, p_W))) {
    throw Error(fmt::format("--{} {}: the point lies outside the scan", option, Text(p_W)));
  }
  const std::optional<std::array<int, 3>> best = FindBoneNear(ct, iso_hu, p_W);
  if (!best) {
    throw Error(fmt::format("--{} {}: the point is not in bone; nothing above {:.0f} HU is within {:.0f} mm of it",
                            option, Text(p_W), iso_hu, kSnap_mm));
  }
  return *best;
}

namespace {

// Marks a small ball of bone around a point. Throws kerf::Error if the voxel of a drop point is already marked kKeep.
void MarkBall(const Volume& ct, double iso_hu, const Vec3& p_W, Marker marker, std::vector<std::uint8_t>& markers) {
  const std::array<int, 3> at = Snap(ct, iso_hu, p_W, marker == kKeep ? "keep" : "drop");
  const Vec3 centre_W = ct.WorldFromVoxel({at[0], at[1], at[2]});
  std::array<int, 3> reach{};
  for (int a = 0; a < 3; ++a) reach[a] = static_cast<int>(std::ceil(kSeedRadius_mm / ct.spacing_mm[a]));
  for (int k = at[2] - reach[2]; k <= at[2] + reach[2]; ++k) {
    for (int j = at[1] - reach[1]; j <= at[1] + reach[1]; ++j) {
      for (int i = at[0] - reach[0]; i <= at[0] + reach[0]; ++i) {
        if (!ct.Contains({i, j, k}) || glm::length(ct.WorldFromVoxel({i, j, k}) - centre_W) > kSeedRadius_mm) continue;
        const std::size_t v = ct.Index(i, j, k);
        if (ct.hu[v] < iso_hu) continue;
        if (marker == kDrop && markers[v] == kKeep && at == std::array<int, 3>{i, j, k}) {
          throw Error(fmt::format("--drop {}: a --keep point lies at the same place", Text(p_W)));
        }
        // Where balls overlap, the later one wins; drop points are marked last.
        markers[v] = marker;
      }
    }
  }
}

struct Candidate {
  double threshold_hu = 0;
  Components pieces;
  std::int32_t label = 0;
};

// Finds the lowest threshold at which exactly one piece looks like a mandible (and contains the keep points, if any). A
// piece that does so only in a turned head counts if there is no other one at any threshold.
// `rotation_hint`: set to a description of the first piece that would look like one if the scan were rotated.
std::optional<Candidate> FindCandidate(const Volume& ct, const IsolateOptions& options, const Progress& progress,
                                       std::string& rotation_hint) {
  std::optional<Candidate> turned;
  for (int step = 0; step <= kThresholdSteps; ++step) {
    const auto report = [&](double fraction) {
      if (progress) progress(0.1 + 0.5 * (step + fraction) / (kThresholdSteps + 1));
    };
    const double threshold = options.iso_hu + step * kThresholdStep_HU;
    Candidate c{threshold,
                FindComponents(
                    ct, [&](std::size_t v) { return ct.hu[v] >= threshold; }, report),
                0};
    int upright = 0, inclined = 0;
    std::int32_t inclined_label = 0;
    for (std::size_t n = 0; n < c.pieces.list.size() && c.pieces.list[n].volume_mm3 >= kCandidate_mm3; ++n) {
      const auto label = static_cast<std::int32_t>(n + 1);
      const MandibleLikeness likeness = CheckMandibleLikeness(ct, c.pieces.labels, label, c.pieces.list[n]);
      if (!likeness.rotations.empty() && rotation_hint.empty()) {
        rotation_hint = fmt::format("; above {:.0f} HU a piece ({}) is found, and {}", threshold,
                                    Describe(c.pieces.list[n]), DescribeRotations(likeness, ct.frame));
      }
      if (!likeness.is_mandible) continue;
      if (likeness.turn_deg > 0) {
        ++inclined;
        inclined_label = label;
        continue;
      }
      ++upright;
      c.label = label;
    }
    const bool is_turned = upright == 0 && inclined == 1 && !turned;
    if (upright != 1 && !is_turned) continue;
    if (is_turned) c.label = inclined_label;
    const bool contains_points = std::all_of(options.keep_W.begin(), options.keep_W.end(), [&](const Vec3& p_W) {
      const std::array<int, 3> at = Snap(ct, threshold, p_W, "keep");
      return c.pieces.labels[ct.Index(at[0], at[1], at[2])] == c.label;
    });
    if (!contains_points) continue;
    if (!is_turned) return c;
    turned = std::move(c);
  }
  return turned;
}

// Makes the markers of the automatic method, on the crop.
std::vector<std::uint8_t> MarkCandidate(const Volume& ct, const Volume& crop, const Candidate& candidate) {
  std::vector<std::uint8_t> markers(crop.count(), kUnmarked);
  const Vec3 shift = ct.VoxelFromWorld(crop.origin_W);
  for (int k = 0; k < crop.size[2]; ++k) {
    for (int j = 0; j < crop.size[1]; ++j) {
      for (int i = 0; i < crop.size[0]; ++i) {
        const std::array<int, 3> at = {i + static_cast<int>(std::lround(shift.x)),
                                       j + static_cast<int>(std::lround(shift.y)),
                                       k + static_cast<int>(std::lround(shift.z))};
        if (!ct.Contains(at)) continue;
        const std::int32_t label = candidate.pieces.labels[ct.Index(at[0], at[1], at[2])];
        if (label == candidate.label) {
          markers[crop.Index(i, j, k)] = kKeep;
        } else if (label > 0 && candidate.pieces.list[label - 1].volume_mm3 >= kMarkerPiece_mm3) {
          markers[crop.Index(i, j, k)] = kDrop;
        }
      }
    }
  }
  return markers;
}

// Assigns soft tissue close to bone to the nearest bone, wanted or not.
void AddRim(Isolation& result, const std::vector<std::uint8_t>& unwanted) {
  const Volume& ct = result.ct;
  std::vector<std::uint8_t> owner(ct.count(), kUnmarked);
  std::vector<std::size_t> front;
  for (std::size_t v = 0; v < owner.size(); ++v) {
    if (result.bone[v] != 0)
      owner[v] = kKeep;
    else if (unwanted[v] != 0)
      owner[v] = kDrop;
    if (owner[v] != kUnmarked) front.push_back(v);
  }
  const std::array<std::size_t, 3> stride = {1, static_cast<std::size_t>(ct.size[0]),
                                             static_cast<std::size_t>(ct.size[0]) * ct.size[1]};
  for (int ring = 0; ring < kRim; ++ring) {
    std::vector<std::size_t> next;
    for (const std::size_t v : front) {
      const std::array<int, 3> at = {static_cast<int>(v % stride[1]), static_cast<int>(v / stride[1] % ct.size[1]),
                                     static_cast<int>(v / stride[2])};
      for (int a = 0; a < 3; ++a) {
        for (const int side : {-1, 1}) {
          if (at[a] + side < 0 || at[a] + side >= ct.size[a]) continue;
          const std::size_t w = side < 0 ? v - stride[a] : v + stride[a];
          if (owner[w] != kUnmarked) continue;
          owner[w] = owner[v];
          next.push_back(w);
        }
      }
    }
    front = std::move(next);
  }
  result.keep.resize(owner.size());
  for (std::size_t v = 0; v < owner.size(); ++v) result.keep[v] = owner[v] == kKeep ? 1 : 0;
}

// Returns whether bone lies so close to the edge of the crop that its surface would be open there. Beyond the edge of
// the scan, a crop contains air.
bool ReachesEdgeOfCrop(const Volume& crop, const std::vector<std::uint8_t>& bone) {
  for (std::size_t v = 0; v < bone.size(); ++v) {
    if (bone[v] == 0) continue;
    const std::array<std::size_t, 3> at = {v % crop.size[0], v / crop.size[0] % crop.size[1],
                                           v / crop.size[0] / crop.size[1]};
    for (std::size_t a = 0; a < 3; ++a) {
      if (at[a] < kRim || at[a] + kRim >= static_cast<std::size_t>(crop.size[a])) return true;
    }
  }
  return false;
}

double CalcContact(const Volume& ct, const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) {
  const Vec3 h = ct.spacing_mm;
  const std::array<double, 3> face_mm2 = {h.y * h.z, h.x * h.z, h.x * h.y};
  double area = 0;
  for (int k = 0; k < ct.size[2]; ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i) {
        const std::size_t v = ct.Index(i, j, k);
        for (int axis = 0; axis < 3; ++axis) {
          const std::array<int, 3> at = {i + (axis == 0 ? 1 : 0), j + (axis == 1 ? 1 : 0), k + (axis == 2 ? 1 : 0)};
          if (!ct.Contains(at)) continue;
          const std::size_t w = ct.Index(at[0], at[1], at[2]);
          if ((a[v] != 0 && b[w] != 0) || (b[v] != 0 && a[w] != 0)) area += face_mm2[axis];
        }
      }
    }
  }
  return area;
}

bool ContainsBone(const Components& at_iso) {
  return !at_iso.list.empty() && at_iso.list.front().volume_mm3 >= 1000;
}

Isolation TakeAll(const Volume& ct, const IsolateOptions& options, const Components& at_iso) {
  Isolation result;
  std::array<int, 3> lower = ct.size, upper = {0, 0, 0};
  std::size_t pieces = 0;
  for (const Component& c : at_iso.list) {
    if (c.volume_mm3 < options.smallest_piece_mm3) {
      ++result.dropped_pieces;
      result.dropped_mm3 += c.volume_mm3;
      continue;
    }
    ++pieces;
    for (int a = 0; a < 3; ++a) {
      lower[a] = std::min(lower[a], c.lower[a]);
      upper[a] = std::max(upper[a], c.upper[a]);
    }
  }
  result.ct = CropAround(ct, lower, upper, 0);
  const Vec3 shift = ct.VoxelFromWorld(result.ct.origin_W);
  result.bone.assign(result.ct.count(), 0);
  std::vector<std::uint8_t> unwanted(result.ct.count(), 0);
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(result.ct.size[2]); ++k) {
    for (int j = 0; j < result.ct.size[1]; ++j) {
      for (int i = 0; i < result.ct.size[0]; ++i, ++v) {
        const std::array<int, 3> at = {i + static_cast<int>(std::lround(shift.x)),
                                       j + static_cast<int>(std::lround(shift.y)),
                                       static_cast<int>(k) + static_cast<int>(std::lround(shift.z))};
        if (!ct.Contains(at)) continue;
        const std::int32_t label = at_iso.labels[ct.Index(at[0], at[1], at[2])];
        if (label == 0) continue;
        (static_cast<std::size_t>(label) <= pieces ? result.bone : unwanted)[v] = 1;
      }
    }
  }
  AddRim(result, unwanted);
  result.how = fmt::format("none: all bone in pieces of {:.1f} cm3 and more", options.smallest_piece_mm3 / 1000);
  return result;
}

// Sets result.scan, the scan's voxels in the box around the bone and three voxels of result.ct more.
void CropScan(const Volume& ct, Isolation& result) {
  constexpr int kRoom = 3;
  std::array<int, 3> lower = result.ct.size, upper = {0, 0, 0};
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(result.ct.size[2]); ++k) {
    for (int j = 0; j < result.ct.size[1]; ++j) {
      for (int i = 0; i < result.ct.size[0]; ++i, ++v) {
        if (result.bone[v] == 0) continue;
        const std::array<int, 3> at = {i, j, static_cast<int>(k)};
        for (std::size_t a = 0; a < 3; ++a) {
          lower[a] = std::min(lower[a], at[a]);
          upper[a] = std::max(upper[a], at[a]);
        }
      }
    }
  }
  const Vec3 corner = ct.VoxelFromWorld(result.ct.origin_W);  // of the middle of the first voxel of result.ct
  for (std::size_t a = 0; a < 3; ++a) {
    result.first[a] = std::max(lower[a] - kRoom, 0);
    const int last = std::min(upper[a] + kRoom, result.ct.size[a] - 1);
    const auto begin = static_cast<int>(std::lround(corner[static_cast<int>(a)] - 0.5 * (result.step[a] - 1)));
    lower[a] = begin + result.first[a] * result.step[a];
    upper[a] = begin + (last + 1) * result.step[a] - 1;
  }
  result.scan = Crop(ct, lower, upper);
}

Isolation IsolateOn(const Volume& ct, const IsolateOptions& options, const Progress& progress) {
  const double iso = options.iso_hu;
  const auto part = [&progress](double from, double to) -> Progress {
    if (!progress) return {};
    return [&progress, from, to](double fraction) { progress(from + (to - from) * fraction); };
  };
  const Components at_iso = FindComponents(
      ct, [&](std::size_t v) { return ct.hu[v] >= iso; }, part(0, 0.1));
  if (!ContainsBone(at_iso)) {
    const auto brightest = ct.hu.empty() ? std::int16_t{0} : *std::max_element(ct.hu.begin(), ct.hu.end());
    throw Error(fmt::format(
        "the scan contains no bone: nothing above {:.0f} HU is larger than 1 cm3 (the brightest voxel has {} HU); "
        "check that the values are Hounsfield units, or lower --iso",
        iso, brightest));
  }
  const auto count_iso = [iso](Isolation& r) {
    std::size_t voxels = 0;
    for (const std::uint8_t b : r.bone) voxels += b;
    r.iso_volume_mm3 = static_cast<double>(voxels) * r.ct.CalcVoxelVolume();
  };
  if (!options.isolate) {
    Isolation all = TakeAll(ct, options, at_iso);
    count_iso(all);
    return all;
  }

  Isolation result;
  std::vector<std::uint8_t> markers;
  if (options.mask) {
    markers = MarkMask(ct, options, result);
    if (!options.keep_W.empty() || !options.drop_W.empty()) {
      result.how += fmt::format("; points: {} keep, {} drop", options.keep_W.size(), options.drop_W.size());
    }
  } else if (options.keep_W.empty() || options.drop_W.empty()) {
    std::string rotation_hint;
    const std::optional<Candidate> candidate = FindCandidate(ct, options, progress, rotation_hint);
    if (!candidate) {
      const bool some_points = !options.keep_W.empty() || !options.drop_W.empty();
      Refuse(
          fmt::format("the mandible can't be distinguished from the other bone: no piece between {:.0f} and {:.0f} HU "
                      "has the size and shape of one; it is joined to something else, incomplete, or not in the scan{}",
                      iso, iso + kThresholdSteps * kThresholdStep_HU, rotation_hint),
          at_iso, iso,
          some_points ? fmt::format("; {} points alone only correct a piece that is found without them: give "
                                    "both --keep and --drop points",
                                    options.keep_W.empty() ? "--drop" : "--keep")
                      : "");
    }
    const Component& piece = candidate->pieces.list[candidate->label - 1];
    result.marker_hu = candidate->threshold_hu;
    result.how = fmt::format("automatic: a separate piece above {:.0f} HU", candidate->threshold_hu);
    if (!options.drop_W.empty()) result.how += fmt::format(", {} drop points", options.drop_W.size());
    if (!options.keep_W.empty()) result.how += fmt::format(", {} keep points", options.keep_W.size());
    result.ct = CropAround(ct, piece.lower, piece.upper, kMargin_mm);
    markers = MarkCandidate(ct, result.ct, *candidate);
  } else {
    // The crop contains every piece of bone with a keep point.
    std::array<int, 3> lower = ct.size, upper = {0, 0, 0};
    for (const Vec3& p_W : options.keep_W) {
      const std::array<int, 3> at = Snap(ct, iso, p_W, "keep");
      const Component& c = at_iso.list[at_iso.labels[ct.Index(at[0], at[1], at[2])] - 1];
      for (int a = 0; a < 3; ++a) {
        lower[a] = std::min(lower[a], c.lower[a]);
        upper[a] = std::max(upper[a], c.upper[a]);
      }
    }
    for (const Vec3& p_W : options.drop_W) Snap(ct, iso, p_W, "drop");
    result.ct = CropAround(ct, lower, upper, 0);
    markers.assign(result.ct.count(), kUnmarked);
    result.how = fmt::format("points: {} keep, {} drop", options.keep_W.size(), options.drop_W.size());
  }
  for (const Vec3& p_W : options.keep_W) MarkBall(result.ct, iso, p_W, kKeep, markers);
  for (const Vec3& p_W : options.drop_W) {
    const Vec3 p_V = result.ct.VoxelFromWorld(p_W);
    if (result.ct.Contains({static_cast<int>(std::lround(p_V.x)), static_cast<int>(std::lround(p_V.y)),
                            static_cast<int>(std::lround(p_V.z))})) {
      MarkBall(result.ct, iso, p_W, kDrop, markers);
    }
  }
  for (std::size_t v = 0; v < markers.size(); ++v) {
    if (markers[v] == kUnmarked && result.ct.hu[v] < iso - kPartial_HU) markers[v] = kOutside;
  }
  if (progress) progress(0.65);
  std::vector<std::uint8_t> grown = GrowMarkers(result.ct, iso, markers, part(0.65, 0.9));
  if (result.mask) GiveBack(result, iso, markers, grown);
  if (progress) progress(0.9);

  // Selects, on the wanted side, the piece that contains most of the markers, and the others that a mask names: of a
  // mandible only fragments, since automatic segmentations have small islands elsewhere.
  constexpr double kNamedShare = 0.5;      // of a piece
  constexpr double kNamedPiece_mm3 = 100;  // at least
  constexpr double kFragment = 0.05;       // of the mandible, at least
  const Components wanted = FindComponents(
      result.ct, [&](std::size_t v) { return grown[v] == kKeep && result.ct.hu[v] >= iso; }, part(0.9, 1));
  std::vector<std::size_t> marked(wanted.list.size() + 1, 0);
  for (std::size_t v = 0; v < markers.size(); ++v) {
    if (result.mask ? result.mask->samples.wanted[v] != 0 : markers[v] == kKeep) ++marked[wanted.labels[v]];
  }
  marked[0] = 0;
  const auto label = static_cast<std::int32_t>(std::max_element(marked.begin(), marked.end()) - marked.begin());
  if (label == 0) Refuse(options.mask ? "the mask contains no bone" : "the keep points mark no bone", at_iso, iso);
  if (!options.keep_W.empty() && !options.drop_W.empty()) {
    for (const Vec3& p_W : options.keep_W) {
      const std::array<int, 3> at = Snap(result.ct, iso, p_W, "keep");
      if (wanted.labels[result.ct.Index(at[0], at[1], at[2])] != label) {
        Refuse(fmt::format("the keep points lie in separate pieces of bone: {} is not joined to the others", Text(p_W)),
               at_iso, iso);
      }
    }
  }
  const Component& piece = wanted.list[label - 1];
  const MandibleLikeness likeness = CheckMandibleLikeness(result.ct, wanted.labels, label, piece);
  if (options.check_shape && !options.mask && !likeness.is_mandible) {
    Refuse(fmt::format("the isolated bone ({}) does not look like a mandible: {}", Describe(piece),
                       Describe(likeness, ct.frame)),
           at_iso, iso, "; add points, or use --any-shape to write it anyway");
  }
  result.mandible = likeness.is_mandible;
  result.up_W = likeness.up_W;
  if (likeness.turn_deg > 0)
    result.how += fmt::format("; the head is turned by about {:.0f} degrees", likeness.turn_deg);
  result.shape_objection = Describe(likeness, ct.frame);
  std::vector<bool> is_kept(wanted.list.size() + 1, false);
  for (std::size_t n = 1; n < is_kept.size(); ++n) {
    const double volume_mm3 = wanted.list[n - 1].volume_mm3;
    const double named_mm3 = result.mask ? static_cast<double>(marked[n]) * result.ct.CalcVoxelVolume() : 0;
    is_kept[n] = n == static_cast<std::size_t>(label) ||
                 (named_mm3 > kNamedShare * volume_mm3 &&
                  volume_mm3 >= (result.mandible ? kFragment * piece.volume_mm3 : kNamedPiece_mm3));
    result.pieces += is_kept[n] ? 1 : 0;
    if (is_kept[n]) continue;
    ++result.dropped_pieces;
    result.dropped_mm3 += volume_mm3;
  }
  result.bone.assign(result.ct.count(), 0);
  std::vector<std::uint8_t> unwanted(result.ct.count(), 0);
  for (std::size_t v = 0; v < result.bone.size(); ++v) {
    if (is_kept[wanted.labels[v]])
      result.bone[v] = 1;
    else if (result.ct.hu[v] >= iso)
      unwanted[v] = 1;
  }
  if (ReachesEdgeOfCrop(result.ct, result.bone)) {
    Refuse(
        fmt::format("the bone goes on for more than {:.0f} mm beside the part that was recognised", kMargin_mm), at_iso,
        iso,
        fmt::format("; mark what does not belong to it with --drop, less than {:.0f} mm from that part", kMargin_mm));
  }
  result.contact_mm2 = CalcContact(result.ct, result.bone, unwanted);
  if (result.mask) {
    result.mask->cut_off = FindCutOff(result, iso, markers);
    FindGivenAway(result, iso);
  }
  AddRim(result, unwanted);
  count_iso(result);
  return result;
}

}  // namespace

Isolation Isolate(const Volume& ct, const IsolateOptions& options, const Progress& progress) {
  const std::array<int, 3> step = ChooseBlocks(ct);
  if (step == std::array<int, 3>{1, 1, 1}) {
    Isolation result = IsolateOn(ct, options, progress);
    result.cut_mm2 = CalcCutArea(ct, result, options.iso_hu);
    return result;
  }
  Isolation result = IsolateOn(JoinBlocks(ct, step, options.iso_hu), options, progress);
  result.step = step;
  CropScan(ct, result);
  std::size_t voxels = 0;
  const Volume& scan = result.scan;
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(scan.size[2]); ++k) {
    for (int j = 0; j < scan.size[1]; ++j) {
      for (int i = 0; i < scan.size[0]; ++i, ++v) {
        if (scan.hu[v] >= options.iso_hu && result.keep[result.Find(i, j, static_cast<int>(k))] != 0) ++voxels;
      }
    }
  }
  result.iso_volume_mm3 = static_cast<double>(voxels) * scan.CalcVoxelVolume();
  result.cut_mm2 = CalcCutArea(ct, result, options.iso_hu);
  return result;
}

bool IsNearBone(const Volume& ct, double iso_hu, const Vec3& p_W) {
  return FindBoneNear(ct, iso_hu, p_W).has_value();
}

}  // namespace kerf
