// kerf assess: compares the cut with the plan.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/assess_picture.h"
#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "bone/mesh/decimate.h"
#include "bone/pieces/measure.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "kerf/version.h"
#include "session/export/write_export.h"
#include "session/marks/structures.h"
#include "session/plan/cut_state.h"
#include "session/run/make_bone.h"
#include "session/run/run_loop.h"
#include "session/run/run_pictures.h"
#include "session/run/run_scene.h"
#include "session/run/session_recorder.h"
#include "session/scene/schema.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

constexpr std::size_t kMaxPiecesFile = std::size_t{64} << 20;
/// A structure is printed if the cut is nearer, or if as much of it was removed.
constexpr double kNear_mm = 2;
constexpr double kLeastRemoved_mm3 = 0.005;  // prints as 0.01

struct AssessArguments {
  std::string file;
  std::vector<std::string> before;
  std::string after;
  std::string plan;
  std::string bone_file;
  std::string pieces;
  std::vector<std::string> moves;
  std::string folder;
  std::string markups;
  std::string table;
  std::optional<double> margin_mm;
  std::optional<double> blade_mm;
  AssessOptions assess;
  double smallest_mm3 = 1;
  std::size_t triangles = 0;
  bool obj = false;
  bool no_pictures = false;
  bool json = false;
};

/// Input of the comparison.
struct Subject {
  std::string title;
  Plan plan;
  Bone before;
  Bone after;
  double blade_mm = DiscSaw{}.thickness_mm;
  std::vector<ExportFigure> figures;
  std::vector<ExportCurve> curves;
  std::vector<ExportFact> provenance;
  bool of_patient = true;
  // For recordings only:
  ExportRecording recording;
  std::uint64_t hash = 0;  // of the bone at the end of the last one, without the pieces taken out of it
  double duration_s = 0;
  double largest_force_N = 0;
  double hand_J = 0;
};

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string TitleOf(const Scene& scene) {
  return scene.TitleOrName();
}

/// Reads planned planes, with a warning about those that are skipped.
std::vector<PlannedPlane> ReadPlanes(const std::string& path) {
  std::vector<std::string> skipped;
  std::vector<PlannedPlane> planes = ReadPlannedPlanes(path, &skipped);
  for (const std::string& plane : skipped) SayWarning("{} was cut, not planned, and is skipped", plane);
  return planes;
}

/// Adds the wanted cuts of an exercise to the plan, as planes and, for a single cut, a stop. Those of an earlier
/// recording are already in it.
void AddWantedCuts(const Scene& scene, bool is_only, Plan& plan) {
  const std::vector<WantedCut> cuts = MakeWantedCuts(scene.exercise, MakeTool(scene));
  const bool numbered = cuts.size() > 1 || !is_only;
  for (const WantedCut& cut : cuts) {
    const std::string number = numbered ? fmt::format(" {}", plan.planes.size() + 1) : "";
    if (cut.length_mm > 0) {
      plan.planes.push_back({.name = "wanted cut" + number,
                             .plane = {cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}), cut.across_W},
                             .margin_mm = cut.margin_mm,
                             .width_mm = kPlaneSizeRange_mm.Clamp(cut.length_mm),
                             .height_mm = kPlaneSizeRange_mm.Clamp(cut.depth_mm),
                             .up_W = -cut.into_W});
    }
    if (numbered) continue;  // a stop holds for all of the bone below it
    plan.stops.push_back(
        {.name = "wanted depth", .p_W_mm = cut.start_W, .direction_W = cut.into_W, .depth_mm = cut.depth_mm});
  }
}

/// Replays a recording of a loop and takes the bones and the plan from it. With `is_later`, it goes on with the bone of
/// the one before, whose bone before the cut and whose plan are kept.
void TakeRecording(const std::string& file, const AssessArguments& options, bool is_later, StageBars& bars,
                   Subject& subject) {
  RecordingReader recording(file);
  const RecordingHeader& header = recording.header();
  if (header.kind != RecordedKind::kLoop) {
    throw Error(
        fmt::format("{}: is a recording of 'kerf run'; write its bone with 'kerf replay {} -o FOLDER', then use 'kerf "
                    "assess SCENE --after FOLDER/bone.vdb'",
                    file, file));
  }
  const RecordedScene recorded = OpenRecordedScene(recording, file == options.file ? options.bone_file : "");
  if (is_later && header.bone_hash != subject.hash) {
    throw Error(fmt::format("{}: did not begin with the bone that the recording before it ended with", file));
  }
  const std::size_t first_warning = subject.recording.warnings.size();
  if (subject.recording.is_whole()) subject.recording.state = ToString(recording.damage().state);
  for (std::string& warning : FindDamageWarnings(recording)) subject.recording.warnings.push_back(std::move(warning));
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = std::clamp(recording.damage().whole_s, 0.01, kMaxLoop_s);
  loop.stop = &CatchInterrupt();
  loop.output.scene_file = header.scene_file;
  loop.replay.recording = &recording;
  loop.output.keep_bones = true;
  loop.output.log = LoopLog::kNone;
  LoopSummary summary =
      RunLoop(recorded.scene, loop, [&](const std::string& now, double fraction) { bars.Show(now, fraction); });
  if (summary.replayed && summary.replayed->divergence) {
    subject.recording.warnings.push_back(fmt::format("differs from the recording from tick {} on: {}",
                                                     summary.replayed->divergence->step + 1,
                                                     summary.replayed->divergence->what));
  }
  for (std::size_t i = first_warning; i < subject.recording.warnings.size(); ++i) {
    SayWarning("{}: {}", file, subject.recording.warnings[i]);
  }
  subject.title = is_later ? fmt::format("{}; {}", subject.title, TitleOf(recorded.scene)) : TitleOf(recorded.scene);
  if (!recorded.scene.plan.empty()) {
    subject.plan = recorded.scene.plan;
  } else if (recorded.scene.exercise.given) {
    // An exercise prescribes a cut as a plan does.
    AddWantedCuts(recorded.scene, options.before.empty(), subject.plan);
  }
  subject.of_patient = IsOfPatient(recorded.scene);
  const double cut_width_mm = CalcCutWidth(MakeTool(recorded.scene));
  subject.blade_mm = is_later ? std::max(subject.blade_mm, cut_width_mm) : cut_width_mm;
  if (!is_later) subject.before = std::move(summary.before);
  subject.after = std::move(summary.after);
  subject.hash = summary.bone_hash;
  if (summary.fragments) subject.after = PutBack(subject.after, summary.fragments->out);
  subject.duration_s += summary.simulated_s;
  subject.largest_force_N = std::max(subject.largest_force_N, summary.force.largest_simulated_N);
  subject.hand_J += summary.hand_J;
  subject.figures = {{"duration", "s", subject.duration_s},
                     {"largest force on the hand", "N", subject.largest_force_N},
                     {"work of the hand", "J", subject.hand_J}};
  const std::string file_name = std::filesystem::path(file).filename().string();
  ExportCurve curve{.title = options.before.empty() ? "Force on the hand" : "Force on the hand, " + file_name,
                    .x_label = "time, s",
                    .y_label = "force, N",
                    .points = {}};
  for (const ForcePoint& p : summary.force_curve.points()) curve.points.emplace_back(p.time_s, p.hand_N);
  if (curve.points.size() > 1) subject.curves.push_back(std::move(curve));
  subject.provenance.push_back({"recording", file_name});
  subject.provenance.push_back(
      {"recorded", fmt::format("{} by kerf {} ({})", header.created, header.version, header.commit)});
  subject.provenance.push_back({"scene", header.scene_name});
}

/// Reads the bones from files, or the bone before the cut from the scene.
void TakeBones(const AssessArguments& options, StageBars& bars, Subject& subject) {
  const bool markups = IsPlanesPath(options.file);
  if (options.after.empty()) {
    throw CLI::RequiredError("--after");
  }
  subject.provenance = {{markups ? "plan" : "scene", std::filesystem::path(options.file).filename().string()}};
  const auto show = [&](double fraction) { bars.Show("reading the bones", fraction); };
  if (markups) {
    if (options.before.empty()) throw CLI::RequiredError("--before");
    subject.plan.planes = ReadPlanes(options.file);
    const std::string file_name = std::filesystem::path(options.file).filename().string();
    subject.title = file_name.substr(0, file_name.find('.'));
    subject.before = ReadBone(options.before.front());
  } else {
    const Scene scene = ReadScene(options.file);
    subject.title = TitleOf(scene);
    subject.plan = scene.plan;
    subject.of_patient = IsOfPatient(scene);
    subject.blade_mm = CalcCutWidth(MakeTool(scene));
    subject.before = options.before.empty() ? MakeSceneBone(scene, show) : ReadBone(options.before.front());
  }
  show(0.5);
  subject.after = ReadBone(options.after);
  const auto name_of = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  if (!options.before.empty()) subject.provenance.push_back({"bone before", name_of(options.before.front())});
  subject.provenance.push_back({"bone after", name_of(options.after)});
}

Subject TakeSubject(const AssessArguments& options) {
  StageBars bars;
  Subject subject;
  const bool recording = EndsWith(options.file, ".kerf");
  if (recording) {
    const auto is_bone = [](const std::string& file) { return !EndsWith(file, ".kerf"); };
    if (!options.after.empty() || std::any_of(options.before.begin(), options.before.end(), is_bone)) {
      throw CLI::ValidationError("--before, --after", "a recording contains its own bones");
    }
    std::vector<std::string> files = options.before;
    files.push_back(options.file);
    for (std::size_t i = 0; i < files.size(); ++i) TakeRecording(files[i], options, i > 0, bars, subject);
  } else {
    if (options.before.size() > 1 || (!options.before.empty() && EndsWith(options.before.front(), ".kerf"))) {
      throw CLI::ValidationError("--before", "takes one bone (.vdb), or recordings (.kerf) if FILE is a recording");
    }
    TakeBones(options, bars, subject);
  }
  if (!options.plan.empty()) {
    subject.plan = Plan{};
    subject.plan.planes = ReadPlanes(options.plan);
    subject.provenance.push_back({"plan", std::filesystem::path(options.plan).filename().string()});
  }
  if (options.margin_mm) {
    for (PlannedPlane& plane : subject.plan.planes) plane.margin_mm = *options.margin_mm;
  }
  if (options.blade_mm) subject.blade_mm = *options.blade_mm;
  subject.provenance.push_back({"bone before, hash", fmt::format("{:016x}", subject.before.CalcHash())});
  subject.provenance.push_back({"bone after, hash", fmt::format("{:016x}", subject.after.CalcHash())});
  subject.provenance.push_back({"voxel", fmt::format("{:g} mm", subject.before.voxel_mm())});
  subject.provenance.push_back({"report by", fmt::format("kerf {} ({})", VersionString(), CommitString())});
  return subject;
}

/// A planned translation of a piece.
struct PlannedMove {
  int piece = 0;
  Vec3 by_W_mm{0};
};

/// Finds the piece that contains the point of --move where it was cut off; within a voxel, the nearest. Throws
/// kerf::Error if there is none, or if it is the largest piece, against which the others move.
PlannedMove FindMove(const std::string& text, const PieceSet& pieces) {
  const std::vector<double> v = ParseNumbers(text, ',', 6, "--move", "x,y,z,dx,dy,dz in mm, such as 0,5,-36,0,-6,0");
  const Vec3 p_W(v[0], v[1], v[2]);
  PlannedMove move{-1, {v[3], v[4], v[5]}};
  double least_mm = std::numeric_limits<double>::infinity();
  for (int i = 0; i < pieces.size(); ++i) {
    const double distance_mm = pieces.piece(i).bone.SignedDistance(p_W);
    if (pieces.state(i).deleted || distance_mm > pieces.piece(i).bone.voxel_mm() || distance_mm >= least_mm) continue;
    move.piece = i;
    least_mm = distance_mm;
  }
  if (move.piece < 0) throw Error(fmt::format("--move {}: its point is in no piece", text));
  if (move.piece == 0) throw Error(fmt::format("--move {}: its point is in the largest piece, which stays", text));
  return move;
}

/// Prints where a piece is compared with its planned place, and how it meets the largest one.
void PrintMove(const PlannedMove& move, const PieceSet& pieces) {
  const Piece& piece = pieces.piece(move.piece);
  const double off_mm = glm::length(pieces.CalcCentroid(move.piece) - piece.centroid_P - move.by_W_mm);
  fmt::print("  {:<16}  planned move {:.2f} mm; now {:.2f} mm and {:.2f} deg from there\n", piece.name,
             glm::length(move.by_W_mm), off_mm, CalcRotationAngle(pieces.state(move.piece).X_WP));
  const PieceContact contact = pieces.CalcContact(move.piece, 0);
  fmt::print("  {:<16}  overlap with {} {:.1f} mm3, least gap {}\n", "", pieces.piece(0).name, contact.overlap_mm3,
             contact.gap ? fmt::format("{:.2f} mm", contact.gap->gap_mm) : "far");
}

/// Prints the nerves and their canals, and each other structure of which something was removed or that is near the cut.
void PrintStructures(const StructureAssessment& a) {
  for (const StructureResult& s : a.structures) {
    const bool nerve = IsNerve(s.kind);
    if (!s.distance_mm) continue;
    const bool is_removed = s.removed_mm3 >= kLeastRemoved_mm3;
    if (!nerve && !s.is_cut && !is_removed && *s.distance_mm >= kNear_mm) continue;
    std::string text = s.is_severed ? (nerve ? "severed" : "cut through")
                       : s.is_cut   ? "cut"
                                    : fmt::format("{:.1f} mm from the cut", *s.distance_mm);
    if (s.is_cut || is_removed) text += fmt::format(", {:.2f} mm3 of it removed", s.removed_mm3);
    fmt::print("  {:<16}  {}\n", FormatMessage(NameStructure(s)), text);
  }
}

void PrintForPeople(const Subject& subject, const Assessment& a, const StructureAssessment& structures,
                    const PieceSet* pieces, const std::vector<PlannedMove>& moves) {
  fmt::print("{}\n", subject.title);
  for (const std::string& warning : subject.recording.warnings) fmt::print("  recording         {}\n", warning);
  for (const PlaneResult& p : a.planes) {
    if (!p.cut) {
      fmt::print("  {:<16}  no kerf found near it: {}\n", p.planned.name, DescribeNoKerf(p));
      continue;
    }
    fmt::print("  {:<16}  offset {:+.2f} mm, at most {:+.2f} mm; angle {:.2f} deg (pitch {:+.2f}, roll {:+.2f}); {}\n",
               p.planned.name, p.offset_mm, p.furthest_mm, p.angles.angle_deg, p.angles.pitch_deg, p.angles.roll_deg,
               p.within_margin ? fmt::format("within {:g} mm", p.planned.margin_mm)
                               : fmt::format("NOT within {:g} mm", p.planned.margin_mm));
  }
  for (const StopResult& s : a.stops) {
    fmt::print("  {:<16}  {}\n", s.planned.name,
               s.depth_mm ? fmt::format("{:.2f} mm deep, {:+.2f} mm relative to the plan", *s.depth_mm, s.over_mm)
                          : "not reached");
  }
  if (a.planes.empty() && a.stops.empty()) fmt::print("  plan              none\n");
  fmt::print("  removed           {:.2f} mm3", a.removed_mm3);
  if (a.outside_mm3) fmt::print(", {:.2f} of it outside the margins", *a.outside_mm3);
  if (a.too_deep_mm3) fmt::print(", {:.2f} too deep", *a.too_deep_mm3);
  fmt::print("\n");
  PrintStructures(structures);
  if (pieces != nullptr) fmt::print("  pieces            {}\n", pieces->size());
  for (const PlannedMove& move : moves) PrintMove(move, *pieces);
}

/// Throws kerf::Error if the bone has grown.
void CheckRemoved(const Assessment& assessment) {
  constexpr double kSlack = 1e-4;  // of the volume: pieces that are joined again meet within rounding
  if (assessment.removed_mm3 >= -kSlack * assessment.before_mm3) return;
  throw Error(
      fmt::format("the bone after the cut is {:.2f} mm3 larger than the bone before it; they are swapped, or of "
                  "different bones",
                  -assessment.removed_mm3));
}

/// Returns the files that are read, apart from those of a recording; some may be "".
std::vector<std::string> ListInputs(const AssessArguments& options) {
  std::vector<std::string> inputs{options.file, options.plan, options.after, options.bone_file, options.pieces};
  const auto add = [&inputs](const std::vector<std::string>& files) {
    inputs.insert(inputs.end(), files.begin(), files.end());
  };
  add(options.before);
  for (const std::string& path : {options.file, options.plan}) {
    if (IsPlanesPath(path)) add(ListPlaneFiles(path));
  }
  if (!EndsWith(options.file, ".kerf") && !IsPlanesPath(options.file)) {
    add(kerf::ListInputs(ReadScene(options.file), options.file));
  }
  return inputs;
}

/// Throws kerf::Error if the output folder is a folder of planned planes, in which planned.mrk.json would be read
/// again.
void CheckFolder(const AssessArguments& options) {
  std::error_code none;
  for (const std::string& path : {options.file, options.plan}) {
    if (options.folder.empty() || !std::filesystem::equivalent(path, options.folder, none)) continue;
    throw Error(fmt::format("{}: the planned planes are read from this folder; choose another output", options.folder));
  }
}

void Run(const AssessArguments& options) {
  CheckInputsNotOverwritten(ListInputs(options), {options.markups, options.table});
  CheckFolder(options);
  for (const std::string& file : {options.markups, options.table}) {
    if (!file.empty()) CheckWritable(file);
  }
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) lock.emplace(options.folder);
  Subject subject = TakeSubject(options);
  const Assessment assessment =
      AssessCut(subject.plan, subject.before, subject.after, subject.blade_mm, options.assess);
  CheckRemoved(assessment);
  const StructureAssessment structures = AssessStructures(subject.before, subject.after, {});
  std::optional<PieceSet> pieces;
  if (!options.folder.empty() || !options.pieces.empty() || !options.moves.empty() || options.json) {
    pieces.emplace(subject.after, options.smallest_mm3);
    if (!options.pieces.empty()) pieces->Restore(ReadTextFile(options.pieces, kMaxPiecesFile), options.pieces);
  }
  std::vector<PlannedMove> moves;
  for (const std::string& text : options.moves) {
    moves.push_back(FindMove(text, *pieces));
    if (options.pieces.empty()) pieces->Move(moves.back().piece, moves.back().by_W_mm);
  }
  if (!options.folder.empty()) {
    ExportInput taken{.title = subject.title,
                      .plan = &subject.plan,
                      .assessment = &assessment,
                      .pieces = &*pieces,
                      .structures = &structures,
                      .figures = subject.figures,
                      .measures = {},
                      .pictures = {},
                      .curves = subject.curves,
                      .provenance = subject.provenance,
                      .recording = subject.recording};
    for (const PlannedPlane& plane : subject.plan.planes) {
      taken.cut_states.push_back(CalcCutState(subject.before, subject.after, plane));
    }
    StageBars bars;
    const std::string lack = options.no_pictures ? "" : FindLackOfPictures();
    if (!lack.empty()) SayWarning("{}", lack);
    if (!options.no_pictures && lack.empty()) {
      bars.Show("drawing", 0);
      taken.pictures = DrawAssessment(subject.title, assessment, *pieces, subject.of_patient);
    }
    WriteExport(taken, options.folder, {.obj = options.obj, .triangles = options.triangles},
                [&](double fraction) { bars.Show("writing", fraction); });
  }
  if (!options.markups.empty()) {
    std::vector<PlaneMarkup> planes = MakeMarkups(subject.plan);
    for (PlaneMarkup& plane : MakeCutMarkups(assessment)) planes.push_back(std::move(plane));
    WritePlaneMarkups(options.markups, planes);
    if (planes.empty()) SayWarning("{}: contains no planes, because nothing was planned", options.markups);
  }
  if (!options.table.empty()) {
    ExportInput measured;
    measured.plan = &subject.plan;
    measured.assessment = &assessment;
    measured.structures = &structures;
    WriteTextFile(options.table, FormatMeasuresCsv(measured));
  }
  if (options.json) {
    ExportInput printed;
    printed.assessment = &assessment;
    printed.structures = &structures;
    printed.pieces = &*pieces;
    printed.recording = subject.recording;
    fmt::print("{}", FormatAssessmentJson(printed));
  } else {
    PrintForPeople(subject, assessment, structures, pieces ? &*pieces : nullptr, moves);
    if (!options.folder.empty()) fmt::print("  report            {}/report.html\n", options.folder);
  }
  if (!subject.recording.is_whole()) throw ReadDamaged();
}

}  // namespace

void AddAssessCommand(CLI::App& app) {
  const auto options = std::make_shared<AssessArguments>();
  CLI::App* command = app.add_subcommand("assess",
                                         "Compare the cut with its plan, and write a report (docs/planning.md). Exit "
                                         "code 3: the recording is damaged or cut short");
  command
      ->add_option(
          "FILE", options->file,
          "Recording of 'kerf loop', 'rehearse' or 'practise' (.kerf), scene with a [plan] (.toml), or planes of 3D "
          "Slicer (.mrk.json, a folder of these, or a scene .mrml)")
      ->required();
  command
      ->add_option("--before", options->before,
                   "Bone before the cut (.vdb); default: the scene's. If FILE is a recording: one that ended with the "
                   "bone that FILE began with (.kerf), so that both are assessed together; may be repeated, in their "
                   "order")
      ->allow_extra_args(false);
  command->add_option("--after", options->after, "Bone after the cut (.vdb)");
  command->add_option("--plan", options->plan, "Planes of 3D Slicer, as for FILE, instead of the scene's plan");
  command->add_option("--bone", options->bone_file, "Bone file of the recording, if it was moved (.vdb)");
  command->add_option("--pieces", options->pieces, "Positions of the pieces: an earlier pieces.json");
  command
      ->add_option("--move", options->moves,
                   "Planned move x,y,z,dx,dy,dz, mm, of the piece that contains the point x,y,z: is applied, or with "
                   "--pieces compared with where the piece is; may be repeated")
      ->allow_extra_args(false);
  command->add_option("-o,--output", options->folder,
                      "Folder for pieces, planes, measures and report.html; created if missing");
  const auto ending = [](const char* wanted) {
    return [wanted](const std::string& file) {
      return EndsWith(file, wanted) ? std::string() : fmt::format("the name must end in {}", wanted);
    };
  };
  command
      ->add_option("--markups", options->markups,
                   "File for the planned planes and those that were cut (\"NAME, as cut\"), for 3D Slicer (.mrk.json)")
      ->check(ending(".mrk.json"));
  command->add_option("--table", options->table, "File for the measures as a table, also for 3D Slicer (.csv)")
      ->check(ending(".csv"));
  AddNumberOption(*command, "--margin", options->margin_mm, "margin_mm", FindRange<PlannedPlane>("margin_mm"),
                  "margin of all planes, instead of the plan's");
  AddNumberOption(*command, "--blade", options->blade_mm, "blade_mm", Range{0.02, 100},
                  "thickness of the blade, instead of the scene's");
  AddNumber(*command, "--reach", options->assess, "reach_mm")->capture_default_str();
  AddNumberOption(*command, "--smallest-piece", options->smallest_mm3, "smallest_mm3",
                  FindRange<SceneOutput>("smallest_piece_mm3"), "volume below which pieces are omitted")
      ->capture_default_str();
  AddNumberOption(*command, "--triangles", options->triangles, "triangles", kTrianglesRange,
                  "maximum number of triangles of each piece; default: no reduction");
  command->add_flag("--obj", options->obj, "Write pieces as OBJ instead of STL");
  command->add_flag("--no-pictures", options->no_pictures, "Draw no pictures");
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
