// The pictures of a run.
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

/// Of a piece, where it was cut off: for its file and for the pictures.
struct PieceSurface {
  TriangleMesh mesh_W;  // for the file
  Shape shape;          // for the pictures: finer, with the tissues' colours
  std::vector<LegendEntry> legend;
  std::size_t full_triangles = 0;
};

/// Reduced to `error_mm` (mesh/reduce.h), and for the pictures to a quarter of that. As it is for 0.
PieceSurface MakePieceSurface(const Bone& piece, double error_mm);

/// Gets each result by its name and what writes it; may catch what that throws.
using ResultSink = std::function<void(const std::string& name, const std::function<void()>& write)>;
inline void JustWrite(const std::string&, const std::function<void()>& write) {
  write();
}

/// What the pictures are made from.
struct RunPictures {
  const Scene& scene;
  const std::vector<TickRecord>& ticks;
  const Bone& before;
  const Bone& after;
  const std::vector<Bone>& pieces;
  std::string folder;
  bool force_plot = true;                       // of force against depth
  bool apart = true;                            // the pieces apart from each other
  std::span<const PieceOut> out = {};           // taken out; those set aside are drawn there
  std::span<const PieceSurface> surfaces = {};  // of `pieces`, in their order
  ResultSink sink = JustWrite;                  // each picture goes through it
};

/// Writes before.png and after.png; cut.png and, if asked for, force.png when the saw met bone; apart.png when there is
/// more than one piece. Returns their names. A picture that would show no bone is not written; a sentence in `warnings`
/// says so.
std::vector<std::string> WriteRunPictures(const RunPictures& run, const std::function<void(double)>& progress,
                                          std::vector<std::string>& warnings);

/// Whether the scene asks for pictures and this build can draw them; a sentence in `warnings` where it can't.
bool AreDrawn(const Scene& scene, std::vector<std::string>& warnings);

/// Whether the scene's bone lies as in a patient: orientation and captions go by it.
bool IsOfPatient(const Scene& scene);

/// Magnitude of the force against depth, a curve a stroke, over bands of the region that carries most of it.
PlotSpec MakeForcePlot(const std::vector<TickRecord>& ticks, const MaterialTable& materials, const std::string& name);

}  // namespace kerf
