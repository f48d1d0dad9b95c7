// The cost of drawing: `kerf bench view`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "base/table/run_info.h"
#include "experiment/bench/measure.h"
#include "view/live/viewport.h"

namespace kerf {

struct ViewBenchOptions {
  double voxel_mm = 0.1;
  int width = 1280;
  int height = 720;
  double scale = 1;
  int frames = 100;
  double cut_mm = 12;
  std::function<void(const std::string& what, double fraction)> progress;
};
template <typename V>
void Describe(ViewBenchOptions& p, V&& visit) {
  visit("voxel_mm", p.voxel_mm, kBenchVoxelRange_mm, "voxel size of the mandible");
  visit("width", p.width, Range{320, 4096}, "width of the picture in pixels");
  visit("height", p.height, Range{240, 4096}, "height of the picture in pixels");
  visit("scale", p.scale, kDisplayScaleRange, "scale of text and lines");
  visit("frames", p.frames, Range{5, 100'000}, "number of frames drawn of each view");
  visit("cut_mm", p.cut_mm, Range{1, 40}, "length of the disc's path");
}

/// Times of one view.
struct ViewFrames {
  std::string view;
  Percentiles times;  // of whole frames, until the driver has completed them
  double p95_us = 0;
  std::size_t triangles = 0;
  std::size_t chunks = 0;
  int step = 1;  // voxels per cell, of uncut chunks
};

struct ViewReport {
  ViewBenchOptions options;
  RunInfo run;
  std::string renderer;  // the driver's name
  // Times until the first picture, ms.
  double bone_ms = 0;
  double window_ms = 0;
  double meshing_ms = 0;  // with the coarse step
  double upload_ms = 0;
  double first_frame_ms = 0;
  double refining_ms = 0;  // all finer steps, afterwards
  // Times for a chunk that the saw has changed.
  Percentiles remesh;
  Percentiles upload;
  Percentiles both;
  Percentiles undisturbed;  // as `both`, without the times in which the system interrupted the thread
  std::size_t cut_leaves = 0;
  std::vector<ViewFrames> frames;
  std::size_t chunks = 0;
  double surface_MB = 0;  // on the graphics card, for all steps
  double uncut_MB = 0;    // copies of the original leaves, kept to detect cuts
  std::uint64_t bone_hash = 0;

  double first_picture_ms() const { return bone_ms + window_ms + meshing_ms + upload_ms + first_frame_ms; }
};

/// Cuts through the body of the default mandible with a disc and draws the bone without a display. Throws Error if a
/// value is out of range or drawing is not possible.
ViewReport RunViewBench(const ViewBenchOptions& options);

std::string FormatViewTable(const ViewReport& report);
std::string FormatViewMarkdown(const ViewReport& report);
std::string FormatViewJson(const ViewReport& report);

}  // namespace kerf
