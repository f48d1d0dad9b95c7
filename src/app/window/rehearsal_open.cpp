// Opening and closing the case of a rehearsal.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>

#include "app/window/ct_source.h"
#include "app/window/plan_picture.h"
#include "app/window/rehearsal.h"
#include "base/files/extension.h"
#include "kerf/error.h"
#include "session/link/slicer_link.h"
#include "session/project/project.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

constexpr std::chrono::milliseconds kEnd{300};  // time that other threads get to end when the window is closed

/// Returns what tells a series from others, in lines.
std::string DescribeSeries(const DicomSeries& series) {
  const DicomSlice& first = series.slices.front();
  std::string text =
      fmt::format(fmt::runtime(Tr("{} slices of {} x {} pixels")), series.slices.size(), first.size[0], first.size[1]);
  if (const double gap_mm = series.stated_gap_mm(); gap_mm > 0)
    text += fmt::format(fmt::runtime(Tr(", {} mm apart")), ShowNumber(gap_mm, 2));
  if (first.thickness_mm > 0) text += fmt::format(fmt::runtime(Tr(", {} mm thick")), ShowNumber(first.thickness_mm, 2));
  if (!first.kernel.empty()) text += fmt::format(fmt::runtime(Tr(", kernel {}")), first.kernel);
  std::string names = series.modality;
  for (const std::string& name : {series.description, series.part_name, series.study_date}) {
    if (!name.empty()) names += (names.empty() ? "" : ", ") + name;
  }
  return names.empty() ? text : names + "\n" + text;
}

}  // namespace

void Rehearsal::BeginOpening(const std::string& input) {
  const int session = viewer_->sessions() + 1;
  const std::string& folder = options_.viewer.folder;
  loader_.Begin(
      input,
      {.bone_file = fmt::format("{}/bone{}.vdb", folder, session == 1 ? "" : fmt::format("-{}", session)),
       .voxel_mm = options_.voxel_mm,
       .mesh_units = is_sent(input) ? kSentUnits : mesh_units_,
       .project_folder = fmt::format("{}/project{}", folder, inputs_ == 0 ? "" : fmt::format("-{}", inputs_ + 1)),
       .make_bone = keeps_case_,
       .keep_W = separation_ ? separation_->keep_W() : std::vector<Vec3>(),
       .drop_W = separation_ ? separation_->drop_W() : std::vector<Vec3>(),
       .iso = scan_check_ ? scan_check_->iso() : std::nullopt,
       .series = series_,
       .as_ct = !series_.empty(),
       .frame = scan_check_ ? scan_check_->frame() : "",
       .spacing_z_mm = scan_check_ ? scan_check_->spacing_z_mm() : 0,
       .check_placing = !scan_check_},
      !keeps_case_);
}

void Rehearsal::Open(const std::string& path) {
  if (IsCurvesPath(path)) {
    if (viewer_->is_running() && !change_.is_pending()) return editor_.marks.Read(path);
    return viewer_->dialogs().Ask(Tr("Curves of 3D Slicer become marks on a bone. Open the bone first."),
                                  {{Tr("OK"), nullptr}});
  }
  try {
    CheckInput(path);  // a wrong file must not end the session
  } catch (const Error& e) {
    return viewer_->dialogs().Ask(ExplainRefusal(e.what()), {{Tr("OK"), nullptr}});
  }
  if (ended_work_ && !ended_work_->saved) {
    return viewer_->dialogs().Ask(DescribeUnsaved(),
                                  {{Tr("Save the project as"), [this] { AskProjectFile(false); }},
                                   {Tr("Open without saving"), [this, path] { OpenNow(path, true); }},
                                   {Tr("Stay"), nullptr}});
  }
  if (!save_orders_.empty()) {
    return viewer_->dialogs().Ask(Tr("The project is still being saved. Open the other file after that."),
                                  {{Tr("OK"), nullptr}});
  }
  const std::string changes = DescribeChanges();
  if (changes.empty()) return OpenNow(path, false);
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  viewer_->dialogs().Ask(fmt::format("{} {}", changes, AskToSaveBefore(path)),
                         {{Tr("Save"),
                           [this, path] {
                             to_open_once_saved_ = path;
                             SaveProject(false);
                           }},
                          {Tr("Open without saving"), [this, path] { OpenNow(path, true); }},
                          {Tr("Stay"), nullptr}});
}

void Rehearsal::OpenNow(const std::string& path, bool accepts_loss) {
  if (is_loading() && !has_case() && !interrupted_) interrupted_ = loader_.input();
  if (is_opening()) {
    loader_.Cancel();
    opened_.reset();
    EndQuestions();
  } else if (is_loading()) {
    viewer_->End();  // Cancelled() follows
  }
  to_open_ = path;
  accepts_loss_ = accepts_loss;
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
}

void Rehearsal::Cancel() {
  interrupted_.reset();
  if (is_opening()) {
    loader_.Cancel();
    opened_.reset();
    if (separation_ && !separation_->asks()) return separation_->Ask("");  // the points are kept
    if (scan_check_ && !scan_check_->asks() && !separation_) return scan_check_->Ask();
    const bool asked = separation_ || scan_check_;
    EndQuestions();
    if (!has_case() && asked) to_open_ = "";  // the built-in bone
    if (!has_case()) return Reset();
    viewer_->Say(Tr("Opening was cancelled. The case before it is still open."));
  } else if (is_loading()) {
    viewer_->End();  // Cancelled() follows
  }
}

bool Rehearsal::is_loading() const {
  const LiveSession* session = viewer_->session();
  return is_opening() || (session != nullptr && session->stage() == LiveStage::kLoading && is_new_bone_);
}

/// Empties the window and forgets everything that belongs to the bone.
void Rehearsal::Reset() {
  if (in_pieces_) LeavePieces();
  begins_in_pieces_ = false;
  pieces_.Reset();
  menu_.reset();
  change_.Drop();
  to_save_.reset();
  checkpoints_.clear();
  editor_.document.Load({}, {});
  editor_.gestures.Reset();
  editor_.marks.Reset();
  unsaved_cut_ = {};
  to_open_once_saved_.reset();
  cut_.reset();
  choice_ = {};
  ended_work_.reset();
  save_orders_.clear();
  before_.reset();
  original_.reset();
  earlier_recordings_.clear();
  earlier_bones_.clear();
  sessions_.clear();
  distances_.Reset();
  ct_reader_.Cancel();
  plan_link_.End();
  HidePlan(*viewer_);
  editor_.gestures.Hide();
  viewer_->Clear();
}

void Rehearsal::FollowOpening() {
  ShowOpeningFault();
  const bool ready = viewer_->session() == nullptr || viewer_->is_running();
  if (to_open_ && ready && !change_.is_pending() && !change_.is_making() && !viewer_->quitting()) {
    const std::string input = *std::exchange(to_open_, std::nullopt);
    keeps_case_ = has_case();
    if (!keeps_case_) Reset();
    is_command_line_ = false;
    BeginOpening(input);
  }
  const std::shared_ptr<const Volume> ct = loader_.ct();
  try {
    if (std::optional<OpenedInput> opened = loader_.Take()) opened_ = std::move(opened);
  } catch (const UnclearUnit& e) {
    return AskForUnit(e);
  } catch (const UnclearSeries& e) {
    return AskForSeries(e);
  } catch (const NotPlaced& e) {
    return AskAboutScan(ct, e.placing(), e.values());
  } catch (const NotHu& e) {
    return AskAboutScan(ct, std::nullopt, e);
  } catch (const NotIsolated& e) {
    return AskForPoints(ct, e);
  } catch (const Error& e) {
    if (is_command_line_) throw;
    return FailToOpen(e.what());
  }
  if (!opened_ || viewer_->quitting()) return;
  if (has_case() && !AskBeforeCaseEnds()) return;
  if (viewer_->session() != nullptr) return viewer_->End();
  OpenedInput opened = *std::exchange(opened_, std::nullopt);
  if (keeps_case_) Reset();
  BeginCase(std::move(opened));
}

/// Opens a bone that a peer of the link has sent, once nothing else is being opened or asked.
void Rehearsal::FollowSentBone() {
  const std::shared_ptr<SlicerLink>& link = options_.viewer.link;
  const bool busy = is_loading() || to_open_ || to_open_once_saved_ || change_.is_pending() || change_.is_making() ||
                    viewer_->dialogs().is_open() || viewer_->quitting();
  if (!link || busy) return;
  const std::optional<SentBone> bone = link->bone().Fetch();
  if (!bone) return;
  try {
    sent_bone_ = WriteSentBone(*bone, fmt::format("{}/{}-{}", options_.viewer.folder, kBoneName, ++sent_bones_));
  } catch (const Error& e) {
    link->Refuse(e.what());
    return viewer_->Warn(TrMade(e.what()));
  }
  viewer_->Say(Tr("3D Slicer has sent a bone."));
  Open(sent_bone_);
}

/// Prepares a question about what is being opened. Returns why it is asked as a sentence.
std::string Rehearsal::BeginQuestion(const char* event, const std::string& why) {
  viewer_->trace().Write(event, {{"why", why}});
  is_command_line_ = false;  // from now on, the window stays
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  std::string sentence = TrMade(why);
  if (!sentence.empty()) sentence[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence[0])));
  return sentence;
}

/// Asks for the unit of a surface's coordinates, with which it is opened again.
void Rehearsal::AskForUnit(const UnclearUnit& e) {
  const std::string why = BeginQuestion("asks_for_unit", e.why());
  if (!has_case()) Reset();
  std::vector<Dialogs::Answer> answers;
  for (const auto& [unit, side_mm] : e.choices()) {
    answers.push_back({fmt::format("{}: {} mm", unit, ShowNumber(side_mm, side_mm < 100 ? 1 : 0)), [this, unit = unit] {
                         mesh_units_ = unit;
                         BeginOpening(loader_.input());
                       }});
  }
  answers.push_back({Tr("Cancel"), nullptr});
  viewer_->dialogs().Ask(
      fmt::format("{}.\n\n{}", why, Tr("In which unit are its coordinates, and how long is then its largest side?")),
      std::move(answers));
  viewer_->dialogs().IgnoreEnter();
}

/// Asks which series of a folder is the CT, with which it is opened again.
void Rehearsal::AskForSeries(const UnclearSeries& e) {
  const std::string why = BeginQuestion("asks_for_series", e.why());
  if (!has_case()) Reset();
  std::vector<Dialogs::Answer> answers;
  for (std::size_t i = 0; i < e.series().size(); ++i) {
    const DicomSeries& series = e.series()[i];
    Dialogs::Answer& answer = answers.emplace_back(Dialogs::Answer{DescribeSeries(series), [this, uid = series.name()] {
                                                                     series_ = uid;
                                                                     BeginOpening(loader_.input());
                                                                   }});
    answer.picture = Image{1, 1, {Rgb8{0, 0, 0}}};
    if (i >= e.pictures.size() || e.pictures[i].empty()) continue;
    const int side = static_cast<int>(std::lround(std::sqrt(e.pictures[i].size())));
    answer.picture = Image{side, side, {}};
    for (const std::uint8_t grey : e.pictures[i]) answer.picture.pixels.push_back({grey, grey, grey});
  }
  answers.push_back({Tr("Cancel"), [this] { EndQuestions(); }});
  viewer_->dialogs().Ask(
      fmt::format("{}.\n\n{}", why,
                  e.series().size() > 1 ? Tr("Which one is the CT of the bone?") : Tr("Click on it if it is a CT.")),
      std::move(answers));
  viewer_->dialogs().IgnoreEnter();
}

/// Asks, with the slices of a CT, for what its file does not state.
void Rehearsal::AskAboutScan(const std::shared_ptr<const Volume>& ct, const std::optional<AssumedPlacing>& placing,
                             const std::optional<NotHu>& values) {
  BeginQuestion("asks_about_scan", values ? values->why() : "");
  const bool begins = !scan_check_;
  if (begins) scan_check_.emplace(ct, placing, values);
  preview_.set_greys(scan_check_->CalcGreys(false));
  preview_.Follow(ct);
  if (begins) preview_.Show(CalcScanBox(*ct).centre());
  scan_check_->Ask();
}

void Rehearsal::ImportChecked() {
  scan_check_->EndAsking();
  preview_.set_greys(scan_check_->CalcGreys(true));
  BeginOpening(loader_.input());
}

void Rehearsal::EndQuestions() {
  separation_.reset();
  mesh_units_.clear();
  series_.clear();
  if (scan_check_) preview_.set_greys({});
  scan_check_.reset();
}

/// Asks for points with which the mandible is separated from bone that it touches.
void Rehearsal::AskForPoints(const std::shared_ptr<const Volume>& ct, const NotIsolated& e) {
  constexpr double kRim_mm = 15;  // around the bone
  constexpr double kTeeth = 0.2;  // where they are, from front to back
  const std::string why = BeginQuestion("asks_for_points", e.why());
  if (!separation_) {
    separation_.emplace(ct, scan_check_ ? scan_check_->CalcIsoHu() : IsolateOptions{}.iso_hu);
    const CtWindow& window = viewer_->slices().window();
    preview_.set_greys(scan_check_ ? scan_check_->CalcGreys(true) : CtGreys{window.level_HU, window.width_HU});
    preview_.Follow(ct);
    preview_.set_box(e.largest_W().Grown(kRim_mm));
    Vec3 shown_W = e.largest_W().centre();
    shown_W.y += (kTeeth - 0.5) * e.largest_W().size().y;
    preview_.Show(shown_W);
  }
  separation_->Ask(why);
}

void Rehearsal::SeparateJaws() {
  if (separation_->Separate()) BeginOpening(loader_.input());
}

/// Returns the question whether to save the open case before another one is opened.
std::string Rehearsal::AskToSaveBefore(const std::string& path) const {
  return is_sent(path) ? Tr("Save the project before the bone that 3D Slicer has sent is opened?")
                       : Tr("Save the project before you open something else?");
}

/// Returns true if the case that is open may end now. The user may have worked on it while the next one was opened.
bool Rehearsal::AskBeforeCaseEnds() {
  if (viewer_->dialogs().is_open() || writer_.is_saving() || !save_orders_.empty()) return false;
  if (accepts_loss_) return true;
  const bool lost_work = ended_work_ && !ended_work_->saved;
  const std::string loss = lost_work ? DescribeUnsaved() : DescribeChanges();
  if (loss.empty()) return true;
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  viewer_->dialogs().Ask(lost_work ? loss : fmt::format("{} {}", loss, AskToSaveBefore(loader_.input())),
                         {{Tr("Save"), [this] { SaveProject(false); }},
                          {Tr("Open without saving"), [this] { accepts_loss_ = true; }},
                          {Tr("Stay"), [this] { opened_.reset(); }}});
  return false;
}

/// A change of saw or guide would begin another session. Returns true, with a message, if an input is being opened.
bool Rehearsal::RefuseWhileOpening() {
  if (!to_open_ && !is_opening()) return false;
  viewer_->Say(Tr("Another file is being opened. Wait for it, or cancel it with Escape."));
  return true;
}

void Rehearsal::FailToOpen(const std::string& sentence) {
  viewer_->trace().Write("not_opened", {{"failure", sentence}});
  if (is_sent(loader_.input())) options_.viewer.link->Refuse(sentence);
  EndQuestions();
  if (!has_case()) {
    Reset();
    if (!interrupted_) return viewer_->Say(ExplainRefusal(sentence));
    to_open_ = std::exchange(interrupted_, std::nullopt);  // what was loading before is loaded again
  }
  opening_fault_ = ExplainRefusal(sentence);
  ShowOpeningFault();
}

void Rehearsal::ShowOpeningFault() {
  if (opening_fault_.empty() || viewer_->dialogs().is_open()) return;
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  viewer_->dialogs().Ask(fmt::format("{}\n\n{}", std::exchange(opening_fault_, {}),
                                     has_case() ? Tr("The case that was open is still open.")
                                                : Tr("What was loading before is loaded again.")),
                         {{Tr("OK"), nullptr}});
}

void Rehearsal::BeginCase(OpenedInput opened) {
  interrupted_.reset();
  EndQuestions();
  if (!loader_.input().empty()) {
    AddRecent(viewer_->settings(), loader_.input());
    viewer_->KeepSettings();
  }
  scene_ = std::move(opened.scene);
  scene_file_ = opened.scene_file;
  original_ = opened.original;
  viewer_->set_original(original_);
  scene_files_ = std::move(opened.scene_files);
  choice_.guided = FindGuide(scene_) != scene_.effects.end();
  project_file_ = opened.project ? std::filesystem::absolute(loader_.input()).string() : "";
  views_ = opened.project ? opened.project->views : std::vector<ProjectView>();
  pieces_json_ = opened.project ? opened.project->pieces_json : "";
  measurements_ = opened.project ? opened.project->measurements : std::vector<MeasuredPoints>();
  earlier_recordings_ = opened.project ? opened.project->recordings : std::vector<std::string>();
  if (opened.project) earlier_bones_ = opened.project->bones;
  sessions_ = opened.project ? ListSessions(*opened.project) : std::vector<ProjectSession>();
  input_ = opened.project || !opened.scene_file.empty() ? "" : loader_.input();
  if (opened.project) TakeSettings(opened.project->settings);
  editor_.document.Load(scene_.plan, opened.project ? opened.project->marks : std::vector<Mark>());
  if (const auto guide = FindGuide(scene_); guide != scene_.effects.end()) {
    const std::vector<PlannedPlane>& planes = editor_.document.plan().planes;
    const auto guided =
        std::find_if(planes.begin(), planes.end(), [&](const PlannedPlane& plane) { return IsGuideOf(*guide, plane); });
    if (guided != planes.end()) editor_.document.set_plane_index(static_cast<std::size_t>(guided - planes.begin()));
  }
  if (!given_planes_.empty()) editor_.document.Add(std::exchange(given_planes_, {}));
  editor_.document.set_unsaved(false);
  if (opened.bone && !opened.bone_is_saved) to_save_ = ToSave{opened.bone, scene_.bone.file};
  shows_import_ = !opened.warnings.empty();
  is_new_bone_ = true;
  ++inputs_;
  first_recording_ = result_.recordings.size();
  viewer_->ShowCt(MakeCtSource(std::move(opened.ct)));
  Restart(std::move(opened.bone), opened.bone_was_shown);
}

/// Begins to read the CT of a project's bone, of which the project itself has only what is near the bone, or nothing.
void Rehearsal::ReadCtAgain() {
  if (!input_.empty() && LowerExtension(input_) != ".vdb") return ct_reader_.Begin(before_, input_);
  viewer_->Warn(before_->has_hu()
                    ? Tr("This project contains the CT only near the bone: the rest of the slices is black.")
                    : Tr("This project does not contain the CT, so the slices show the bone's tissues."));
}

/// Lets the slices show the CT that was read again, or says why it was not.
void Rehearsal::FollowCtReader() {
  const std::optional<CtReader::Result> result = ct_reader_.Take();
  if (!result) return;
  viewer_->trace().Write("ct_again", {{"failure", result->why_not}});
  if (!result->ct) return viewer_->Warn(TrMade(result->why_not));
  viewer_->ShowCt(MakeCtSource(result->ct));
}

void Rehearsal::Cancelled() {
  result_.recordings.pop_back();
  if (is_new_bone_) --inputs_;
  if (!viewer_->quitting()) Reset();
}

bool Rehearsal::TakeFailure(const std::string& sentence, LoopSummary* summary) {
  if (summary != nullptr) {
    sessions_.push_back(MakeSession());
    KeepWork(fmt::format(fmt::runtime(Tr("The session has ended by a failure: {}")), sentence), sentence, scene_,
             std::make_shared<const Bone>(std::move(summary->after)));
    return true;
  }
  if (to_save_ && change_.is_pending()) {
    result_.recordings.pop_back();
    std::shared_ptr<const Bone> bone = std::exchange(to_save_, std::nullopt)->bone;
    KeepWork(fmt::format(fmt::runtime(Tr("The session could not be continued: {}")), sentence), sentence, scene_,
             std::move(bone));
    return true;
  }
  if (is_command_line_ || !is_new_bone_) return false;
  result_.recordings.pop_back();
  --inputs_;
  Reset();
  viewer_->Say(sentence);
  return true;
}

// ---- closing

std::string Rehearsal::DescribeChanges() const {
  if (!viewer_->is_running() && !ended_work_) return {};
  const bool plan = editor_.document.is_unsaved() || pieces_.is_unsaved();
  if (!unsaved_cut_.is_unsaved()) {
    return plan ? Tr("The plan, the marks, the pieces or the measurements have changed since they were last saved.")
                : "";
  }
  if (project_file_.empty()) return Tr("The cut in the bone is not saved in a project.");
  return plan ? Tr("The bone was cut since the project was last saved, and the plan, the marks or the pieces have "
                   "changed.")
              : Tr("The bone was cut since the project was last saved.");
}

std::string Rehearsal::DescribeUnsaved() const {
  if (ended_work_ && !ended_work_->saved) {
    return Tr(
        "The session has ended, and the project was not saved after that: the bone as it is now, the plan, the "
        "marks and the pieces would be lost. Save the project?");
  }
  if (!save_orders_.empty()) return Tr("The project is still to be saved. Save it before you quit?");
  const std::string changes = DescribeChanges();
  return changes.empty() ? "" : fmt::format("{} {}", changes, Tr("Save the project before you quit?"));
}

/// Ends what other threads still do: a file that is being written is completed, and loading is cancelled.
void Rehearsal::EndWork() {
  loader_.Cancel();
  ct_reader_.Cancel();
  while (writer_.is_saving() || !save_orders_.empty()) {
    if (const std::string why = writer_.FinishSaving(); !why.empty()) {
      result_.failures.push_back(fmt::format("the project was not saved: {}", why));
    }
    if (save_orders_.empty()) continue;
    if (!has_work()) {
      result_.failures.push_back(
          fmt::format("{}: was not saved, because the session had ended", save_orders_.front().file));
      save_orders_.clear();
    }
    FollowSaving();
  }
  writer_.FinishExport();
  result_.take_away = writer_.take_away();
  result_.exports = writer_.exports();
  for (std::string& sentence : saver_.Finish()) result_.warnings.push_back(std::move(sentence));
  const auto until = std::chrono::steady_clock::now() + kEnd;
  result_.left_work = viewer_->left_work() || !distances_.WaitUntil(until) || !loader_.WaitUntil(until) ||
                      !ct_reader_.WaitUntil(until) || !editor_.marks.WaitUntil(until);
}

}  // namespace kerf
