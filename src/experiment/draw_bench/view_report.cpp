#include <fmt/format.h>

#include "experiment/bench/times_json.h"
#include "experiment/draw_bench/view_bench.h"

namespace kerf {
namespace {

std::string FormatTimes(const Percentiles& t) {
  return fmt::format("p50 {:.2f} ms, p99 {:.2f}, max {:.2f}", 1e-3 * t.p50_us, 1e-3 * t.p99_us, 1e-3 * t.max_us);
}

std::string FormatFirst(const ViewReport& r) {
  return fmt::format("{:.2f} s: bone {:.2f}, window {:.2f}, coarse surface {:.2f}, upload {:.2f}, first frame {:.2f}",
                     1e-3 * r.first_picture_ms(), 1e-3 * r.bone_ms, 1e-3 * r.window_ms, 1e-3 * r.meshing_ms,
                     1e-3 * r.upload_ms, 1e-3 * r.first_frame_ms);
}

std::string FormatEnvironment(const ViewReport& r) {
  return fmt::format("{} x {} pixels, scale {:g}; {}; {}, {} core{}; load {:.1f} before", r.options.width,
                     r.options.height, r.options.scale, r.renderer, r.machine.cpu, r.machine.cores,
                     r.machine.cores == 1 ? "" : "s", r.machine.load);
}

}  // namespace

std::string FormatViewTable(const ViewReport& r) {
  std::string text = fmt::format("View, default mandible at {:g} mm\n", r.options.voxel_mm);
  text += fmt::format("  first picture   {}\n", FormatFirst(r));
  text += fmt::format("  finer steps     {:.2f} s later\n", 1e-3 * r.refining_ms);
  text += fmt::format("  a changed chunk {} (limit 2), undisturbed {}: mesh {}; upload {}; {} times, {} leaves\n",
                      FormatTimes(r.both), FormatTimes(r.undisturbed), FormatTimes(r.remesh), FormatTimes(r.upload),
                      r.both.count, r.cut_leaves);
  for (const ViewFrames& f : r.frames) {
    text += fmt::format("  frame, {:<24} p50 {:.1f} ms, p95 {:.1f}, max {:.1f}; {} triangles in {} chunks, step {}\n",
                        f.view, 1e-3 * f.times.p50_us, 1e-3 * f.p95_us, 1e-3 * f.times.max_us, f.triangles, f.chunks,
                        f.step);
  }
  text += fmt::format("  surface         {:.1f} MB in {} chunks; {:.1f} MB kept for cut leaves\n", r.surface_MB,
                      r.chunks, r.uncut_MB);
  text += fmt::format("  bone            {:016x} after the cut\n  {}\n", r.bone_hash, FormatEnvironment(r));
  return text;
}

std::string FormatViewMarkdown(const ViewReport& r) {
  std::string text = "| what | p50 | p95 or p99 | max | sample |\n|---|---|---|---|---|\n";
  const auto chunk = [&](const char* what, const Percentiles& t) {
    text += fmt::format("| {} | {:.2f} ms | {:.2f} ms (p99) | {:.2f} ms | {} chunks |\n", what, 1e-3 * t.p50_us,
                        1e-3 * t.p99_us, 1e-3 * t.max_us, t.count);
  };
  chunk("a changed chunk, meshed and uploaded", r.both);
  chunk("the same, without chunks that the system interrupted", r.undisturbed);
  chunk("of which meshing", r.remesh);
  chunk("of which upload", r.upload);
  for (const ViewFrames& f : r.frames) {
    text += fmt::format("| frame, {} | {:.1f} ms | {:.1f} ms (p95) | {:.1f} ms | {} frames, {} triangles |\n", f.view,
                        1e-3 * f.times.p50_us, 1e-3 * f.p95_us, 1e-3 * f.times.max_us, f.times.count, f.triangles);
  }
  text += fmt::format(
      "\nDefault mandible at {:g} mm; first picture after {}; finer steps {:.2f} s later. The surface takes {:.1f} MB "
      "in {} "
      "chunks, "
      "and the data kept for {} cut leaves {:.1f} MB. {}.\n",
      r.options.voxel_mm, FormatFirst(r), 1e-3 * r.refining_ms, r.surface_MB, r.chunks, r.cut_leaves, r.uncut_MB,
      FormatEnvironment(r));
  return text;
}

std::string FormatViewJson(const ViewReport& r) {
  nlohmann::ordered_json json;
  json["voxel_mm"] = r.options.voxel_mm;
  json["width"] = r.options.width;
  json["height"] = r.options.height;
  json["scale"] = r.options.scale;
  json["renderer"] = r.renderer;
  json["cpu"] = r.machine.cpu;
  json["cores"] = r.machine.cores;
  json["load"] = RoundedJson(r.machine.load);
  json["first_picture_ms"] = {
      {"all", RoundedJson(r.first_picture_ms())}, {"bone", RoundedJson(r.bone_ms)},
      {"window", RoundedJson(r.window_ms)},       {"coarse_surface", RoundedJson(r.meshing_ms)},
      {"upload", RoundedJson(r.upload_ms)},       {"first_frame", RoundedJson(r.first_frame_ms)}};
  json["refining_ms"] = RoundedJson(r.refining_ms);
  json["chunk"] = {{"both", TimesJson(r.both)},
                   {"undisturbed", TimesJson(r.undisturbed)},
                   {"remesh", TimesJson(r.remesh)},
                   {"upload", TimesJson(r.upload)}};
  json["cut_leaves"] = r.cut_leaves;
  for (const ViewFrames& f : r.frames) {
    json["frames"].push_back({{"view", f.view},
                              {"times", TimesJson(f.times)},
                              {"p95_us", RoundedJson(f.p95_us)},
                              {"triangles", f.triangles},
                              {"chunks", f.chunks},
                              {"step", f.step}});
  }
  json["surface_MB"] = RoundedJson(r.surface_MB);
  json["chunks"] = r.chunks;
  json["uncut_MB"] = RoundedJson(r.uncut_MB);
  json["bone_hash"] = fmt::format("{:016x}", r.bone_hash);
  return json.dump(2) + "\n";
}

}  // namespace kerf
