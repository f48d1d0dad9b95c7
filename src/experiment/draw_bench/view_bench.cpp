#include "experiment/draw_bench/view_bench.h"

#include <vtkRenderWindow.h>

#include <glm/geometric.hpp>

#include "bone/material/region_table.h"
#include "bone/models/mandible.h"
#include "experiment/bench/cut_cases.h"
#include "experiment/bench/measure.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "view/live/surface_worker.h"
#include "view/live/viewport.h"
#include "view/picture/offscreen.h"
#include "view/ui/panels.h"
#include "view/ui/picture_marks.h"

namespace kerf {
namespace {

constexpr double kTick_s = 0.001;
constexpr int kTicksPerFrame = 16;

// Returns panels that are as full as they can be in a session.
HudState MakeHud(const std::vector<PlotPoint>& force, const Pose& X_WT) {
  HudState hud;
  hud.force = force;
  hud.now_s = force.empty() ? 0 : force.back().time_s;
  hud.values.force_N = force.empty() ? 0 : force.back().force_N;
  hud.values.depth_mm = X_WT.p_AB.z;
  hud.values.feed_mm_per_s = 5;
  hud.values.rpm = 7500;
  return hud;
}

// Submits the panels that are shown while cutting.
void DrawPanels(Ui& ui, const HudState& hud, Viewport& view) {
  ui.BeginFrame(1.0 / 60);
  const UiAreas areas = CalcUiAreas(ui, true, false);
  PictureMarks marks;
  marks.mm_per_pixel = 0.1;
  DrawPictureMarks(ui, marks, areas.scene);
  if (BeginPanel(ui, "left", areas.left, true)) {
    ValuesSection(ui, hud);
    ForceSection(ui, hud);
    EndPanel();
  }
  ui.EndFrame();
  view.SetAreas({areas.scene.left, areas.scene.top, areas.scene.width, areas.scene.height},
                {areas.cube.left, areas.cube.top, areas.cube.width, areas.cube.height});
}

struct Cut {
  CutCase cut;
  double ticks_done = 0;

  Pose At(double tick) const {
    const Vec3 p_B = cut.X_BT_start.p_AB + cut.feed_mm_per_s * kTick_s * tick * cut.direction_B;
    return {cut.X_WB.R_AB * cut.X_BT_start.R_AB, cut.X_WB.Point(p_B)};
  }
};

ViewFrames DrawFrames(const std::string& name, const ViewBenchOptions& options, vtkRenderWindow& window, Viewport& view,
                      const std::function<void(int)>& before) {
  ViewFrames frames;
  frames.view = name;
  std::vector<double> times_us;
  for (int i = -2; i < options.frames; ++i) {
    if (options.progress && i >= 0) options.progress("frames, " + name, 1.0 * i / options.frames);
    before(i);
    const double us = TimeWork([&] {
                        view.Render();
                        window.WaitForCompletion();
                      }).us();
    if (i >= 0) times_us.push_back(us);
  }
  frames.p95_us = CalcPercentile(times_us, 0.95);
  frames.times = CalcPercentiles(times_us);
  frames.triangles = view.stats().triangles;
  frames.chunks = view.stats().drawn;
  frames.step = view.stats().step;
  return frames;
}

}  // namespace

ViewReport RunViewBench(const ViewBenchOptions& options) {
  CheckParameters(options);
  ViewReport report;
  report.options = options;
  report.run = ReadRunInfo();
  const auto tell = [&](const char* what, double fraction) {
    if (options.progress) options.progress(what, fraction);
  };

  // ---- until the first picture
  tell("bone", 0);
  double start_ms = ReadClock_ms();
  const auto lap = [&] {
    const double now_ms = ReadClock_ms();
    const double took_ms = now_ms - start_ms;
    start_ms = now_ms;
    return took_ms;
  };
  MandibleParams mandible;
  mandible.voxel_mm = options.voxel_mm;
  const Bone bone = MakeMandible(mandible, DefaultMandibleTable());
  report.bone_ms = lap();
  tell("first picture", 0);
  OffscreenWindow offscreen(options.width, options.height);
  vtkRenderWindow& window = offscreen.window();
  Ui ui;
  Viewport view(window);
  view.SetPanels(ui.prop());
  ui.SetSize(options.width, options.height, options.scale);
  view.Resize(options.width, options.height, options.scale);
  report.window_ms = lap();
  SurfaceWorker worker(bone);
  worker.WaitFirst();
  report.meshing_ms = lap();
  view.BeginBone(bone.materials(), worker.origin_W(), worker.bounds_W(), bone.voxel_mm());
  const auto fetch = [&] {
    for (auto meshes = worker.Fetch(256); !meshes.empty(); meshes = worker.Fetch(256)) {
      for (const ChunkMesh& mesh : meshes) view.SetChunk(mesh);
    }
  };
  fetch();
  report.upload_ms = lap();
  view.camera().Look(View::kThreeQuarter);
  view.FitAll();
  view.Render();
  window.WaitForCompletion();
  report.first_frame_ms = lap();
  report.renderer = view.renderer_name();
  worker.WaitIdle();
  report.refining_ms = lap();
  fetch();

  // ---- a cut, frame by frame
  Cut cut{MakeMandibleCut(false), 0};
  SimulationParams params;
  params.tool = cut.cut.tool;
  view.SetTool(cut.cut.tool);
  Simulation simulation(bone, params, cut.At(0));
  BoneChunks chunks{Bone(bone)};
  const std::size_t before_bytes = chunks.CalcMemoryBytes();
  std::vector<double> remesh_us, upload_us, both_us, undisturbed_us;
  std::vector<PlotPoint> force;
  const double mm_per_tick = cut.cut.feed_mm_per_s * kTick_s;
  const int first_tick = static_cast<int>(0.6 * cut.cut.warm_up_mm / mm_per_tick);
  const int ticks = static_cast<int>(options.cut_mm / mm_per_tick);
  simulation.SetDown(cut.At(first_tick));
  LeafMessage message;
  ChunkMesh mesh;
  for (int tick = 1; tick <= ticks; ++tick) {
    TickInput in;
    in.X_WT = cut.At(first_tick + tick);
    in.dt_s = kTick_s;
    in.rpm = cut.cut.rpm;
    const TickOutput out = simulation.Tick(in);
    force.push_back({kTick_s * tick, glm::length(out.f_T_W_N)});
    if (tick % kTicksPerFrame != 0) continue;
    tell("cut", 1.0 * tick / ticks);
    for (int i = 0; i < simulation.changed_count(); ++i) {
      const ChangedLeaf leaf = simulation.changed(i);
      message.index = leaf.index;
      std::copy_n(leaf.cut, 512, message.values.begin());
      chunks.Take(message);
      worker.Offer(message);
      ++report.cut_leaves;
    }
    simulation.ClearChanged();
    simulation.Refill();
    for (;;) {
      const long interruptions = CountDisturbances().interruptions;
      const std::int64_t t0_ns = ReadClock_ns();
      if (!chunks.Next(mesh)) break;
      const std::int64_t t1_ns = ReadClock_ns();
      view.SetChunk(mesh);
      const std::int64_t t2_ns = ReadClock_ns();
      remesh_us.push_back(1e-3 * static_cast<double>(t1_ns - t0_ns));
      upload_us.push_back(1e-3 * static_cast<double>(t2_ns - t1_ns));
      both_us.push_back(1e-3 * static_cast<double>(t2_ns - t0_ns));
      if (CountDisturbances().interruptions == interruptions) undisturbed_us.push_back(both_us.back());
    }
  }
  report.remesh = CalcPercentiles(remesh_us);
  report.upload = CalcPercentiles(upload_us);
  report.both = CalcPercentiles(both_us);
  report.undisturbed = CalcPercentiles(undisturbed_us);
  report.uncut_MB = 1e-6 * (static_cast<double>(chunks.CalcMemoryBytes()) - static_cast<double>(before_bytes));
  report.bone_hash = chunks.bone().CalcHash();
  worker.WaitIdle();
  fetch();

  // ---- frames
  const Pose X_WT = cut.At(first_tick + ticks);
  const auto move = [&](int i) {
    Pose moved = X_WT;
    moved.p_AB.z += 0.01 * (i % 50);
    view.SetToolPose(moved, 7500, 0.1 * i);
    view.SetForce(ForceArrow{moved.p_AB, Vec3{0.2, 0.1, 2}});
    HudState hud = MakeHud(force, moved);
    hud.values.force_N = 2 + 0.01 * (i % 50);
    DrawPanels(ui, hud, view);
  };
  report.frames.push_back(DrawFrames("whole bone", options, window, view, move));
  report.frames.push_back(DrawFrames("whole bone, turning", options, window, view, [&](int i) {
    move(i);
    view.camera().Orbit(3, 0);
  }));
  view.set_translucent(true);
  report.frames.push_back(DrawFrames("whole bone, translucent", options, window, view, move));
  view.set_translucent(false);
  view.camera().set_target_W(X_WT.p_AB);
  view.camera().set_height_mm(40);
  report.frames.push_back(DrawFrames("at the cut, 40 mm", options, window, view, move));
  report.chunks = view.stats().chunks;
  report.surface_MB = 1e-6 * static_cast<double>(view.stats().surface_bytes);
  return report;
}

}  // namespace kerf
