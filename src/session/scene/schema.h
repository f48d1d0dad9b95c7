// Keys of a scene file: unit (in the name), range and meaning of each. The reader, the writer, `kerf scene --defaults`
// and the tests all use these descriptions, so they are consistent. A key that is a parameter of the library too takes
// its description from there.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "cut/tool/drive.h"
#include "cut/tool/shape.h"
#include "kerf/describe.h"
#include "session/scene/scene.h"

namespace kerf {

/// Values of `law` in [force].
const std::vector<std::string_view>& ForceLawWords();

inline constexpr std::size_t kMaxStrokes = 1000;
inline constexpr std::size_t kMaxLayers = 1000;
inline constexpr std::size_t kMaxPathRows = 2'000'000;
inline constexpr double kMaxDuration_s = 36'000;

/// Values of `kind` in [material].
inline constexpr std::array<std::string_view, 3> kMaterialKindWords{"regions", "uniform", "ct"};

/// Visits the key that determines which other keys are used.
template <typename V>
void DescribeMaterialKind(SceneMaterial& p, V&& visit) {
  std::string kind(kMaterialKindWords[static_cast<std::size_t>(p.kind)]);
  visit("kind", kind, Choices{{kMaterialKindWords.begin(), kMaterialKindWords.end()}},
        "source of the bone's stiffness: regions: constants of each region; uniform: the same everywhere; ct: E from "
        "the CT numbers of an imported bone");
  for (std::size_t i = 0; i < kMaterialKindWords.size(); ++i) {
    if (kind == kMaterialKindWords[i]) p.kind = static_cast<MaterialKind>(i);
  }
}

/// Keys for kind = "uniform".
template <typename V>
void DescribeUniform(SceneMaterial& p, V&& visit) {
  visit("E_GPa", p.E_GPa, Range{0.001, 1000}, "Young's modulus of the whole bone");
  visit("nu", p.nu, kPoissonRatioRange, "Poisson's ratio of the whole bone");
}

/// The key osteon_direction, which has no default.
template <typename V>
void DescribeOsteons(Vec3& direction, V&& visit) {
  visit("osteon_direction", direction, kDirectionRange,
        "direction of the osteons in cortical bone, world frame; any length but 0; only laws that depend on it");
}

/// Keys for kind = "ct", except the texts.
template <typename V>
void DescribeCt(SceneMaterial& p, V&& visit) {
  std::string where = p.ct_all ? "all" : "cancellous";
  visit("ct_applies_to", where, Choices{{"cancellous", "all"}},
        "regions that take E from the CT numbers; in cortical bone these determine E poorly");
  p.ct_all = where == "all";
}

template <typename V>
void Describe(SceneTool& p, V&& visit) {
  std::string word(GetShape(p.shape));
  visit("shape", word, Choices{GetToolShapes()}, DescribeToolShapes().c_str());
  for (const Tool& other : GetDefaultTools()) {
    if (word != GetShape(other) || other.index() == p.shape.index()) continue;
    p.shape = other;
    p.rpm = CalcOrdinaryRate(other);
  }
  std::visit(
      [&](auto& tool) {
        DescribeShape(tool, visit);
        DescribeEdge(tool, visit);
        visit("rpm", p.rpm, CalcRateRange(tool),
              "speed of the spindle, or double strokes a minute of a blade with a stroke; without the key, an ordinary "
              "speed of "
              "the shape; 0: stopped, does not cut");
        if (GetDrive(tool) == DriveMotion::kRotation) {
          visit("reverse", p.reverse,
                GetSense(tool) < 0 ? "false: turns clockwise, as seen from the handpiece; true: counter-clockwise"
                                   : "false: turns counter-clockwise, as seen from the handpiece; true: clockwise");
        }
        DescribeSteel("E_GPa", p.E_GPa, 1, tool.nu, tool.p_TG_mm, visit);
      },
      p.shape);
}

template <typename V>
void Describe(SceneStroke& p, V&& visit) {
  visit("start_mm", p.start_mm, kCoordinateRange_mm,
        "position of the tool's origin, of a disc its centre, at the start of the stroke");
  visit("end_mm", p.end_mm, kCoordinateRange_mm, "the same at the end of the stroke");
  visit("feed_mm_per_s", p.feed_mm_per_s, Range{0.001, 1000}, "feed rate of the tool's origin");
  visit("disc_normal", p.disc_normal, kDirectionRange,
        "z axis of the tool frame, of a disc its spindle axis; world frame, any length but 0");
  visit("dwell_s", p.dwell_s, Range{0, 3600}, "time at rest at end_mm with the drive on");
  visit("retract", p.retract,
        "true: the tool is lifted out and set down at start_mm instantly, without cutting; false: it continues from "
        "the previous stroke");
}

/// Parameters of the law in `p`.
template <typename V>
void DescribeLawParameters(ForceLaw& p, V&& visit) {
  const std::vector<LawParameter>& parameters = p.info().parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    visit(parameters[i].key, p.values()[i], Range{parameters[i].lower, parameters[i].upper}, parameters[i].meaning);
  }
}

/// Visits the law first: if the visitor changes it, `p` becomes that law with its defaults.
template <typename V>
void Describe(ForceLaw& p, V&& visit) {
  std::string law = p.name();
  visit("law", law, Choices{ForceLawWords()}, "force law: force on a tooth (docs/physics.md)");
  if (law != p.name()) p = ForceLaw(law);
  DescribeLawParameters(p, visit);
}

/// Keys with which effects convert a thrust to a cutting force: effect and key. They have no use if the force law
/// states the cutting force.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 2> kCuttingRatioKeys{
    {{"tangential_force", "ratio"}, {"tooth_vibration", "tangential_share"}}};

/// Visits all parameters except texts that name files.
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
      visit(parameter.key, *text, Choices{parameter.words}, parameter.meaning);
    }
  }
}

template <typename V>
void Describe(SceneSimulation& p, V&& visit) {
  std::string mode = p.mode == SceneMode::kSlab ? "slab" : "voxel";
  visit("mode", mode, Choices{{"voxel", "slab"}},
        "voxel: the tool removes the bone that it sweeps; slab: the paper's slice on a rail, needs no grid");
  p.mode = mode == "slab" ? SceneMode::kSlab : SceneMode::kVoxel;
  visit("rate_hz", p.rate_hz, kTickRateRange_hz, "ticks per second of simulated time");
  DescribeSampling(p, visit);
  DescribeCarving(p, visit);
}

template <typename V>
void Describe(SceneSlab& p, V&& visit) {
  SlabParams& q = p.params;
  visit("direction", p.direction, kDirectionRange,
        "direction of the cut, in the disc's plane at the start of the path; any length but 0; the paper's is y");
  std::string law(ToString(q.reading));
  visit("law", law, Choices{{"as_computed", "corrected"}},
        "cutting resistance: as the paper's tables were computed (n^3 F_1), or corrected (true arc, sum of the teeth's "
        "forces)");
  q.reading = PaperReadingFromString(law).value_or(PaperReading::kAsComputed);
  std::string depth = p.depth_by == SlabDepth::kPaperTable2 ? "paper_table_2" : "bone";
  visit("depth_by", depth, Choices{{"bone", "paper_table_2"}},
        "source of each region's depth: the bone along the plane, or bands about the depths of the paper's Table 2");
  p.depth_by = depth == "paper_table_2" ? SlabDepth::kPaperTable2 : SlabDepth::kBone;
  DescribeSlice(q, visit);
  std::string hold = p.hold == SlabBody::kLeft ? "left" : p.hold == SlabBody::kRight ? "right" : "slice";
  visit("hold", hold, Choices{{"slice", "left", "right"}},
        "body that the hand holds; left and right only if segments_move = true");
  p.hold = hold == "left" ? SlabBody::kLeft : hold == "right" ? SlabBody::kRight : SlabBody::kSlice;
  DescribeSegments(q, visit);
}

template <typename V>
void Describe(SceneOutput& p, V&& visit) {
  visit("pictures", p.pictures, "true: write PNG pictures: before, after, the cut in close-up, force against depth");
  visit("pieces", p.pieces, "true: write each separate piece as STL");
  visit("bone", p.bone, "true: write the bone after the cut as .vdb");
  visit("smallest_piece_mm3", p.smallest_piece_mm3, Range{0, 1e6},
        "smallest volume of a piece; smaller ones are counted as dust and not written");
  visit("forces_every_ticks", p.forces_every_ticks, Range{1, 1000000}, "ticks per row of forces.csv");
}

/// Values of `model` in [bone]; each is also the name of its table of parameters.
const std::vector<std::string_view>& BoneModelWords();
/// Returns the source that the word names; kBlock for any other word.
BoneSource BoneSourceFromModel(std::string_view word);
/// Returns the word for the source, or "" for kFile.
std::string_view ToString(BoneSource source);

}  // namespace kerf
