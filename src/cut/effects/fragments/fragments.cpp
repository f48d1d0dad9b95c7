// fragments: what the cut takes off becomes a piece with a number.
//
//   Voxels with phi < 0 that share a face belong together. A piece is connected bone of at least dust_mm3; less is
//   dust, which is counted.
// The effect itself leaves every piece where it is, part of the one bone volume: the force cannot tell that it came
// off. Whoever runs the simulation takes out what the parameters say, while the tool is clear of it.
#include "cut/effects/fragments/fragments.h"

#include "cut/effects/effects.h"

namespace kerf {

FragmentsEffect::FragmentsEffect(const FragmentsParams& params, const EffectSetup& setup) : watch_(setup.bone, params) {
  Tell();
  pieces_ = told_pieces_;
  crumbs_ = told_crumbs_;
}

void FragmentsEffect::End(EffectEnd&) {
  pieces_ = told_pieces_.load(std::memory_order_relaxed);
  crumbs_ = told_crumbs_.load(std::memory_order_relaxed);
}

void FragmentsEffect::Report(std::span<double> channels) const {
  channels[0] = pieces_;
  channels[1] = crumbs_;
}

std::size_t FragmentsEffect::Look(double time_s) {
  const std::size_t count = watch_.Look(time_s);
  Tell();
  return count;
}

void FragmentsEffect::Tell() {
  const FoundPieces& found = watch_.finder().found();
  told_pieces_.store(static_cast<int>(found.pieces.size()), std::memory_order_relaxed);
  told_crumbs_.store(static_cast<int>(found.dust_count), std::memory_order_relaxed);
}

const EffectInfo& Fragments() {
  static const EffectInfo kEffect{
      .name = "fragments",
      .summary = "what the cut takes off: pieces found off the haptic thread, numbered, with volume, place and region",
      .source = "connected voxels, by shared faces",
      .reads = "changed leaves of the bone, between ticks",
      .writes = "events: a piece came off; nothing that is felt",
      .state =
          "connected parts of each leaf that holds bone: some 150 bytes a leaf, 4 for each leaf of the bone's box; 29 "
          "MB for a mandible at 0.1 mm",
      .sleeps = "in the tick always; while nothing is cut a look is one comparison",
      .hooks = kEffectEnd,
      .parameters =
          {{"dust_mm3", 1.0, 0, 1e6,
            "what is smaller is dust: counted, told by no event; an assumption, as smallest_piece_mm3 of [output]"},
           {"every_ms", 50.0, 1, 10000, "between two looks at what was cut"},
           {"apart_mm", 6.0, 0, 1000, "in fragments.png, and where they are moved: so far away from the largest"},
           {"pieces",
            std::string("held"),
            0,
            0,
            "what becomes of each but the largest once the tool is clear of it: stays in the bone, is set aside, is "
            "out "
            "of the way and not drawn, is gone",
            {"held", "moved", "hidden", "deleted"}},
           {"move_mm", Vec3(0), -1000, 1000, "how pieces are moved; 0: apart_mm along the line between the middles"},
           {"remove_dust", false, 0, 0, "take dust out of the bone once the tool is clear of all of it"}},
      .channels = {{"pieces", "of at least dust_mm3, as found last"}, {"crumbs", "smaller ones, likewise"}},
      .make = [](std::span<const EffectValue> values, const EffectSetup& setup) -> std::unique_ptr<Effect> {
        FragmentsParams params;
        params.dust_mm3 = std::get<double>(values[0]);
        params.every_ms = std::get<double>(values[1]);
        params.apart_mm = std::get<double>(values[2]);
        const std::string& fate = std::get<std::string>(values[3]);
        for (std::size_t i = 0; i < std::size(kPieceFates); ++i) {
          if (fate == kPieceFates[i]) params.pieces = static_cast<PieceFate>(i);
        }
        params.move_mm = std::get<Vec3>(values[4]);
        params.remove_dust = std::get<bool>(values[5]);
        return std::make_unique<FragmentsEffect>(params, setup);
      }};
  return kEffect;
}

}  // namespace kerf
