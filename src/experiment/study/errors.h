// Computation of errors: between two series of forces, and between two cut surfaces.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "experiment/study/case.h"
#include "experiment/study/records.h"

namespace kerf {

/// ErrorFigures::noise_N contains only frequencies above this.
inline constexpr double kNoiseAbove_Hz = 20;

/// Computes the force errors of ErrorFigures from the forces, N, of a case and of its reference at the ends of the same
/// ticks, which are dt_s apart. If the reference has no force at all, its force counts as kMinForce_N. Both series must
/// have the same length.
void CalcForceErrors(std::span<const Vec3> f_N, std::span<const Vec3> reference_N, double dt_s, ErrorFigures& errors);

/// Returns the time, s, after which |f| stays below a tenth of its peak. The first sample is at dt_s; samples are
/// interpolated linearly. Returns nullopt if there is no force or if the last sample is not below a tenth of the peak.
std::optional<double> FindBreakthrough(std::span<const Vec3> f_N, double dt_s);

/// Returns |removed - reference| / reference, or the removed volume in mm^3 if the reference removes nothing.
double CalcVolumeError(double removed_mm3, double reference_mm3);

/// Returns the force of the reference in `count` ticks of 1 / rate_hz: on a path, the mean over each tick; with a hand,
/// the force at the end of each tick.
std::vector<Vec3> SampleReference(const StudyReference& reference, Holding holding, double rate_hz, std::size_t count);

/// Computes the surface errors from the distances, mm, >= 0, from one surface to the other and back: the mean of the
/// two means, the larger of the two percentiles and the larger of the two maxima. Leaves `errors` unchanged if one
/// direction has no distances.
void CalcSurfaceErrors(std::vector<double> there_mm, std::vector<double> back_mm, ErrorFigures& errors);

/// Returns the width of the rim with which the reference's disc cuts, mm, or 0 if the whole disc cuts.
double GetReferenceEdge_mm(Holding holding, const DiscSaw& saw);

/// Stores the symmetric distance between the cut surface of `bone` and the exact one in `errors`. Of the bone's
/// surface, only points inside the uncut solid are used, because the rest of it is not cut. The points on the exact
/// surface are points of the disc's outline along its path, projected onto that surface.
void CalcCutSurfaceErrors(const Bone& bone, const ExactBone& exact, std::span<const ReferenceTick> ticks,
                          const DiscSaw& saw, double edge_mm, ErrorFigures& errors);

}  // namespace kerf
