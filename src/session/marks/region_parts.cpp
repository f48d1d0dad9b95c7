#include "session/marks/region_parts.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "bone/material/segment_regions.h"
#include "cut/effects/structure_voxels.h"

namespace kerf {
namespace {

constexpr double kMinTooth_mm3 = 5;
constexpr double kOtherSide = 0.2;  // part of the volume

/// Volume and centre of a part.
struct PartSum {
  double mm3 = 0;
  double left_mm3 = 0;  // on the patient's left
  Vec3 centre{0};
  Box3 box{};
  Box3 turned{};  // by 45 degrees about z

  /// Returns true if the part is more than one tooth.
  bool IsRow(double voxel_mm) const {
    const double width_mm = voxel_mm + std::max({box.size().x, box.size().y, turned.size().x, turned.size().y});
    return mm3 > kMaxTooth_mm3 || width_mm > kMaxTooth_mm;
  }
};

std::vector<PartSum> SumParts(const RegionParts& parts, int count, double mid_x_mm) {
  const double h = parts.voxel_mm();
  std::vector<PartSum> sums(static_cast<std::size_t>(count));
  for (const RegionParts::Run& run : parts.runs()) {
    PartSum& sum = sums[static_cast<std::size_t>(run.part)];
    const double mm3 = h * h * h * (run.z1 - run.z0 + 1);
    sum.mm3 += mm3;
    if (run.x * h > mid_x_mm) sum.left_mm3 += mm3;
    const Vec3 p = parts.PointOf(run, run.z0);
    sum.box.Include(p);
    sum.turned.Include(std::numbers::sqrt2 / 2 * Vec3(p.x + p.y, p.x - p.y, 0));
    sum.centre += mm3 * 0.5 * (parts.PointOf(run, run.z0) + parts.PointOf(run, run.z1));
  }
  for (PartSum& sum : sums) {
    if (sum.mm3 > 0) sum.centre /= sum.mm3;
  }
  return sums;
}

/// Numbers the teeth of each side from the patient's middle, by the angle about the middle of the dental arch's back,
/// up to a row whose teeth cannot be counted.
void NumberTeeth(std::vector<StructureResult>& teeth, const std::vector<PartSum>& sums, double mid_x_mm) {
  double back_mm = -std::numeric_limits<double>::infinity();
  for (const PartSum& sum : sums) back_mm = std::max(back_mm, sum.centre.y);
  // A part in the middle may hide teeth of either side.
  if (std::ranges::any_of(teeth, [](const auto& t) { return t.fdi == 0 && t.side == BodySide::kBoth; })) return;
  for (const BodySide side : {BodySide::kLeft, BodySide::kRight}) {
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < teeth.size(); ++i) {
      if (teeth[i].side != side) continue;
      order.emplace_back(std::atan2(std::abs(sums[i].centre.x - mid_x_mm), back_mm - sums[i].centre.y + 1), i);
    }
    std::sort(order.begin(), order.end());
    for (std::size_t k = 0; k < order.size() && !teeth[order[k].second].is_row; ++k) {
      teeth[order[k].second].number = static_cast<int>(k) + 1;
    }
  }
}

/// Returns the regions of teeth with numbers, by number, and takes them out of `regions`.
std::map<int, int> TakeNumbered(const Bone& bone, std::array<bool, 256>& regions) {
  std::map<int, int> numbered;
  for (const auto& [id, region] : bone.materials().regions()) {
    const int fdi = FindToothNumber(region);
    if (fdi == 0 || !regions[static_cast<std::size_t>(id)] || !numbered.emplace(fdi, id).second) continue;
    regions[static_cast<std::size_t>(id)] = false;
  }
  return numbered;
}

}  // namespace

int FindPartOf(const RemovedCell& cell, const Bone& before, const RegionParts& parts,
               const std::array<bool, 256>& regions) {
  const auto has_tissue = [&](int region) {
    return region > 0 && region < 256 && regions[static_cast<std::size_t>(region)];
  };
  if (!(cell.mm3 > 0) || parts.runs().empty() || (cell.region > 0 && !has_tissue(cell.region))) return -1;
  if (const int part = parts.FindPart(cell.p_W); part >= 0) return part;
  // At the surface, the voxel may be outside of the bone.
  const double h = parts.voxel_mm();
  const Vec3 middle = h * glm::floor(cell.p_W / h + 0.5);
  double nearest_mm = std::numeric_limits<double>::infinity();
  int nearest = -1;
  for (int i = 0; i < 27; ++i) {
    const Vec3 q_W = middle + h * Vec3(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
    const double distance_mm = glm::length(q_W - cell.p_W);
    if (distance_mm >= nearest_mm) continue;
    const int part = parts.FindPart(q_W);
    // Without a region of its own, the place belongs to the nearest voxel that has one.
    if (part < 0 && (cell.region > 0 || before.RegionAt(q_W) <= 0)) continue;
    nearest_mm = distance_mm;
    nearest = part;
  }
  return nearest;
}

BodySide CalcSide(double size, double left) {
  if (left > (1 - kOtherSide) * size) return BodySide::kLeft;
  return left < kOtherSide * size ? BodySide::kRight : BodySide::kBoth;
}

RegionParts::RegionParts(const Bone& bone, Tissue tissue, double mid_x_mm) : h_(bone.region_voxel_mm()) {
  std::array<bool, 256> unnumbered = FindRegionsOf(bone, tissue);
  const std::map<int, int> numbered = TakeNumbered(bone, unnumbered);
  AddRuns(bone, unnumbered, 0);
  int count = 0;
  if (tissue == Tissue::kTooth) {
    if (!runs_.empty()) count = DivideTeeth();
  } else if (tissue == Tissue::kCanal) {
    count = 2;  // 0 on the patient's right, 1 on the left
    for (Run& run : runs_) run.part = run.x * h_ > mid_x_mm ? 1 : 0;
  } else {
    count = 1;
  }
  std::vector<int> fdi(static_cast<std::size_t>(count), 0);
  for (const auto& [number, region] : numbered) {
    std::array<bool, 256> regions{};
    regions[static_cast<std::size_t>(region)] = true;
    AddRuns(bone, regions, count++);
    fdi.push_back(number);
  }
  if (runs_.empty()) return;
  const std::vector<PartSum> sums = SumParts(*this, count, mid_x_mm);
  for (std::size_t i = 0; i < sums.size(); ++i) {
    structures_.push_back({.kind = tissue == Tissue::kTooth   ? MarkKind::kTooth
                                   : tissue == Tissue::kCanal ? MarkKind::kCanal
                                                              : MarkKind::kLesion,
                           .side = CalcSide(sums[i].mm3, sums[i].left_mm3),
                           .is_row = tissue == Tissue::kTooth && fdi[i] == 0 && sums[i].IsRow(h_),
                           .fdi = fdi[i],
                           .size_mm3 = sums[i].mm3});
  }
  if (tissue == Tissue::kTooth) NumberTeeth(structures_, sums, mid_x_mm);
}

/// Adds the voxels of the regions to a part.
void RegionParts::AddRuns(const Bone& bone, const std::array<bool, 256>& regions, int part) {
  StructureVoxels voxels(h_);
  voxels.AddRegions(bone, regions);
  voxels.Finish();
  const auto index = [this](double x) { return static_cast<int>(std::floor(x / h_ + 0.5)); };
  for (const Box3& box : voxels.MakeBoxes()) {
    const Vec3 middle = box.centre();
    columns_[{index(middle.x), index(middle.y)}].push_back(runs_.size());
    runs_.push_back({.x = index(middle.x),
                     .y = index(middle.y),
                     .z0 = index(box.lower.z + 0.5 * h_),
                     .z1 = index(box.upper.z - 0.5 * h_),
                     .part = part});
  }
}

int RegionParts::FindPart(const Vec3& p_W) const {
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
int RegionParts::LabelConnected() {
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

/// Makes the parts of the teeth: connected ones, the smallest of which join the nearest tooth. Returns their number.
int RegionParts::DivideTeeth() {
  const int count = LabelConnected();
  const std::vector<PartSum> sums = SumParts(*this, count, 0);
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
  for (Run& run : runs_) run.part = number[static_cast<std::size_t>(run.part)];
  return static_cast<int>(teeth.size());
}

}  // namespace kerf
