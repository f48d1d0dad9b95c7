// The diagrams of a study.
#pragma once

#include <string>
#include <vector>

#include "experiment/study/pooled.h"
#include "view/plot/plot.h"

namespace kerf {

struct StudyFigure {
  std::string name;     // name of its files, without extension
  std::string caption;  // for the report: its content and how to read it
  PlotSpec plot;
};

/// Returns the figures for each holding: work_precision_* (slowest and worst path), near_* (detail of it),
/// typical_* (medians), worst_pose_*, slab_voxel_*, convergence_KNOB_*, volume_* and surface_* against the voxel size.
/// Figures without data are left out.
std::vector<StudyFigure> MakeStudyFigures(const StudyResults& study);

/// Returns diagrams of the error against the knob's number, one for each numeric knob, and of volume and surface
/// against the voxel edge.
std::vector<StudyFigure> MakeKnobFigures(const StudyResults& study, Holding holding);

/// Common properties of all diagrams: size, logarithmic axes.
PlotSpec MakeStudyPlot();
/// Colour and mark of a knob, the same in every diagram.
MarkerStyle StyleOfKnob(const std::string& knob);
/// "tool coupled to a handle", "tool on a prescribed path".
std::string DescribeHolding(Holding holding);
/// Adds lines at 3.5 % and 7 % of force; `at_start`: with their labels on the left.
void AddForceLines(PlotSpec& plot, bool at_start);

inline constexpr const char* kWorstPath = "worst";  // name of the path with the worst-case pose

}  // namespace kerf
