// Check that the values of a volume are Hounsfield units, and conversion of grey values to their scale.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bone/import/volume.h"
#include "kerf/describe.h"
#include "kerf/error.h"

namespace kerf {

/// Values of a CT that are a linear function of HU, by the peaks of air and soft tissue in its histogram.
struct GreyScale {
  double air = -1000;
  double soft = 40;
  double CalcScale() const { return (soft - air) / 1040; }  // values per HU
  double FromHu(double hu) const { return air + (hu + 1000) * CalcScale(); }
  double ToHu(double value) const { return (value - air) / CalcScale() - 1000; }
};

/// The values of a CT are no Hounsfield units, and the threshold of bone does not fit them. Another one may.
class NotHu : public Error {
 public:
  /// `what`: for a terminal, with options of kerf import. `why`: the reason alone, in words. `proposed_iso`: a
  /// threshold of bone in the CT's own values.
  NotHu(const std::string& what, std::string why, double proposed_iso, const GreyScale& scale)
      : Error(what), why_(std::move(why)), proposed_iso_(proposed_iso), scale_(scale) {}
  const std::string& why() const { return why_; }
  double proposed_iso() const { return proposed_iso_; }
  const GreyScale& scale() const { return scale_; }

 private:
  std::string why_;
  double proposed_iso_;
  GreyScale scale_;
};

/// How often the values of a CT occur: the fractions of its voxels in equal bins, which nearly all voxels lie in.
struct ValueHistogram {
  double lower = 0, upper = 1;  // of all bins
  std::vector<double> fractions;
  double CalcMiddle(std::size_t bin) const {
    return lower + (static_cast<double>(bin) + 0.5) * (upper - lower) / static_cast<double>(fractions.size());
  }
};

/// Counts at most about a million voxels. The bins reach at least from `within.lower` to `within.upper`.
ValueHistogram CalcHistogram(const Volume& ct, std::size_t bins, const Range& within);

/// Finds the scale of a CT whose values are no HU, such as the grey values of a cone-beam CT: its histogram has peaks
/// of air and of soft tissue that are not near -1000 and 40, and bone above them. Returns nothing for HU, for label
/// maps and for what has no such peaks.
std::optional<GreyScale> FindGreyScale(const Volume& ct);

/// The surface of bone in a CT's own values, and in the values that the import uses.
struct BoneLevel {
  double iso = 300;      // in the file's values
  double iso_hu = 300;   // in the volume's values after TakeAsHu()
  bool is_grey = false;  // the values were converted
  std::string warning;   // one sentence; empty for HU
};

/// Converts the values of a CT that are no HU to approximate HU, in which soft tissue has 40 and air -1000, so that all
/// thresholds of tissues apply. `iso`: the bone's surface in the file's values; with `automatic` it is that of 300 HU
/// instead. Throws kerf::Error, with `name` in the message, for a label map (2 to 128 different integers from 0 to 255,
/// in regions) unless `iso` is within their range, and NotHu if `iso` cannot separate bone in values that are no HU.
BoneLevel TakeAsHu(Volume& ct, double iso, bool automatic, const std::string& name);

/// Returns the warning of TakeAsHu() for the volume, which stays as it is.
std::string CheckHu(const Volume& ct, double iso_hu, const std::string& name);

}  // namespace kerf
