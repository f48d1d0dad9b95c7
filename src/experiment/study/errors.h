// The arithmetic of errors: two series of forces, and two cut surfaces.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "experiment/study/case.h"
#include "experiment/study/records.h"

namespace kerf {

inline constexpr double kNoiseAbove_Hz = 20;

/// Forces of a case and of its reference at the ends of the same ticks, dt_s apart, N. Fills what is of forces; see
/// ErrorFigures. A reference without any force counts as kLeastForce_N. Both series must be of one length.
void CalcForceErrors(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, double dt_s, ErrorFigures& errors);

/// When |f| falls below a tenth of its peak for good, s; the first sample stands at dt_s, and between samples it goes
/// straight. None when there is no force, or it never does.
std::optional<double> FindBreakthrough(std::span<const Vec3> f_N, double dt_s);

/// |removed - reference| / reference; where the reference removes nothing, what was removed in mm^3.
double CalcVolumeError(double removed_mm3, double reference_mm3);

/// The reference at the ends of `count` ticks of 1 / rate_hz. On a path, the mean over each tick; in a hand, what was
/// felt at its end.
std::vector<Vec3> SampleReference(const StudyReference& reference, Holding holding, double rate_hz, std::size_t count);

/// Distances, mm, >= 0, from one surface to the other and back: means over both, percentile and maximum the worse of
/// the two. Zeros when one side has none.
void CalcSurfaceErrors(std::vector<double> there_mm, std::vector<double> back_mm, ErrorFigures& errors);

/// How far inside its rim the reference's disc cuts, mm; 0: all of it does.
double GetReferenceEdge_mm(Holding holding, const DiscSaw& saw);

/// Nearest rank; 0 for none.
double CalcPercentile(std::vector<double> values, double share);

/// Symmetric distance of the cut surface of `bone` from the exact one, into `errors`. Of the bone's surface, points
/// that lie inside the uncut solid: elsewhere it is not cut. Of the exact one, points of the disc's outline along its
/// way, moved on to the surface.
void CalcCutSurfaceErrors(const Bone& bone, const ExactBone& exact, std::span<const ReferenceTick> ticks,
                          const DiscSaw& saw, double edge_mm, ErrorFigures& errors);

}  // namespace kerf
