#include "cut/contact/met_material.h"

#include <algorithm>
#include <cstddef>

#include "bone/grid/grids.h"
#include "cut/force/laws.h"

namespace kerf {

void CheckTissues(const ForceLaw& law, const Bone& bone) {
  if (!LacksTissue(law)) return;
  MaterialTable occurring;
  for (const auto& [id, volume_mm3] : bone.CalcRegionVolumes()) {
    if (volume_mm3 > 0 && bone.materials().Contains(id)) occurring.Add(bone.materials().At(id));
  }
  CheckTissues(law, occurring);
}

MaterialLookup::MaterialLookup(const Bone& bone, const Tool& tool)
    : by_ct_(GridsOf(bone).by_modulus),
      any_by_ct_(GridsOf(bone).modulus != nullptr),
      tool_E_MPa_(CalcModulus(tool)),
      tool_nu_(CalcPoissonRatio(tool)) {
  for (const auto& [id, region] : bone.materials().regions()) {
    moduli_.a[id] = region.E_MPa;
    nu_[id] = region.nu;
    tissue_[id] = static_cast<std::uint8_t>(CutTissue(region.tissue));
    moduli_.b[id] = CalcReducedModulus(tool_E_MPa_, tool_nu_, region.E_MPa, region.nu);
  }
}

int MaterialLookup::Find(const BoneField& field, const Vec3& p_W, unsigned reads, ToothCut& cut) const {
  const BoneField::RegionCell cell = field.FindRegionCell(p_W);
  const double E_ct_MPa = any_by_ct_ ? field.ModulusAt(p_W) : 0;
  // The sums are local: in `cut` each addition would wait for the last one to reach memory.
  double sum = 0;
  double E_MPa = 0;
  double E_star_MPa = 0;
  const int first = cell.regions[0];
  const bool is_one = std::all_of(cell.regions.begin(), cell.regions.end(), [first](int id) { return id == first; });
  if (is_one && IsRegion(first) && !(E_ct_MPa > 0 && by_ct_[first])) {
    const double E_of_first = moduli_.a[first];
    const double E_star_of_first = moduli_.b[first];
    for (std::size_t corner = 0; corner < cell.regions.size(); ++corner) {
      const double weight = CalcCornerWeight(corner, cell.f);
      sum += weight;
      E_MPa += weight * E_of_first;
      E_star_MPa += weight * E_star_of_first;
    }
    cut.E_MPa = E_MPa / sum;
    cut.E_star_MPa = E_star_MPa / sum;
    if ((reads & kReadsTissue) != 0) cut.tissue[tissue_[first]] = 1;
    return first;
  }
  int region = 0;
  double largest = 0;
  VisitRegions(cell.regions, cell.f, [&](int id, double weight) {
    sum += weight;
    if (E_ct_MPa > 0 && by_ct_[id]) {
      E_MPa += weight * E_ct_MPa;
      E_star_MPa += weight * CalcReducedModulus(tool_E_MPa_, tool_nu_, E_ct_MPa, nu_[id]);
    } else {
      E_MPa += weight * moduli_.a[id];
      E_star_MPa += weight * moduli_.b[id];
    }
    if ((reads & kReadsTissue) != 0) cut.tissue[tissue_[id]] += weight;
    if (weight > largest) {
      largest = weight;
      region = id;
    }
  });
  if (!(sum > 0)) return 0;
  cut.E_MPa = E_MPa / sum;
  cut.E_star_MPa = E_star_MPa / sum;
  if ((reads & kReadsTissue) != 0) {
    for (double& fraction : cut.tissue) fraction /= sum;
  }
  return region;
}

}  // namespace kerf
