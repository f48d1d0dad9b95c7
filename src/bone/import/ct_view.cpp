#include "bone/import/ct_view.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/import/blocks.h"
#include "bone/import/components.h"
#include "bone/import/hu_sampler.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kSmallestShown_mm3 = 1000;
constexpr double kMaxGap_mm = 10;       // beside the bone; the CT's table is farther away
constexpr double kMaxGapBelow_mm = 50;  // for a mandible that is not joined to the skull
constexpr double kViewMargin_mm = 5;
constexpr double kAir_HU = -1000;
// Grey scale: fat and muscle dark, enamel white.
constexpr double kBlack_HU = -300;
constexpr double kWhite_HU = 1700;
constexpr Rgb8 kBackground{16, 18, 22};

// Orientation of a picture's axes in the patient. `toward_eye` gives the side of the viewer.
struct Frame {
  int across;  // index of the patient's axis that points to the right
  int down;
  bool down_is_positive;  // if false, that axis points up
  double toward_eye;      // +1 or -1, along the viewing axis
};
constexpr std::array<Frame, 3> kFrames{{{1, 2, false, 1}, {0, 2, false, -1}, {0, 1, true, -1}}};

const Frame& FrameOf(CtAxis axis) {
  return kFrames[static_cast<std::size_t>(axis)];
}

Rgb8 Mix(const Rgb8& a, const Rgb8& b, double fraction) {
  Rgb8 mixed{};
  for (std::size_t c = 0; c < 3; ++c) {
    mixed[c] = static_cast<std::uint8_t>(std::lround(a[c] + std::clamp(fraction, 0.0, 1.0) * (b[c] - a[c])));
  }
  return mixed;
}

Rgb8 ColourOf(double hu, double iso_hu) {
  constexpr Rgb8 kDimBone{150, 110, 60};
  constexpr Rgb8 kBrightBone{255, 250, 235};
  if (hu >= iso_hu) return Mix(kDimBone, kBrightBone, (hu - iso_hu) / std::max(1.0, kWhite_HU - iso_hu));
  return Mix(kBackground, {120, 128, 140}, (hu - kBlack_HU) / (iso_hu - kBlack_HU));
}

// A picture of the box, initially empty, and the position of each of its pixels in the patient.
class Canvas {
 public:
  Canvas(CtAxis axis, const CtViewOptions& options) : frame_(FrameOf(axis)) {
    const Box3& box = options.box_W;
    const auto count = [&](int a) {
      return std::clamp(static_cast<int>(std::ceil(box.size()[a] / options.pixel_mm)), 1, 8192);
    };
    view.columns = count(frame_.across);
    view.rows = count(frame_.down);
    view.left_mm = box.lower[frame_.across];
    view.right_mm = box.upper[frame_.across];
    view.top_mm = frame_.down_is_positive ? box.lower[frame_.down] : box.upper[frame_.down];
    view.bottom_mm = frame_.down_is_positive ? box.upper[frame_.down] : box.lower[frame_.down];
    view.pixels.resize(static_cast<std::size_t>(view.columns) * static_cast<std::size_t>(view.rows), kBackground);
  }

  Vec3 PointAt(int column, int row) const {
    Vec3 p_W{0};
    p_W[frame_.across] = view.left_mm + (column + 0.5) / view.columns * (view.right_mm - view.left_mm);
    p_W[frame_.down] = view.top_mm + (row + 0.5) / view.rows * (view.bottom_mm - view.top_mm);
    return p_W;
  }

  template <typename ColourAt>
  void Fill(const ColourAt& colour_at) {
    tbb::parallel_for(0, view.rows, [&](int row) {
      for (int column = 0; column < view.columns; ++column) {
        view.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(view.columns) +
                    static_cast<std::size_t>(column)] = colour_at(PointAt(column, row));
      }
    });
  }

  CtView view;

 private:
  const Frame& frame_;
};

// The CT's values; air outside it.
class Scan {
 public:
  explicit Scan(const Volume& ct) : ct_(ct), sampler_(ct), axes_from_world_(glm::inverse(ct.axes_W)) {}

  bool Contains(const Vec3& p_W) const {
    const Vec3 p_V = axes_from_world_ * (p_W - ct_.origin_W) / ct_.spacing_mm;
    for (int a = 0; a < 3; ++a) {
      if (!(p_V[a] >= -0.5 && p_V[a] <= ct_.size[a] - 0.5)) return false;
    }
    return true;
  }
  double HuAt(const Vec3& p_W) const { return Contains(p_W) ? sampler_.At(p_W) : kAir_HU; }

 private:
  const Volume& ct_;
  HuSampler sampler_;
  glm::dmat3 axes_from_world_;
};

}  // namespace

CtView DrawCtSlice(const Volume& ct, CtAxis axis, double at_mm, const CtViewOptions& options) {
  const Scan scan(ct);
  Canvas canvas(axis, options);
  canvas.Fill([&](Vec3 p_W) {
    constexpr double kTint = 0.65;
    p_W[static_cast<int>(axis)] = at_mm;
    const Rgb8 colour = ColourOf(scan.HuAt(p_W), options.iso_hu);
    const std::optional<Rgb8> tint = options.tint ? options.tint(p_W) : std::nullopt;
    return tint ? Mix(colour, *tint, kTint) : colour;
  });
  return std::move(canvas.view);
}

CtView SliceVolume(const Volume& ct, CtAxis axis, double at_mm, const CtGreys& greys, double pixel_mm) {
  const Scan scan(ct);
  Canvas canvas(axis, {.box_W = CalcScanBox(ct), .pixel_mm = pixel_mm});
  const double black_HU = greys.level_HU - 0.5 * greys.width_HU;
  constexpr Rgb8 kOrange{255, 140, 40};
  canvas.Fill([&](Vec3 p_W) {
    p_W[static_cast<int>(axis)] = at_mm;
    if (!scan.Contains(p_W)) return Rgb8{0, 0, 0};
    const double hu = scan.HuAt(p_W);
    const Rgb8 grey = Mix({0, 0, 0}, {255, 255, 255}, (hu - black_HU) / greys.width_HU);
    return greys.tinted_from && hu >= *greys.tinted_from ? Mix(grey, kOrange, 0.5) : grey;
  });
  return std::move(canvas.view);
}

Box3 CalcScanBox(const Volume& ct) {
  Box3 scan_W;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p_V;
    for (int a = 0; a < 3; ++a) p_V[a] = (corner >> a & 1) != 0 ? ct.size[a] - 0.5 : -0.5;
    scan_W.Include(ct.WorldFromVoxel(p_V));
  }
  return scan_W;
}

CtView DrawCtSurface(const Volume& ct, CtAxis axis, const CtViewOptions& options) {
  constexpr Rgb8 kShadow{70, 55, 40};
  constexpr Rgb8 kLit{250, 240, 220};
  const Scan scan(ct);
  const int depth = static_cast<int>(axis);
  const double toward_eye = FrameOf(axis).toward_eye;
  const double step_mm = std::min({ct.spacing_mm.x, ct.spacing_mm.y, ct.spacing_mm.z});
  const double length_mm = options.box_W.size()[depth];
  Vec3 eye_W{0};
  eye_W[depth] = toward_eye;
  Canvas canvas(axis, options);
  canvas.Fill([&](Vec3 p_W) {
    double before_hu = kAir_HU;
    for (double d = 0; d <= length_mm; d += step_mm) {
      p_W[depth] = (toward_eye > 0 ? options.box_W.upper[depth] : options.box_W.lower[depth]) - toward_eye * d;
      const double hu = scan.HuAt(p_W);
      if (hu >= options.iso_hu) {
        // Moves back to where the iso value is crossed.
        p_W[depth] += toward_eye * step_mm * (hu - options.iso_hu) / std::max(1.0, hu - before_hu);
        Vec3 out_W{0};
        for (int a = 0; a < 3; ++a) {
          Vec3 step{0};
          step[a] = step_mm;
          out_W[a] = scan.HuAt(p_W - step) - scan.HuAt(p_W + step);
        }
        const double slope = glm::length(out_W);
        const double facing = slope > 0 ? std::max(0.0, glm::dot(out_W, eye_W) / slope) : 1;
        // Distant surfaces are slightly darker.
        return Mix(kShadow, kLit, facing * (1 - 0.35 * d / std::max(1.0, length_mm)));
      }
      before_hu = hu;
    }
    return kBackground;
  });
  return std::move(canvas.view);
}

Box3 FindBoneBox(const Volume& ct, double iso_hu, const std::string& name) {
  const Volume joined = JoinBlocks(ct, ChooseBlocks(ct), iso_hu);
  const Components pieces = FindComponents(joined, [&](std::size_t v) { return joined.hu[v] >= iso_hu; });
  Box3 bone_W;
  for (const Component& piece : pieces.list) {
    if (piece.volume_mm3 < kSmallestShown_mm3) break;
    Box3 near_W = pieces.list.front().box_W.Grown(kMaxGap_mm);
    near_W.lower.z -= kMaxGapBelow_mm;
    if (glm::clamp(piece.centre_W, near_W.lower, near_W.upper) != piece.centre_W) continue;
    bone_W.Include(piece.box_W.lower);
    bone_W.Include(piece.box_W.upper);
  }
  if (bone_W.empty()) {
    throw Error(fmt::format("{}: no bone: no piece above {:.0f} HU is 1 cm3 or larger; choose another value with --iso",
                            name, iso_hu));
  }
  const Box3 scan_W = CalcScanBox(ct);
  bone_W = bone_W.Grown(kViewMargin_mm);
  return {glm::max(bone_W.lower, scan_W.lower), glm::min(bone_W.upper, scan_W.upper)};
}

}  // namespace kerf
