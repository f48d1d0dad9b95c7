#include "app/window/rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>

#include "app/window/export_order.h"
#include "app/window/is_ready.h"
#include "app/window/pieces_mode.h"
#include "base/files/files.h"
#include "bone/vdb/bonefile.h"
#include "kerf/error.h"
#include "session/plan/edit_plane.h"
#include "session/scene/path_csv.h"

namespace kerf {
namespace {

/// Returns the smallest rotation from one unit vector to another, less than half a turn.
Quat RotationBetween(const Vec3& from, const Vec3& to) {
  const Vec3 axis = glm::cross(from, to);
  return glm::normalize(Quat{1 + glm::dot(from, to), axis.x, axis.y, axis.z});
}

const Range kDepthRange_mm = FindRange<DepthStop>("depth_mm");

std::optional<double> ParseDepth(const std::string& text) {
  double depth_mm = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), depth_mm);
  if (error != std::errc{} || end != text.data() + text.size() || !kDepthRange_mm.Contains(depth_mm)) return {};
  return depth_mm;
}

}  // namespace

Rehearsal::Rehearsal(const RehearsalOptions& options) : options_(options) {
  for (const std::string& file : options_.plans) {
    for (PlannedPlane& plane : ReadPlannedPlanes(file)) plan_.planes.push_back(std::move(plane));
  }
  options_.viewer.watch = true;
  viewer_ = std::make_unique<ViewerApp>(options_.viewer);
}

Rehearsal::~Rehearsal() = default;

RehearsalResult Rehearsal::Run() {
  opening_ = std::async(std::launch::async, [this] {
    return OpenInput(options_.input, options_.open, [this](const std::string& stage, double fraction) {
      const std::lock_guard lock(mutex_);
      opening_stage_ = stage;
      opening_fraction_ = fraction;
    });
  });
  viewer_->Run(*this);
  return result_;
}

bool Rehearsal::cuts() const {
  return !in_pieces_ && !picking_ && !menu_;
}

// ---- sessions

void Rehearsal::Restart() {
  result_.recordings.push_back("");
  viewer_->Begin(scene_, scene_file_, viewer_->sessions() > 0);
  result_.recordings.back() = viewer_->recording();
}

void Rehearsal::Began() {
  const bool first = viewer_->sessions() == 1;
  before_ = viewer_->bone_at_start();
  if (!sampler_) sampler_ = std::make_unique<PhiSampler>(*before_);
  checkpoints_ = {"start"};
  if (first) {
    making_nerve_ = std::async(std::launch::async,
                               [bone = before_] { return std::make_unique<RegionDistance>(*bone, Tissue::kCanal); });
    viewer_->Say("Space starts the saw; drag with the left button to move it; F1 for help");
  } else if (change_) {
    viewer_->Say(std::exchange(change_, std::nullopt)->what);
  }
  ShowPlanInPicture();
}

void Rehearsal::ContinueWith(const std::string& what, std::function<void(Scene&)> change) {
  if (!viewer_->is_running() || change_) return;
  change_ = Change{.what = what, .apply = std::move(change)};
  viewer_->SetSpindle(false);
  viewer_->End();
}

void Rehearsal::Ended(LoopSummary summary) {
  if (!change_ || viewer_->quitting()) return;
  const Pose X_WT = viewer_->figures().coupled.X_WT;
  changing_ = std::async(std::launch::async, [this, X_WT, bone = std::move(summary.after)] {
    Scene scene = scene_;
    const std::string file = fmt::format("{}/bone-{}.vdb", options_.viewer.folder, viewer_->sessions() + 1);
    WriteBone(bone, file);
    scene.bone.source = BoneSource::kFile;
    scene.bone.file = std::filesystem::absolute(file).string();
    change_->apply(scene);
    const Tool tool = MakeTool(scene);
    const Pose X_clear = FindClearPose(bone, tool, X_WT);
    // The tool starts at the first pose of the path, and the hand continues from there.
    scene.path = {};
    scene.path.poses = {{.time_s = 0, .X_WT = X_clear}, {.time_s = 1, .X_WT = X_clear}};
    scene.path.poses.back().X_WT.p_AB.z += 1;
    const std::string path = fmt::format("{}/path-{}.csv", options_.viewer.folder, viewer_->sessions() + 1);
    WriteTextFile(path, FormatPathCsv(scene.path.poses));
    scene.path.file = std::filesystem::absolute(path).string();
    return scene;
  });
}

void Rehearsal::SelectSaw(std::size_t number) {
  if (number >= options_.saws.size() || (saw_is_listed_ && number == saw_)) return;
  if (!viewer_->is_running() || change_) return;
  const Saw& saw = options_.saws[number];
  ContinueWith(fmt::format("Saw: {}", saw.name), [saw](Scene& scene) { UseSaw(scene, saw); });
  saw_ = number;
  saw_is_listed_ = true;
}

void Rehearsal::ToggleGuide() {
  if (!viewer_->is_running() || change_) return;
  const PlannedPlane* planned = plane();
  const DepthStop* stop = plan_.stops.empty() ? nullptr : &plan_.stops.front();
  if (!guided_ && planned == nullptr && stop == nullptr) {
    viewer_->Say("There is no plan to guide the saw yet; press N");
    return;
  }
  try {
    const std::optional<EffectChoice> guide = guided_ ? std::nullopt : std::optional(MakeGuide(planned, stop));
    guided_ = !guided_;
    ContinueWith(guided_ ? "The guide keeps the saw in the planned plane" : "The guide is off", [guide](Scene& scene) {
      std::erase_if(scene.effects, [](const EffectChoice& e) { return std::string_view(e.name()) == "guide"; });
      if (guide) scene.effects.push_back(*guide);
    });
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
}

// ---- undo

void Rehearsal::RequestCheckpoint() {
  viewer_->AskText("Name of the checkpoint:", fmt::format("cut {}", checkpoints_.size()),
                   [this](const std::optional<std::string>& name) {
                     if (!name || name->empty() || !viewer_->is_running()) return;
                     checkpoints_.push_back(*name);
                     viewer_->session()->Ask({.kind = LoopAction::Kind::kCheckpoint, .name = *name});
                   });
}

void Rehearsal::GoBack(const std::string& name) {
  if (!viewer_->is_running()) return;
  // A spinning saw would cut the restored bone.
  viewer_->SetSpindle(false);
  viewer_->session()->Ask({.kind = LoopAction::Kind::kUndo, .name = name});
}

void Rehearsal::GoForward() {
  if (!viewer_->is_running()) return;
  viewer_->SetSpindle(false);
  viewer_->session()->Ask({.kind = LoopAction::Kind::kRedo, .name = ""});
}

void Rehearsal::ShowCheckpoints() {
  std::vector<MenuItem> items;
  for (auto name = checkpoints_.rbegin(); name != checkpoints_.rend(); ++name) {
    items.push_back({.name = *name, .detail = "", .choose = [this, back = *name] { GoBack(back); }});
  }
  SetMenu(Menu("Go back to", std::move(items)));
}

// ---- the plan

const PlannedPlane* Rehearsal::plane() const {
  return plane_ < plan_.planes.size() ? &plan_.planes[plane_] : nullptr;
}

void Rehearsal::ShowPlanInPicture() {
  std::vector<PlaneOverlay> planes;
  for (std::size_t i = 0; i < plan_.planes.size(); ++i) {
    const PlannedPlane& p = plan_.planes[i];
    planes.push_back({.name = p.name,
                      .p_W = p.plane.p_W,
                      .normal_W = p.plane.normal_W,
                      .width_mm = p.width_mm,
                      .height_mm = p.height_mm,
                      .up_W = CalcPlaneAxes(p).up_W,
                      .selected = i == plane_});
  }
  viewer_->view().SetPlanes(planes);
  if (const auto watch = viewer_->cut_watch()) watch->SetPlanes(plan_.planes);
  std::vector<DepthStopOverlay> stops;
  for (const DepthStop& stop : plan_.stops) {
    stops.push_back(
        {.name = stop.name, .p_W = stop.p_W_mm + stop.depth_mm * stop.direction_W, .normal_W = -stop.direction_W});
  }
  viewer_->view().SetDepthStops(stops);
}

void Rehearsal::FollowCut() {
  const std::shared_ptr<CutWatch> watch = viewer_->cut_watch();
  if (!watch) return;
  if (std::optional<PlanesReport> report = watch->Fetch()) cut_ = std::move(report);
  for (const FreedPiece& piece : watch->TakeFreed()) {
    viewer_->Say(fmt::format("A piece of {:.0f} mm\u00b3 came free", piece.volume_mm3));
    viewer_->trace().Write("came_free", {{"mm3", piece.volume_mm3}});
  }
}

void Rehearsal::PickPoints(const std::string& prompt, std::size_t count,
                           std::function<void(const std::vector<Vec3>&)> done) {
  viewer_->controls().Release();
  viewer_->SetSpindle(false);
  picking_ = Picking{.prompt = prompt, .count = count, .points = {}, .done = std::move(done)};
}

void Rehearsal::AlignToPlane() {
  const PlannedPlane* planned = plane();
  if (planned == nullptr) return viewer_->Say("No plane is planned yet; press N");
  if (!viewer_->is_running()) return;
  // Aligns the spindle with the plane's normal by the smaller rotation and moves the disc's centre into the plane.
  Pose X = viewer_->figures().coupled.X_WT;
  const Vec3 spindle = X.Vector({0, 0, 1});
  Vec3 normal = planned->plane.normal_W;
  if (glm::dot(normal, spindle) < 0) normal = -normal;
  X.R_AB = glm::normalize(RotationBetween(spindle, normal) * X.R_AB);
  X.p_AB -= glm::dot(X.p_AB - planned->plane.p_W, normal) * normal;
  viewer_->controls().Set(X);
  viewer_->Say(fmt::format("The saw is turning into {}; keep it clear of the bone", planned->name));
}

void Rehearsal::WritePlan() {
  const std::string file = options_.viewer.folder + "/plan.mrk.json";
  WritePlaneMarkups(file, MakeMarkups(plan_));
  viewer_->Say(fmt::format("Plan: {}", file));
}

void Rehearsal::ShowPlan() {
  const bool any = !plan_.planes.empty();
  const auto added = [this](PlannedPlane planned) {
    plan_.planes.push_back(std::move(planned));
    plane_ = plan_.planes.size() - 1;
    ShowPlanInPicture();
    viewer_->trace().Write("plan", {{"planes", plan_.planes.size()}, {"stops", plan_.stops.size()}});
  };
  std::vector<MenuItem> items;
  items.push_back({.name = "Plane through three points", .detail = "click them on the bone", .choose = [this, added] {
                     PickPoints("A point of the plane on the bone", 3, [this, added](const std::vector<Vec3>& p) {
                       added(PlacePlane(MakePlaneName(plan_), p[0], p[1], p[2]));
                     });
                   }});
  items.push_back({.name = "Plane where the blade is", .detail = "", .choose = [this, added] {
                     added(PlacePlane(MakePlaneName(plan_), viewer_->figures().coupled.X_WT));
                   }});
  items.push_back({.name = "Depth stop", .detail = "click its point on the bone", .choose = [this] {
                     PickPoints("Where the cut begins on the bone", 1,
                                [this](const std::vector<Vec3>& p) { AskDepth(p.front()); });
                   }});
  items.push_back(
      {.name = "Turn the saw into the plane", .detail = any ? plane()->name : "", .enabled = any, .choose = [this] {
         AlignToPlane();
       }});
  items.push_back(
      {.name = "Next plane", .detail = any ? plane()->name : "", .enabled = plan_.planes.size() > 1, .choose = [this] {
         plane_ = (plane_ + 1) % plan_.planes.size();
         ShowPlanInPicture();
       }});
  items.push_back({.name = "Remove this plane", .detail = any ? plane()->name : "", .enabled = any, .choose = [this] {
                     plan_.planes.erase(plan_.planes.begin() + static_cast<std::ptrdiff_t>(plane_));
                     plane_ = 0;
                     ShowPlanInPicture();
                   }});
  items.push_back({.name = "Remove all depth stops", .detail = "", .enabled = !plan_.stops.empty(), .choose = [this] {
                     plan_.stops.clear();
                     ShowPlanInPicture();
                   }});
  items.push_back({.name = "Read planes of 3D Slicer", .detail = ".mrk.json", .choose = [this] {
                     viewer_->AskText("File:", "", [this](const std::optional<std::string>& file) {
                       if (!file) return;
                       try {
                         for (PlannedPlane& p : ReadPlannedPlanes(*file)) plan_.planes.push_back(std::move(p));
                         plane_ = plan_.planes.size() - 1;
                         ShowPlanInPicture();
                       } catch (const Error& e) {
                         viewer_->Say(e.what());
                       }
                     });
                   }});
  items.push_back({.name = "Write the plan", .detail = "plan.mrk.json", .enabled = !plan_.empty(), .choose = [this] {
                     WritePlan();
                   }});
  SetMenu(Menu("Plan", std::move(items)));
}

void Rehearsal::AskDepth(const Vec3& p_W) {
  viewer_->AskText("Depth in mm:", "5", [this, p_W](const std::optional<std::string>& text) {
    if (!text) return;
    const std::optional<double> depth_mm = ParseDepth(*text);
    if (!depth_mm)
      return viewer_->Say(fmt::format("The depth must be a number from {}", ShowRange(kDepthRange_mm, "mm")));
    DepthStop stop;
    stop.name = MakeStopName(plan_);
    stop.p_W_mm = p_W;
    // The direction into the bone: from the blade's current centre to the point.
    stop.direction_W =
        CalcDirection(p_W - viewer_->figures().coupled.X_WT.p_AB).value_or(viewer_->MakeBasis().forward_W);
    stop.depth_mm = *depth_mm;
    plan_.stops.push_back(stop);
    ShowPlanInPicture();
    viewer_->trace().Write("plan", {{"planes", plan_.planes.size()}, {"stops", plan_.stops.size()}});
  });
}

// ---- pieces and export

void Rehearsal::EnterPieces() {
  if (!viewer_->is_running() || change_) return;
  viewer_->SetSpindle(false);
  viewer_->controls().Release();
  if (!pieces_) pieces_ = std::make_unique<PiecesMode>(*viewer_);
  pieces_->Enter();
  in_pieces_ = true;
}

void Rehearsal::Export() {
  if (!viewer_->is_running() || exporting_.valid() || change_) return;
  viewer_->SetSpindle(false);
  ExportOrder order;
  order.folder = options_.viewer.folder + "/take-away";
  order.obj = options_.obj;
  order.scene = viewer_->session()->scene();
  order.recordings = result_.recordings;
  order.plan = plan_;
  order.marks = marks_;
  if (saw_is_listed_) order.saw_name = options_.saws[saw_].name;
  order.before = before_;
  order.forces = viewer_->forces();
  try {
    order.pictures.emplace_back("As seen in the window", viewer_->GrabScene());
  } catch (const Error& e) {
    return viewer_->Say(e.what());
  }
  if (pieces_ && pieces_->is_up_to_date()) order.pieces_json = pieces_->pieces()->FormatJson();
  if (pieces_) order.measures = pieces_->measures();
  order.after = viewer_->session()->AskBone();
  viewer_->Say("Exporting pieces, planes and report");
  exporting_ = std::async(std::launch::async,
                          [order = std::make_shared<ExportOrder>(std::move(order))] { return RunExport(*order); });
}

void Rehearsal::SaveProject() {
  if (!viewer_->is_running() || saving_.valid() || change_) return;
  viewer_->SetSpindle(false);
  auto project = std::make_shared<Project>();
  project->title = scene_.TitleOrName();
  project->scene = viewer_->session()->scene();
  project->scene.plan = plan_;
  project->marks = marks_;
  for (const std::string& recording : result_.recordings) {
    if (std::filesystem::exists(recording)) project->recordings.push_back(recording);  // a session that has ended
  }
  if (pieces_ && pieces_->is_up_to_date()) project->pieces_json = pieces_->pieces()->FormatJson();
  std::shared_future<Bone> now = viewer_->session()->AskBone().share();
  viewer_->Say("Saving the project");
  saving_ = std::async(std::launch::async, [project, now, before = before_, folder = options_.viewer.folder] {
    project->bone_file = folder + "/bone-before.vdb";
    project->cut_bone_file = folder + "/bone-now.vdb";
    WriteBone(*before, project->bone_file);
    WriteBone(now.get(), project->cut_bone_file);
    const std::string file = folder + "/case" + kProjectExtension;
    WriteProject(file, *project);
    return file;
  });
}

// ---- events

void Rehearsal::SetMenu(Menu menu) {
  viewer_->controls().Release();
  menu_ = std::move(menu);
}

bool Rehearsal::TakeClick(const WindowEvent& event) {
  if (event.kind != WindowEvent::Kind::kMouseDown || event.button != MouseButton::kLeft) return false;
  const ScreenPoint at{event.x, event.y};
  if (viewer_->surface() == nullptr || viewer_->view().IsOnPanel(at)) return false;
  const std::optional<Vec3> p_W = viewer_->surface()->Pick(viewer_->view().camera().CalcRay(at));
  if (!p_W) {
    viewer_->Say("There is no bone under the mouse");
    return true;
  }
  picking_->points.push_back(*p_W);
  viewer_->trace().Write("point", {{"mm", {p_W->x, p_W->y, p_W->z}}});
  if (picking_->points.size() < picking_->count) return true;
  const Picking picked = *std::exchange(picking_, std::nullopt);
  try {
    picked.done(picked.points);
  } catch (const Error& e) {
    viewer_->Say(e.what());
  }
  return true;
}

bool Rehearsal::TakeKey(const WindowEvent& event) {
  if (event.repeat) return false;
  if (event.control) {
    if (event.key == Key::kZ && !event.shift) return GoBack(""), true;
    if (event.key == Key::kY || (event.key == Key::kZ && event.shift)) return GoForward(), true;
    if (event.key == Key::kS) return SaveProject(), true;
    return false;
  }
  if (event.key >= Key::k1 && event.key <= Key::k9) {
    SelectSaw(static_cast<std::size_t>(event.key) - static_cast<std::size_t>(Key::k1));
    return true;
  }
  switch (event.key) {
    case Key::kTab:
      SelectSaw(saw_is_listed_ ? (saw_ + 1) % options_.saws.size() : 0);
      return true;
    case Key::kC:
      RequestCheckpoint();
      return true;
    case Key::kB:
      ShowCheckpoints();
      return true;
    case Key::kN:
      ShowPlan();
      return true;
    case Key::kG:
      ToggleGuide();
      return true;
    case Key::kP:
      EnterPieces();
      return true;
    case Key::kF9:
      Export();
      return true;
    default:
      return false;
  }
}

bool Rehearsal::Take(const WindowEvent& event) {
  using Kind = WindowEvent::Kind;
  if (menu_) {
    const Menu::State state = menu_->Take(event, [this](double x, double y) {
      return viewer_->view().PickMenuRow({x, y});
    });
    if (state == Menu::State::kOpen) return event.kind != Kind::kScroll && event.kind != Kind::kKeyUp;
    const Menu done = *std::exchange(menu_, std::nullopt);
    if (state == Menu::State::kChosen && done.chosen().choose) {
      try {
        done.chosen().choose();
      } catch (const Error& e) {
        viewer_->Say(e.what());
      }
    }
    return true;
  }
  if (picking_) {
    if (event.kind == Kind::kKeyDown && event.key == Key::kEscape) {
      picking_.reset();
      return true;
    }
    return TakeClick(event);
  }
  if (in_pieces_) {
    if (pieces_->Take(event)) return true;
    if (event.kind == Kind::kKeyDown && (event.key == Key::kEscape || event.key == Key::kP) && !event.control) {
      pieces_->Leave();
      in_pieces_ = false;
      return true;
    }
    if (event.kind == Kind::kKeyDown && event.key == Key::kF9) return Export(), true;
    return false;
  }
  return event.kind == Kind::kKeyDown && TakeKey(event);
}

// ---- frames

void Rehearsal::Update(double /*dt_s*/) {
  if (IsReady(opening_)) {
    OpenedInput opened = opening_.get();
    scene_ = std::move(opened.scene);
    scene_file_ = std::move(opened.scene_file);
    if (opened.project) {
      marks_ = opened.project->marks;
      mark_tubes_ = MakeMarkTubes(marks_);
    }
    for (const PlannedPlane& planned : scene_.plan.planes) plan_.planes.push_back(planned);
    for (const DepthStop& stop : scene_.plan.stops) plan_.stops.push_back(stop);
    if (!viewer_->quitting()) Restart();
  }
  if (IsReady(changing_)) {
    scene_ = changing_.get();
    if (!viewer_->quitting()) Restart();
  }
  if (IsReady(making_nerve_)) nerve_ = making_nerve_.get();
  if (IsReady(exporting_)) {
    try {
      result_.take_away = exporting_.get();
      viewer_->Say(fmt::format("Exported: {}", result_.take_away));
      viewer_->trace().Write("taken_away", {{"folder", result_.take_away}});
    } catch (const std::exception& e) {  // the session has ended in the meantime and returns no bone
      viewer_->Say(fmt::format("Nothing was exported: {}", e.what()));
      viewer_->trace().Write("taken_away", {{"failure", e.what()}});
    }
  }
  if (IsReady(saving_)) {
    try {
      const std::string file = saving_.get();
      viewer_->Say(fmt::format("Project: {}", file));
      viewer_->trace().Write("project", {{"file", file}});
    } catch (const std::exception& e) {
      viewer_->Say(fmt::format("The project was not saved: {}", e.what()));
      viewer_->trace().Write("project", {{"failure", e.what()}});
    }
  }
  FollowCut();
  if (in_pieces_) pieces_->Update();
}

void Rehearsal::Fill(HudState& hud) {
  hud.status.mode = in_pieces_ ? "Pieces" : "Rehearse";
  if (saw_is_listed_) hud.status.saw = options_.saws[saw_].name;
  if (viewer_->is_running()) {
    const Tool tool = MakeTool(viewer_->session()->scene());
    const Pose& X_WT = viewer_->figures().coupled.X_WT;
    hud.values.nerve_mm = FindNearestStructure(nerve_.get(), "nerve", mark_tubes_, tool, X_WT).distance_mm;
    if (sampler_) hud.values.depth_mm = CalcBladeDepth(*sampler_, tool, X_WT);
    if (const PlannedPlane* planned = plane()) {
      const PlaneDeviation off = CalcDeviation(*planned, tool, X_WT);
      hud.values.plan_offset_mm = off.offset_mm;
      hud.values.plan_angle_deg = off.angle_deg;
    }
    if (!plan_.stops.empty()) {
      const StopDeviation stop = CalcDeviation(plan_.stops.front(), tool, X_WT);
      HudGauge gauge;
      gauge.title = plan_.stops.front().name;
      gauge.upper = std::max(1.0, 1.5 * plan_.stops.front().depth_mm);
      gauge.value = stop.depth_mm;
      gauge.goal = plan_.stops.front().depth_mm;
      gauge.level = stop.left_mm < -1     ? HudLevel::kBad
                    : stop.left_mm < -0.3 ? HudLevel::kWarn
                    : stop.left_mm < 0.3  ? HudLevel::kGood
                    : stop.left_mm < 1    ? HudLevel::kWarn
                                          : HudLevel::kPlain;
      gauge.word = stop.left_mm < -0.3  ? "too deep"
                   : stop.left_mm < 0.3 ? "stop"
                   : stop.left_mm < 1   ? "slow"
                                        : "continue";
      hud.gauge = gauge;
    }
  }
  if (opening_.valid()) {
    const std::lock_guard lock(mutex_);
    hud.progress = HudProgress{.title = "Opening", .stage = opening_stage_, .fraction = opening_fraction_};
  } else if (changing_.valid()) {
    hud.progress = HudProgress{.title = change_ ? change_->what : "", .stage = "saving the bone", .fraction = {}};
  } else if (change_ && hud.progress) {
    hud.progress->title = change_->what;
  }
  if (picking_) {
    hud.banner =
        HudBanner{.kind = HudBanner::Kind::kQuestion,
                  .text = fmt::format("{} ({} of {})", picking_->prompt, picking_->points.size() + 1, picking_->count),
                  .answers = "left click   Esc: cancel"};
  }
  if (menu_) hud.menu = menu_->Show();
  if (in_pieces_) pieces_->Fill(hud);
}

std::vector<HudKeyGroup> Rehearsal::help() const {
  if (in_pieces_) return pieces_->help();
  return {{"Rehearse",
           {{"1-9, Tab", "another saw"},
            {"N", "plan: planes, depth stops"},
            {"G", "guide along the plan on/off"},
            {"Ctrl+Z  Ctrl+Y", "undo, redo"},
            {"C", "checkpoint with a name"},
            {"B", "return to a checkpoint"},
            {"P", "pieces: move, measure"},
            {"F9", "export: pieces, planes, report"}}}};
}

void Rehearsal::Describe(nlohmann::json& state) const {
  state["mode"] = menu_ ? "menu" : picking_ ? "picking" : in_pieces_ ? "pieces" : "cutting";
  if (menu_) state["menu"] = menu_->title();
  state["planes"] = plan_.planes.size();
  state["stops"] = plan_.stops.size();
  state["guided"] = guided_;
  state["plane_cut"] = nlohmann::json::array();
  if (cut_) {
    for (const PlanesReport::Row& row : cut_->planes) state["plane_cut"].push_back(row.state.fraction());
  }
  state["saw"] = saw_is_listed_ ? options_.saws[saw_].name : "";
  if (in_pieces_) pieces_->Describe(state);
}

}  // namespace kerf
