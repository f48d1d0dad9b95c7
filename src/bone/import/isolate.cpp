#include "bone/import/isolate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "bone/import/blocks.h"
#include "bone/import/depth.h"
#include "bone/import/mandible_likeness.h"
#include "bone/import/watershed.h"
#include "kerf/error.h"

namespace kerf {

namespace {

constexpr double kThresholdStep_HU = 50;
constexpr int kThresholdSteps = 12;       // above iso; beyond it thin cortex disappears and markers would break into
                                          // crumbs
constexpr double kMarkerPiece_mm3 = 300;  // other bone of at least this volume cannot be a crumb of the mandible
constexpr double kCandidate_mm3 = 8000;
constexpr double kMargin_mm = 10;    // around a candidate
constexpr int kAirMargin = 4;        // voxels of air beyond the scan, so that bone cut by its edge has a surface there
constexpr double kPartial_HU = 150;  // voxels this far below iso are certainly soft tissue
constexpr double kSeedRadius_mm = 1.5;
constexpr double kSnap_mm = 4;         // maximum distance of a point from the bone
constexpr double kLeastInBone = 0.25;  // of a mask that belongs to the scan; marrow is not bone by its HU
constexpr int kRim = 3;                // voxels of soft tissue that are assigned with the bone

using Progress = std::function<void(double)>;

std::string Text(const Vec3& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", p.x, p.y, p.z);
}

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

// Returns the bone voxel nearest to a point. Throws kerf::Error if there is none nearby.
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

// Returns the fraction of the mask's wanted voxels that lie outside the scan, and includes the others, and those that
// are undecided, in the box of voxels from `lower` to `upper`.
double FindMaskInScan(const Volume& ct, const BoneMask& mask, std::array<int, 3>& lower, std::array<int, 3>& upper) {
  const Volume& map = mask.tissue;
  std::size_t wanted = 0, outside = 0;
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(map.size[2]); ++k) {
    for (int j = 0; j < map.size[1]; ++j) {
      for (int i = 0; i < map.size[0]; ++i, ++v) {
        if (!IsWanted(mask.At(v)) && !IsUndecided(mask.At(v))) continue;
        const Vec3 p_V = ct.VoxelFromWorld(map.WorldFromVoxel({i, j, static_cast<double>(k)}));
        const std::array<int, 3> at = {static_cast<int>(std::lround(p_V.x)), static_cast<int>(std::lround(p_V.y)),
                                       static_cast<int>(std::lround(p_V.z))};
        wanted += IsWanted(mask.At(v)) ? 1 : 0;
        if (!ct.Contains(at)) {
          outside += IsWanted(mask.At(v)) ? 1 : 0;
          continue;
        }
        for (std::size_t a = 0; a < 3; ++a) {
          lower[a] = std::min(lower[a], at[a]);
          upper[a] = std::max(upper[a], at[a]);
        }
      }
    }
  }
  return wanted == 0 ? 1 : static_cast<double>(outside) / static_cast<double>(wanted);
}

// Returns for each voxel of a mask the depth of the middle of the thickest part that it belongs to, mm: the radius of
// the largest ball within the mask from which the voxel is less than `slack_mm` away. A bump that is lower than that is
// no part of its own.
std::vector<float> CalcThickness(const Volume& lattice, const std::vector<float>& depth_mm, double slack_mm) {
  constexpr double kRidgeSlope = 0.6;  // of the depth, 1 beside the middle of a part and less along it
  const Vec3& h = lattice.spacing_mm;
  std::vector<float> thickness_mm = depth_mm;
  const auto is_ridge = [&](int i, int j, int k, float depth) {
    for (int side = 0; side < 27; ++side) {
      const std::array<int, 3> at = {i + side % 3 - 1, j + side / 3 % 3 - 1, k + side / 9 - 1};
      if (!lattice.Contains(at)) continue;
      const double step_mm = glm::length(h * Vec3(side % 3 - 1, side / 3 % 3 - 1, side / 9 - 1));
      if (static_cast<double>(depth_mm[lattice.Index(at[0], at[1], at[2])] - depth) > kRidgeSlope * step_mm)
        return false;
    }
    return true;
  };
  for (int k = 0; k < lattice.size[2]; ++k) {
    for (int j = 0; j < lattice.size[1]; ++j) {
      for (int i = 0; i < lattice.size[0]; ++i) {
        const float depth = depth_mm[lattice.Index(i, j, k)];
        if (depth <= 0 || !is_ridge(i, j, k, depth)) continue;
        const double reach_mm = static_cast<double>(depth) + slack_mm;
        const auto from = [&](int at, int a) { return std::max(at - static_cast<int>(reach_mm / h[a]), 0); };
        const auto to = [&](int at, int a) {
          return std::min(at + static_cast<int>(reach_mm / h[a]), lattice.size[static_cast<std::size_t>(a)] - 1);
        };
        for (int z = from(k, 2); z <= to(k, 2); ++z) {
          for (int y = from(j, 1); y <= to(j, 1); ++y) {
            const double across_mm2 = std::pow(h.z * (z - k), 2) + std::pow(h.y * (y - j), 2);
            for (int x = from(i, 0); x <= to(i, 0); ++x) {
              float& here = thickness_mm[lattice.Index(x, y, z)];
              if (here >= depth || across_mm2 + std::pow(h.x * (x - i), 2) >= reach_mm * reach_mm) continue;
              here = depth;
            }
          }
        }
      }
    }
  }
  return thickness_mm;
}

// Makes the crop and the markers of a mask, on the crop. Throws kerf::Error if the mask does not fit the scan.
std::vector<std::uint8_t> MarkMask(const Volume& ct, const IsolateOptions& options, Isolation& result) {
  const BoneMask& mask = *options.mask;
  MaskUse& use = result.mask.emplace();
  use.reach_mm = options.mask_reach_mm > 0 ? options.mask_reach_mm : CalcDefaultReach(mask);
  std::array<int, 3> lower = ct.size, upper = {0, 0, 0};
  use.outside_scan = FindMaskInScan(ct, mask, lower, upper);
  if (use.outside_scan > 0.5) {
    throw Error(
        fmt::format("{:.0f} % of the wanted bone of the mask lies outside the scan; the mask belongs to another "
                    "scan, or its coordinates are in another frame",
                    100 * use.outside_scan));
  }
  // Kept bone must not reach the edge of the crop, also about keep points outside the mask.
  for (const Vec3& p_W : options.keep_W) {
    const std::array<int, 3> at = Snap(ct, options.iso_hu, p_W, "keep");
    for (std::size_t a = 0; a < 3; ++a) {
      lower[a] = std::min(lower[a], at[a]);
      upper[a] = std::max(upper[a], at[a]);
    }
  }
  result.ct = CropAround(ct, lower, upper, use.reach_mm + kMargin_mm);
  const Volume& crop = result.ct;
  use.samples = SampleMask(mask, crop, use.reach_mm);
  std::size_t wanted = 0, in_bone = 0, undecided = 0;
  for (std::size_t v = 0; v < crop.count(); ++v) {
    wanted += use.samples.wanted[v];
    in_bone += use.samples.wanted[v] != 0 && crop.hu[v] >= options.iso_hu ? 1 : 0;
    undecided += use.samples.undecided[v];
  }
  if (wanted == 0) throw Error("the wanted bone of the mask is smaller than a voxel of the scan");
  use.wanted_mm3 = static_cast<double>(wanted) * crop.CalcVoxelVolume();
  use.in_bone = static_cast<double>(in_bone) / static_cast<double>(wanted);
  if (use.in_bone < kLeastInBone) {
    throw Error(
        fmt::format("only {:.0f} % of the wanted bone of the mask lies in bone above {:.0f} HU; the mask belongs "
                    "to another scan, its coordinates are in another frame, or --iso is too high",
                    100 * use.in_bone, options.iso_hu));
  }
  const std::vector<float> depth_mm = CalcDepth(crop, use.samples.wanted);
  std::vector<float> outer_mm = depth_mm;
  if (undecided > 0) {
    std::vector<std::uint8_t> either = use.samples.wanted;
    for (std::size_t v = 0; v < either.size(); ++v) either[v] |= use.samples.undecided[v];
    outer_mm = CalcDepth(crop, either);
  }
  // Where the mask is thinner than twice the reach, its middle is the marker, also where that is marrow.
  const std::vector<float> thickness_mm = CalcThickness(crop, depth_mm, use.reach_mm);
  std::vector<std::uint8_t> markers(crop.count(), kUnmarked);
  use.certain.assign(crop.count(), 0);
  for (std::size_t v = 0; v < crop.count(); ++v) {
    const auto depth = static_cast<double>(depth_mm[v]);
    use.certain[v] = depth > use.reach_mm ? 1 : 0;
    if (depth > std::min(use.reach_mm, 0.5 * static_cast<double>(thickness_mm[v]))) markers[v] = kKeep;
    if (crop.hu[v] >= options.iso_hu && static_cast<double>(outer_mm[v]) < -use.reach_mm) markers[v] = kDrop;
  }
  result.how = fmt::format("{}, where it and the CT differ by more than {:.4g} mm", mask.how, use.reach_mm);
  return markers;
}

// Returns 1 for the bone that is joined to the wanted bone, that a mask marked as unwanted because it lies outside, and
// that is in no segment of other bone.
std::vector<std::uint8_t> FindCutOff(const Isolation& result, double iso_hu, const std::vector<std::uint8_t>& markers) {
  const Volume& ct = result.ct;
  const Components all = FindComponents(ct, [&](std::size_t v) { return ct.hu[v] >= iso_hu; });
  const auto kept =
      static_cast<std::size_t>(std::find(result.bone.begin(), result.bone.end(), 1) - result.bone.begin());
  std::vector<std::uint8_t> cut_off(ct.count(), 0);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    if (markers[v] != kDrop || all.labels[v] != all.labels[kept]) continue;
    cut_off[v] = result.bone[v] == 0 && result.mask->samples.other[v] == 0 ? 1 : 0;
  }
  return cut_off;
}

// Finds the bone that the mask names and that is not in the result, and its greatest distance from it.
void FindGivenAway(Isolation& result, double iso_hu) {
  constexpr double kSpeck_mm3 = 10;  // noise at the border of a mask; counted, but its distance is not
  const Volume& ct = result.ct;
  MaskUse& use = *result.mask;
  use.given_away.assign(ct.count(), 0);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    use.given_away[v] = use.samples.wanted[v] != 0 && ct.hu[v] >= iso_hu && result.bone[v] == 0 ? 1 : 0;
  }
  const Components parts = FindComponents(ct, [&](std::size_t v) { return use.given_away[v] != 0; });
  if (parts.list.empty() || parts.list.front().volume_mm3 < kSpeck_mm3) return;
  const std::vector<float> depth_mm = CalcDepth(ct, result.bone);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    const std::int32_t label = parts.labels[v];
    if (label == 0 || parts.list[static_cast<std::size_t>(label - 1)].volume_mm3 < kSpeck_mm3) continue;
    use.given_away_mm = std::max(use.given_away_mm, -static_cast<double>(depth_mm[v]));
  }
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

// Returns whether bone lies in the outermost voxels of the scan.
bool TouchesEdge(const Volume& ct, const Isolation& result) {
  const Vec3 shift = ct.VoxelFromWorld(result.ct.origin_W);
  for (int k = 0; k < result.ct.size[2]; ++k) {
    for (int j = 0; j < result.ct.size[1]; ++j) {
      for (int i = 0; i < result.ct.size[0]; ++i) {
        if (result.bone[result.ct.Index(i, j, k)] == 0) continue;
        const std::array<int, 3> at = {i, j, k};
        for (int a = 0; a < 3; ++a) {
          const int n = at[a] + static_cast<int>(std::lround(shift[a]));
          if (n <= 0 || n >= ct.size[a] - 1) return true;
        }
      }
    }
  }
  return false;
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
    all.cut_by_scan = TouchesEdge(ct, all);
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
  const std::vector<std::uint8_t> grown = GrowMarkers(result.ct, iso, markers, part(0.65, 0.9));
  if (progress) progress(0.9);

  // Selects, on the wanted side, the piece that contains most of the markers.
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
  if (likeness.turn_deg > 0) result.how += fmt::format("; the head is turned by {:.0f} degrees", likeness.turn_deg);
  result.shape_objection = Describe(likeness, ct.frame);
  result.bone.assign(result.ct.count(), 0);
  std::vector<std::uint8_t> unwanted(result.ct.count(), 0);
  for (std::size_t v = 0; v < result.bone.size(); ++v) {
    if (wanted.labels[v] == label)
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
  for (std::size_t n = 0; n < wanted.list.size(); ++n) {
    if (n + 1 == static_cast<std::size_t>(label)) continue;
    ++result.dropped_pieces;
    result.dropped_mm3 += wanted.list[n].volume_mm3;
  }
  result.contact_mm2 = CalcContact(result.ct, result.bone, unwanted);
  if (result.mask) {
    result.mask->cut_off = FindCutOff(result, iso, markers);
    FindGivenAway(result, iso);
  }
  AddRim(result, unwanted);
  count_iso(result);
  result.cut_by_scan = TouchesEdge(ct, result);
  return result;
}

}  // namespace

Isolation Isolate(const Volume& ct, const IsolateOptions& options, const Progress& progress) {
  const std::array<int, 3> step = ChooseBlocks(ct);
  if (step == std::array<int, 3>{1, 1, 1}) return IsolateOn(ct, options, progress);
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
  return result;
}

bool IsNearBone(const Volume& ct, double iso_hu, const Vec3& p_W) {
  return FindBoneNear(ct, iso_hu, p_W).has_value();
}

}  // namespace kerf
