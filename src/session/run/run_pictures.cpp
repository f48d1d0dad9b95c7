#include "session/run/run_pictures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "bone/grid/coarse_surface.h"
#include "bone/mesh/reduce.h"
#include "cut/tool/looks.h"
#include "cut/tool/words.h"
#include "kerf/surface.h"
#include "session/scene/saws.h"
#include "view/picture/colours.h"
#include "view/picture/picture.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr double kCloseUpMm = 34;        // height of the region in the close-up
constexpr double kShortestBandMm = 0.4;  // shorter runs of a region are merged with their neighbour

/// Ticks of the first contact, the largest force and the last contact.
struct Moments {
  std::size_t first = 0;  // tick of first contact
  std::size_t peak = 0;   // tick of the largest force
  std::size_t last = 0;   // last tick in bone
  bool any = false;
};

Moments FindMoments(const std::vector<TickRecord>& ticks) {
  Moments m;
  double peak = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (ticks[i].out.engaged_teeth <= 0) continue;
    if (!m.any) m.first = i;
    m.any = true;
    m.last = i;
    const double force = glm::length(ticks[i].out.f_T_W_N);
    if (force > peak) {
      peak = force;
      m.peak = i;
    }
  }
  return m;
}

Shape ShapeOf(const Bone& bone, TriangleMesh mesh, std::vector<LegendEntry>* legend) {
  Shape shape;
  SurfaceColours colours = CalcSurfaceColours(bone, mesh, ColourBy::kTissue);
  shape.point_colours = std::move(colours.points);
  shape.mesh_W = std::move(mesh);
  if (legend) *legend = std::move(colours.legend);
  return shape;
}

/// Adds the bone after the cut: its pieces, and the parts that are too small to be pieces.
void AddAfter(const RunPictures& run, const DrawnPieces& pieces, PictureSpec& spec) {
  for (const PieceSurface& piece : pieces.surfaces) {
    spec.shapes.push_back(piece.shape);
    for (const LegendEntry& entry : piece.legend) {
      const bool listed = std::any_of(spec.legend.begin(), spec.legend.end(),
                                      [&](const LegendEntry& other) { return other.text == entry.text; });
      if (!listed) spec.legend.push_back(entry);
    }
  }
  spec.shapes.push_back(ShapeOf(run.after, ExtractSurface(*pieces.dust), nullptr));
}

Vec3 UpNotAlong(const Vec3& direction) {
  return std::abs(glm::normalize(direction).z) < 0.9 ? Vec3(0, 0, 1) : Vec3(0, -1, 0);
}

bool ShowsBone(const PictureSpec& spec) {
  return std::any_of(spec.shapes.begin(), spec.shapes.end(),
                     [](const Shape& shape) { return !shape.mesh_W.triangles.empty(); });
}

Vec3 Centroid(const TriangleMesh& mesh) {
  Vec3 sum(0);
  for (const Vec3& p : mesh.points) sum += p;
  return mesh.points.empty() ? sum : sum / static_cast<double>(mesh.points.size());
}

/// Returns a view of the bone from the side of the cut, slightly from above and in front.
Camera OverviewCamera(const Bone& bone, const Vec3& cut_W) {
  const double side = cut_W.x - bone.CalcBounds().centre().x;
  return {Vec3(side >= 0 ? 0.75 : -0.75, -1, 0.55), Vec3(0, 0, 1), {}, 0};
}

/// Returns the force that the longest arrow stands for: 1, 2 or 5 times a power of ten, at least `force_N` > 0.
double CalcArrowForce(double force_N) {
  const double power = std::pow(10, std::floor(std::log10(force_N)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= force_N) return factor * power;
  }
  return 10 * power;
}

/// Returns the foremost point of the tool at a tick.
Vec3 LeadingPoint(const std::vector<TickRecord>& ticks, std::size_t i, const Tool& tool) {
  const Pose& X_WT = ticks[i].X_WT;
  const Vec3 feed_T = X_WT.InverseVector(X_WT.p_AB - ticks[i > 0 ? i - 1 : i].X_WT.p_AB);
  return X_WT.Point(FindForemost(tool, feed_T));
}

/// Returns the horizontal direction in the disc's plane, away from the centre of the bone.
Vec3 CalcOutward(const Bone& bone, const Vec3& p_W, const Vec3& normal) {
  Vec3 outward = p_W - bone.CalcBounds().centre();
  outward.z = 0;
  outward -= glm::dot(outward, normal) * normal;
  outward.z = 0;
  if (glm::length(outward) < 1e-6) outward = Vec3(-normal.y, normal.x, 0);
  if (glm::length(outward) < 1e-6) outward = Vec3(0, -1, 0);
  return glm::normalize(outward);
}

}  // namespace

bool IsOfPatient(const Scene& scene) {
  return scene.bone.source == BoneSource::kFile || scene.bone.source == BoneSource::kMandible;
}

PieceSurface MakePieceSurface(const Bone& piece, double error_mm, bool has_file,
                              const std::function<void(double)>& progress) {
  constexpr double kExtracted = 0.2;
  // On the large triangles of a reduced surface, the light of a rounded edge spreads over the flat sides beside it.
  constexpr std::size_t kDrawnInFull = 1'000'000;
  PieceSurface surface;
  Shape& shape = surface.shape;
  shape = ShapeOf(piece, ExtractSurface(piece), &surface.legend);
  progress(kExtracted);
  const bool is_large = shape.mesh_W.triangles.size() > kDrawnInFull;
  if (!(error_mm > 0) || (!has_file && !is_large)) {
    if (has_file) surface.mesh_W = shape.mesh_W;
    progress(1);
    return surface;
  }
  std::vector<std::uint32_t> colours;
  colours.reserve(shape.point_colours.size());
  for (const Rgb8& c : shape.point_colours) colours.push_back(c[0] + 256U * c[1] + 65536U * c[2]);
  ReducedMesh reduced =
      Reduce(shape.mesh_W, error_mm, colours, [&](double fraction) { progress(std::lerp(kExtracted, 1.0, fraction)); });
  surface.mesh_W = std::move(reduced.mesh);
  if (is_large) {
    std::vector<Rgb8> kept;
    kept.reserve(reduced.from.size());
    for (const std::uint32_t p : reduced.from) kept.push_back(shape.point_colours[p]);
    shape.mesh_W = has_file ? surface.mesh_W : std::move(surface.mesh_W);
    shape.point_colours = std::move(kept);
  }
  return surface;
}

bool AreDrawn(const Scene& scene, std::vector<std::string>& warnings) {
  if (!scene.output.pictures) return false;
  const std::string lack = FindLackOfPictures();
  if (!lack.empty()) warnings.push_back(lack);
  return lack.empty();
}

std::vector<double> CalcWaysApart(std::span<const double> places_mm, double gap_mm) {
  std::vector<std::size_t> order(places_mm.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return places_mm[a] < places_mm[b]; });
  std::vector<double> ways_mm(places_mm.size());
  double way_mm = -0.5 * gap_mm * (static_cast<double>(places_mm.size()) - 1);
  for (const std::size_t i : order) {
    ways_mm[i] = way_mm;
    way_mm += gap_mm;
  }
  return ways_mm;
}

std::vector<std::string> WriteRunPictures(const RunPictures& run, const std::function<void(double)>& progress,
                                          std::vector<std::string>& warnings) {
  std::vector<std::string> written;
  std::vector<std::string> left_out;
  const Moments moments = FindMoments(run.ticks);
  const TickRecord& first = run.ticks[moments.any ? moments.first : 0];
  const TickRecord& peak = run.ticks[moments.any ? moments.peak : 0];
  const bool patient = IsOfPatient(run.scene);
  const Tool tool = MakeTool(run.scene);
  const Camera overview = OverviewCamera(run.before, peak.X_WT.p_AB);
  const std::string name = run.scene.TitleOrName();
  const auto show = [&](double fraction) {
    if (progress) progress(fraction);
  };
  const auto write = [&](const PictureSpec& spec, const char* file, double drawn) {
    if (!ShowsBone(spec)) {
      left_out.emplace_back(file);
      return;
    }
    run.sink(file, [&] {
      WritePicture(spec, run.folder + "/" + file);
      written.emplace_back(file);
    });
    show(drawn);
  };
  const auto base = [&](const std::string& title) {
    PictureSpec spec;
    spec.title = title;
    spec.orientation = patient ? Orientation::kPatient : Orientation::kAxes;
    return spec;
  };

  PictureSpec before = base(name + ": before the cut");
  // Triangles much smaller than a pixel would only take time. The generic mandible has no thin walls, which might go.
  const Box3 box = run.before.CalcBounds();
  const double pixel_mm = glm::length(box.upper - box.lower) / before.height;
  const bool is_fine = run.scene.bone.source == BoneSource::kMandible && 2 * run.before.voxel_mm() < 1.5 * pixel_mm;
  TriangleMesh surface = is_fine ? ExtractCoarseSurface(run.before) : ExtractSurface(run.before);
  show(0.3 * kBeforeDrawn);
  before.shapes.push_back(ShapeOf(run.before, std::move(surface), &before.legend));
  show(0.5 * kBeforeDrawn);
  before.tools.push_back({tool, first.X_WT, 1});
  before.camera = overview;
  before.caption = fmt::format("{:.1f} cm3 of bone; {}, at first contact", run.volume_before_mm3 / 1000,
                               DescribeTool(run.scene.tool.shape));
  write(before, "before.png", kBeforeDrawn);
  before = {};

  const DrawnPieces pieces = run.make_pieces();
  const std::size_t piece_count = pieces.surfaces.size();
  PictureSpec after = base(name + ": after the cut");
  AddAfter(run, pieces, after);
  after.caption = fmt::format("{} separate piece{}{}", piece_count, piece_count == 1 ? "" : "s",
                              run.out.empty() ? "" : " in place");
  for (const PieceOut& piece : run.out) {
    if (piece.id != kAllDust) after.caption += fmt::format(", 1 {}", ToString(piece.fate));
    if (piece.fate != PieceFate::kMoved) continue;
    Shape shape = ShapeOf(piece.bone, ExtractSurface(piece.bone), nullptr);
    for (Vec3& p : shape.mesh_W.points) p += piece.move_mm;
    after.shapes.push_back(std::move(shape));
  }
  after.camera = overview;
  after.fit_to_tool = false;
  write(after, "after.png", 0.55);

  // Show the kerf's opening on the outer side of the bone, slightly from above and from one side of the disc's plane.
  PictureSpec cut = base(name + ": the cut in close-up");
  cut.shapes = std::move(after.shapes);
  cut.legend = after.legend;
  const TickRecord& last = run.ticks[moments.any ? moments.last : 0];
  const Vec3 normal = peak.X_WT.Vector({0, 0, 1});
  const Vec3 middle =
      0.5 * (LeadingPoint(run.ticks, moments.first, tool) + LeadingPoint(run.ticks, moments.last, tool));
  const Vec3 across = glm::dot(normal, overview.toward_eye_W) < 0 ? -normal : normal;
  const Vec3 outward = CalcOutward(run.before, middle, normal);
  const Vec3 toward_eye = outward + 0.55 * across + Vec3(0, 0, 0.35);
  const double travel_mm = glm::length(last.X_WT.p_AB - first.X_WT.p_AB);
  cut.camera = MakeCamera(toward_eye, UpNotAlong(toward_eye), middle, std::clamp(travel_mm + 12, 16.0, 48.0));
  cut.tools.push_back({tool, peak.X_WT, 1, run.scene.tool.CalcTickRpm()});
  const double peak_N = glm::length(peak.out.f_T_W_N);
  std::string scale;
  if (peak_N > 0) {
    const Vec3 tail = LeadingPoint(run.ticks, moments.peak, tool);
    const double arrow_N = CalcArrowForce(peak_N);
    const double arrow_mm = cut.camera.height_mm < 30 ? 5 : 10;  // ends in the picture
    const Vec3 tip = tail + peak.out.f_T_W_N / arrow_N * arrow_mm;
    scale = fmt::format(" (arrow: {:g} mm for {:g} N)", arrow_mm, arrow_N);
    cut.arrows.push_back({tail, tip, kForceColour, fmt::format("{:.1f} N", peak_N)});
  }
  cut.caption = fmt::format(
      "bone after the cut; tool and force on it (from its leading edge) when that was largest: {:.1f} N at {:.2f} "
      "s{}",
      peak_N, peak.time_s, scale);
  if (const std::string sense = DescribeSense(run.scene.tool); !sense.empty() && run.scene.tool.rpm != 0) {
    cut.caption += fmt::format("; it turns {} (bent arrow)", sense);
  }
  if (moments.any) write(cut, "cut.png", 0.8);
  cut = {};
  after = {};

  if (run.apart && piece_count > 1) {
    PictureSpec apart = base(name + ": the pieces moved apart");
    // Many pieces must not become specks.
    const double gap_mm = std::min(12.0, 60.0 / static_cast<double>(piece_count - 1));
    std::vector<double> places_mm;
    for (const PieceSurface& piece : pieces.surfaces) {
      if (apart.legend.empty()) apart.legend = piece.legend;
      apart.shapes.push_back(piece.shape);
      places_mm.push_back(glm::dot(Centroid(piece.shape.mesh_W), normal));
    }
    const std::vector<double> ways_mm = CalcWaysApart(places_mm, gap_mm);
    for (std::size_t i = 0; i < ways_mm.size(); ++i) {
      for (Vec3& p : apart.shapes[i].mesh_W.points) p += ways_mm[i] * normal;
    }
    apart.camera = {across + 0.75 * outward + Vec3(0, 0, 0.45), Vec3(0, 0, 1), {}, 0};
    apart.caption = fmt::format(
        "{} pieces, each moved {:.2g} mm further from the next along the spindle's axis; the cut "
        "faces show the layers",
        piece_count, gap_mm);
    write(apart, "apart.png", 0.95);
  }

  if (moments.any && run.force_plot) {
    run.sink("force.png", [&] {
      WritePlot(MakeForcePlot(run.ticks, run.after.materials(), name, tool), run.folder + "/force.png");
      written.emplace_back("force.png");
    });
  }
  show(1);
  if (!left_out.empty()) {
    warnings.push_back(fmt::format("no bone is left to draw: {} {} not written", fmt::join(left_out, " and "),
                                   left_out.size() == 1 ? "is" : "are"));
  }
  return written;
}

namespace {

struct Run {
  int region;
  double x0;
  double x1;
};

/// Returns intervals of travel in which one region carries most of the force; short ones are merged with the previous
/// one.
std::vector<Run> FindRegionRuns(const std::vector<TickRecord>& ticks, std::size_t segment) {
  std::vector<Run> runs;
  for (const TickRecord& t : ticks) {
    if (t.segment != segment || t.out.main_region == 0) continue;
    const bool is_continued = !runs.empty() && t.travel_mm - runs.back().x1 < kShortestBandMm;
    if (!is_continued || runs.back().region != t.out.main_region)
      runs.push_back({t.out.main_region, t.travel_mm, t.travel_mm});
    runs.back().x1 = t.travel_mm;
  }
  std::vector<Run> merged;
  for (const Run& run : runs) {
    const bool adjoins = !merged.empty() && run.x0 - merged.back().x1 < kShortestBandMm;
    if (adjoins && (run.x1 - run.x0 < kShortestBandMm || merged.back().region == run.region)) {
      merged.back().x1 = run.x1;
      continue;
    }
    if (adjoins) merged.back().x1 = run.x0;
    merged.push_back(run);
  }
  return merged;
}

/// Colours of the bands: pale, distinguishable, and assigned in order of appearance, so that neighbours always differ.
constexpr Rgb8 kBandColours[] = {{252, 232, 205}, {219, 234, 245}, {222, 240, 226},
                                 {240, 226, 238}, {250, 244, 205}, {228, 228, 228}};

constexpr std::size_t kForceIntervals = 500;      // of the longest travel, about two pixels each
constexpr Rgb8 kForceRangeColour{166, 206, 227};  // pale blue
constexpr Rgb8 kForceCurveColour{0, 114, 178};
constexpr Rgb8 kTeethCurveColour{213, 94, 0};

/// Values of a curve in one interval of travel.
struct ForceInterval {
  double middle_mm = 0;
  double sum = 0;
  double lowest = 0;
  double highest = 0;
  int count = 0;
  int turns = 0;  // from rising to falling or back

  double mean() const { return sum / count; }
};

/// Divides a curve into the intervals of travel that contain points.
std::vector<ForceInterval> DivideByTravel(const PlotSeries& curve, double interval_mm) {
  std::vector<ForceInterval> intervals;
  double last_index = -1;
  double slope = 0;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    const double index = std::min(std::floor(curve.x[i] / interval_mm), kForceIntervals - 1.0);
    const double y = curve.y[i];
    if (intervals.empty() || index != last_index) {
      intervals.push_back({.middle_mm = (index + 0.5) * interval_mm, .lowest = y, .highest = y});
    }
    last_index = index;
    ForceInterval& interval = intervals.back();
    interval.sum += y;
    ++interval.count;
    interval.lowest = std::min(interval.lowest, y);
    interval.highest = std::max(interval.highest, y);
    const double now = i > 0 ? y - curve.y[i - 1] : 0;
    if (now * slope < 0) ++interval.turns;
    if (now != 0) slope = now;
  }
  return intervals;
}

/// Returns true if a curve would be drawn as a block: in most intervals it rises and falls, and visibly.
bool IsRipple(const std::vector<ForceInterval>& intervals) {
  double peak = 0;
  for (const ForceInterval& interval : intervals) peak = std::max(peak, interval.highest);
  const auto count = std::count_if(intervals.begin(), intervals.end(), [&](const ForceInterval& interval) {
    return interval.turns >= 2 && interval.highest - interval.lowest > 0.04 * peak;
  });
  return 2 * static_cast<std::size_t>(count) > intervals.size();
}

/// Replaces a curve by the means of its intervals and returns their ranges, as a closely drawn zigzag.
PlotSeries SplitRipple(const std::vector<ForceInterval>& intervals, PlotSeries& curve) {
  PlotSeries range;
  range.colour = kForceRangeColour;
  range.width = 3;
  curve.x.clear();
  curve.y.clear();
  for (const ForceInterval& interval : intervals) {
    range.x.insert(range.x.end(), {interval.middle_mm, interval.middle_mm});
    range.y.insert(range.y.end(), {interval.lowest, interval.highest});
    curve.x.push_back(interval.middle_mm);
    curve.y.push_back(interval.mean());
  }
  return range;
}

}  // namespace

PlotSpec MakeForcePlot(const std::vector<TickRecord>& ticks, const MaterialTable& materials, const std::string& name,
                       const Tool& tool) {
  PlotSpec plot;
  plot.title = name + ": force on the tool";
  plot.x.label = "travel along the feed since first contact (mm); for a plunge, the depth";
  plot.y.label = "force (N)";
  plot.y.lower = 0;
  // A tool without teeth has pieces of its lips or flutes in their place.
  const std::string line(GetWords(tool).line);
  const double teeth_unit = line.empty() ? 1 : CalcTooth(tool).width_mm;
  const std::string teeth_label = line.empty() ? "engaged teeth" : fmt::format("engaged length of the {}s", line);
  plot.y_right.label = line.empty() ? teeth_label : teeth_label + " (mm)";
  plot.y_right.lower = 0;
  std::size_t segments = 0;
  std::size_t longest = 0;
  double longest_mm = -1;
  for (const TickRecord& t : ticks) {
    segments = std::max(segments, t.segment + 1);
    if (t.travel_mm > longest_mm) {
      longest_mm = t.travel_mm;
      longest = t.segment;
    }
  }
  // A curve ends shortly after its stroke's last contact.
  std::vector<double> end_mm(segments, 0);
  for (const TickRecord& t : ticks) {
    if (t.out.engaged_teeth > 0) end_mm[t.segment] = t.travel_mm + 0.2;
  }
  constexpr std::size_t kMaxCurves = 6;
  const double interval_mm = longest_mm > 0 ? longest_mm / kForceIntervals : 1;
  std::vector<PlotSeries> ranges;
  std::vector<PlotSeries> curves;
  for (std::size_t segment = 0; segment < std::min(segments, kMaxCurves); ++segment) {
    PlotSeries force;
    force.label = segments > 1 ? fmt::format("force, stroke {}", segment + 1) : std::string("force");
    PlotSeries teeth;
    teeth.label = teeth_label;
    teeth.right_axis = true;
    teeth.width = 1.5;
    teeth.dash = 6;
    for (const TickRecord& t : ticks) {
      if (t.segment != segment || !t.touched || t.travel_mm > end_mm[segment]) continue;
      force.x.push_back(t.travel_mm);
      force.y.push_back(glm::length(t.out.f_T_W_N));
      teeth.x.push_back(t.travel_mm);
      teeth.y.push_back(teeth_unit * t.out.engaged_teeth);
    }
    if (force.x.size() < 2) continue;
    if (const std::vector<ForceInterval> intervals = DivideByTravel(force, interval_mm); IsRipple(intervals)) {
      PlotSeries range = SplitRipple(intervals, force);
      if (ranges.empty()) range.label = fmt::format("lowest to highest force in each {:.2g} mm", interval_mm);
      ranges.push_back(std::move(range));
      force.label += ", mean";
    }
    if (segments == 1) {
      // The force is often proportional to the number of teeth: on this axis its curve lies below that of the force.
      plot.y_right.upper = 1.6 * *std::max_element(teeth.y.begin(), teeth.y.end());
      if (!(*plot.y_right.upper > 0)) plot.y_right.upper.reset();
      if (const std::vector<ForceInterval> of_teeth = DivideByTravel(teeth, interval_mm); IsRipple(of_teeth)) {
        SplitRipple(of_teeth, teeth);
        teeth.label += ", mean";
      }
      force.colour = kForceCurveColour;
      teeth.colour = kTeethCurveColour;
      curves.push_back(std::move(force));
      curves.push_back(std::move(teeth));
    } else {
      curves.push_back(std::move(force));
    }
  }
  plot.series = std::move(ranges);
  plot.series.insert(plot.series.end(), std::make_move_iterator(curves.begin()), std::make_move_iterator(curves.end()));
  std::map<int, std::size_t> order;  // order in which the regions appear
  for (const Run& run : FindRegionRuns(ticks, longest)) {
    const std::size_t colour = order.emplace(run.region, order.size()).first->second % std::size(kBandColours);
    // Label the band with the region's name if it fits, otherwise with its number if that fits.
    const double fraction = (run.x1 - run.x0) / longest_mm;
    std::string label = fraction > 0.025 ? fmt::format("{}", run.region) : std::string();
    if (materials.Contains(run.region)) {
      const std::string named = fmt::format("{} {}", run.region, materials.At(run.region).name);
      if (fraction > 0.009 * static_cast<double>(named.size())) label = named;
    }
    plot.bands.push_back({run.x0, run.x1, label, kBandColours[colour]});
  }
  plot.caption = fmt::format("bands: the region that carries most of the force{}",
                             segments > 1 ? fmt::format(", on stroke {}", longest + 1) : std::string());
  return plot;
}

}  // namespace kerf
