// The diagrams of a study.
#pragma once

#include <string>
#include <vector>

#include "experiment/study/pooled.h"
#include "view/plot/plot.h"

namespace kerf {

struct StudyFigure {
  std::string name;     // of its files, without extension
  std::string caption;  // for the report: what it shows, and how it is to be read
  PlotSpec plot;
};

/// Per holding: work_precision_* (slowest and worst path), near_* (its middle), typical_* (medians), worst_pose_*,
/// slab_voxel_*, convergence_KNOB_*, volume_* and surface_* against the voxel; those for which there are figures.
std::vector<StudyFigure> MakeStudyFigures(const StudyResults& study);

/// Error against number, one for each knob that has numbers, and of volume and surface against the voxel's edge.
std::vector<StudyFigure> MakeKnobFigures(const StudyResults& study, Holding holding);

/// Of all diagrams: size, logarithmic axes.
PlotSpec MakeStudyPlot();
/// Colour and mark of a knob, the same in every diagram.
MarkerStyle StyleOfKnob(const std::string& knob);
/// "tool in a hand", "tool led along its path".
std::string DescribeHolding(Holding holding);
/// Lines at 3.5 % and 7 % of force; `at_start`: with their words on the left.
void AddForceLines(PlotSpec& plot, bool at_start);

inline constexpr const char* kWorstPath = "worst";  // the name of the path whose pose is the hardest

}  // namespace kerf
