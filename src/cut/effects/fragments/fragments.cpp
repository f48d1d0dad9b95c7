// fragments: bone that a cut separates becomes a numbered piece.
//
//   Voxels with phi < 0 that share a face are connected. A piece is connected bone of at least dust_mm3; smaller parts
//   are crumbs, which are only counted.
//
// The effect itself leaves every piece in place, as part of the one bone volume, so that the separation has no effect
// on the force. The owner of the simulation takes out the pieces that the parameters select, while the tool is clear of
// them.
#include "cut/effects/fragments/fragments.h"

#include "cut/effects/effects.h"
#include "cut/effects/parameters.h"

namespace kerf {

FragmentsEffect::FragmentsEffect(const FragmentsParams& params, const EffectSetup& setup) : watch_(setup.bone, params) {
  PublishCounts();
  pieces_ = reported_pieces_;
  crumbs_ = reported_crumbs_;
}

void FragmentsEffect::End(EffectEnd&) {
  pieces_ = reported_pieces_.load(std::memory_order_relaxed);
  crumbs_ = reported_crumbs_.load(std::memory_order_relaxed);
}

void FragmentsEffect::Report(std::span<double> channels) const {
  channels[0] = pieces_;
  channels[1] = crumbs_;
}

std::size_t FragmentsEffect::Look(double time_s) {
  const std::size_t count = watch_.Look(time_s);
  PublishCounts();
  return count;
}

void FragmentsEffect::PublishCounts() {
  const FoundPieces& found = watch_.finder().found();
  reported_pieces_.store(static_cast<int>(found.pieces.size()), std::memory_order_relaxed);
  reported_crumbs_.store(static_cast<int>(found.dust_count), std::memory_order_relaxed);
}

const EffectInfo& Fragments() {
  static const EffectInfo kEffect{
      .name = "fragments",
      .summary =
          "pieces that the cut separates: found outside the haptic thread, with number, volume, place and region",
      .source = "connected components of voxels that share faces",
      .reads = "changed leaves of the bone, between ticks",
      .writes = "events when a piece comes off; no force",
      .state =
          "connected parts of each leaf that contains bone: about 150 bytes per leaf, 4 for each leaf of the bone's "
          "box; 29 MB for a mandible at 0.1 mm",
      .sleeps = "always in the tick; outside it, a check costs one comparison while nothing is cut",
      .hooks = kEffectEnd,
      .parameters = ListEffectParameters<FragmentsParams>(),
      .channels = {{"pieces", "pieces of at least dust_mm3, at the last check"},
                   {"crumbs", "pieces below dust_mm3, at the last check"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        return std::make_unique<FragmentsEffect>(ReadEffectParameters<FragmentsParams>(values), setup);
      }};
  return kEffect;
}

}  // namespace kerf
