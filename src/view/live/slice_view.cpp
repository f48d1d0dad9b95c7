#include "view/live/slice_view.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <unordered_map>
#include <utility>

#include "bone/grid/parts_reader.h"
#include "cut/tool/edge_motion.h"
#include "cut/tool/looks.h"
#include "kerf/error.h"
#include "view/live/scene_shapes.h"

namespace kerf {
namespace {

constexpr Rgb8 kBoneLine{255, 200, 40};
constexpr Rgb8 kToolLine{80, 200, 255};
constexpr Rgb8 kNerveLine{255, 130, 210};
constexpr Rgb8 kToothLine{235, 235, 225};
constexpr Rgb8 kCursorLine{120, 255, 140};
// As in 3D, but lighter, because they are drawn on grey.
constexpr Rgb8 kPlanPointLine{90, 180, 255};
constexpr Rgb8 kMarkPointLine{255, 130, 210};

// Grey values of a bone without CT numbers.
std::uint8_t GreyOf(Tissue tissue) {
  switch (tissue) {
    case Tissue::kTooth:
      return 240;
    case Tissue::kCortical:
      return 196;
    case Tissue::kCancellous:
      return 128;
    case Tissue::kCanal:
      return 62;
    case Tissue::kMetal:
      return 255;
    case Tissue::kLesion:
      return 90;
    case Tissue::kOther:
      break;
  }
  return 160;
}
constexpr double kAirGrey = 14;

std::string SideOf(const Vec3& direction) {
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(direction[i]) > std::abs(direction[axis])) axis = i;
  }
  constexpr const char* kLetters[3][2] = {{"R", "L"}, {"A", "P"}, {"I", "S"}};
  return kLetters[axis][direction[axis] > 0 ? 1 : 0];
}

Quat MakeRotation(const Vec3& right, const Vec3& up) {
  return glm::normalize(glm::quat_cast(glm::dmat3{right, up, glm::cross(right, up)}));
}

// Values on a regular grid, rows from the top.
struct Samples {
  int columns = 0;
  int rows = 0;
  std::vector<float> values;

  float At(int column, int row) const {
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
  }
};

// Joins segments whose ends have equal keys into lines.
template <typename Point>
class LineJoiner {
 public:
  using Key = std::uint64_t;
  void Add(Key a, const Point& at_a, Key b, const Point& at_b) {
    if (a == b) return;
    const auto i = static_cast<std::uint32_t>(segments_.size());
    segments_.push_back({{a, b}, {at_a, at_b}});
    ends_[a].push_back(i);
    ends_[b].push_back(i);
  }
  std::vector<std::vector<Point>> Join() const {
    std::vector<bool> used(segments_.size(), false);
    std::vector<std::vector<Point>> lines;
    // Open lines first, from their ends; what remains is closed.
    for (const bool open : {true, false}) {
      for (std::uint32_t i = 0; i < segments_.size(); ++i) {
        for (const std::size_t end : {0, 1}) {
          if (used[i] || (open && ends_.at(segments_[i].keys[end]).size() != 1)) continue;
          lines.push_back(Follow(i, end, used));
        }
      }
    }
    return lines;
  }

 private:
  struct Segment {
    std::array<Key, 2> keys;
    std::array<Point, 2> points;
  };
  std::vector<Point> Follow(std::uint32_t i, std::size_t from, std::vector<bool>& used) const {
    std::vector<Point> line{segments_[i].points[from]};
    for (;;) {
      used[i] = true;
      const std::size_t to = 1 - from;
      line.push_back(segments_[i].points[to]);
      const Key key = segments_[i].keys[to];
      bool found = false;
      for (const std::uint32_t next : ends_.at(key)) {
        if (used[next]) continue;
        i = next;
        from = segments_[i].keys[0] == key ? 0 : 1;
        found = true;
        break;
      }
      if (!found) return line;
    }
  }

  std::vector<Segment> segments_;
  std::unordered_map<Key, std::vector<std::uint32_t>> ends_;
};

// Lines of value 0 (marching squares), in columns and rows of the samples.
std::vector<std::vector<OverlayPoint>> FindZeroLines(const Samples& samples) {
  LineJoiner<OverlayPoint> joiner;
  const auto edge_key = [&](int column, int row, bool down) {
    return 2 * (static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(samples.columns) +
                static_cast<std::uint64_t>(column)) +
           (down ? 1 : 0);
  };
  for (int row = 0; row + 1 < samples.rows; ++row) {
    for (int column = 0; column + 1 < samples.columns; ++column) {
      const std::array<float, 4> v{samples.At(column, row), samples.At(column + 1, row),
                                   samples.At(column + 1, row + 1), samples.At(column, row + 1)};
      int inside = 0;
      for (std::size_t i = 0; i < 4; ++i) inside |= v[i] < 0 ? 1 << i : 0;
      if (inside == 0 || inside == 15) continue;
      // The crossings of the cell's edges: top, right, bottom, left.
      const auto at = [](double a, double b) { return a / (a - b); };
      const std::array<OverlayPoint, 4> points{{{column + at(v[0], v[1]), static_cast<double>(row)},
                                                {column + 1.0, row + at(v[1], v[2])},
                                                {column + at(v[3], v[2]), row + 1.0},
                                                {static_cast<double>(column), row + at(v[0], v[3])}}};
      const std::array<std::uint64_t, 4> keys{edge_key(column, row, false), edge_key(column + 1, row, true),
                                              edge_key(column, row + 1, false), edge_key(column, row, true)};
      std::array<std::size_t, 4> crossed{};
      std::size_t count = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        if ((v[i] < 0) != (v[(i + 1) % 4] < 0)) crossed[count++] = i;
      }
      const auto add = [&](std::size_t a, std::size_t b) { joiner.Add(keys[a], points[a], keys[b], points[b]); };
      if (count == 2) {
        add(crossed[0], crossed[1]);
      } else {
        // Two opposite corners are inside; the mean decides whether they are connected.
        const bool joined = (v[0] + v[1] + v[2] + v[3] < 0) == (v[0] < 0);
        add(0, joined ? 1 : 3);
        add(2, joined ? 3 : 1);
      }
    }
  }
  return joiner.Join();
}

Samples SamplePhi(const Bone& bone, int columns, int rows, const std::function<Vec3(int, int)>& point_of) {
  const BoneGrids& grids = GridsOf(bone);
  const double voxel_mm = grids.voxel_mm();
  Samples samples{columns, rows, {}};
  samples.values.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  tbb::parallel_for(tbb::blocked_range<int>(0, rows, 8), [&](const tbb::blocked_range<int>& range) {
    const PartsReader phi(grids);
    for (int row = range.begin(); row < range.end(); ++row) {
      float* to = &samples.values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns)];
      for (int column = 0; column < columns; ++column) {
        to[column] = static_cast<float>(phi.Sample(point_of(column, row) / voxel_mm));
      }
    }
  });
  return samples;
}

std::vector<OverlayPoint> ToPixels(const SliceFrame& frame, const std::vector<Vec3>& points_W) {
  std::vector<OverlayPoint> points;
  points.reserve(points_W.size());
  for (const Vec3& p : points_W) points.push_back(frame.PixelOf(p));
  return points;
}

/// Adds the outline of the tool where its stroke has it and, dashed, that of all that it passes in a stroke.
void AddToolLines(const SliceFrame& frame, const SliceScene& scene, std::vector<SliceLine>& lines) {
  const Tool& tool = *scene.tool;
  const Pose X_SW = frame.X_WS.Inverse();
  const auto in_slice = [&X_SW](const Pose& X_WT) { return Pose{X_SW.R_AB * X_WT.R_AB, X_SW.Point(X_WT.p_AB)}; };
  const auto add = [&](const std::vector<Vec3>& outline_S, bool dashed) {
    if (outline_S.empty()) return;
    SliceLine line{SliceLineKind::kTool, {}, kToolLine, 1.5, dashed, ""};
    for (const Vec3& p : outline_S) line.points.push_back(frame.PixelOf(frame.X_WS.Point(p)));
    lines.push_back(std::move(line));
  };
  // At least as thick as a pixel, so that a thin blade is always found.
  const Pose X_WE = EdgeMotion(CalcSwingRadius(tool)).Move(scene.X_WT, scene.displacement_mm);
  add(MakeToolSection(tool, in_slice(X_WE), frame.mm_per_pixel), false);
  add(MakeStrokeSection(tool, in_slice(scene.X_WT), frame.mm_per_pixel), true);
}

void AddPlaneLine(const SliceFrame& frame, const PlaneOverlay& plane, std::vector<SliceLine>& lines) {
  const std::vector<Vec3> corners =
      MakeRectangle(plane.p_W, plane.normal_W, plane.up_W, plane.width_mm, plane.height_mm);
  // A plane that lies in the slice has no line in it; rounding would draw any.
  constexpr double kParallel = 0.9994;  // 2 degrees
  if (std::abs(glm::dot(glm::normalize(plane.normal_W), frame.X_WS.Vector({0, 0, 1}))) > kParallel) return;
  std::vector<Vec3> met;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3& a = corners[i];
    const Vec3& b = corners[(i + 1) % corners.size()];
    const double da = frame.DistanceOf(a);
    const double db = frame.DistanceOf(b);
    if ((da < 0) != (db < 0)) met.push_back(a + da / (da - db) * (b - a));
  }
  if (met.size() != 2) return;
  lines.push_back(
      {SliceLineKind::kPlane, ToPixels(frame, met), plane.colour, plane.selected ? 3.0 : 2.0, false, plane.name});
}

void AddPoint(const SliceFrame& frame, const PointOverlay& point, std::vector<SliceLine>& lines) {
  constexpr int kSides = 24;
  constexpr double kRadius_px = 5;
  const OverlayPoint c = frame.PixelOf(point.p_W);
  SliceLine line{.kind = SliceLineKind::kPoint,
                 .points = {},
                 .colour = point.kind == PointKind::kPlan ? kPlanPointLine : kMarkPointLine,
                 .width_points = 2,
                 .dashed = std::abs(frame.DistanceOf(point.p_W)) > 1,
                 .name = point.label};
  for (int i = 0; i <= kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    line.points.push_back({c.column + kRadius_px * std::cos(angle), c.row + kRadius_px * std::sin(angle)});
  }
  lines.push_back(std::move(line));
}

void AddCursor(const SliceFrame& frame, const Vec3& p_W, std::vector<SliceLine>& lines) {
  constexpr double kGap = 5;
  constexpr double kArm = 14;
  const OverlayPoint c = frame.PixelOf(p_W);
  const bool away = std::abs(frame.DistanceOf(p_W)) > 1;
  for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    lines.push_back({SliceLineKind::kCursor,
                     {{c.column + kGap * x, c.row + kGap * y}, {c.column + kArm * x, c.row + kArm * y}},
                     kCursorLine,
                     1.5,
                     away,
                     ""});
  }
}

}  // namespace

const char* ToString(SliceKind kind) {
  switch (kind) {
    case SliceKind::kAxial:
      return "axial";
    case SliceKind::kCoronal:
      return "coronal";
    case SliceKind::kSagittal:
      return "sagittal";
    case SliceKind::kBlade:
      break;
  }
  return "blade";
}

bool SliceSpec::operator==(const SliceSpec& o) const {
  const bool same = kind == o.kind && centre_W == o.centre_W && offset_mm == o.offset_mm && width_mm == o.width_mm &&
                    width_px == o.width_px && height_px == o.height_px && window.level_HU == o.window.level_HU &&
                    window.width_HU == o.window.width_HU;
  return same && (kind != SliceKind::kBlade || (X_WT.p_AB == o.X_WT.p_AB && X_WT.R_AB == o.X_WT.R_AB));
}

Vec3 SliceFrame::PointOf(const OverlayPoint& px) const {
  return X_WS.Point({(px.column - 0.5 * width) * mm_per_pixel, (0.5 * height - px.row) * mm_per_pixel, 0});
}

OverlayPoint SliceFrame::PixelOf(const Vec3& p_W) const {
  const Vec3 p_S = X_WS.InversePoint(p_W);
  return {0.5 * width + p_S.x / mm_per_pixel, 0.5 * height - p_S.y / mm_per_pixel};
}

double SliceFrame::DistanceOf(const Vec3& p_W) const {
  return X_WS.InversePoint(p_W).z;
}

SliceFrame CalcSliceFrame(const SliceSpec& spec) {
  const bool sides = kSliceSide_px.Contains(spec.width_px) && kSliceSide_px.Contains(spec.height_px);
  if (!sides || !(spec.width_mm > 0) || !std::isfinite(spec.width_mm) || !(spec.window.width_HU > 0)) {
    throw Error("A slice must be wider than 0 mm and have 8 to 1024 pixels a side and a window wider than 0 HU");
  }
  if (!IsInWorld(spec.centre_W) || !std::isfinite(spec.offset_mm) ||
      (spec.kind == SliceKind::kBlade && !IsValid(spec.X_WT))) {
    throw Error("The position of a slice must be finite");
  }
  SliceFrame frame;
  frame.width = spec.width_px;
  frame.height = spec.height_px;
  frame.mm_per_pixel = spec.width_mm / spec.width_px;
  Vec3 right{1, 0, 0};
  Vec3 up{0, 0, 1};
  Vec3 along{0, 0, 1};  // direction of the offset
  switch (spec.kind) {
    case SliceKind::kAxial:
      up = {0, -1, 0};
      break;
    case SliceKind::kCoronal:
      along = {0, 1, 0};
      break;
    case SliceKind::kSagittal:
      right = {0, 1, 0};
      along = {1, 0, 0};
      break;
    case SliceKind::kBlade: {
      along = spec.X_WT.Vector({0, 0, 1});
      const Vec3 upright = Vec3{0, 0, 1} - along.z * along;
      up = glm::length(upright) > 0.1 ? glm::normalize(upright) : spec.X_WT.Vector({0, 1, 0});
      right = glm::cross(up, along);
      break;
    }
  }
  frame.X_WS.R_AB = MakeRotation(right, up);
  Vec3 middle = spec.centre_W;
  // The blade's plane contains the tool's centre, wherever the middle of the image is.
  if (spec.kind == SliceKind::kBlade) middle -= glm::dot(middle - spec.X_WT.p_AB, along) * along;
  frame.X_WS.p_AB = middle + spec.offset_mm * along;
  return frame;
}

SliceImage CalcSlice(const Bone& bone, const SliceSpec& spec, const InnerSurfaces* inner, const CtSource* ct) {
  SliceImage slice;
  slice.spec = spec;
  slice.frame = CalcSliceFrame(spec);
  const SliceFrame& frame = slice.frame;
  slice.has_ct = ct != nullptr || bone.has_hu();
  slice.right_letter = SideOf(frame.X_WS.Vector({1, 0, 0}));
  slice.left_letter = SideOf(frame.X_WS.Vector({-1, 0, 0}));
  slice.up_letter = SideOf(frame.X_WS.Vector({0, 1, 0}));
  slice.down_letter = SideOf(frame.X_WS.Vector({0, -1, 0}));
  const int width = frame.width;
  const int height = frame.height;
  slice.image = {width, height, {}};
  slice.image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));

  // The level set at the pixels' centres, or at every second one in large images: enough for an outline.
  const int stride = std::max(width, height) > 640 ? 2 : 1;
  const auto pixel_centre = [&](int column, int row) { return frame.PointOf({column + 0.5, row + 0.5}); };
  const Samples phi = SamplePhi(bone, (width + stride - 1) / stride, (height + stride - 1) / stride,
                                [&](int column, int row) { return pixel_centre(stride * column, stride * row); });

  const BoneGrids& grids = GridsOf(bone);
  std::array<double, 256> greys{};
  for (std::size_t id = 0; id < greys.size(); ++id) {
    const bool known = grids.materials.Contains(static_cast<int>(id));
    greys[id] = GreyOf(known ? grids.materials.At(static_cast<int>(id)).tissue : Tissue::kOther);
  }
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& range) {
    const auto to_grey = [](double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0) + 0.5); };
    const auto put = [&](int column, int row, std::uint8_t g) {
      slice.image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(column)] = {g, g, g};
    };
    const auto to_level = [&](double hu) {
      return to_grey(255 * ((hu - spec.window.level_HU) / spec.window.width_HU + 0.5));
    };
    if (ct != nullptr) {
      for (int row = range.begin(); row < range.end(); ++row) {
        for (int column = 0; column < width; ++column) put(column, row, to_level((*ct)(pixel_centre(column, row))));
      }
      return;
    }
    if (slice.has_ct) {
      auto hu = grids.hu->getConstAccessor();
      const double hu_mm = grids.hu->voxelSize()[0];
      for (int row = range.begin(); row < range.end(); ++row) {
        for (int column = 0; column < width; ++column) {
          put(column, row, to_level(SampleTrilinear(hu, pixel_centre(column, row) / hu_mm)));
        }
      }
      return;
    }
    auto region = grids.region->getConstAccessor();
    const double region_mm = grids.region_voxel_mm();
    for (int row = range.begin(); row < range.end(); ++row) {
      for (int column = 0; column < width; ++column) {
        const double inside =
            std::clamp(0.5 - static_cast<double>(phi.At(column / stride, row / stride)) / frame.mm_per_pixel, 0.0, 1.0);
        double grey = kAirGrey;
        if (inside > 0) {
          const int id = region.getValue(NearestVoxel(pixel_centre(column, row), region_mm));
          const double of_tissue = greys[static_cast<std::size_t>(std::clamp(id, 0, 255))];
          grey += inside * ((id == 0 ? greys[0] : of_tissue) - kAirGrey);
        }
        put(column, row, to_grey(grey));
      }
    }
  });

  for (std::vector<OverlayPoint>& line : FindZeroLines(phi)) {
    for (OverlayPoint& p : line) p = {stride * p.column + 0.5, stride * p.row + 0.5};
    slice.lines.push_back({SliceLineKind::kBone, std::move(line), kBoneLine, 1.5, false, ""});
  }
  if (inner != nullptr) {
    const auto add = [&](const TriangleMesh& mesh, SliceLineKind kind, const Rgb8& colour) {
      // Regions extend a little beyond the bone's surface; only the part within the bone is shown.
      const auto add_run = [&](const std::vector<Vec3>& run) {
        if (run.size() > 1) slice.lines.push_back({kind, ToPixels(frame, run), colour, 1.8, false, ""});
      };
      for (const std::vector<Vec3>& line : SliceMesh(mesh, frame.X_WS)) {
        std::vector<Vec3> run;
        for (const Vec3& p : line) {
          if (bone.SignedDistance(p) <= 0) {
            run.push_back(p);
          } else {
            add_run(std::exchange(run, {}));
          }
        }
        add_run(run);
      }
    };
    add(inner->teeth_W, SliceLineKind::kTooth, kToothLine);
    add(inner->canal_W, SliceLineKind::kNerve, kNerveLine);
  }
  return slice;
}

std::vector<SliceLine> CalcSliceLines(const SliceFrame& frame, const SliceScene& scene) {
  std::vector<SliceLine> lines;
  for (const MarkOverlay& mark : scene.marks) {
    for (const std::vector<Vec3>& line : SliceMesh(MakeTubeMesh(mark.points_W, mark.radius_mm), frame.X_WS)) {
      lines.push_back(
          {SliceLineKind::kMark, ToPixels(frame, line), mark.colour, mark.selected ? 3.0 : 1.8, false, mark.label});
    }
  }
  for (const PlaneOverlay& plane : scene.planes) AddPlaneLine(frame, plane, lines);
  for (const PointOverlay& point : scene.points) AddPoint(frame, point, lines);
  if (scene.tool) AddToolLines(frame, scene, lines);
  if (scene.cursor_W) AddCursor(frame, *scene.cursor_W, lines);
  return lines;
}

void DrawSliceLines(const std::vector<SliceLine>& lines, double scale, Image& image) {
  constexpr double kDash = 6;
  for (const SliceLine& line : lines) {
    const double half = 0.5 * line.width_points * scale;
    double along = 0;
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
      const OverlayPoint& a = line.points[i];
      const OverlayPoint& b = line.points[i + 1];
      const double dx = b.column - a.column;
      const double dy = b.row - a.row;
      const double length = std::hypot(dx, dy);
      const double reach = half + 1;
      const int left = std::max(0, static_cast<int>(std::floor(std::min(a.column, b.column) - reach)));
      const int right = std::min(image.width - 1, static_cast<int>(std::ceil(std::max(a.column, b.column) + reach)));
      const int top = std::max(0, static_cast<int>(std::floor(std::min(a.row, b.row) - reach)));
      const int bottom = std::min(image.height - 1, static_cast<int>(std::ceil(std::max(a.row, b.row) + reach)));
      for (int row = top; row <= bottom; ++row) {
        for (int column = left; column <= right; ++column) {
          const double px = column + 0.5 - a.column;
          const double py = row + 0.5 - a.row;
          const double t = length > 0 ? std::clamp((px * dx + py * dy) / (length * length), 0.0, 1.0) : 0;
          if (line.dashed && std::fmod(along + t * length, 2 * kDash * scale) > kDash * scale) continue;
          const double cover = std::clamp(half + 0.5 - std::hypot(px - t * dx, py - t * dy), 0.0, 1.0);
          if (cover <= 0) continue;
          Rgb8& pixel = image.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                                     static_cast<std::size_t>(column)];
          for (std::size_t c = 0; c < 3; ++c) {
            pixel[c] = static_cast<std::uint8_t>(pixel[c] + cover * (line.colour[c] - pixel[c]) + 0.5);
          }
        }
      }
      along += length;
    }
  }
}

std::vector<std::vector<Vec3>> SliceMesh(const TriangleMesh& mesh_W, const Pose& X_WS) {
  const Vec3 normal = X_WS.Vector({0, 0, 1});
  const double level = glm::dot(normal, X_WS.p_AB);
  std::vector<double> heights;
  heights.reserve(mesh_W.points.size());
  for (const Vec3& p : mesh_W.points) heights.push_back(glm::dot(normal, p) - level);
  LineJoiner<Vec3> joiner;
  for (const auto& t : mesh_W.triangles) {
    std::array<std::uint64_t, 2> keys{};
    std::array<Vec3, 2> points{};
    std::size_t count = 0;
    for (std::size_t i = 0; i < 3 && count < 2; ++i) {
      // The edge is cut in the same direction by both of its triangles, so that both find the same point.
      const std::uint32_t a = std::min(t[i], t[(i + 1) % 3]);
      const std::uint32_t b = std::max(t[i], t[(i + 1) % 3]);
      if ((heights[a] < 0) == (heights[b] < 0)) continue;
      keys[count] = static_cast<std::uint64_t>(a) << 32 | b;
      points[count++] =
          mesh_W.points[a] + heights[a] / (heights[a] - heights[b]) * (mesh_W.points[b] - mesh_W.points[a]);
    }
    if (count == 2) joiner.Add(keys[0], points[0], keys[1], points[1]);
  }
  return joiner.Join();
}

std::vector<std::vector<Vec3>> CalcSectionLines(const Bone& bone, const PlaneOverlay& plane, double step_mm) {
  if (!(step_mm > 0)) throw Error("The step of a section must be above 0 mm");
  const std::vector<Vec3> c = MakeRectangle(plane.p_W, plane.normal_W, plane.up_W, plane.width_mm, plane.height_mm);
  constexpr double kMaxSide = 2000;
  const auto count = [&](double side_mm) {
    return static_cast<int>(std::clamp(std::ceil(side_mm / step_mm), 1.0, kMaxSide)) + 1;
  };
  const int columns = count(plane.width_mm);
  const int rows = count(plane.height_mm);
  const auto point_of = [&](double column, double row) {
    return c[0] + column / (columns - 1) * (c[1] - c[0]) + row / (rows - 1) * (c[3] - c[0]);
  };
  const Samples phi = SamplePhi(bone, columns, rows, [&](int column, int row) { return point_of(column, row); });
  std::vector<std::vector<Vec3>> lines_W;
  for (const std::vector<OverlayPoint>& line : FindZeroLines(phi)) {
    std::vector<Vec3> line_W;
    for (const OverlayPoint& p : line) line_W.push_back(point_of(p.column, p.row));
    lines_W.push_back(std::move(line_W));
  }
  return lines_W;
}

}  // namespace kerf
