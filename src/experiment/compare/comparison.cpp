#include "experiment/compare/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>

#include "base/files/peak_memory.h"
#include "cut/force/measured.h"
#include "experiment/compare/run_cases.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "session/run/run_slab.h"
#include "session/run/run_slab_scene.h"
#include "session/scene/path.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

/// With more bins than this, the depth steps would be smaller than the motion in any tick.
constexpr double kMaxBins = 200'000;
constexpr int kFewestBins = 2;

CompareCase VoxelCase(const ForceLaw& law) {
  CompareCase what;
  what.id = fmt::format("voxel_{}", law.name());
  what.label = fmt::format("voxel {}", law.name());
  what.law = law;
  return what;
}

CompareCase SlabCase(PaperReading reading) {
  CompareCase what;
  what.slab = true;
  what.reading = reading;
  what.id = fmt::format("slab_{}", ToString(reading));
  what.label = reading == PaperReading::kAsComputed ? "slab as computed" : "slab corrected";
  return what;
}

bool HasLaw(const CompareCase& what, const ForceLaw& law) {
  return !what.slab && std::string_view(what.law.name()) == law.name() && what.law.values() == law.values();
}

void CheckScene(const Scene& scene) {
  if (!std::holds_alternative<DiscSaw>(scene.tool.shape)) {
    throw Error(fmt::format("{}: slab mode, with which the scene is compared, requires a disc, not a {}", scene.name,
                            DescribeToolBriefly(MakeTool(scene))));
  }
  if (!scene.slab.given) {
    const Path path = MakePath(scene);
    const PathSegment& first = path.segments().front();
    const Vec3 motion = path.CalcPose(0, first.end_s).p_AB - path.CalcPose(0, first.start_s).p_AB;
    const double length_mm = glm::length(motion);
    std::string hint;
    if (length_mm > 0) {
      const Vec3 d = motion / length_mm + Vec3(0.0);  // the sum turns -0 into 0
      hint = fmt::format(" = [{:.4g}, {:.4g}, {:.4g}], the direction of its first stroke, or another", d.x, d.y, d.z);
    }
    throw Error(
        fmt::format("{}: to compare with slab mode the scene needs the cut direction; add [slab] with direction{}",
                    scene.name, hint));
  }
  if (scene.tool.rpm == 0) throw Error(fmt::format("{}: rpm = 0: a stopped saw makes no cut to compare", scene.name));
  if (scene.slab.hold != SlabBody::kSlice) {
    throw Error(
        fmt::format("{}: [slab] hold = \"{}\" leaves the blade where the path starts, but a comparison must move it "
                    "along the path; set hold = \"slice\"",
                    scene.name, scene.slab.hold == SlabBody::kLeft ? "left" : "right"));
  }
}

std::string FileName(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

/// Sets the source of the bone's stiffness, for the user and as JSON. Files are given without the folders of this
/// machine.
void SetMaterial(Comparison& c, Scene scene, const MaterialSummary& material) {
  scene.bone.materials = FileName(scene.bone.materials);
  c.material_json = MaterialJson(scene, material);
  if (material.kind == MaterialKind::kRegions) {
    const std::string from = scene.bone.materials.empty() ? "the bone's own table" : scene.bone.materials;
    c.material = fmt::format("E by region, from {}", from);
    return;
  }
  c.material = DescribeMaterial(scene, material);
  if (material.kind == MaterialKind::kCt) {
    const auto [low, high] = CalcValidHu(material.law);
    c.material += fmt::format(" ({:.0f} to {:.0f} HU)", low, high);
  }
}

/// Adds quotes if a shell could split the word or interpret characters in it.
std::string Quote(const std::string& word) {
  const bool plain = word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-,+") ==
                     std::string::npos;
  if (plain) return word;
  std::string quoted = "'";
  for (const char letter : word) quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return quoted + "'";
}

std::string MakeCommand(const Scene& scene, const CompareParams& params, const std::string& scene_file) {
  const std::string file = scene_file.empty() ? scene.name + ".toml" : FileName(scene_file);
  std::string command = fmt::format("kerf compare {}", Quote(file));
  if (!params.laws.empty()) command += fmt::format(" --laws {}", fmt::join(params.laws, ","));
  return command + fmt::format(" --depth-step {} --repeat {}", params.depth_step_mm, params.repetitions);
}

/// Returns the entry that collects the bins of a region within the slice.
CompareRegion& RegionOf(std::vector<CompareRegion>& regions, int id) {
  const auto found = std::find_if(regions.begin(), regions.end(), [&](const CompareRegion& r) { return r.id == id; });
  if (found != regions.end()) return *found;
  regions.emplace_back().id = id;
  return regions.back();
}

void FindRegions(Comparison& c, const MaterialTable& materials) {
  c.region_of_bin.assign(c.grid.count, 0);
  const double rounding_mm = 1e-9 * c.grid.step_mm * static_cast<double>(c.grid.count);
  for (std::size_t i = 0; i < c.grid.count; ++i) {
    const double depth_mm = c.grid.Centre(i);
    const SlabProfile::Layer* layer = c.profile.Find(depth_mm);
    const double to_end_mm = c.profile.end_mm - depth_mm;
    if (to_end_mm <= -0.5 * c.grid.step_mm + rounding_mm || layer == nullptr) {
      c.beyond_bins.push_back(i);
      continue;
    }
    // In the bin in which the slice ends, the tool partly cuts and partly moves freely, so this bin belongs to neither
    // list.
    if (to_end_mm < 0.5 * c.grid.step_mm - rounding_mm) continue;
    c.slice_bins.push_back(i);
    c.region_of_bin[i] = layer->region;
    CompareRegion& region = RegionOf(c.regions, layer->region);
    if (region.bins.empty()) region.top_mm = depth_mm - 0.5 * c.grid.step_mm;
    region.bottom_mm = depth_mm + 0.5 * c.grid.step_mm;
    region.E_MPa += layer->E_MPa;  // a sum; divided by the number of bins further below
    region.bins.push_back(i);
  }
  if (c.slice_bins.empty()) {
    throw Error(fmt::format("{}: the slice is {:.3g} mm long, less than a depth step of {:g} mm; choose a smaller step",
                            c.scene, c.profile.end_mm, c.grid.step_mm));
  }
  for (CompareRegion& region : c.regions) {
    region.E_MPa /= static_cast<double>(region.bins.size());
    if (region.id == 0) {
      region.name = "gap without bone";
      region.tissue = "none";
    } else if (materials.Contains(region.id)) {
      region.name = materials.At(region.id).name;
      region.tissue = ToString(materials.At(region.id).tissue);
    } else {
      region.name = fmt::format("region {}", region.id);
      region.tissue = "unknown";
    }
  }
}

/// Selects the samples in which the tool goes deeper than before, and computes curves on the grid that all cases reach.
void MakeCurves(Comparison& c, const std::vector<std::vector<DepthSample>>& samples) {
  double deepest_mm = std::numeric_limits<double>::infinity();
  std::vector<std::vector<DepthSample>> advances;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    advances.push_back(TakeAdvance(samples[k]));
    deepest_mm = std::min(deepest_mm, advances.back().empty() ? 0 : advances.back().back().depth_mm);
  }
  const double bins = std::floor(std::max(0.0, deepest_mm) / c.grid.step_mm);
  if (bins > kMaxBins) {
    throw Error(fmt::format("{}: {:.0f} mm in steps of {} mm gives too many steps; choose larger steps", c.scene,
                            deepest_mm, c.grid.step_mm));
  }
  c.grid.count = static_cast<std::size_t>(bins);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    CaseResult& result = c.cases[k];
    result.ticks = samples[k].size();
    result.ticks_on_curve = advances[k].size();
    result.curve = CalcDepthCurve(advances[k], c.grid);
    const auto& force = result.curve.force_N;
    if (std::count_if(force.begin(), force.end(), [](double f) { return std::isfinite(f); }) < kFewestBins) {
      throw Error(
          fmt::format("{}: along direction = [{:g}, {:g}, {:g}] the disc goes less than {:g} mm into the bone, too "
                      "little to compare; the path must go into the bone along this direction",
                      c.scene, c.direction_W.x, c.direction_W.y, c.direction_W.z, kFewestBins * c.grid.step_mm));
    }
  }
}

void AddWarnings(Comparison& c, const Scene& scene, const MaterialSummary& material) {
  const auto add = [&](const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) {
      if (std::find(c.warnings.begin(), c.warnings.end(), warning) == c.warnings.end()) c.warnings.push_back(warning);
    }
  };
  Scene as = scene;
  as.simulation.mode = SceneMode::kVoxel;
  for (const CaseResult& result : c.cases) {
    if (result.what.slab) continue;
    as.force = result.what.law;
    add(FindWarnings(as, c.voxel_mm));
    add({fmt::format("{}: {}; {}; {}", as.force.name(), DescribeAccuracy(as.force, MakeTool(as)),
                     DescribeBlades(as.force, MakeTool(as)), FindCaveat(as.force.info()).good_for)});
  }
  as.simulation.mode = SceneMode::kSlab;
  as.force = ForceLaw();  // the laws of voxel mode do not apply to a slab, so no warning should mention one
  add(FindWarnings(as, c.voxel_mm));
  add({"slab: " + DescribeSlabLaw(scene)});
  add(material.warnings);
  const std::size_t compared = c.cases.back().slice.bins;
  const double compared_mm = c.grid.step_mm * static_cast<double>(compared);
  if (compared_mm < c.profile.end_mm - 2 * c.grid.step_mm) {
    c.warnings.push_back(fmt::format(
        "the path goes through {:.3g} mm of the slice's {:.3g} mm; statements about the slice apply to that part only",
        compared_mm, c.profile.end_mm));
  }
  for (const CaseResult& result : c.cases) {
    if (2 * result.curve.interpolated > c.grid.count) {
      c.warnings.push_back(
          fmt::format("{}: {} of {} depths were passed between two ticks and are interpolated; use larger depth steps "
                      "or more ticks",
                      result.what.label, result.curve.interpolated, c.grid.count));
    }
  }
}

}  // namespace

void CheckCompareParams(const CompareParams& params) {
  for (const std::string& law : params.laws) {
    if (law != "all") ForceLaw{law};  // throws for an unknown name
  }
  CheckParameters(params);
}

ForceLaw MakeSlabLaw(const SlabParams& slab) {
  ForceLaw law("hertz_constant_bite");
  law.Set("contact_share_of_pitch", slab.contact_share_of_pitch);
  return law;
}

const CaseResult* FindEqualLaw(const Comparison& c) {
  const auto found = std::find_if(c.cases.begin(), c.cases.end(),
                                  [law = MakeSlabLaw(c.slab)](const CaseResult& r) { return HasLaw(r.what, law); });
  return found == c.cases.end() ? nullptr : &*found;
}

std::vector<CompareCase> MakeCompareCases(const ForceLaw& own, const std::vector<std::string>& laws,
                                          const SlabParams& slab) {
  std::vector<CompareCase> cases{VoxelCase(own)};
  const auto add = [&](const std::string& name) {
    const CompareCase what = VoxelCase(ForceLaw(name));
    const bool there = std::any_of(cases.begin(), cases.end(), [&](const CompareCase& c) { return c.id == what.id; });
    if (!there) cases.push_back(what);
  };
  for (const std::string& name : laws) {
    if (name != "all") {
      add(name);
      continue;
    }
    for (const ForceLawInfo* law : ForceLaws()) add(law->name);
  }
  // Differences that remain with the slab's own law are caused by the slab.
  const ForceLaw slab_law = MakeSlabLaw(slab);
  if (std::none_of(cases.begin(), cases.end(), [&](const CompareCase& c) { return HasLaw(c, slab_law); })) {
    CompareCase what = VoxelCase(slab_law);
    if (std::any_of(cases.begin(), cases.end(), [&](const CompareCase& c) { return c.id == what.id; })) {
      what.id = "voxel_slab_law";
      what.label = "voxel with the slab's law";
    }
    cases.push_back(what);
  }
  cases.push_back(SlabCase(PaperReading::kAsComputed));
  cases.push_back(SlabCase(PaperReading::kCorrected));
  return cases;
}

void FinishComparison(Comparison& c, const MaterialTable& materials) {
  c.region_of_bin.clear(), c.regions.clear(), c.slice_bins.clear(), c.beyond_bins.clear();
  FindRegions(c, materials);
  const std::vector<double>& reference = c.reference().curve.force_N;
  for (CaseResult& result : c.cases) {
    const std::vector<double>& force = result.curve.force_N;
    result.peak_N = result.peak_depth_mm = 0;
    for (const std::size_t i : c.slice_bins) {
      if (!(force[i] > result.peak_N)) continue;
      result.peak_N = force[i];
      result.peak_depth_mm = c.grid.Centre(i);
    }
    result.slice = CalcDifference(force, reference, c.slice_bins, c.grid.step_mm);
    result.beyond = CalcDifference(force, reference, c.beyond_bins, c.grid.step_mm);
    result.regions.clear();
    for (const CompareRegion& region : c.regions) {
      result.regions.push_back(CalcDifference(force, reference, region.bins, c.grid.step_mm));
    }
  }
  c.rms_between_N.assign(c.cases.size(), std::vector<double>(c.cases.size(), 0));
  for (std::size_t a = 0; a < c.cases.size(); ++a) {
    for (std::size_t b = 0; b < c.cases.size(); ++b) {
      c.rms_between_N[a][b] =
          CalcDifference(c.cases[a].curve.force_N, c.cases[b].curve.force_N, c.slice_bins, c.grid.step_mm).rms_N;
    }
  }
}

Comparison CompareScene(const Scene& scene, const CompareParams& params, const CompareProgress& progress,
                        const std::string& scene_file) {
  CheckCompareParams(params);
  CheckScene(scene);
  const std::vector<CompareCase> cases = MakeCompareCases(scene.force, params.laws, MakeSlabParams(scene));
  const Path path = MakePath(scene);
  MakeSlabPlane(scene);  // throws before the long computation
  MaterialSummary material;
  const auto making = [&](double fraction) {
    if (progress) progress("making the bone", fraction);
  };
  const Bone bone = MakeSceneBone(scene, making, &material);

  Comparison c;
  c.scene = scene.name;
  c.title = scene.title;
  c.command = MakeCommand(scene, params, scene_file);
  SetMaterial(c, scene, material);
  c.depth_by = scene.slab.depth_by == SlabDepth::kPaperTable2 ? "paper_table_2" : "bone";
  c.voxel_mm = bone.voxel_mm();
  c.rate_hz = scene.simulation.rate_hz;
  c.feed_mm_per_s = path.CalcMaxSpeed();
  c.rpm = scene.tool.rpm;
  c.saw = MakeDiscSaw(scene);
  c.direction_W = glm::normalize(scene.slab.direction);
  c.profile = MakeSlabProfile(scene, bone);
  c.slab = MakeSlabParams(scene);
  c.grid.step_mm = params.depth_step_mm;
  c.repetitions = params.repetitions;
  c.cases.resize(cases.size());

  // The repetitions of the cases alternate, so that a temporarily slow machine affects all cases.
  std::vector<std::vector<DepthSample>> samples(cases.size());
  const double runs = static_cast<double>(cases.size()) * params.repetitions;
  for (int repetition = 0; repetition < params.repetitions; ++repetition) {
    for (std::size_t k = 0; k < cases.size(); ++k) {
      const double done = static_cast<double>(repetition) * static_cast<double>(cases.size()) + static_cast<double>(k);
      CaseRun run = RunCase(cases[k], scene, bone, c.profile, [&](double fraction) {
        if (progress) progress("cutting in each case", (done + fraction) / runs);
      });
      CaseResult& result = c.cases[k];
      if (repetition > 0 && (run.force_hash != result.force_hash || run.bone_hash != result.bone_hash)) {
        throw Error(fmt::format("{}: {} gave different forces when repeated", scene.name, cases[k].label));
      }
      if (repetition == 0 || run.times.p99_us < result.times.p99_us) result.times = run.times;
      result.p50_us.push_back(run.times.p50_us);
      result.p99_us.push_back(run.times.p99_us);
      if (repetition > 0) continue;
      result.what = cases[k];
      result.work_mJ = run.work_mJ;
      result.removed_mm3 = run.removed_mm3;
      result.force_hash = run.force_hash;
      result.bone_hash = run.bone_hash;
      result.memory_bytes = run.memory_bytes;
      samples[k] = std::move(run.samples);
    }
  }
  MakeCurves(c, samples);
  FinishComparison(c, bone.materials());
  c.peak_memory_MB = ReadPeakMemory_MB();
  AddWarnings(c, scene, material);
  return c;
}

}  // namespace kerf
