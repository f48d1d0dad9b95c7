// Pictures of the wanted cut and of the one that was made: outlines in mm, and drawings of them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "bone/grid/removed.h"
#include "session/scene/exercise.h"
#include "view/picture/image.h"

namespace kerf {

struct PlotFrame;

struct PicturePoint {
  double x_mm = 0;
  double y_mm = 0;

  bool operator==(const PicturePoint&) const = default;
};
/// Line through points. In an outline, the first point is repeated at the end.
using PictureLine = std::vector<PicturePoint>;

/// View of the cut: outlines of volumes projected onto the picture, or of their section. x is along the line, from its
/// start, to the right.
struct CutView {
  std::vector<PictureLine> wanted;  // bone in the wanted cut
  std::vector<PictureLine> made;    // bone that was removed
  std::vector<PictureLine> bone;    // surface of the bone before the cut
  PictureLine line;                 // the line to follow
  // The part to show.
  double left_mm = 0;
  double right_mm = 0;
  double bottom_mm = 0;
  double top_mm = 0;

  bool operator==(const CutView&) const = default;
};

struct CutPicture {
  /// Seen in the direction into the bone; y is across the cut (WantedCut::across_W), 0 on the line. Shows the cuts at
  /// least one voxel below the surface.
  CutView above;
  /// Seen across the cut; y is -depth, 0 at the line. `bone` is the section in the wanted plane.
  CutView side;
  double scale_bar_mm = 0;  // length of a scale bar that fits both views

  bool operator==(const CutPicture&) const = default;
};

/// Makes the outlines. `cells`: FindRemoved(before, after). Error of an outline: a tenth of a voxel at flat walls, half
/// a voxel at edges. Takes a few tenths of a second.
CutPicture MakeCutPicture(const Bone& before, const Bone& after, const WantedCut& cut,
                          std::span<const RemovedCell> cells);

/// Draws one view. The wanted cut is dashed and blue, the one made solid and orange, so that they can be distinguished
/// without colour. `title` is placed above it, `wanted` and `made` name the outlines. Both axes have the same scale.
struct CutViewTexts {
  std::string title;
  std::string wanted = "wanted";
  std::string made = "made";
  std::string x_label = "along the line (mm)";
  std::string y_label;
};
/// Returns the texts in English.
CutViewTexts AboveTexts();
CutViewTexts SideTexts();
/// Throws kerf::Error if this machine cannot draw. `width`: pixels, as in PlotSpec. `frame` (optional): as in
/// RenderPlot().
Image RenderCutView(const CutView& view, const CutViewTexts& texts, int width, PlotFrame* frame = nullptr);
/// Returns the same picture as SVG, without XML header, for a page.
std::string FormatCutViewSvg(const CutView& view, const CutViewTexts& texts, int width, PlotFrame* frame = nullptr);

}  // namespace kerf
