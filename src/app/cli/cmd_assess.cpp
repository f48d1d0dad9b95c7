// kerf assess: compares the cut with the plan.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
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
#include "bone/pieces/join.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "kerf/version.h"
#include "session/export/write_export.h"
#include "session/run/make_bone.h"
#include "session/run/run_loop.h"
#include "session/run/run_pictures.h"
#include "session/run/run_scene.h"
#include "session/run/session_recorder.h"
#include "session/scene/schema.h"

namespace kerf::cli {
namespace {

constexpr std::size_t kMaxPiecesFile = std::size_t{64} << 20;

struct AssessArguments {
  std::string file;
  std::string before;
  std::string after;
  std::string plan;
  std::string bone_file;
  std::string pieces;
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
  ExportRecording recording;  // unset for bones in files
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

/// Replays a recording of a loop and takes the bones and the plan from it.
void TakeRecording(const AssessArguments& options, StageBars& bars, Subject& subject) {
  RecordingReader recording(options.file);
  const RecordingHeader& header = recording.header();
  if (header.kind != RecordedKind::kLoop) {
    throw Error(
        fmt::format("{}: is a recording of 'kerf run'; write its bone with 'kerf replay {} -o FOLDER', then use 'kerf "
                    "assess SCENE --after FOLDER/bone.vdb'",
                    options.file, options.file));
  }
  const RecordedScene recorded = OpenRecordedScene(recording, options.bone_file);
  subject.recording = {ToString(recording.damage().state), FindDamageWarnings(recording)};
  for (const std::string& warning : subject.recording.warnings) SayWarning("{}: {}", options.file, warning);
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
    SayWarning("{}: {}", options.file, subject.recording.warnings.back());
  }
  subject.title = TitleOf(recorded.scene);
  subject.plan = recorded.scene.plan;
  if (subject.plan.empty() && recorded.scene.exercise.given) {
    // An exercise prescribes a cut as a plan does.
    const std::vector<WantedCut> cuts = MakeWantedCuts(recorded.scene.exercise, MakeTool(recorded.scene));
    for (const WantedCut& cut : cuts) {
      const std::string number = cuts.size() > 1 ? fmt::format(" {}", &cut - cuts.data() + 1) : "";
      if (cut.length_mm > 0) {
        subject.plan.planes.push_back(
            {.name = "wanted cut" + number,
             .plane = {cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}), cut.across_W},
             .margin_mm = cut.margin_mm,
             .width_mm = kPlaneSizeRange_mm.Clamp(cut.length_mm),
             .height_mm = kPlaneSizeRange_mm.Clamp(cut.depth_mm),
             .up_W = -cut.into_W});
      }
      if (cuts.size() > 1) continue;  // a stop holds for all of the bone below it
      subject.plan.stops.push_back({.name = "wanted depth" + number,
                                    .p_W_mm = cut.start_W,
                                    .direction_W = cut.into_W,
                                    .depth_mm = cut.depth_mm});
    }
  }
  subject.of_patient = IsOfPatient(recorded.scene);
  subject.blade_mm = CalcCutWidth(MakeTool(recorded.scene));
  subject.before = std::move(summary.before);
  subject.after = std::move(summary.after);
  if (summary.fragments) {
    std::vector<const Bone*> out;
    for (const PieceOut& piece : summary.fragments->out) out.push_back(&piece.bone);
    subject.after = JoinBones(subject.after, out);
  }
  subject.figures = {{"duration", "s", summary.simulated_s},
                     {"largest force on the hand", "N", summary.force.largest_simulated_N},
                     {"work of the hand", "J", summary.hand_J}};
  ExportCurve curve{.title = "Force on the hand", .x_label = "time, s", .y_label = "force, N", .points = {}};
  for (const ForcePoint& p : summary.force_curve.points()) curve.points.emplace_back(p.time_s, p.hand_N);
  if (curve.points.size() > 1) subject.curves.push_back(std::move(curve));
  subject.provenance = {{"recording", std::filesystem::path(options.file).filename().string()},
                        {"recorded", fmt::format("{} by kerf {} ({})", header.created, header.version, header.commit)},
                        {"scene", header.scene_name}};
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
    subject.before = ReadBone(options.before);
  } else {
    const Scene scene = ReadScene(options.file);
    subject.title = TitleOf(scene);
    subject.plan = scene.plan;
    subject.of_patient = IsOfPatient(scene);
    subject.blade_mm = CalcCutWidth(MakeTool(scene));
    subject.before = options.before.empty() ? MakeSceneBone(scene, show) : ReadBone(options.before);
  }
  show(0.5);
  subject.after = ReadBone(options.after);
  const auto name_of = [](const std::string& path) { return std::filesystem::path(path).filename().string(); };
  if (!options.before.empty()) subject.provenance.push_back({"bone before", name_of(options.before)});
  subject.provenance.push_back({"bone after", name_of(options.after)});
}

Subject TakeSubject(const AssessArguments& options) {
  StageBars bars;
  Subject subject;
  const bool recording = EndsWith(options.file, ".kerf");
  if (recording) {
    if (!options.before.empty() || !options.after.empty()) {
      throw CLI::ValidationError("--before, --after", "a recording contains its own bones");
    }
    TakeRecording(options, bars, subject);
  } else {
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

void PrintForPeople(const Subject& subject, const Assessment& a, const PieceSet* pieces) {
  fmt::print("{}\n", subject.title);
  for (const std::string& warning : subject.recording.warnings) fmt::print("  recording         {}\n", warning);
  for (const PlaneResult& p : a.planes) {
    if (!p.cut) {
      fmt::print("  {:<16}  no kerf found near it\n", p.planned.name);
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
  if (pieces != nullptr) fmt::print("  pieces            {}\n", pieces->size());
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
  std::vector<std::string> inputs{options.file,  options.plan,      options.before,
                                  options.after, options.bone_file, options.pieces};
  const auto add = [&inputs](const std::vector<std::string>& files) {
    inputs.insert(inputs.end(), files.begin(), files.end());
  };
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
  std::optional<PieceSet> pieces;
  if (!options.folder.empty() || !options.pieces.empty()) {
    pieces.emplace(subject.after, options.smallest_mm3);
    if (!options.pieces.empty()) pieces->Restore(ReadTextFile(options.pieces, kMaxPiecesFile), options.pieces);
  }
  if (!options.folder.empty()) {
    ExportInput taken{.title = subject.title,
                      .plan = &subject.plan,
                      .assessment = &assessment,
                      .pieces = &*pieces,
                      .figures = subject.figures,
                      .measures = {},
                      .pictures = {},
                      .curves = subject.curves,
                      .provenance = subject.provenance,
                      .recording = subject.recording};
    StageBars bars;
    if (!options.no_pictures && kPicturesBuilt) {
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
    WriteTextFile(options.table, FormatMeasuresCsv(measured));
  }
  if (options.json) {
    fmt::print("{}", FormatAssessmentJson(assessment, subject.recording));
  } else {
    PrintForPeople(subject, assessment, pieces ? &*pieces : nullptr);
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
  command->add_option("--before", options->before, "Bone before the cut (.vdb); default: the scene's");
  command->add_option("--after", options->after, "Bone after the cut (.vdb)");
  command->add_option("--plan", options->plan, "Planes of 3D Slicer, as for FILE, instead of the scene's plan");
  command->add_option("--bone", options->bone_file, "Bone file of the recording, if it was moved (.vdb)");
  command->add_option("--pieces", options->pieces, "Positions of the pieces: an earlier pieces.json");
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
