#include "cut/removal/paced_cutter.h"

#include <algorithm>

#include "cut/tool/shape.h"

namespace kerf {
namespace {

constexpr double kMaxLead = 0.25;  // maximum lead of the tool over its cut, in voxels or thicknesses of a thinner blade

double CalcMaxLead(const Tool& tool, double voxel_mm) {
  return kMaxLead * (IsBlade(tool) ? std::min(CalcThickness(tool), voxel_mm) : voxel_mm);
}

}  // namespace

PacedCutter::PacedCutter(Cutter& cutter, const Tool& tool, double reach_mm, double voxel_mm, int interval_ticks)
    : cutter_(&cutter), reach_mm_(reach_mm), max_mm_(CalcMaxLead(tool, voxel_mm)), interval_(interval_ticks) {}

Cutter::Result PacedCutter::Cut(const Pose& X_from, const Pose& X_to, const SlideRange& slide) {
  if (interval_ == 1) return cutter_->Cut(X_from, X_to, slide);
  Cutter::Result before;
  // If the tool turns back, a single sweep from X_cut_ to its new pose would miss the point of return.
  if (waits_ && glm::dot(X_from.p_AB - X_cut_.p_AB, X_to.p_AB - X_from.p_AB) < 0) before = Flush(X_from);
  if (before.out_of_leaves) return before;
  if (!waits_) {
    X_cut_ = X_from;
    slide_ = slide;
    ticks_ = 0;
  }
  slide_ = {std::min(slide_.least_mm, slide.least_mm), std::max(slide_.most_mm, slide.most_mm)};
  waits_ = true;
  if (ticks_ + 1 < interval_ && CalcTravel(X_cut_, X_to, reach_mm_) <= max_mm_) return before;
  Cutter::Result result = Flush(X_to);
  result.removed_mm3 += before.removed_mm3;
  return result;
}

Cutter::Result PacedCutter::Flush(const Pose& X_to) {
  if (!waits_) return {};
  const Cutter::Result result = cutter_->Cut(X_cut_, X_to, slide_);
  waits_ = result.out_of_leaves;
  return result;
}

}  // namespace kerf
