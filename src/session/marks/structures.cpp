#include "session/marks/structures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <tuple>

#include "bone/grid/removed.h"
#include "cut/effects/structure_voxels.h"
#include "session/marks/mark_tube.h"

namespace kerf {
namespace {

constexpr double kMinTooth_mm3 = 5;
constexpr double kOtherSide = 0.2;  // part of the volume
constexpr double kRootReach_mm = 1.5;
constexpr double kCluster_mm = 2;

/// Points in groups of neighbours, to find the nearest pair of two clouds without comparing all.
class PointCloud {
 public:
  void Add(const Vec3& p) {
    const auto cell = [](double x) { return static_cast<int>(std::floor(x / kCluster_mm)); };
    Cluster& cluster = clusters_[{cell(p.x), cell(p.y), cell(p.z)}];
    cluster.points.push_back(p);
    cluster.box.Include(p);
  }
  bool empty() const { return clusters_.empty(); }

  struct Pair {
    double distance_mm = std::numeric_limits<double>::infinity();
    Vec3 p{0};  // of this cloud
    Vec3 q{0};  // of the other
  };
  Pair FindNearest(const PointCloud& other) const {
    std::vector<std::tuple<double, const Cluster*, const Cluster*>> order;
    for (const auto& [a_cell, a] : clusters_) {
      for (const auto& [b_cell, b] : other.clusters_) {
        const Vec3 gap = glm::max(glm::max(a.box.lower - b.box.upper, b.box.lower - a.box.upper), Vec3(0));
        order.emplace_back(glm::length(gap), &a, &b);
      }
    }
    std::sort(order.begin(), order.end(),
              [](const auto& a, const auto& b) { return std::get<double>(a) < std::get<double>(b); });
    Pair best;
    for (const auto& [least_mm, a, b] : order) {
      if (least_mm >= best.distance_mm) break;
      for (const Vec3& p : a->points) {
        for (const Vec3& q : b->points) {
          const double distance_mm = glm::length(p - q);
          if (distance_mm < best.distance_mm) best = {.distance_mm = distance_mm, .p = p, .q = q};
        }
      }
    }
    return best;
  }

 private:
  struct Cluster {
    std::vector<Vec3> points;
    Box3 box;
  };
  std::map<std::tuple<int, int, int>, Cluster> clusters_;
};

/// Voxels of the region grid as runs along z, with the connected part to which each run belongs.
class RegionParts {
 public:
  RegionParts(const Bone& bone, Tissue tissue) : h_(bone.region_voxel_mm()) {
    StructureVoxels voxels(h_);
    voxels.AddRegions(bone, FindRegionsOf(bone, tissue));
    voxels.Finish();
    const auto index = [this](double x) { return static_cast<int>(std::floor(x / h_ + 0.5)); };
    for (const Box3& box : voxels.MakeBoxes()) {
      const Vec3 middle = box.centre();
      columns_[{index(middle.x), index(middle.y)}].push_back(runs_.size());
      runs_.push_back({.x = index(middle.x),
                       .y = index(middle.y),
                       .z0 = index(box.lower.z + 0.5 * h_),
                       .z1 = index(box.upper.z - 0.5 * h_)});
    }
  }

  struct Run {
    int x = 0;
    int y = 0;
    int z0 = 0;
    int z1 = 0;
    int part = 0;
  };
  std::vector<Run>& runs() { return runs_; }
  double voxel_mm() const { return h_; }
  Vec3 PointOf(const Run& run, int z) const { return h_ * Vec3(run.x, run.y, z); }
  double CalcVolume(const Run& run) const { return h_ * h_ * h_ * (run.z1 - run.z0 + 1); }
  /// Returns the part of the voxel that contains the point; -1 if there is none.
  int FindPart(const Vec3& p_W) const {
    const auto index = [this](double x) { return static_cast<int>(std::floor(x / h_ + 0.5)); };
    const auto column = columns_.find({index(p_W.x), index(p_W.y)});
    if (column == columns_.end()) return -1;
    const int z = index(p_W.z);
    for (const std::size_t i : column->second) {
      if (runs_[i].z0 <= z && z <= runs_[i].z1) return runs_[i].part;
    }
    return -1;
  }
  /// Numbers the connected parts from 0 and returns their number.
  int LabelConnected() {
    int count = 0;
    std::vector<std::size_t> open;
    for (Run& run : runs_) run.part = -1;
    for (std::size_t first = 0; first < runs_.size(); ++first) {
      if (runs_[first].part >= 0) continue;
      runs_[first].part = count;
      open.push_back(first);
      while (!open.empty()) {
        const Run run = runs_[open.back()];
        open.pop_back();
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const auto column = columns_.find({run.x + dx, run.y + dy});
          if (column == columns_.end()) continue;
          for (const std::size_t i : column->second) {
            if (runs_[i].part >= 0 || runs_[i].z0 > run.z1 || runs_[i].z1 < run.z0) continue;
            runs_[i].part = count;
            open.push_back(i);
          }
        }
      }
      ++count;
    }
    return count;
  }

 private:
  double h_;
  std::vector<Run> runs_;
  std::map<std::pair<int, int>, std::vector<std::size_t>> columns_;
};

/// Volumes and places of the parts.
struct PartSums {
  double mm3 = 0;
  double left_mm3 = 0;  // on the patient's left
  Vec3 centre{0};
  PointCloud points;
};

std::vector<PartSums> SumParts(RegionParts& parts, int count, double mid_x_mm, bool with_points) {
  std::vector<PartSums> sums(static_cast<std::size_t>(count));
  for (const RegionParts::Run& run : parts.runs()) {
    PartSums& sum = sums[static_cast<std::size_t>(run.part)];
    const double mm3 = parts.CalcVolume(run);
    sum.mm3 += mm3;
    if (run.x * parts.voxel_mm() > mid_x_mm) sum.left_mm3 += mm3;
    sum.centre += mm3 * 0.5 * (parts.PointOf(run, run.z0) + parts.PointOf(run, run.z1));
    for (int z = run.z0; with_points && z <= run.z1; ++z) sum.points.Add(parts.PointOf(run, z));
  }
  for (PartSums& sum : sums) {
    if (sum.mm3 > 0) sum.centre /= sum.mm3;
  }
  return sums;
}

/// Makes the parts of the canals: 0 on the patient's right, 1 on the left.
int DivideCanals(RegionParts& parts, double mid_x_mm) {
  for (RegionParts::Run& run : parts.runs()) run.part = run.x * parts.voxel_mm() > mid_x_mm ? 1 : 0;
  return 2;
}

/// Makes the parts of the teeth: connected ones, the smallest of which join the nearest tooth.
int DivideTeeth(RegionParts& parts, double mid_x_mm) {
  const int count = parts.LabelConnected();
  const std::vector<PartSums> sums = SumParts(parts, count, mid_x_mm, false);
  std::vector<int> teeth;
  for (int i = 0; i < count; ++i) {
    if (sums[static_cast<std::size_t>(i)].mm3 >= kMinTooth_mm3) teeth.push_back(i);
  }
  if (teeth.empty() && count > 0) teeth.push_back(0);
  std::vector<int> number(static_cast<std::size_t>(count), 0);
  for (int i = 0; i < count; ++i) {
    double best_mm = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < teeth.size(); ++k) {
      const double distance_mm =
          teeth[k] == i
              ? -1
              : glm::length(sums[static_cast<std::size_t>(i)].centre - sums[static_cast<std::size_t>(teeth[k])].centre);
      if (distance_mm >= best_mm) continue;
      best_mm = distance_mm;
      number[static_cast<std::size_t>(i)] = static_cast<int>(k);
    }
  }
  for (RegionParts::Run& run : parts.runs()) run.part = number[static_cast<std::size_t>(run.part)];
  return static_cast<int>(teeth.size());
}

BodySide CalcSide(double mm3, double left_mm3) {
  if (left_mm3 > (1 - kOtherSide) * mm3) return BodySide::kLeft;
  return left_mm3 < kOtherSide * mm3 ? BodySide::kRight : BodySide::kBoth;
}

ToothPart CalcToothPart(const Bone& bone, const std::array<bool, 256>& teeth, const Vec3& p_W) {
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const Vec3 direction = glm::normalize(Vec3(x, y, z));
        for (double s = bone.region_voxel_mm(); s <= kRootReach_mm; s += bone.region_voxel_mm()) {
          const Vec3 q = p_W + s * direction;
          const int region = bone.SignedDistance(q) < 0 ? bone.RegionAt(q) : 0;
          if (region > 0 && region < 256 && !teeth[static_cast<std::size_t>(region)]) return ToothPart::kRoot;
        }
      }
    }
  }
  return ToothPart::kCrown;
}

/// Numbers the teeth of each side from the patient's middle, by the angle about the middle of the dental arch's back.
void NumberTeeth(std::vector<StructureResult>& teeth, const std::vector<Vec3>& centres, double mid_x_mm) {
  double back_mm = -std::numeric_limits<double>::infinity();
  for (const Vec3& p : centres) back_mm = std::max(back_mm, p.y);
  for (const BodySide side : {BodySide::kLeft, BodySide::kRight}) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < teeth.size(); ++i) {
      if (teeth[i].side != side) continue;
      order.emplace_back(std::atan2(std::abs(centres[i].x - mid_x_mm), back_mm - centres[i].y + 1), i);
    }
    std::sort(order.begin(), order.end());
    for (std::size_t k = 0; k < order.size(); ++k) teeth[order[k].second].number = static_cast<int>(k) + 1;
  }
}

void AddRegionStructures(const Bone& before, const std::vector<RemovedCell>& removed, const PointCloud& cut,
                         Tissue tissue, double mid_x_mm, std::vector<StructureResult>& results) {
  RegionParts parts(before, tissue);
  if (parts.runs().empty()) return;
  const bool tooth = tissue == Tissue::kTooth;
  const int count = tooth ? DivideTeeth(parts, mid_x_mm) : DivideCanals(parts, mid_x_mm);
  const std::vector<PartSums> sums = SumParts(parts, count, mid_x_mm, true);
  const std::array<bool, 256> regions = FindRegionsOf(before, tissue);
  std::vector<double> removed_mm3(sums.size(), 0.0);
  std::vector<Vec3> removed_p(sums.size(), Vec3(0));
  for (const RemovedCell& cell : removed) {
    if (!(cell.mm3 > 0) || cell.region <= 0 || cell.region > 255 || !regions[static_cast<std::size_t>(cell.region)]) {
      continue;
    }
    const int part = parts.FindPart(cell.p_W);
    if (part < 0) continue;
    removed_mm3[static_cast<std::size_t>(part)] += cell.mm3;
    removed_p[static_cast<std::size_t>(part)] += cell.mm3 * cell.p_W;
  }
  std::vector<StructureResult> found;
  std::vector<Vec3> centres;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const PartSums& sum = sums[i];
    if (!(sum.mm3 > 0)) continue;
    StructureResult result{.kind = tooth ? MarkKind::kTooth : MarkKind::kCanal,
                           .side = CalcSide(sum.mm3, sum.left_mm3),
                           .is_cut = removed_mm3[i] > 0,
                           .removed_mm3 = removed_mm3[i],
                           .size_mm3 = sum.mm3};
    if (result.is_cut) {
      result.distance_mm = 0;
      result.p_W = removed_p[i] / removed_mm3[i];
    } else if (!cut.empty()) {
      const PointCloud::Pair pair = sum.points.FindNearest(cut);
      // Between the centres of a voxel and of a removed cell, each of which ends half of its edge before.
      result.distance_mm = std::max(0.0, pair.distance_mm - 0.5 * (parts.voxel_mm() + before.voxel_mm()));
      result.p_W = pair.p;
    }
    if (tooth && result.distance_mm) result.part = CalcToothPart(before, regions, result.p_W);
    found.push_back(result);
    centres.push_back(sum.centre);
  }
  if (tooth) NumberTeeth(found, centres, mid_x_mm);
  results.insert(results.end(), found.begin(), found.end());
}

StructureResult AssessMark(const Mark& mark, const std::vector<RemovedCell>& removed, double voxel_mm,
                           double mid_x_mm) {
  const MarkTube tube(mark);
  double length_mm = 0;
  double left_mm = 0;
  for (std::size_t i = 1; i < tube.curve_W().size(); ++i) {
    const Vec3& a = tube.curve_W()[i - 1];
    const Vec3& b = tube.curve_W()[i];
    const double step_mm = glm::length(b - a);
    length_mm += step_mm;
    // The part of the segment with x above the middle.
    const double low = std::min(a.x, b.x);
    const double high = std::max(a.x, b.x);
    left_mm += step_mm * (high > low ? std::clamp((high - mid_x_mm) / (high - low), 0.0, 1.0) : a.x > mid_x_mm ? 1 : 0);
  }
  const double r = mark.radius_mm;
  StructureResult result{.name = mark.name,
                         .kind = mark.kind,
                         .side = length_mm > 0                         ? CalcSide(length_mm, left_mm)
                                 : tube.curve_W().front().x > mid_x_mm ? BodySide::kLeft
                                                                       : BodySide::kRight,
                         .is_mark = true,
                         .size_mm3 = std::numbers::pi * r * r * (length_mm + 4.0 / 3.0 * r)};
  Vec3 sum(0);
  for (const RemovedCell& cell : removed) {
    if (!(cell.mm3 > 0)) continue;
    const MarkTube::Nearest nearest = tube.Find(cell.p_W);
    if (nearest.distance_mm <= 0) {
      result.removed_mm3 += cell.mm3;
      sum += cell.mm3 * nearest.p_W;
    }
    const double distance_mm = std::max(0.0, nearest.distance_mm - 0.5 * voxel_mm);
    if (result.distance_mm && distance_mm >= *result.distance_mm) continue;
    result.distance_mm = distance_mm;
    result.p_W = nearest.p_W;
  }
  result.is_cut = result.removed_mm3 > 0;
  if (result.is_cut) {
    result.distance_mm = 0;
    result.p_W = sum / result.removed_mm3;
  }
  return result;
}

}  // namespace

StructureAssessment AssessStructures(const Bone& before, const Bone& after, const std::vector<Mark>& marks,
                                     std::optional<double> mid_x_mm) {
  CheckMarks(marks);
  const std::vector<RemovedCell> removed = FindRemoved(before, after);
  const double mid = mid_x_mm.value_or(before.empty() ? 0.0 : before.CalcBounds().centre().x);
  PointCloud cut;
  for (const RemovedCell& cell : removed) {
    if (cell.mm3 > 0) cut.Add(cell.p_W);
  }
  StructureAssessment out;
  AddRegionStructures(before, removed, cut, Tissue::kCanal, mid, out.structures);
  out.canal_known = !out.structures.empty();
  const std::size_t canals = out.structures.size();
  AddRegionStructures(before, removed, cut, Tissue::kTooth, mid, out.structures);
  out.teeth_known = out.structures.size() > canals;
  for (const Mark& mark : marks) {
    if (mark.points_W.empty()) continue;
    out.structures.push_back(AssessMark(mark, removed, before.voxel_mm(), mid));
    out.canal_known |= mark.kind == MarkKind::kNerve || mark.kind == MarkKind::kCanal;
    out.teeth_known |= mark.kind == MarkKind::kTooth || mark.kind == MarkKind::kRoot;
  }
  std::stable_sort(out.structures.begin(), out.structures.end(),
                   [](const StructureResult& a, const StructureResult& b) {
                     if (a.is_cut != b.is_cut) return a.is_cut;
                     return a.distance_mm.value_or(0) < b.distance_mm.value_or(0);
                   });
  return out;
}

std::string MakeStructureName(const StructureResult& structure) {
  if (!structure.name.empty()) return structure.name;
  const bool tooth = structure.kind == MarkKind::kTooth;
  switch (structure.side) {
    case BodySide::kLeft:
      return tooth ? fmt::format("tooth {} from the middle, patient's left", structure.number)
                   : "canal of the nerve, patient's left";
    case BodySide::kRight:
      return tooth ? fmt::format("tooth {} from the middle, patient's right", structure.number)
                   : "canal of the nerve, patient's right";
    case BodySide::kBoth:
      break;
  }
  return tooth ? "teeth on both sides of the middle" : "canal of the nerve, on both sides";
}

std::string DescribePlace(const Vec3& p_W) {
  const auto word = [](double x, const char* positive, const char* negative) {
    const double rounded = std::round(10 * x) / 10;
    return rounded == 0 ? std::string("0.0 mm")
                        : fmt::format("{:.1f} mm {}", std::abs(rounded), rounded > 0 ? positive : negative);
  };
  return fmt::format("{}, {}, {}", word(p_W.x, "left", "right"), word(p_W.y, "back", "front"),
                     word(p_W.z, "up", "down"));
}

}  // namespace kerf
