#include "app/window/practice.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "app/window/beeper.h"
#include "app/window/is_ready.h"
#include "base/files/files.h"
#include "kerf/error.h"
#include "loop/record/recording.h"
#include "session/plan/plan.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// The gauge asks the student to slow down from kSlow_mm before the goal on, and to stop from kStop_mm on.
constexpr double kSlow_mm = 1.0;
constexpr double kStop_mm = 0.3;

HudLevel LevelOf(double to_goal_mm) {
  return to_goal_mm < -kSlow_mm   ? HudLevel::kBad
         : to_goal_mm < -kStop_mm ? HudLevel::kWarn
         : to_goal_mm < kStop_mm  ? HudLevel::kGood
         : to_goal_mm < kSlow_mm  ? HudLevel::kWarn
                                  : HudLevel::kPlain;
}

/// Formats a value with its unit: small values with one more digit, integers without decimals.
std::string ShowValue(double value, const std::string& unit) {
  const int digits = value == std::round(value) && unit.empty() ? 0 : std::abs(value) < 0.1 ? 3 : 2;
  const std::string shown = fmt::format("{:.{}f}", std::abs(value) < 0.0005 ? 0.0 : value, digits);
  return unit.empty() ? shown : fmt::format("{} {}", shown, unit == "degrees" ? "°" : unit);
}

/// Returns the path of the score sheet next to a recording.
std::string PageOf(const std::string& recording) {
  return recording.substr(0, recording.rfind('.')) + ".html";
}

/// Returns the colour of the blade. The colours are distinguishable with red-green colour blindness.
Rgb8 ColourOf(HudLevel level) {
  switch (level) {
    case HudLevel::kGood:
      return {0, 158, 115};
    case HudLevel::kWarn:
      return {230, 159, 0};
    case HudLevel::kBad:
      return {170, 40, 60};
    default:
      return kSteelColour;
  }
}

}  // namespace

Practice::Practice(const PracticeOptions& options) : options_(options) {
  options_.viewer.ghost = false;  // the handle's picture would hide the blade's colour
  if (!options_.exercise.empty()) FindExercise(options_.exercise);
  if (!options_.student.empty()) history_.emplace(FindHistoryFile());
  viewer_ = std::make_unique<ViewerApp>(options_.viewer);
}

Practice::~Practice() {
  stop_scoring_ = true;
}

std::vector<std::string> Practice::Run() {
  if (options_.exercise.empty()) {
    Choose();
  } else {
    Start(options_.exercise, options_.level);
  }
  viewer_->Run(*this);
  return recordings_;
}

// ---- choosing

void Practice::Choose() {
  state_ = State::kChoosing;
  std::vector<MenuItem> items;
  for (const Exercise& exercise : ListExercises()) {
    items.push_back({.name = exercise.title, .detail = exercise.goal, .enabled = true, .choose = [this, &exercise] {
                       ChooseLevel(exercise);
                     }});
  }
  menu_.emplace("Exercises, easy to hard", std::move(items), "Up, Down: move   Enter: select   Ctrl+Q: quit");
}

void Practice::ChooseLevel(const Exercise& exercise) {
  static constexpr std::array<const char*, kLevels> kAids{"all aids", "no depth stop", "gauge and blade colour",
                                                          "gauge only", "no aids"};
  std::vector<MenuItem> items;
  for (int level = 1; level <= kLevels; ++level) {
    items.push_back({.name = fmt::format("Level {}", level),
                     .detail = kAids[static_cast<std::size_t>(level - 1)],
                     .enabled = true,
                     .choose = [this, id = exercise.id, level] { Start(id, level); }});
  }
  menu_.emplace(exercise.title, std::move(items));
}

void Practice::Start(const std::string& id, int level) {
  exercise_ = &FindExercise(id);
  scene_ = MakeExerciseScene(id, level);
  if (scene_.exercise.depth_stop) {
    const WantedCut cut = MakeWantedCut(scene_.exercise, MakeTool(scene_));
    const DepthStop stop{.name = "goal", .p_W_mm = cut.start_W, .direction_W = cut.into_W, .depth_mm = cut.depth_mm};
    scene_.effects.push_back(MakeGuide(nullptr, &stop));
  }
  options_.level = level;
  gauge_.reset();
  nerve_.reset();
  sheet_.reset();
  scored_ = true;
  state_ = State::kCutting;
  viewer_->Begin(scene_, exercise_->file);
  recordings_.push_back(viewer_->recording());
}

// ---- cutting

void Practice::Began() {
  const std::shared_ptr<const Bone> bone = viewer_->bone_at_start();
  gauge_ = std::make_unique<DepthGauge>(*bone, MakeWantedCut(scene_.exercise, MakeTool(scene_)));
  making_nerve_ =
      std::async(std::launch::async, [bone] { return std::make_unique<RegionDistance>(*bone, Tissue::kCanal); });
  if (scene_.exercise.sound) beeper_ = std::make_unique<Beeper>();
  ShowGoal();
  // View from the side and a little from above, with the line across the picture. Motion is restricted to the blade's
  // plane, so that cuts are straight.
  const WantedCut& cut = gauge_->cut();
  const Vec3 side_W = glm::cross(cut.along_W, -cut.into_W);  // the line points to the right
  const Vec3 middle_W = cut.ToWorld({0.5 * cut.length_mm, 0, 0});
  // Look at the cut from outside the bone.
  const bool inside = glm::dot(side_W, middle_W - viewer_->bone_at_start()->CalcBounds().centre()) < -1;
  ViewCamera& camera = viewer_->view().camera();
  camera.Look((inside ? -side_W : side_W) - 0.6 * cut.into_W, -cut.into_W);
  viewer_->view().FitAll();
  camera.set_target_W(middle_W - 0.25 * cut.radius_mm * cut.into_W);
  camera.set_height_mm(std::min(camera.height_mm(), 3.2 * cut.radius_mm + cut.length_mm));
  viewer_->controls().set_in_blade_plane(true);
  begun_ = false;
}

void Practice::ShowGoal() {
  const WantedCut& cut = gauge_->cut();
  GuideOverlay line;
  line.points_W = {cut.ToWorld({0, 0, 0}), cut.ToWorld({cut.length_mm, 0, 0})};
  viewer_->view().SetGuides({line});
  if (exercise_->toml.find("\"osteotomy\"") == std::string::npos) return viewer_->view().SetPlanes({});
  viewer_->view().SetPlanes({{.name = "plan",
                              .p_W = cut.ToWorld({0.5 * cut.length_mm, 0.5 * cut.depth_mm, 0}),
                              .normal_W = cut.across_W,
                              .width_mm = cut.length_mm + 20,
                              .height_mm = cut.depth_mm + 20,
                              .up_W = -cut.into_W}});
}

void Practice::Finish(bool scored) {
  scored_ = scored;
  beeper_.reset();
  viewer_->SetSpindle(false);
  viewer_->End();
}

std::optional<DepthReading> Practice::Read() const {
  return gauge_ && viewer_->is_running() ? gauge_->Calc(viewer_->figures().coupled.X_WT) : std::nullopt;
}

void Practice::Ended(LoopSummary /*summary*/) {
  beeper_.reset();
  viewer_->view().ClearTool();
  if (viewer_->quitting()) return;
  if (scored_) {
    Score();
  } else {
    Choose();
  }
}

void Practice::Score() {
  state_ = State::kScoring;
  scoring_ = std::async(std::launch::async, [this, file = recordings_.back()] {
    RecordingReader recording(file);
    ScoreOptions score;
    score.stop = &stop_scoring_;
    return ScoreRecording(recording, score, [this](const std::string& stage, double fraction) {
      const std::lock_guard lock(mutex_);
      scoring_stage_ = stage;
      scoring_fraction_ = fraction;
    });
  });
}

// ---- the result

HudResult Practice::MakeResult() const {
  HudResult result;
  result.title = fmt::format("{}, level {}", exercise_->title, options_.level);
  result.headline = sheet_->total                ? fmt::format("{:.0f} out of 100", *sheet_->total)
                    : sheet_->incomplete.empty() ? "not scored"
                                                 : "not graded";
  if (const std::optional<double> fraction = sheet_->Get("cut_share"); fraction && sheet_->total) {
    result.rows.push_back({.name = "fraction of the wanted cut",
                           .value = fmt::format("{:.2f}", *fraction),
                           .note = "times the points below",
                           .level = *fraction > 0.9   ? HudLevel::kGood
                                    : *fraction > 0.6 ? HudLevel::kWarn
                                                      : HudLevel::kBad});
  }
  for (const bool counts : {true, false}) {
    for (const MeasureRow& row : sheet_->rows) {
      if (!row.value || (row.weight > 0) != counts || std::string_view(row.info->key) == "cut_share") continue;
      HudResultRow line;
      line.name = row.info->name;
      line.value = ShowValue(*row.value, row.info->unit);
      line.note = counts ? fmt::format("{:.0f} % of its points", 100 * row.points.value_or(0)) : "information";
      const double points = row.points.value_or(1);
      line.level = !counts         ? HudLevel::kPlain
                   : points >= 0.7 ? HudLevel::kGood
                   : points >= 0.4 ? HudLevel::kWarn
                                   : HudLevel::kBad;
      result.rows.push_back(std::move(line));
    }
  }
  result.footer = fmt::format("Enter: again{}   Esc: other exercises   Report: {}",
                              options_.level < kLevels ? "   N: next level" : "", PageOf(recordings_.back()));
  return result;
}

// ---- events and frames

void Practice::AddActions(ActionList& actions) {
  actions.Add({.id = "exercise.finish",
               .menu = Mark("Exercise"),
               .label = Mark("Finish and see the score"),
               .shortcut = {Key::kEnter},
               .run = [this] { Finish(true); },
               .enabled = [this] { return state_ == State::kCutting && viewer_->is_running(); },
               .relevant = [this] { return state_ == State::kCutting; },
               .button = Mark("Finish")});
  actions.Add({.id = "exercise.leave",
               .menu = Mark("Exercise"),
               .label = Mark("Leave without a score"),
               .shortcut = {Key::kEscape},
               .run = [this] { Finish(false); },
               .enabled = [this] { return state_ == State::kCutting && viewer_->is_running(); }});
  actions.Add({.id = "exercise.again",
               .menu = Mark("Exercise"),
               .label = Mark("Try again"),
               .shortcut = {Key::kEnter},
               .run = [this] { Start(exercise_->id, options_.level); },
               .enabled = [this] { return state_ == State::kResult; },
               .relevant = [this] { return state_ == State::kResult; },
               .button = Mark("Try again")});
  actions.Add({.id = "exercise.next",
               .menu = Mark("Exercise"),
               .label = Mark("Next level"),
               .shortcut = {Key::kN},
               .run = [this] { Start(exercise_->id, options_.level + 1); },
               .enabled = [this] { return state_ == State::kResult && options_.level < kLevels; }});
  actions.Add({.id = "exercise.list",
               .menu = Mark("Exercise"),
               .label = Mark("Other exercises"),
               .shortcut = {Key::kEscape},
               .run = [this] { Choose(); },
               .enabled = [this] { return state_ == State::kResult; }});
}

void Practice::PickMenuRow(int row) {
  if (!menu_ || menu_->Pick(row) != Menu::State::kChosen) return;
  const Menu done = *std::exchange(menu_, std::nullopt);
  done.chosen().choose();
}

void Practice::Open(const std::string& /*path*/) {
  viewer_->Say(Tr("An exercise brings its own bone; use 'kerf rehearse' to open a file"));
}

bool Practice::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (menu_) {
    if (event.control) return false;
    const Menu::State state = menu_->Take(event);
    if (state == Menu::State::kOpen) return event.kind != Kind::kKeyUp && event.key != Key::kF12;
    const Menu done = *std::exchange(menu_, std::nullopt);
    if (state == Menu::State::kChosen) {
      done.chosen().choose();
    } else {
      Choose();
    }
    return true;
  }
  return false;
}

void Practice::Update(double /*dt_s*/) {
  if (IsReady(making_nerve_)) nerve_ = making_nerve_.get();
  if (state_ == State::kCutting && viewer_->is_running()) {
    const double limit_s = scene_.exercise.time_limit_s;
    if (limit_s > 0 && viewer_->figures().time_s > limit_s) {
      viewer_->Say("Time is up");
      Finish(true);
    }
    const std::optional<DepthReading> reading = Read();
    const bool in_bone = reading && reading->depth_mm > 0;
    if (beeper_) beeper_->Set(in_bone ? std::optional(reading->to_goal_mm) : std::nullopt);
    if (scene_.exercise.colour) {
      viewer_->view().SetToolColour(in_bone ? ColourOf(LevelOf(reading->to_goal_mm)) : kSteelColour);
    }
  }
  if (!IsReady(scoring_)) return;
  try {
    sheet_ = scoring_.get();
    WriteTextFile(PageOf(recordings_.back()), FormatSheetHtml(*sheet_));
  } catch (const Error& e) {
    viewer_->Say(e.what());
    if (!sheet_) return Choose();
  }
  state_ = State::kResult;
  viewer_->trace().Write("score", {{"total", sheet_->total ? nlohmann::json(*sheet_->total) : nullptr},
                                   {"sheet", nlohmann::json(SheetJson(*sheet_))}});
  if (!history_) return;
  if (sheet_->Get("removed_mm3").value_or(0) <= 0) return viewer_->Say("Nothing was cut: the attempt is not saved");
  try {
    history_->Add(MakeAttempt(*sheet_, options_.student));
    viewer_->Say(fmt::format("Saved for {}{}{}", options_.student,
                             sheet_->incomplete.empty() ? "" : "; not graded: ", fmt::join(sheet_->incomplete, "; ")));
  } catch (const Error& e) {
    viewer_->Say(fmt::format("Not saved: {}; use 'kerf practise --hand-in {}' later", e.what(), recordings_.back()));
  }
}

HudGauge Practice::MakeGauge(const std::optional<DepthReading>& reading) const {
  HudGauge gauge;
  gauge.title = "Depth";
  gauge.upper = scene_.exercise.depth_mm + 1.8 * kSlow_mm;
  gauge.good = kStop_mm;
  gauge.warn = kSlow_mm;
  gauge.goal = scene_.exercise.depth_mm;
  if (!reading) return gauge;
  gauge.value = reading->depth_mm;
  gauge.level = LevelOf(reading->to_goal_mm);
  gauge.word = reading->depth_mm < 0             ? "above the bone"
               : reading->to_goal_mm < -kStop_mm ? "too deep"
               : reading->to_goal_mm < kStop_mm  ? "stop: deep enough"
               : reading->to_goal_mm < kSlow_mm  ? "slow down"
                                                 : "continue";
  return gauge;
}

void Practice::Fill(HudState& hud) {
  hud.status.mode = exercise_ != nullptr && state_ != State::kChoosing
                        ? fmt::format("{}, level {}", exercise_->title, options_.level)
                        : "Practise";
  if (state_ == State::kCutting && viewer_->is_running()) {
    const std::optional<DepthReading> reading = Read();
    // Without the gauge the depth is not shown either.
    if (scene_.exercise.gauge) {
      hud.gauge = MakeGauge(reading);
      if (reading) hud.values.depth_mm = reading->depth_mm;
    }
    if (nerve_ && !nerve_->empty())
      hud.values.nerve_mm = nerve_->Calc(MakeTool(scene_), viewer_->figures().coupled.X_WT);
  }
  if (state_ == State::kCutting && viewer_->is_running()) {
    begun_ = begun_ || viewer_->spindle_on();
    if (!begun_) {
      hud.banner = HudBanner{.kind = HudBanner::Kind::kNotice,
                             .text = exercise_->goal,
                             .answers = "Space: spindle   Enter: finish   Esc: leave   F1: help"};
    }
    const double limit_s = scene_.exercise.time_limit_s;
    if (limit_s > 0) {
      hud.status.right = fmt::format("{:.0f} s left   F1 help", std::max(0.0, limit_s - viewer_->figures().time_s));
    }
  }
  if (state_ == State::kScoring) {
    const std::lock_guard lock(mutex_);
    hud.progress = HudProgress{.title = "Scoring", .stage = scoring_stage_, .fraction = scoring_fraction_};
  }
  if (state_ == State::kResult && sheet_) hud.result = MakeResult();
  if (menu_) hud.menu = menu_->Show();
}

void Practice::Describe(nlohmann::json& state) const {
  state["mode"] = state_ == State::kChoosing  ? "choosing"
                  : state_ == State::kCutting ? "cutting"
                  : state_ == State::kScoring ? "scoring"
                                              : "result";
  state["exercise"] = exercise_ != nullptr ? exercise_->id : "";
  state["level"] = options_.level;
  if (menu_) state["menu"] = menu_->title();
  if (const std::optional<DepthReading> reading = Read()) {
    state["depth_mm"] = std::round(100 * reading->depth_mm) / 100;
    state["to_goal_mm"] = std::round(100 * reading->to_goal_mm) / 100;
  }
}

}  // namespace kerf
