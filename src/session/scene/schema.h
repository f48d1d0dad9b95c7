// The keys of a scene file: unit (in the name), range and meaning of each. The reader, the writer, `kerf scene
// --defaults` and the tests all walk these descriptions, so they can't disagree.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "base/core/describe.h"
#include "session/scene/scene.h"

namespace kerf {

/// The words of `law` in [force].
const std::vector<std::string_view>& ForceLawWords();

/// Coordinates beyond this are a unit error, mm.
inline constexpr Range kCoordinateRange_mm{-kWorldReach_mm, kWorldReach_mm};
inline constexpr std::size_t kMaxStrokes = 1000;
inline constexpr std::size_t kMaxLayers = 1000;
inline constexpr std::size_t kMaxPathRows = 2'000'000;
inline constexpr double kMaxDuration_s = 36'000;

/// The words of `kind` in [material].
inline constexpr std::array<std::string_view, 3> kMaterialKindWords{"regions", "uniform", "ct"};

/// The key that says which of the others there are.
template <typename V>
void DescribeMaterialKind(SceneMaterial& p, V&& visit) {
  std::string kind(kMaterialKindWords[static_cast<std::size_t>(p.kind)]);
  visit("kind", kind, Choices{{kMaterialKindWords.begin(), kMaterialKindWords.end()}},
        "regions: constants by region; uniform: the same everywhere; ct: E from the CT numbers of an imported bone");
  for (std::size_t i = 0; i < kMaterialKindWords.size(); ++i) {
    if (kind == kMaterialKindWords[i]) p.kind = static_cast<MaterialKind>(i);
  }
}

/// Those of kind = "uniform".
template <typename V>
void DescribeUniform(SceneMaterial& p, V&& visit) {
  visit("E_GPa", p.E_GPa, Range{0.001, 1000}, "Young's modulus of all the bone");
  visit("nu", p.nu, Range{0, 0.5}, "Poisson's ratio of all the bone");
}

/// Those of kind = "ct", its texts aside.
template <typename V>
void DescribeCt(SceneMaterial& p, V&& visit) {
  std::string where = p.ct_all ? "all" : "cancellous";
  visit("ct_applies_to", where, Choices{{"cancellous", "all"}},
        "regions that take E from the CT; in cortical bone it says little of E");
  p.ct_all = where == "all";
}

/// The words of `shape` in [tool], in the order of ToolKind.
inline constexpr std::array<std::string_view, 2> kToolKindWords{"disc", "ball"};

/// The keys that only one kind of tool has.
template <typename V>
void DescribeDisc(SceneTool& p, V&& visit) {
  visit("diameter_mm", p.diameter_mm, Range{1, 200}, "diameter of the disc over the teeth");
  visit("thickness_mm", p.thickness_mm, Range{0.02, 10}, "thickness of the disc: the width of the kerf");
  visit("teeth", p.teeth, Range{1, 1000}, "number of teeth, evenly spaced on the rim");
}
template <typename V>
void DescribeBall(SceneTool& p, V&& visit) {
  visit("diameter_mm", p.diameter_mm, Range{0.5, 50}, "diameter of the ball");
  visit("flutes", p.flutes, Range{1, 100}, "cutting edges from pole to pole");
  visit("tooth_width_mm", p.tooth_width_mm, Range{0.01, 50},
        "stretch of a flute's edge that counts as one tooth of the force law; an assumption");
}

template <typename V>
void Describe(SceneTool& p, V&& visit) {
  std::string shape(kToolKindWords[static_cast<std::size_t>(p.kind)]);
  visit("shape", shape, Choices{{kToolKindWords.begin(), kToolKindWords.end()}},
        "disc: a saw that cuts with its rim; ball: a burr that cuts all over");
  for (std::size_t i = 0; i < kToolKindWords.size(); ++i) {
    const auto kind = static_cast<ToolKind>(i);
    if (shape != kToolKindWords[i] || kind == p.kind) continue;
    p.kind = kind;
    p.diameter_mm = kind == ToolKind::kBall ? BallBurr{}.diameter_mm : DiscSaw{}.diameter_mm;
  }
  if (p.kind == ToolKind::kDisc) {
    DescribeDisc(p, visit);
  } else {
    DescribeBall(p, visit);
  }
  visit("rpm", p.rpm, Range{0, 100000}, "speed of the spindle; 0: stopped, does not cut");
  visit("E_GPa", p.E_GPa, Range{1, 1500}, "Young's modulus of the tool's steel");
  visit("nu", p.nu, Range{0, 0.5}, "Poisson's ratio of the tool's steel");
  visit("grip_mm", p.grip_mm, Range{-1000, 1000},
        "the hand's grip in the tool frame (z: spindle, x: feed); torques are about it");
}

template <typename V>
void Describe(SceneStroke& p, V&& visit) {
  visit("start_mm", p.start_mm, kCoordinateRange_mm, "centre of the disc where the stroke starts");
  visit("end_mm", p.end_mm, kCoordinateRange_mm, "centre of the disc where it ends");
  visit("feed_mm_per_s", p.feed_mm_per_s, Range{0.001, 1000}, "speed of the centre");
  visit("disc_normal", p.disc_normal, Range{-1000, 1000}, "spindle axis, world frame; any length but 0");
  visit("dwell_s", p.dwell_s, Range{0, 3600}, "rest at end_mm with the spindle turning");
  visit("retract", p.retract,
        "true: lifted out and set down at start_mm in no time, without cutting; false: goes on from the stroke before");
}

/// The parameters of the law that `p` is.
template <typename V>
void DescribeLawParameters(ForceLaw& p, V&& visit) {
  const std::vector<LawParameter>& parameters = p.info().parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    visit(parameters[i].key, p.values()[i], Range{parameters[i].lower, parameters[i].upper}, parameters[i].meaning);
  }
}

/// Visits the law first: a visitor that changes it makes `p` that law with its presets.
template <typename V>
void Describe(ForceLaw& p, V&& visit) {
  std::string law = p.name();
  visit("law", law, Choices{ForceLawWords()}, "force on a tooth (docs/physics.md)");
  if (law != p.name()) p = ForceLaw(law);
  DescribeLawParameters(p, visit);
}

/// Without the texts that name files.
template <typename V>
void Describe(EffectChoice& p, V&& visit) {
  for (std::size_t i = 0; i < p.values().size(); ++i) {
    const EffectParameter& parameter = p.info().parameters[i];
    const Range range{parameter.lower, parameter.upper};
    EffectValue& value = p.values()[i];
    if (auto* number = std::get_if<double>(&value)) visit(parameter.key, *number, range, parameter.meaning);
    if (auto* flag = std::get_if<bool>(&value)) visit(parameter.key, *flag, parameter.meaning);
    if (auto* vector = std::get_if<Vec3>(&value)) visit(parameter.key, *vector, range, parameter.meaning);
    auto* text = std::get_if<std::string>(&value);
    if (text == nullptr || parameter.file != EffectFileKind::kNone) continue;
    if (parameter.words.empty()) {
      visit(parameter.key, *text, TextLimit{200}, parameter.meaning);
    } else {
      visit(parameter.key, *text, Choices{{parameter.words.begin(), parameter.words.end()}}, parameter.meaning);
    }
  }
}

template <typename V>
void Describe(SceneSimulation& p, V&& visit) {
  std::string mode = p.mode == SceneMode::kSlab ? "slab" : "voxel";
  visit("mode", mode, Choices{{"voxel", "slab"}},
        "voxel: the disc removes what it sweeps; slab: the paper's slice on a rail, needs no grid");
  p.mode = mode == "slab" ? SceneMode::kSlab : SceneMode::kVoxel;
  visit("rate_hz", p.rate_hz, Range{250, 4000}, "ticks a second of simulated time");
  visit("rim_samples_per_pitch", p.rim_samples_per_pitch, Range{1, 256}, "how finely the rim looks for bone");
  visit("substeps", p.substeps, Range{1, 64}, "each tick is worked out in at least so many steps");
  visit("carve_interval_ticks", p.carve_interval_ticks, Range{1, 64},
        "ticks between two removals of bone; it is removed sooner when the tool has gone a quarter of a "
        "voxel");
}

template <typename V>
void Describe(SceneSlab& p, V&& visit) {
  SlabParams& q = p.params;
  visit("direction", p.direction, Range{-1000, 1000},
        "of the cut, in the disc's plane where the path starts; any length but 0; the paper's is y");
  std::string law(ToString(q.reading));
  visit("law", law, Choices{{"as_computed", "corrected"}},
        "cutting resistance: as the paper's tables were computed (n^3 F_1), or corrected (true arc, teeth summed)");
  q.reading = PaperReadingFromString(law).value_or(PaperReading::kAsComputed);
  std::string depth = p.depth_by == SlabDepth::kPaperTable2 ? "paper_table_2" : "bone";
  visit("depth_by", depth, Choices{{"bone", "paper_table_2"}},
        "depth of each region: from the bone along the plane, or bands about the depths of the paper's Table 2");
  p.depth_by = depth == "paper_table_2" ? SlabDepth::kPaperTable2 : SlabDepth::kBone;
  visit("contact_share_of_pitch", q.contact_share_of_pitch, Range{1e-6, 0.5},
        "a tooth's contact radius as a share of the tooth pitch; the paper's is 0.01");
  visit("mass_g", q.mass_g, Range{0.001, 10000}, "mass of the slice and the blade");
  visit("stiffness_N_per_mm", q.stiffness_N_per_mm, Range{0, 1e6}, "spring from the slice to where it began");
  visit("damping_Ns_per_mm", q.damping_Ns_per_mm, Range{0, 1000}, "damper from the slice to the jaw");
  visit("friction_coefficient", q.friction_coefficient, Range{0, 10},
        "of each face of the slice on its segment; none was found measured for bone on bone");
  visit("normal_force_N", q.normal_force_N, Range{0, 10000}, "that presses each face");
  visit("coupling_N_per_mm", q.coupling_N_per_mm, Range{0.001, 1e6},
        "spring from the hand to what it holds; a desktop device renders 0.4 to 5");
  visit("coupling_damping_Ns_per_mm", q.coupling_damping_Ns_per_mm, Range{0, 1000}, "damper beside that spring");
  std::string hold = p.hold == SlabBody::kLeft ? "left" : p.hold == SlabBody::kRight ? "right" : "slice";
  visit("hold", hold, Choices{{"slice", "left", "right"}}, "the body in the hand; left and right only if they move");
  p.hold = hold == "left" ? SlabBody::kLeft : hold == "right" ? SlabBody::kRight : SlabBody::kSlice;
  visit("segments_move", q.segments_move, "true: the two segments slide along the direction too");
  visit("segment_mass_g", q.segment_mass_g, Range{0.001, 10000}, "mass of each segment, when they move");
  visit("segment_stiffness_N_per_mm", q.segment_stiffness_N_per_mm, Range{0, 1e6},
        "spring from each segment to its place, when they move");
  visit("segment_damping_Ns_per_mm", q.segment_damping_Ns_per_mm, Range{0, 1000},
        "damper from each segment to its place, when they move");
}

template <typename V>
void Describe(SceneOutput& p, V&& visit) {
  visit("pictures", p.pictures, "PNG pictures: before, after, the cut from near, force against depth");
  visit("pieces", p.pieces, "each separate piece as STL");
  visit("bone", p.bone, "the bone after the cut as .vdb");
  visit("smallest_piece_mm3", p.smallest_piece_mm3, Range{0, 1e6}, "smaller pieces are counted as dust, not written");
  visit("forces_every_ticks", p.forces_every_ticks, Range{1, 1000000}, "ticks for each row of forces.csv");
}

template <typename V>
void Describe(MaterialLayer& p, V&& visit) {
  visit("thickness_mm", p.thickness_mm, Range{0.001, 1000}, "thickness; the last layer fills what is left");
  visit("region", p.region, Range{1, 255}, "region of the table of materials");
}

/// A block's own parameters and where it stands.
template <typename V>
void DescribeBlock(BlockParams& p, V&& visit) {
  Describe(p, visit);
  visit("top_mm", p.X_WB.p_AB, kCoordinateRange_mm, "middle of its top face (+z), world frame");
  visit("rotation", p.X_WB.R_AB, "from its own axes to the world's: unit quaternion [w, x, y, z]");
}

/// The words of `model` in [bone]; each is the name of its table of parameters too.
const std::vector<std::string_view>& BoneModelWords();
/// kBlock for a word that is none of them.
BoneSource BoneSourceFromModel(std::string_view word);
/// The word, or empty for kFile.
std::string_view ToString(BoneSource source);

}  // namespace kerf
