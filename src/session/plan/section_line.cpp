#include "session/plan/section_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "session/plan/edit_plane.h"

namespace kerf {
namespace {

/// Lattice of phi in the plane's rectangle. An edge of the lattice is identified by its first node and its direction.
class SectionLattice {
 public:
  SectionLattice(const PhiSampler& bone, const PlannedPlane& plane) {
    const auto steps = [&](double size_mm) {
      return std::clamp(static_cast<int>(std::ceil(size_mm / bone.voxel_mm())), 2, kMaxSectionSteps);
    };
    columns_ = steps(plane.width_mm);
    rows_ = steps(plane.height_mm);
    const PlaneAxes axes = CalcPlaneAxes(plane);
    corner_W_ = CalcPlaneCorners(plane)[0];
    across_W_ = plane.width_mm / columns_ * axes.across_W;
    up_W_ = plane.height_mm / rows_ * axes.up_W;
    phi_.reserve(static_cast<std::size_t>(columns_ + 1) * static_cast<std::size_t>(rows_ + 1));
    for (int j = 0; j <= rows_; ++j) {
      for (int i = 0; i <= columns_; ++i) phi_.push_back(bone.Calc(PointOf(i, j)));
    }
  }

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  double At(int i, int j) const { return phi_[Index(i, j)]; }
  /// Edge from node (i, j) to the right (`up` false) or upwards.
  std::uint64_t EdgeOf(int i, int j, bool up) const { return 2 * Index(i, j) + (up ? 1 : 0); }
  /// Returns the point of the edge where phi is 0.
  Vec3 CalcPoint(std::uint64_t edge) const {
    const std::size_t index = edge / 2;
    const int i = static_cast<int>(index % static_cast<std::size_t>(columns_ + 1));
    const int j = static_cast<int>(index / static_cast<std::size_t>(columns_ + 1));
    const bool up = (edge & 1) != 0;
    const double a = At(i, j);
    const double b = up ? At(i, j + 1) : At(i + 1, j);
    return PointOf(i, j) + a / (a - b) * (up ? up_W_ : across_W_);
  }

 private:
  std::size_t Index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_ + 1) + static_cast<std::size_t>(i);
  }
  Vec3 PointOf(int i, int j) const {
    return corner_W_ + static_cast<double>(i) * across_W_ + static_cast<double>(j) * up_W_;
  }

  int columns_ = 0;
  int rows_ = 0;
  Vec3 corner_W_{0};
  Vec3 across_W_{0};
  Vec3 up_W_{0};
  std::vector<double> phi_;
};

/// Directed segments between edges of the lattice, with the bone on their left. Each edge is the start of at most one
/// segment and the end of at most one.
using Segments = std::unordered_map<std::uint64_t, std::uint64_t>;

void AddSegments(const SectionLattice& lattice, int i, int j, Segments& segments) {
  const std::array<double, 4> phi{lattice.At(i, j), lattice.At(i + 1, j), lattice.At(i + 1, j + 1),
                                  lattice.At(i, j + 1)};
  // Edges in counter-clockwise order: edge k lies between corners k and k + 1.
  const std::array<std::uint64_t, 4> edge{lattice.EdgeOf(i, j, false), lattice.EdgeOf(i + 1, j, true),
                                          lattice.EdgeOf(i, j + 1, false), lattice.EdgeOf(i, j, true)};
  std::array<std::size_t, 2> entries{};  // edges where the cell's border enters the bone,
  std::array<std::size_t, 2> exits{};    // and where it leaves it
  std::size_t entry_count = 0;
  std::size_t exit_count = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const bool in = phi[k] < 0;
    const bool next_in = phi[(k + 1) % 4] < 0;
    if (!in && next_in) entries[entry_count++] = k;
    if (in && !next_in) exits[exit_count++] = k;
  }
  if (exit_count == 0) return;
  if (exit_count == 1) {
    segments[edge[exits[0]]] = edge[entries[0]];
    return;
  }
  // Opposite corners are inside. The mean decides whether the two are connected: each exit is then joined with the
  // next entry along the border, otherwise with the previous one.
  const bool connected = phi[0] + phi[1] + phi[2] + phi[3] < 0;
  for (const std::size_t exit : exits) {
    const std::size_t entry = connected ? (exit + 1) % 4 : (exit + 3) % 4;
    segments[edge[exit]] = edge[entry];
  }
}

}  // namespace

std::vector<std::vector<Vec3>> SectionLine(const PhiSampler& bone, const PlannedPlane& plane) {
  const SectionLattice lattice(bone, plane);
  Segments next;
  for (int j = 0; j < lattice.rows(); ++j) {
    for (int i = 0; i < lattice.columns(); ++i) AddSegments(lattice, i, j, next);
  }
  Segments previous;
  for (const auto& [from, to] : next) previous[to] = from;
  // The lines start in the order of the lattice, so that the result does not depend on the order of the map.
  std::vector<std::uint64_t> starts;
  for (const auto& [from, to] : next) starts.push_back(from);
  std::sort(starts.begin(), starts.end(), [&](std::uint64_t a, std::uint64_t b) {
    const bool a_open = previous.count(a) == 0;
    const bool b_open = previous.count(b) == 0;
    return a_open != b_open ? a_open : a < b;  // open lines first, from their ends
  });
  std::vector<std::vector<Vec3>> lines;
  for (const std::uint64_t start : starts) {
    if (next.count(start) == 0) continue;
    std::vector<Vec3> line{lattice.CalcPoint(start)};
    std::uint64_t at = start;
    for (auto found = next.find(at); found != next.end(); found = next.find(at)) {
      at = found->second;
      next.erase(found);
      line.push_back(lattice.CalcPoint(at));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

namespace {

/// Rectangle along the axes of a plane, mm from its centre.
struct SectionBox {
  double left = std::numeric_limits<double>::infinity();
  double right = -left;
  double bottom = left;
  double top = -left;

  void Include(const SectionBox& box) {
    left = std::min(left, box.left);
    right = std::max(right, box.right);
    bottom = std::min(bottom, box.bottom);
    top = std::max(top, box.top);
  }
  bool Contains(const SectionBox& box) const {
    return left <= box.left && right >= box.right && bottom <= box.bottom && top >= box.top;
  }
};

double CalcDistanceTo(const std::vector<Vec3>& line, const Vec3& p_W) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& point : line) nearest = std::min(nearest, glm::length(point - p_W));
  return nearest;
}

}  // namespace

PlannedPlane FitToSection(const PhiSampler& bone, const PlannedPlane& plane, std::span<const Vec3> near_W,
                          double margin_mm) {
  constexpr double kReach_mm = 120;
  PlannedPlane fitted = plane;
  fitted.width_mm = fitted.height_mm = 2 * kReach_mm;
  const std::vector<std::vector<Vec3>> lines = SectionLine(bone, fitted);
  if (lines.empty()) return plane;
  const PlaneAxes axes = CalcPlaneAxes(plane);
  std::vector<SectionBox> boxes;
  for (const std::vector<Vec3>& line : lines) {
    SectionBox box;
    for (const Vec3& p_W : line) {
      const double x = glm::dot(p_W - plane.plane.p_W, axes.across_W);
      const double y = glm::dot(p_W - plane.plane.p_W, axes.up_W);
      box.Include({x, x, y, y});
    }
    boxes.push_back(box);
  }
  SectionBox box;
  for (const Vec3& p_W : near_W) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      if (CalcDistanceTo(lines[i], p_W) < CalcDistanceTo(lines[nearest], p_W)) nearest = i;
    }
    // The nearest line may be that of a cavity: the line around it belongs to the same part.
    for (const SectionBox& other : boxes) {
      if (other.Contains(boxes[nearest])) box.Include(other);
    }
  }
  if (!(box.left <= box.right)) return plane;
  fitted.plane.p_W += 0.5 * (box.left + box.right) * axes.across_W + 0.5 * (box.bottom + box.top) * axes.up_W;
  fitted.width_mm = kPlaneSizeRange_mm.Clamp(box.right - box.left + 2 * margin_mm);
  fitted.height_mm = kPlaneSizeRange_mm.Clamp(box.top - box.bottom + 2 * margin_mm);
  return fitted;
}

}  // namespace kerf
