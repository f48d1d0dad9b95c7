#include <fmt/format.h>

#include "base/table/table_json.h"
#include "experiment/draw_bench/view_bench.h"

namespace kerf {
namespace {

std::string FormatFirst(const ViewReport& r) {
  return fmt::format("{:.2f} s: bone {:.2f}, window {:.2f}, coarse surface {:.2f}, upload {:.2f}, first frame {:.2f}",
                     1e-3 * r.first_picture_ms(), 1e-3 * r.bone_ms, 1e-3 * r.window_ms, 1e-3 * r.meshing_ms,
                     1e-3 * r.upload_ms, 1e-3 * r.first_frame_ms);
}

std::string FormatEnvironment(const ViewReport& r) {
  return fmt::format("{} x {} pixels, scale {:g}; {}; {}", r.options.width, r.options.height, r.options.scale,
                     r.renderer, DescribeRun(r.run));
}

TextTable MakeViewTable(const ViewReport& r) {
  TextTable table({"what", "p50", "p95 or p99", "max", "sample"});
  const auto ms = [](double us, const char* format) { return fmt::format(fmt::runtime(format), 1e-3 * us); };
  const auto chunk = [&](const char* what, const Percentiles& t) {
    table.Add({what, ms(t.p50_us, "{:.2f} ms"), ms(t.p99_us, "{:.2f} ms (p99)"), ms(t.max_us, "{:.2f} ms"),
               fmt::format("{} chunks", t.count)});
  };
  chunk("a changed chunk, meshed and uploaded", r.both);
  chunk("the same, without chunks that the system interrupted", r.undisturbed);
  chunk("of which meshing", r.remesh);
  chunk("of which upload", r.upload);
  for (const ViewFrames& f : r.frames) {
    table.Add({"frame, " + f.view, ms(f.times.p50_us, "{:.1f} ms"), ms(f.p95_us, "{:.1f} ms (p95)"),
               ms(f.times.max_us, "{:.1f} ms"), fmt::format("{} frames, {} triangles", f.times.count, f.triangles)});
  }
  return table;
}

std::string DescribeView(const ViewReport& r) {
  return fmt::format(
      "\nDefault mandible at {:g} mm; first picture after {}; finer steps {:.2f} s later. The surface takes {:.1f} MB "
      "in {} "
      "chunks, "
      "and the data kept for {} cut leaves {:.1f} MB. {}.\n",
      r.options.voxel_mm, FormatFirst(r), 1e-3 * r.refining_ms, r.surface_MB, r.chunks, r.cut_leaves, r.uncut_MB,
      FormatEnvironment(r));
}

}  // namespace

std::string FormatViewTable(const ViewReport& r) {
  return MakeViewTable(r).FormatTerminal() + DescribeView(r);
}

std::string FormatViewMarkdown(const ViewReport& r) {
  return MakeViewTable(r).FormatMarkdown() + DescribeView(r);
}

std::string FormatViewJson(const ViewReport& r) {
  nlohmann::ordered_json json = RunJson(r.run);
  json["voxel_mm"] = r.options.voxel_mm;
  json["width"] = r.options.width;
  json["height"] = r.options.height;
  json["scale"] = r.options.scale;
  json["renderer"] = r.renderer;
  json["cpu"] = r.run.cpu;
  json["cores"] = r.run.cores;
  json["load"] = RoundedJson(r.run.load);
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
  return DumpJson(json);
}

}  // namespace kerf
