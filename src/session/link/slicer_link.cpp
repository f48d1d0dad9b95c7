#include "session/link/slicer_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <glm/geometric.hpp>
#include <utility>

#include "bone/grid/set_leaf.h"
#include "kerf/error.h"
#include "kerf/surface.h"
#include "kerf/version.h"
#include "loop/haptics/loop_body.h"
#include "session/run/effect_record.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kBoneSlot = 0;
constexpr int kStatusSlot = 1;
constexpr int kNamesSlot = 2;
constexpr int kToolSlot = 3;
constexpr int kRefusalSlot = 4;
constexpr std::chrono::seconds kBetweenRefusals{1};  // of the same sentence
constexpr const char* kHandName = "kerf_hand";
constexpr std::chrono::milliseconds kBetweenBones{500};
/// Pause after a surface was made, as a multiple of the time that it took: the loop shares the processor.
constexpr int kRest = 3;
constexpr double kAdaptivity = 0.1;
constexpr std::chrono::seconds kLastWait{2};

IgtlStamp Stamp(const char* device) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return {device, std::chrono::duration<double>(now).count()};
}

std::shared_ptr<const std::string> Share(std::string messages) {
  return std::make_shared<const std::string>(std::move(messages));
}

/// Returns a line "NAME VALUE" for the force and for each number. `names`: of the numbers, one per line.
std::string DescribeMoment(const LinkMoment& moment, const std::string& names) {
  std::string text = fmt::format("force_N {:.3f}", glm::length(moment.f_H_W_N));
  std::size_t from = 0;
  for (const double number : moment.numbers) {
    if (from >= names.size()) break;
    const std::size_t end = std::min(names.find('\n', from), names.size());
    text += fmt::format("\n{} {:.3f}", names.substr(from, end - from), number);
    from = end + 1;
  }
  return text;
}

}  // namespace

SlicerLink::SlicerLink(const IgtlServerOptions& options)
    : state_(fmt::format("kerf {}: no session yet", VersionString())) {
  meshing_ = std::thread([this] { MeshInTurn(); });
  try {
    server_ = std::make_unique<IgtlServer>(
        options, IgtlServer::Calls{.frame = [this] { return MakeFrame(); },
                                   .welcome = [this] { return MakeWelcome(); },
                                   .take = [this](auto peer, const IgtlHeader& header,
                                                  auto content) { return Answer(peer, header, content); },
                                   .max_bytes = [this](const IgtlHeader& header) { return MaxBytes(header); },
                                   .refuse = [this](const std::string& why) { return MakeRefusal(why); },
                                   .gone = [this](auto peer) { hand_.Leave(peer); }});
  } catch (...) {
    EndMeshing();
    throw;
  }
}

SlicerLink::~SlicerLink() {
  server_.reset();
  EndMeshing();
}

void SlicerLink::EndMeshing() {
  {
    const std::lock_guard lock(mutex_);
    end_ = true;
  }
  changed_.notify_all();
  meshing_.join();
}

void SlicerLink::Show(const std::string& title, const TriangleMesh& tool_T) {
  const Bytes tool = Share(MakeIgtlSurface(Stamp("kerf_tool_shape"), tool_T));
  {
    const std::lock_guard lock(mutex_);
    state_ = fmt::format("kerf {}: {}", VersionString(), title);
    tool_bytes_ = tool;
  }
  server_->Send(kToolSlot, tool);
  server_->Send(kStatusSlot, MakeStatus());
}

void SlicerLink::Begin(const LoopInitialState& initial) {
  const std::lock_guard lock(mutex_);
  first_bone_ = initial.bone;
  leaves_.clear();
  cut_mm3_ = 0;
  names_ = "time_s\ncut_mm3";
  for (const EffectFigure& figure : EffectRecord(initial.effects).figures) {
    names_ += fmt::format("\n{}.{}", figure.effect, figure.name);
  }
  moment_ = LinkMoment{.X_WT = initial.X_WT, .f_H_W_N = Vec3(0), .numbers = {0, 0}};
  server_->Send(kNamesSlot, Share(MakeIgtlText(Stamp("kerf_names"), names_)));
}

void SlicerLink::TakeLeaf(const LeafMessage& leaf) {
  const std::lock_guard lock(mutex_);
  leaves_[leaf.index] = leaf.values;
}

void SlicerLink::TakeTick(const LoopTick& tick, std::span<const double> channels) {
  const std::lock_guard lock(mutex_);
  cut_mm3_ += tick.coupled.removed_mm3;
  if (!moment_) moment_.emplace();
  moment_->X_WT = tick.coupled.X_WT;
  moment_->f_H_W_N = tick.coupled.f_H_W_N;
  moment_->numbers.assign({tick.time_s, cut_mm3_});
  moment_->numbers.insert(moment_->numbers.end(), channels.begin(), channels.end());
}

void SlicerLink::End(const std::string& sentence) {
  {
    std::unique_lock lock(mutex_);
    state_ = sentence;
    hurries_ = true;
    changed_.notify_all();
    changed_.wait_for(lock, kLastWait, [this] { return leaves_.empty() && !meshes_; });
  }
  server_->Send(kStatusSlot, MakeStatus());
  server_->WaitUntilSent(kLastWait);
}

SlicerLink::Bytes SlicerLink::MakeFrame() {
  std::optional<LinkMoment> moment;
  std::string names;
  {
    const std::lock_guard lock(mutex_);
    moment = std::exchange(moment_, std::nullopt);
    names = names_;
  }
  if (!moment) return nullptr;
  return Share(MakeIgtlTransform(Stamp("kerf_tool"), moment->X_WT) +
               MakeIgtlForce(Stamp("kerf_force"), moment->f_H_W_N) +
               MakeIgtlNumbers(Stamp("kerf_numbers"), moment->numbers) +
               MakeIgtlText(Stamp("kerf_values"), DescribeMoment(*moment, names)));
}

SlicerLink::Bytes SlicerLink::MakeStatus() {
  const std::lock_guard lock(mutex_);
  return Share(MakeIgtlStatus(Stamp("kerf"), false, state_));
}

std::vector<SlicerLink::Bytes> SlicerLink::MakeWelcome() {
  std::vector<Bytes> welcome{MakeStatus()};
  const std::lock_guard lock(mutex_);
  if (tool_bytes_) welcome.push_back(tool_bytes_);
  if (!names_.empty()) welcome.push_back(Share(MakeIgtlText(Stamp("kerf_names"), names_)));
  if (bone_bytes_) welcome.push_back(bone_bytes_);
  return welcome;
}

void SlicerLink::TakeHand(IgtlServer::PeerNumber peer, std::span<const std::uint8_t> content) {
  if (!hand_.Accepts(peer, Clock::now())) {
    throw Error(fmt::format("another peer already sends {}; it is followed until it is silent for {:g} s", kHandName,
                            std::chrono::duration<double>(ToolHolder::kSilent).count()));
  }
  tracked_tool_->Take(content);
}

std::size_t SlicerLink::MaxBytes(const IgtlHeader& header) const {
  if (!IsBoneMessage(header)) return IgtlServer::kMaxBodyBytes;
  bone_.Check();
  return kMaxBoneBytes;
}

SlicerLink::Bytes SlicerLink::Answer(IgtlServer::PeerNumber peer, const IgtlHeader& header,
                                     std::span<const std::uint8_t> content) {
  if (header.type == "GET_STATUS") return MakeStatus();
  try {
    if (header.type == "TRANSFORM" && header.device == kHandName) {
      TakeHand(peer, content);
    } else if (IsBoneMessage(header)) {
      bone_.Take(header, content);
      return Share(MakeIgtlStatus(Stamp("kerf"), false, "the bone was received; it is opened once nothing is asked"));
    } else if (header.type == "TRANSFORM" || header.type == "POINT") {
      plan_.Take(header, content);
    }
  } catch (const Error& e) {
    return MakeRefusal(e.what());
  }
  return nullptr;  // other messages are not understood
}

/// Returns null if the sentence was sent within the last second.
SlicerLink::Bytes SlicerLink::MakeRefusal(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  ++refusals_;
  if (sentence == refusal_ && now - refused_at_ < kBetweenRefusals) return nullptr;
  refusal_ = sentence;
  refused_at_ = now;
  return Share(MakeIgtlStatus(Stamp("kerf"), true, sentence));
}

std::uint64_t SlicerLink::refusals() const {
  const std::lock_guard lock(mutex_);
  return refusals_;
}

void SlicerLink::Refuse(const std::string& sentence) {
  if (const Bytes refusal = MakeRefusal(sentence)) server_->Send(kRefusalSlot, refusal);
}

/// Makes the surface of the bone after changes, in a thread of its own.
void SlicerLink::MeshInTurn() {
  std::optional<Bone> bone;
  Clock::time_point next = Clock::now();
  std::unique_lock lock(mutex_);
  while (!end_) {
    if (!hurries_ && changed_.wait_until(lock, next, [this] { return end_ || hurries_; })) continue;
    if (hurries_ && leaves_.empty() && !first_bone_) {
      changed_.wait(lock, [this] { return end_ || !leaves_.empty(); });
      continue;
    }
    next = Clock::now() + kBetweenBones;
    if (!first_bone_ && leaves_.empty()) continue;
    const auto leaves = std::exchange(leaves_, {});
    if (first_bone_) bone = std::exchange(first_bone_, std::nullopt);
    meshes_ = true;
    lock.unlock();
    const Clock::time_point began = Clock::now();
    for (const auto& [index, values] : leaves) SetCut(*bone, index, values);
    const Bytes bytes = Share(MakeIgtlSurface(Stamp("kerf_bone"), ExtractSurface(*bone, kAdaptivity)));
    next = Clock::now() + std::max<Clock::duration>(kBetweenBones, kRest * (Clock::now() - began));
    lock.lock();
    bone_bytes_ = bytes;
    server_->Send(kBoneSlot, bytes);
    meshes_ = false;
    changed_.notify_all();
  }
}

}  // namespace kerf
