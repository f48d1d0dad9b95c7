// Pictures of a run.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "kerf/bone.h"
#include "session/run/run.h"
#include "session/scene/scene.h"
#include "view/picture/picture.h"
#include "view/plot/plot.h"

namespace kerf {

/// Surface of a piece, at the place where it was cut off, for its file and for the pictures.
struct PieceSurface {
  TriangleMesh mesh_W;  // for the file
  Shape shape;          // for the pictures, with the tissues' colours
  std::vector<LegendEntry> legend;
};

/// Makes the surface, reduced with an error of at most `error_mm` (mesh/reduce.h); 0: not reduced. For the pictures it
/// is reduced only if it has more than a million triangles. `has_file`: false if only they need it. `progress` is
/// called with values from 0 to 1.
PieceSurface MakePieceSurface(const Bone& piece, double error_mm, bool has_file,
                              const std::function<void(double)>& progress);

/// Called with the name of each result and the function that writes it; may catch its exceptions.
using ResultSink = std::function<void(const std::string& name, const std::function<void()>& write)>;
inline void JustWrite(const std::string&, const std::function<void()>& write) {
  write();
}

/// What the bone consists of after the run.
struct DrawnPieces {
  std::span<const PieceSurface> surfaces;
  const Bone* dust = nullptr;
};

/// Inputs of the pictures.
struct RunPictures {
  const Scene& scene;
  const std::vector<TickRecord>& ticks;
  const Bone& before;
  double volume_before_mm3;
  const Bone& after;
  std::function<DrawnPieces()> make_pieces;  // called once, after before.png is drawn
  std::string folder;
  bool force_plot = true;              // plot of force against depth
  bool apart = true;                   // the separated pieces
  std::span<const PieceOut> out = {};  // taken out; pieces that are set aside are drawn where they are
  ResultSink sink = JustWrite;         // each picture is written through it
};

/// Progress of WriteRunPictures() at which before.png is drawn.
inline constexpr double kBeforeDrawn = 0.4;

/// Writes before.png and after.png; if the saw touched bone, cut.png and, if requested, force.png; if there is more
/// than one piece, apart.png. Returns the names of the files. A picture that would show no bone is not written, and a
/// sentence is added to `warnings`.
std::vector<std::string> WriteRunPictures(const RunPictures& run, const std::function<void(double)>& progress,
                                          std::vector<std::string>& warnings);

/// Returns the ways along an axis that pieces at these places on it are moved, so that each comes `gap_mm` further from
/// the next: two pieces that an earlier cut has separated may lie on the same side of this one. Their mean is 0.
std::vector<double> CalcWaysApart(std::span<const double> places_mm, double gap_mm);

/// Returns true if the scene requests pictures and this build and machine can draw them. If they can't, adds a sentence
/// to `warnings`.
bool AreDrawn(const Scene& scene, std::vector<std::string>& warnings);

/// Returns true if the scene's bone is in the patient's frame, which determines orientation and captions.
bool IsOfPatient(const Scene& scene);

/// Plots the magnitude of the force against depth, one curve per stroke, with bands in the background that show which
/// region carries most of it. A force that changes faster than the plot can show is plotted as its mean and its range.
PlotSpec MakeForcePlot(const std::vector<TickRecord>& ticks, const MaterialTable& materials, const std::string& name,
                       const Tool& tool);

}  // namespace kerf
