#include "bone/grid/cell_fields.h"

#include <algorithm>
#include <cmath>

#include "bone/grid/cell_volume.h"

namespace kerf {
namespace {

// Change of the slope along an axis, in mm per mm, from which on a bend of the cut begins to count as a kink, and over
// which it comes to do so. The surface of a bur of 1 mm bends by 0.2 in a cell of 0.1 mm.
constexpr float kLeastKink = 0.5f;
constexpr float kKinkRange = 0.3f;

constexpr int kParts = 4;  // into which a cell with a kink is divided, along each axis
constexpr int kNodes = kParts + 1;
constexpr float kLeastShift = 0.02f;  // shift of the cut below which a kink does not matter, in voxels

/// Values of the cut at four voxels in a row, `stride` apart from the first.
class Row {
 public:
  Row(const float* first, int stride, float voxel_mm)
      : v_{first[0], first[stride], first[2 * stride], first[3 * stride]} {
    const float least = std::min(std::abs(left_), std::abs(right_));
    if ((left_ < 0) != (right_ < 0) || least < kLeastShift * voxel_mm) return;
    kink_ = std::clamp((std::abs(left_ + right_) / voxel_mm - kLeastKink) / kKinkRange, 0.0f, 1.0f);
  }

  /// How much of a kink the bend between the inner two is, 0 to 1.
  float kink() const { return kink_; }
  /// Sets the values on the way from the inner one to the next.
  template <typename Set>
  void Interpolate(Set&& set) const {
    set(0, v_[1]);
    for (int i = 1; i < kParts; ++i) {
      const float t = static_cast<float>(i) / kParts;
      const float linear = v_[1] + t * (v_[2] - v_[1]);
      // The straight lines from the left and from the right, less the one between.
      const float shift = std::min(std::abs(t * left_), std::abs((1 - t) * right_));
      set(i, linear + (left_ < 0 ? kink_ * shift : -kink_ * shift));
    }
    set(kParts, v_[2]);
  }

 private:
  float v_[4];
  float left_ = v_[0] - 2 * v_[1] + v_[2];
  float right_ = v_[1] - 2 * v_[2] + v_[3];
  float kink_ = 0;
};

}  // namespace

std::array<float, 8> CellFields::CutCorners(int x, int y, int z) const {
  std::array<float, 8> corners;
  for (int i = 0; i < 8; ++i) {
    corners[static_cast<std::size_t>(i)] = CutAt(x + (i >> 2), y + (i >> 1 & 1), z + (i & 1));
  }
  return corners;
}

void CellFields::LoadPart(const PhiParts& parts, int bx, int by, int bz) {
  LoadCutPart(parts.cut, bx, by, bz);
  if (bx < 0 || by < 0 || bz < 0) return;
  for (int x = 0; x < (bx > 0 ? 1 : 8); ++x) {
    for (int y = 0; y < (by > 0 ? 1 : 8); ++y) {
      const float* const row = parts.whole + 64 * x + 8 * y;
      float* const to = &whole_.at(8 * bx + x, 8 * by + y, 8 * bz);
      bz > 0 ? std::copy_n(row, 1, to) : std::copy_n(row, 8, to);
    }
  }
}

void CellFields::LoadCutPart(const float* values, int bx, int by, int bz) {
  const auto first = [](int b) { return b < 0 ? 7 : 0; };
  const auto last = [](int b) { return b > 0 ? 1 : 7; };
  for (int x = first(bx); x <= last(bx); ++x) {
    for (int y = first(by); y <= last(by); ++y) {
      const float* const row = values + 64 * x + 8 * y + first(bz);
      float* const to = cut_.data() + At(8 * bx + x, 8 * by + y, 8 * bz + first(bz));
      bz == 0 ? std::copy_n(row, 8, to) : std::copy_n(row, bz < 0 ? 1 : 2, to);
    }
  }
}

void CellFields::FindWhetherCut() {
  is_cut_ = std::any_of(cut_.begin(), cut_.end(), [this](float value) { return value != -band_mm_; });
}

bool CellFields::DiffersAround(const CellFields& other, int x, int y, int z) const {
  for (int i = x - 1; i <= x + 2; ++i) {
    for (int j = y - 1; j <= y + 2; ++j) {
      const float* const row = cut_.data() + At(i, j, z - 1);
      if (!std::equal(row, row + 4, other.cut_.data() + At(i, j, z - 1))) return true;
    }
  }
  return false;
}

/// Returns whether the slope of the cut changes along one of the cell's edges.
bool CellFields::HasKink(int x, int y, int z) const {
  const float* const lowest = cut_.data() + At(x, y, z);
  constexpr int kStride[3] = {kEdge * kEdge, kEdge, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const int along = kStride[axis];
    for (int edge = 0; edge < 4; ++edge) {
      const float* const v =
          lowest + (edge >> 1) * kStride[(axis + 1) % 3] + (edge & 1) * kStride[(axis + 2) % 3] - along;
      if (Row(v, along, voxel_mm_).kink() > 0) return true;
    }
  }
  return false;
}

double CellFields::CalcFraction(int x, int y, int z) const {
  const std::array<float, 8> whole = WholeCorners(x, y, z);
  if (!is_cut_) return CalcCellFraction(whole);  // with the same bits as below
  if (std::none_of(whole.begin(), whole.end(), [](float value) { return value < 0; })) return 0;
  std::array<float, 8> cut = CutCorners(x, y, z);
  // See PhiParts::CutAt().
  bool is_beside_air = false;
  for (std::size_t i = 0; i < 8; ++i) {
    if (!(whole[i] >= band_mm_)) continue;
    cut[i] = band_mm_;
    is_beside_air = true;
  }
  // A kink moves the values in a cell by less than a voxel.
  const auto [least, most] = std::minmax_element(cut.begin(), cut.end());
  if (*most < -voxel_mm_) return CalcCellFraction(whole);
  if (*least > voxel_mm_) return 0;
  return !is_beside_air && HasKink(x, y, z) ? CalcFineFraction(x, y, z) : CalcCellFraction(whole, cut);
}

/// Returns the fraction from both fields in the parts of the cell.
double CellFields::CalcFineFraction(int x, int y, int z) const {
  // The cut on the grid of the parts: first along z, then along y, then along x.
  float along_z[4][4][kNodes];
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const float* const v = cut_.data() + At(x + i - 1, y + j - 1, z - 1);
      Row(v, 1, voxel_mm_).Interpolate([&](int k, float value) { along_z[i][j][k] = value; });
    }
  }
  float along_y[4][kNodes][kNodes];
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < kNodes; ++k) {
      const Row row(&along_z[i][0][k], kNodes, voxel_mm_);
      row.Interpolate([&](int j, float value) { along_y[i][j][k] = value; });
    }
  }
  float cut[kNodes][kNodes][kNodes];
  for (int j = 0; j < kNodes; ++j) {
    for (int k = 0; k < kNodes; ++k) {
      const Row row(&along_y[0][j][k], kNodes * kNodes, voxel_mm_);
      row.Interpolate([&](int i, float value) { cut[i][j][k] = value; });
    }
  }
  const std::array<float, 8> corners = WholeCorners(x, y, z);
  const auto [least, most] = std::minmax_element(&cut[0][0][0], &cut[0][0][0] + kNodes * kNodes * kNodes);
  if (*most < 0) return CalcCellFraction(corners);
  if (*least >= 0) return 0;
  float whole[kNodes][kNodes][kNodes];
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j < kNodes; ++j) {
      for (int k = 0; k < kNodes; ++k) {
        const double f[3] = {i / double{kParts}, j / double{kParts}, k / double{kParts}};
        whole[i][j][k] = static_cast<float>(InterpolateInCell(corners, f));
      }
    }
  }
  // What the cut takes of each part, so that a cut that does not meet the bone takes nothing at all.
  double taken = 0;
  for (int part = 0; part < kParts * kParts * kParts; ++part) {
    std::array<float, 8> of_whole;
    std::array<float, 8> of_cut;
    for (int corner = 0; corner < 8; ++corner) {
      const int i = part / (kParts * kParts) + (corner >> 2);
      const int j = part / kParts % kParts + (corner >> 1 & 1);
      const int k = part % kParts + (corner & 1);
      of_whole[static_cast<std::size_t>(corner)] = whole[i][j][k];
      of_cut[static_cast<std::size_t>(corner)] = cut[i][j][k];
    }
    if (std::all_of(of_cut.begin(), of_cut.end(), [](float value) { return value < 0; })) continue;
    taken += CalcCellFraction(of_whole) - CalcCellFraction(of_whole, of_cut);
  }
  return CalcCellFraction(corners) - taken / (kParts * kParts * kParts);
}

}  // namespace kerf
