// The diagrams of a study.
#pragma once

#include <string>
#include <vector>

#include "experiment/study/pooled.h"
#include "view/plot/plot.h"

namespace kerf {

struct StudyFigure {
  std::string name;     // name of its files, without extension
  std::string caption;  // what it shows and how to read it, for the report
  PlotSpec plot;
};

/// Returns the figures for each holding: work_precision_* (slowest and worst path), near_* (a detail of that),
/// typical_* (medians), worst_pose_*, slab_voxel_*, convergence_KNOB_*, and volume_* and surface_* as functions of the
/// voxel size. Figures without data are left out.
std::vector<StudyFigure> MakeStudyFigures(const StudyResults& study);

/// Returns a diagram of the error as a function of the knob's number for each numeric knob, and diagrams of the volume
/// and surface errors as functions of the voxel edge.
std::vector<StudyFigure> MakeKnobFigures(const StudyResults& study, Holding holding);

/// Returns an empty diagram with the properties that all diagrams share: its size and logarithmic axes.
PlotSpec MakeStudyPlot();
/// Returns the colour and the marker of a knob, which are the same in every diagram.
MarkerStyle StyleOfKnob(const std::string& knob);
/// Returns "tool coupled to a handle" or "tool on a prescribed path".
std::string DescribeHolding(Holding holding);
/// Adds lines at force errors of 3.5 % and 7 %. If `at_start` is true, their labels are on the left.
void AddForceLines(PlotSpec& plot, bool at_start);

inline constexpr const char* kWorstPath = "worst";  // name of the path with the worst-case pose

}  // namespace kerf
