#include "bone/import/mandible_likeness.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>
#include <utility>

#include "base/core/hash.h"
#include "base/core/symmetric_eigen.h"
#include "bone/import/patient_frame.h"

namespace kerf {

namespace {

std::string Outside(const char* what, double value, double lower, double upper, const char* unit) {
  const int digits = value < 10 ? 2 : 0;
  if (value < lower) return fmt::format("its {} of {:.{}f} {} is below {:.0f}", what, value, digits, unit, lower);
  if (value > upper) return fmt::format("its {} of {:.{}f} {} is above {:.0f}", what, value, digits, unit, upper);
  return "";
}

// Number of bins along an axis of the box, from 0 to 1, symmetric about its middle.
constexpr int kBins = 8;

int FindBin(double t) {
  return (t > 0.25 ? 1 : 0) + (3 * t >= 1 ? 1 : 0) + (t >= 0.4 ? 1 : 0) + (t > 0.5 ? 1 : 0) + (t > 0.6 ? 1 : 0) +
         (3 * t >= 2 ? 1 : 0) + (t > 0.75 ? 1 : 0);
}

// Number of voxels in each bin of the box around a component.
using Counts = std::array<std::array<std::array<std::size_t, kBins>, kBins>, kBins>;  // z, y, x

// Counts the points that `for_each` visits.
template <typename ForEach>
Counts CountPoints(ForEach&& for_each) {
  Box3 box;
  for_each([&box](const Vec3& p) { box.Include(p); });
  Counts counts{};
  for_each([&](const Vec3& p) {
    const Vec3 t = (p - box.lower) / box.size();
    ++counts[static_cast<std::size_t>(FindBin(t.z))][static_cast<std::size_t>(FindBin(t.y))]
            [static_cast<std::size_t>(FindBin(t.x))];
  });
  return counts;
}

// Calls visit(p_W) for the centres of a component's voxels.
template <typename Visit>
void ForEachVoxel(const Volume& lattice, const std::vector<std::int32_t>& labels, std::int32_t label,
                  const Component& component, Visit&& visit) {
  for (int k = component.lower[2]; k <= component.upper[2]; ++k) {
    for (int j = component.lower[1]; j <= component.upper[1]; ++j) {
      for (int i = component.lower[0]; i <= component.upper[0]; ++i) {
        if (labels[lattice.Index(i, j, k)] == label) visit(lattice.WorldFromVoxel({i, j, k}));
      }
    }
  }
}

Counts CountVoxels(const Volume& lattice, const std::vector<std::int32_t>& labels, std::int32_t label,
                   const Component& component) {
  return CountPoints([&](const auto& visit) { ForEachVoxel(lattice, labels, label, component, visit); });
}

// Returns the objection to the size in the patient's axes; empty if there is none.
std::string FindSizeObjection(double volume_mm3, const Vec3& size) {
  for (const std::string& text :
       {Outside("volume", volume_mm3 / 1000, 8, 120, "cm3"), Outside("width", size.x, 80, 150, "mm"),
        Outside("depth from front to back", size.y, 50, 130, "mm"), Outside("height", size.z, 40, 120, "mm")}) {
    if (!text.empty()) return text;
  }
  return "";
}

// Sets the fractions and the objection, if any, for voxels that lie along the columns of `turn` in the patient's axes.
void CheckFractions(const Counts& counts, const glm::dmat3& turn, MandibleLikeness& shape) {
  shape.back_middle = shape.back_left = shape.back_right = shape.front_middle = 0;
  shape.top_left = shape.top_middle = shape.top_right = shape.top_front = 0;
  double n = 0;
  double top = 0;
  double bottom = 0, bottom_middle = 0;
  for (int bin = 0; bin < kBins * kBins * kBins; ++bin) {
    const std::array<int, 3> at = {bin % kBins, bin / kBins % kBins, bin / kBins / kBins};
    const auto count = static_cast<double>(counts[at[2]][at[1]][at[0]]);
    if (count == 0) continue;
    // 0 to kBins - 1: right to left, front to back, bottom to top.
    const Vec3 middle((kBins - 1) / 2.0);
    const Vec3 t = turn * (Vec3(at[0], at[1], at[2]) - middle) + middle;
    const int third = t.x < 1.5 ? 0 : t.x < 5.5 ? 1 : 2;
    n += count;
    if (t.y > 3.5) (third == 0 ? shape.back_right : third == 1 ? shape.back_middle : shape.back_left) += count;
    if (t.y < 2.5 && third == 1) shape.front_middle += count;
    if (t.z < 0.5) {
      bottom += count;
      if (third == 1) bottom_middle += count;
    }
    if (t.z > 6.5) {
      top += count;
      if (t.y < 2.5) shape.top_front += count;
      (third == 0 ? shape.top_right : third == 1 ? shape.top_middle : shape.top_left) += count;
    }
  }
  for (double* fraction : {&shape.back_middle, &shape.back_left, &shape.back_right, &shape.front_middle})
    *fraction /= n;
  for (double* fraction : {&shape.top_left, &shape.top_middle, &shape.top_right, &shape.top_front})
    *fraction /= std::max(top, 1.0);

  const auto object = [&shape](const char* text) {
    if (shape.objection.empty()) shape.objection = text;
  };
  if (shape.back_middle > 0.02) object("it is not open to the back, as the arch of a mandible is");
  // 0.19 and more in a mandible, 0.1 in a pelvis.
  if (shape.front_middle < 0.14) object("it has no chin in the middle of its front");
  if (std::min(shape.back_left, shape.back_right) < 0.08) object("it has no ramus at the back on one side");
  if (shape.top_middle > 0.05) object("its top reaches across the middle, as a skull's or an upper jaw's does");
  if (shape.top_front > 0.1) object("its top reaches to the front, as the wings of a pelvis do");
  if (std::min(shape.top_left, shape.top_right) < 0.15) object("only one side reaches up to a condyle");
  // 0.4 to 0.5 in a mandible, 0.8 in one whose y and z are exchanged, which mirrors it.
  if (bottom_middle > 0.7 * bottom) object("its bottom is a chin without the lower borders of the two sides");
}

bool KeepsAxes(const glm::dmat3& turn) {
  return turn[0][0] != 0 && turn[1][1] != 0;
}

// Returns the rotations that map axes to axes, first those that only change signs. A mandible looks the same in a
// mirror, so reflections need not be tried.
std::vector<glm::dmat3> MakeRotations() {
  std::vector<glm::dmat3> rotations;
  std::array<int, 3> order = {0, 1, 2};
  do {
    for (const Vec3& sign : {Vec3(-1, -1, 1), Vec3(-1, 1, -1), Vec3(1, -1, -1), Vec3(1, 1, 1)}) {
      glm::dmat3 turn(0);
      for (int a = 0; a < 3; ++a) turn[a][order[static_cast<std::size_t>(a)]] = sign[a];
      if (glm::determinant(turn) < 0) turn = -turn;
      rotations.push_back(turn);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

constexpr double kMaxTurn_deg = 66;     // 45 about two axes, which is 63, and what the axes are uncertain by
constexpr int kPitchStep_deg = 5;       // of turns about the left-right axis
constexpr int kLeastPitches = 5;        // in a row; a piece of skull passes in fewer
constexpr double kLeastAcross_mm = 50;  // seen from the side, in any direction; a flat arch is high only when pitched
constexpr double kMaxDepth = 1.7;       // of the height; more in one that is upside down and turned
constexpr double kAlike = 0.7;
constexpr std::size_t kTurnPoints = 30000;

// Returns the axis along which the points are spread most, the left-right one of a mandible, towards positive x.
Vec3 FindWidestAxis(const std::vector<Vec3>& points_W) {
  const SymmetricEigen eigen = CalcPointSpread(points_W).scatter;
  const auto largest = std::max_element(eigen.values.begin(), eigen.values.end());
  const Vec3 axis = eigen.vectors[static_cast<std::size_t>(largest - eigen.values.begin())];
  return axis.x < 0 ? -axis : axis;
}

// Finds a turn of the head after whose undoing a piece has the size and shape of a mandible with two like sides, also
// if it then nods a little more or less. Returns the likeness in the middle of such turns.
MandibleLikeness FindTurn(const Volume& lattice, const std::vector<std::int32_t>& labels, std::int32_t label,
                          const Component& component) {
  std::vector<Vec3> points_W;
  const std::size_t every = std::max<std::size_t>(1, component.voxels / kTurnPoints);
  std::size_t seen = 0;
  ForEachVoxel(lattice, labels, label, component, [&](const Vec3& p_W) {
    if (MixHash(seen++) % every == 0) points_W.push_back(p_W);  // at random: every n-th may be of one side
  });
  MandibleLikeness best;
  const Vec3 x_W = FindWidestAxis(points_W);
  const Vec3 up_W(0, 0, 1);
  if (x_W.x < std::cos(kMaxTurn_deg / kDegreesPerRad)) return best;
  const Vec3 level_W = glm::normalize(up_W - x_W.z * x_W);
  const auto pitched = [&](int pitch_deg) {
    const double pitch = pitch_deg / kDegreesPerRad;
    return std::cos(pitch) * level_W + std::sin(pitch) * glm::cross(x_W, level_W);
  };
  for (int pitch_deg = -90; pitch_deg < 90; pitch_deg += 2 * kPitchStep_deg) {
    const Vec3 across_W = pitched(pitch_deg);
    double lower = 1e300, upper = -1e300;
    for (const Vec3& p_W : points_W) {
      lower = std::min(lower, glm::dot(p_W, across_W));
      upper = std::max(upper, glm::dot(p_W, across_W));
    }
    if (upper - lower < kLeastAcross_mm) return best;
  }
  const auto are_alike = [](double a, double b) { return std::min(a, b) > kAlike * std::max(a, b); };
  std::vector<std::pair<MandibleLikeness, Vec3>> passed;  // in a row, with their sizes
  std::size_t longest = 0;
  for (int pitch_deg = -60; pitch_deg <= 60; pitch_deg += kPitchStep_deg) {
    const Vec3 z_W = pitched(pitch_deg);
    const Vec3 y_W = glm::cross(z_W, x_W);
    const glm::dmat3 head_from_world = glm::transpose(glm::dmat3(x_W, y_W, z_W));
    const auto for_each = [&](const auto& visit) {
      for (const Vec3& p_W : points_W) visit(head_from_world * p_W);
    };
    Box3 box;
    for_each([&box](const Vec3& p) { box.Include(p); });
    MandibleLikeness turned;
    turned.up_W = z_W;
    turned.turn_deg = kDegreesPerRad * std::acos(std::clamp((x_W.x + y_W.y + z_W.z - 1) / 2, -1.0, 1.0));
    turned.objection = FindSizeObjection(component.volume_mm3, box.size());
    const Counts counts = CountPoints(for_each);
    if (turned.objection.empty()) CheckFractions(counts, glm::dmat3(1), turned);
    if (turned.turn_deg > kMaxTurn_deg || !turned.objection.empty() ||
        !are_alike(turned.back_left, turned.back_right) || !are_alike(turned.top_left, turned.top_right)) {
      passed.clear();
      continue;
    }
    passed.emplace_back(turned, box.size());
    if (passed.size() < kLeastPitches || passed.size() <= longest) continue;
    longest = passed.size();
    const auto& [middle, size] = passed[longest / 2];
    best = middle;
    best.is_mandible = size.y < kMaxDepth * size.z;
  }
  return best;
}

}  // namespace

MandibleLikeness CheckMandibleLikeness(const Volume& lattice, const std::vector<std::int32_t>& labels,
                                       std::int32_t label, const Component& component) {
  MandibleLikeness shape;
  const Vec3 size = component.box_W.size();
  shape.objection = FindSizeObjection(component.volume_mm3, size);
  std::optional<Counts> counts;
  if (shape.objection.empty()) {
    counts = CountVoxels(lattice, labels, label, component);
    CheckFractions(*counts, glm::dmat3(1), shape);
  }
  shape.is_mandible = shape.objection.empty();
  if (shape.is_mandible) return shape;
  for (const glm::dmat3& turn : MakeRotations()) {
    if (!FindSizeObjection(component.volume_mm3, glm::abs(turn * size)).empty()) continue;
    if (!counts) counts = CountVoxels(lattice, labels, label, component);
    MandibleLikeness turned;
    CheckFractions(*counts, turn, turned);
    if (!turned.objection.empty()) continue;
    shape.rotations.push_back(turn);
    if (KeepsAxes(turn)) break;
  }
  // A mandible with other axes is turned farther.
  if (!FindSizeObjection(component.volume_mm3, Vec3(100)).empty()) return shape;
  const MandibleLikeness turned = FindTurn(lattice, labels, label, component);
  return turned.is_mandible ? turned : shape;
}

std::string DescribeRotations(const MandibleLikeness& likeness, const std::string& frame) {
  if (likeness.rotations.empty()) return "";
  glm::dmat3 mirror(1);
  mirror[0][0] = -1;
  std::string frames;
  std::string mirrored;
  for (const glm::dmat3& turn : likeness.rotations) {
    frames += (frames.empty() ? "" : " or ") + FrameName(turn * LpsFromFrame(frame));
    mirrored += (mirrored.empty() ? "" : " or ") + FrameName(mirror * turn * LpsFromFrame(frame));
  }
  const glm::dmat3& turn = likeness.rotations.front();
  std::string how = "has its axes in another order";
  if (KeepsAxes(turn)) {
    how = turn[1][1] > 0   ? "is upside down"
          : turn[2][2] > 0 ? "faces backwards, as when RAS is read as LPS or the reverse"
                           : "is upside down and faces backwards";
  }
  return fmt::format(
      "it looks like a mandible that {}: the file's coordinates are likely {}, or {} if mirrored, and not {}; find out "
      "which, since the shape does not distinguish left from right, and set it with --frame",
      how, frames, mirrored, frame);
}

std::string Describe(const MandibleLikeness& likeness, const std::string& frame) {
  const std::string rotations = DescribeRotations(likeness, frame);
  return likeness.objection + (rotations.empty() ? "" : "; ") + rotations;
}

}  // namespace kerf
