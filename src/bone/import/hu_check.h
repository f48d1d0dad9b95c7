// Check that the values of a volume are Hounsfield units.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "bone/import/volume.h"
#include "kerf/error.h"

namespace kerf {

/// The values of a CT are no Hounsfield units, and the threshold of bone does not fit them. Another one may.
class NotHu : public Error {
 public:
  /// `what`: for a terminal, with options of kerf import. `why`: the reason alone, in words. `proposed_iso`: a
  /// threshold of bone in the CT's own values.
  NotHu(const std::string& what, std::string why, double proposed_iso)
      : Error(what), why_(std::move(why)), proposed_iso_(proposed_iso) {}
  const std::string& why() const { return why_; }
  double proposed_iso() const { return proposed_iso_; }

 private:
  std::string why_;
  double proposed_iso_;
};

/// Recognises a label map (2 to 128 different integers from 0 to 255) and a CT without its offset of -1024 (air near 0,
/// soft tissue near 1000 to 1100). Throws kerf::Error (NotHu for the CT), with `name` in the message, if `iso_hu`
/// cannot separate bone in such a volume: for labels if it is outside their range, for the CT if it is below the soft
/// tissue. Returns a warning sentence if `iso_hu` fits the values of such a volume, and "" if the values are HU.
std::string CheckHu(const Volume& ct, double iso_hu, const std::string& name);

}  // namespace kerf
