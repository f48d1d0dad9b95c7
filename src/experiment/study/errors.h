// Computation of errors: between two series of forces, and between two cut surfaces.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "experiment/study/case.h"
#include "experiment/study/records.h"

namespace kerf {

inline constexpr double kNoiseAbove_Hz = 20;

/// Takes the forces of a case and of its reference at the ends of the same ticks, dt_s apart, N. Fills the force
/// errors; see ErrorFigures. A reference without any force counts as kMinForce_N. Both series must have the same
/// length.
void CalcForceErrors(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, double dt_s, ErrorFigures& errors);

/// Time after which |f| stays below a tenth of its peak, s. The first sample is at dt_s; samples are interpolated
/// linearly. Returns nullopt if there is no force or it never stays below.
std::optional<double> FindBreakthrough(std::span<const Vec3> f_N, double dt_s);

/// |removed - reference| / reference, or the removed volume in mm^3 if the reference removes nothing.
double CalcVolumeError(double removed_mm3, double reference_mm3);

/// Returns the reference at the ends of `count` ticks of 1 / rate_hz. On a path, the mean over each tick; with a hand,
/// the force at its end.
std::vector<Vec3> SampleReference(const StudyReference& reference, Holding holding, double rate_hz, std::size_t count);

/// Takes the distances, mm, >= 0, from one surface to the other and back. Computes the mean over both directions, and
/// the larger of the two percentiles and maxima. All are zero if one direction has no distances.
void CalcSurfaceErrors(std::vector<double> there_mm, std::vector<double> back_mm, ErrorFigures& errors);

/// Width of the rim with which the reference's disc cuts, mm; 0: all of the disc cuts.
double GetReferenceEdge_mm(Holding holding, const DiscSaw& saw);

/// Nearest rank; 0 if there are no values.
double CalcPercentile(std::vector<double> values, double fraction);

/// Stores the symmetric distance between the cut surface of `bone` and the exact one in `errors`. On the bone's
/// surface, only points inside the uncut solid are used: elsewhere it is not cut. On the exact surface, points of the
/// disc's outline along its path are used, projected onto the surface.
void CalcCutSurfaceErrors(const Bone& bone, const ExactBone& exact, std::span<const ReferenceTick> ticks,
                          const DiscSaw& saw, double edge_mm, ErrorFigures& errors);

}  // namespace kerf
