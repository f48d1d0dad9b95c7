#include "loop/record/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "base/compress/bytes.h"
#include "base/core/printable.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using nlohmann::ordered_json;

constexpr double kBlock_s = 0.25;
constexpr double kMaxStep_s = 1000;
constexpr double kMaxRecordedTime_s = 1e12;
constexpr std::uint64_t kMaxSteps = 1'000'000'000'000'000;
constexpr double kSameTime_s = 1e-6;

std::string Hex(std::uint64_t hash) {
  return fmt::format("{:016x}", hash);
}

/// Reads the expected keys of a JSON object and ignores all others, which later versions may add.
class JsonReader {
 public:
  JsonReader(const std::string& text, const char* what) : what_(what) {
    json_ = ordered_json::parse(text, nullptr, false);
    if (!json_.is_object()) Fail("is not JSON");
  }
  std::string Text(const char* key) const {
    const auto it = json_.find(key);
    if (it == json_.end() || !it->is_string()) Fail(fmt::format("has no string \"{}\"", key));
    return it->get<std::string>();
  }
  double Number(const char* key, double lower, double upper) const {
    const auto it = json_.find(key);
    if (it == json_.end() || !it->is_number()) Fail(fmt::format("has no number \"{}\"", key));
    const auto value = it->get<double>();
    if (!(value >= lower && value <= upper)) {
      Fail(fmt::format("has {} = {:g}, which is outside the range {:g} to {:g}", key, value, lower, upper));
    }
    return value;
  }
  bool Has(const char* key) const { return json_.contains(key); }
  std::uint64_t Hash(const char* key) const {
    const std::string text = Text(key);
    if (text.size() != 16 || text.find_first_not_of("0123456789abcdef") != std::string::npos) {
      Fail(fmt::format("has {} = \"{}\", which is not a hash", key, text.substr(0, 40)));
    }
    return std::stoull(text, nullptr, 16);
  }
  Pose ReadPose(const char* key) const {
    const auto it = json_.find(key);
    if (it == json_.end() || !it->is_array() || it->size() != 7 ||
        !std::all_of(it->begin(), it->end(), [](const ordered_json& x) { return x.is_number(); })) {
      Fail(fmt::format("has no pose \"{}\"", key));
    }
    const auto at = [&](std::size_t i) { return (*it)[i].get<double>(); };
    const Pose X{Quat{at(3), at(4), at(5), at(6)}, Vec3{at(0), at(1), at(2)}};
    if (!IsValid(X) || !IsInWorld(X.p_AB)) Fail(fmt::format("has an invalid pose \"{}\"", key));
    return X;
  }

 private:
  [[noreturn]] void Fail(const std::string& fault) const { throw Error(fmt::format("its {} {}", what_, fault)); }

  const char* what_;
  ordered_json json_;
};

std::string FormatHeader(const RecordingHeader& header) {
  const Vec3& p = header.X_WT_start.p_AB;
  const Quat& q = header.X_WT_start.R_AB;
  const ordered_json json{{"kerf_recording", 2},
                          {"kind", ToString(header.kind)},
                          {"computation", header.computation},
                          {"version", header.version},
                          {"commit", header.commit},
                          {"compiler", header.compiler},
                          {"machine", header.machine},
                          {"created", header.created},
                          {"taken_up_from", header.taken_up_from},
                          {"scene_name", header.scene_name},
                          {"scene_file", header.scene_file},
                          {"bone_hash", Hex(header.bone_hash)},
                          {"material_hash", Hex(header.material_hash)},
                          {"voxel_mm", header.voxel_mm},
                          {"rate_hz", header.rate_hz},
                          {"start", {p.x, p.y, p.z, q.w, q.x, q.y, q.z}},
                          {"check_bits", header.check_bits},
                          {"state_every_steps", header.state_every_steps},
                          {"hash_every_steps", header.hash_every_steps},
                          {"scene", header.scene_toml}};
  return json.dump(1, ' ', false, ordered_json::error_handler_t::replace);
}

RecordingHeader ParseHeader(const std::string& text) {
  const JsonReader json(text, "header");
  RecordingHeader header;
  if (const double version = json.Number("kerf_recording", 1, 1e9); version > 2) {
    throw Error(fmt::format("was written by a later version of kerf (format {:g})", version));
  }
  const std::string kind = json.Text("kind");
  if (kind == "loop") {
    header.kind = RecordedKind::kLoop;
  } else if (kind == "run") {
    header.kind = RecordedKind::kRun;
  } else if (kind == "slab") {
    header.kind = RecordedKind::kSlab;
  } else {
    throw Error(fmt::format("is of kind \"{}\", which this version does not support", kind.substr(0, 40)));
  }
  header.computation = json.Has("computation") ? static_cast<int>(json.Number("computation", 1, 1e9)) : 1;
  header.version = Printable(json.Text("version"));
  header.commit = Printable(json.Text("commit"));
  header.compiler = Printable(json.Text("compiler"));
  header.machine = Printable(json.Text("machine"));
  header.created = Printable(json.Text("created"));
  header.taken_up_from = Printable(json.Text("taken_up_from"));
  header.scene_name = Printable(json.Text("scene_name"));
  header.scene_file = Printable(json.Text("scene_file"));
  header.scene_toml = json.Text("scene");
  // The drills of earlier versions have no chisel edge.
  if (const std::size_t at = header.scene_toml.find("\nshape = \"drill\"");
      at != std::string::npos && header.scene_toml.find("\nchisel_share = ") == std::string::npos) {
    header.scene_toml.insert(at, "\nchisel_share = 0");
  }
  header.bone_hash = json.Hash("bone_hash");
  header.material_hash = json.Hash("material_hash");
  header.voxel_mm = json.Number("voxel_mm", 1e-6, 1e6);
  header.rate_hz = json.Number("rate_hz", 1, 1e6);
  header.X_WT_start = json.ReadPose("start");
  header.check_bits = static_cast<int>(json.Number("check_bits", 8, 16));
  header.state_every_steps = static_cast<int>(json.Number("state_every_steps", 1, 1e9));
  header.hash_every_steps = static_cast<int>(json.Number("hash_every_steps", 1, 1e9));
  return header;
}

std::string FormatEnd(const RecordingEnd& end) {
  ordered_json json{{"steps", end.steps},
                    {"time_s", end.time_s},
                    {"force_hash", Hex(end.force_hash)},
                    {"voxel_hash", Hex(end.voxel_hash)},
                    {"why", end.why}};
  if (end.bone_hash) json["bone_hash"] = Hex(*end.bone_hash);
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

RecordingEnd ParseEnd(const std::string& text) {
  const JsonReader json(text, "end");
  RecordingEnd end;
  end.steps = static_cast<std::uint64_t>(json.Number("steps", 0, static_cast<double>(kMaxSteps)));
  end.time_s = json.Number("time_s", 0, kMaxRecordedTime_s);
  end.force_hash = json.Hash("force_hash");
  end.voxel_hash = json.Hash("voxel_hash");
  if (json.Has("bone_hash")) end.bone_hash = json.Hash("bone_hash");
  end.why = Printable(json.Text("why"));
  return end;
}

std::string FormatEvent(const RecordedEvent& event) {
  const ordered_json json{{"step", event.step},
                          {"time_s", event.time_s},
                          {"what", event.what},
                          {"name", event.name},
                          {"number", event.number}};
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

RecordedEvent ParseEvent(const std::string& text) {
  const JsonReader json(text, "list of events");
  RecordedEvent event;
  event.step = static_cast<std::uint64_t>(json.Number("step", 0, static_cast<double>(kMaxSteps)));
  event.time_s = json.Number("time_s", 0, kMaxRecordedTime_s);
  event.what = Printable(json.Text("what"));
  event.name = Printable(json.Text("name"));
  event.number = static_cast<std::uint32_t>(json.Number("number", 0, 4e9));
  return event;
}

}  // namespace

bool RecordingHeader::IsReplayable() const {
  if (kind == RecordedKind::kSlab || computation == kComputation) return true;
  const auto has = [this](const char* shape) {
    return scene_toml.find(fmt::format("shape = \"{}\"", shape)) != std::string::npos;
  };
  return computation == 2 && !has("reciprocating") && !has("oscillating") && !has("piezo");
}

const char* ToString(RecordedKind kind) {
  switch (kind) {
    case RecordedKind::kLoop:
      return "loop";
    case RecordedKind::kRun:
      return "run";
    case RecordedKind::kSlab:
      break;
  }
  return "slab";
}

void CheckNewRecording(const std::string& path) {
  if (path.empty()) throw Error("--record does not specify a file");
  CheckWritable(path);
  std::error_code none;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, none))) {
    throw Error(fmt::format("{}: already exists; a recording never replaces a file", path));
  }
}

RecordingWriter::RecordingWriter(const std::string& path, const RecordingHeader& header,
                                 const std::map<std::string, std::string>& files, const std::optional<SealKey>& key)
    : file_(path),
      key_(key),
      steps_in_block_(static_cast<std::size_t>(
          std::clamp(std::floor(kBlock_s * header.rate_hz), 1.0, static_cast<double>(kMaxStepsInBlock)))) {
  // The header is written twice, because a recording cannot be read without it.
  for (int i = 0; i < 2; ++i) file_.Append(BlockKind::kMeta, FormatHeader(header));
  for (const auto& [name, bytes] : files) {
    ByteWriter out;
    out.PutText(name);
    out.PutText(bytes);
    file_.Append(BlockKind::kFile, out.bytes());
  }
}

void RecordingWriter::Add(const RecordedStep& step, double time_s) {
  if (block_.steps.size() >= steps_in_block_) Flush();
  if (block_.steps.empty()) {
    block_.first_step = steps_;
    block_.first_time_s = time_s_;
  }
  block_.steps.push_back(step);
  ++steps_;
  time_s_ = time_s;
}

void RecordingWriter::AddState(RecordedState state) {
  state.step = steps_ - 1;
  block_.states.push_back(state);
}

void RecordingWriter::AddHash(std::uint64_t force, std::uint64_t bone) {
  block_.hashes.push_back({steps_ - 1, force, bone});
}

void RecordingWriter::AddEvent(RecordedEvent event) {
  Flush();
  event.step = steps_;
  event.time_s = time_s_;
  file_.Append(BlockKind::kEvent, FormatEvent(event));
}

void RecordingWriter::AddPiece(std::uint32_t number, const std::string& bytes) {
  ByteWriter out;
  out.PutNumber(number);
  out.PutText(bytes);
  file_.Append(BlockKind::kPiece, out.bytes());
}

void RecordingWriter::Flush() {
  if (block_.steps.empty()) return;
  file_.Append(BlockKind::kSteps, EncodeBlock(block_));
  written_steps_ = steps_;
  written_s_ = time_s_;
  block_ = {};
}

void RecordingWriter::Finish(const RecordingEnd& end) {
  Flush();
  file_.Append(BlockKind::kEnd, FormatEnd(end));
  file_.Append(BlockKind::kSeal, FormatSeal(MakeSeal(file_.digest(), key_)));
  file_.Close();
}

RecordingReader::RecordingReader(const std::string& path) : blocks_(path) {
  const std::vector<BlockPlace>& places = blocks_.places();
  if (places.empty() || places.front().kind != BlockKind::kMeta) {
    const bool damaged = !blocks_.gaps().empty() && !blocks_.gaps().front().torn;
    throw Error(fmt::format("{}: {} its header; nothing can be read from it", path,
                            damaged ? "is damaged in" : "is cut short before"));
  }
  try {
    header_ = ParseHeader(blocks_.Read(places.front()));
    Read();
    CheckSeal();
    FindDamage();
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path, e.what()));
  }
}

void RecordingReader::Read() {
  auto gap = blocks_.gaps().begin();
  const std::vector<BlockPlace>& places = blocks_.places();
  for (std::size_t i = 0; i < places.size(); ++i) {
    for (; gap != blocks_.gaps().end() && gap->before_place <= i; ++gap) {
      if (gap->lost_blocks > 0) lost_.push_back({gap->lost_blocks, gap->last_kind});
    }
    switch (places[i].kind) {
      case BlockKind::kSteps:
        TakeSteps(places[i]);
        break;
      case BlockKind::kEvent:
        if (events_.size() == kMaxEvents) throw Error("holds too many events for a recording");
        events_.push_back(ParseEvent(blocks_.Read(places[i])));
        break;
      case BlockKind::kEnd:
        TakeEnd(places[i]);
        break;
      case BlockKind::kMeta:
      case BlockKind::kFile:
      case BlockKind::kPiece:
      case BlockKind::kSeal:
        break;
    }
  }
  ReportLostBlocks(false);
}

void RecordingReader::TakeEnd(const BlockPlace& place) {
  end_ = ParseEnd(blocks_.Read(place));
  if (end_->steps == next_step_) return;
  if (lost_.empty() || end_->steps < next_step_) {
    throw Error(fmt::format("its end states {} steps, but it holds {}: it was changed after it was written",
                            end_->steps, next_step_));
  }
  AddLostSteps(end_->steps, end_->time_s);
}

void RecordingReader::TakeSteps(const BlockPlace& place) {
  const RecordedBlock block = DecodeBlock(blocks_.Read(place));
  if (block.first_step != next_step_) {
    if (lost_.empty() || block.first_step < next_step_) throw Error("lacks steps in the middle");
    AddLostSteps(block.first_step, block.first_time_s);
  }
  ReportLostBlocks(false);
  for (const RecordedStep& step : block.steps) {
    if (!(step.dt_s >= 0 && step.dt_s <= kMaxStep_s)) throw Error("has a tick with an invalid duration");
    if ((step.flags & kRecordedPieceLeaves) != 0)
      pieces_.try_emplace(step.piece, LostSteps{next_step_, 0, duration_s_, 0});
    ++next_step_;
    duration_s_ += CalcElapsed(step, header_.rate_hz);
  }
  steps_ += block.steps.size();
  steps_places_.push_back(place);
}

/// Adds a gap for the steps whose blocks are missing.
void RecordingReader::AddLostSteps(std::uint64_t until_step, double until_s) {
  if (until_step > kMaxSteps || !(until_s >= duration_s_ - kSameTime_s && until_s <= kMaxRecordedTime_s)) {
    throw Error("has steps after a gap at an impossible time");
  }
  damage_.gaps.push_back({next_step_, until_step - next_step_, duration_s_, until_s});
  damage_.lost_steps += until_step - next_step_;
  next_step_ = until_step;
  duration_s_ = until_s;
  ReportLostBlocks(true);
}

/// Reports missing blocks that contained no steps as faults. `with_steps`: some of the missing blocks contained steps.
void RecordingReader::ReportLostBlocks(bool with_steps) {
  for (const LostBlocks& lost : lost_) {
    const bool is_other = lost.count == 1 && lost.last_kind && *lost.last_kind != BlockKind::kSteps;
    if (is_other || !with_steps) faults_.push_back(Describe(lost));
  }
  lost_.clear();
}

void RecordingReader::CheckSeal() {
  const std::vector<BlockPlace>& places = blocks_.places();
  const BlockKind last = places.back().kind;
  if (blocks_.first_line_is_bad()) faults_.emplace_back("its first line is damaged");
  if (const std::optional<std::uint32_t>& number = blocks_.broken_link()) {
    seal_.is_broken = true;
    faults_.push_back(
        fmt::format("the chain is broken between its blocks {} and {}: one of them was changed after it was written",
                    *number, *number + 1));
  }
  seal_.is_chained = blocks_.version() > 1;
  if (last != (seal_.is_chained ? BlockKind::kSeal : BlockKind::kEnd)) {
    const BlockKind should_be_last = seal_.is_chained ? BlockKind::kSeal : BlockKind::kEnd;
    const auto is_end = [&](const BlockPlace& place) { return place.kind == should_be_last; };
    has_last_block_ = std::any_of(places.begin(), places.end(), is_end);
    if (has_last_block_) faults_.emplace_back("it holds blocks after its end");
    return;
  }
  has_last_block_ = true;
  if (!seal_.is_chained) return;
  const SealBlock seal = ParseSeal(blocks_.Read(places.back()));
  const bool is_signed = IsSignedBy(seal.digest, seal.key, seal.signature);
  const bool fits = seal.digest == blocks_.last_link().digest;
  if (!fits) faults_.emplace_back("its seal does not belong to these blocks");
  if (!seal.key.empty() && !is_signed) faults_.emplace_back("its signature does not match its blocks");
  seal_.is_broken = seal_.is_broken || !fits || (!seal.key.empty() && !is_signed);
  seal_.is_whole = blocks_.gaps().empty() && faults_.empty();
  if (seal_.is_whole && is_signed) seal_.signer = seal.key;
}

void RecordingReader::FindDamage() {
  const std::vector<BlockGap>& gaps = blocks_.gaps();
  for (const BlockGap& gap : gaps) {
    damage_.lost_blocks += gap.lost_blocks;
    damage_.bad_bytes += gap.bytes;
  }
  damage_.has_end = end_.has_value();
  damage_.known_steps = next_step_;
  damage_.whole_steps = damage_.gaps.empty() ? next_step_ : damage_.gaps.front().first_step;
  damage_.whole_s = damage_.gaps.empty() ? duration_s_ : damage_.gaps.front().from_s;
  const bool torn = !gaps.empty() && gaps.back().torn && !has_last_block_;
  if (gaps.size() > (torn ? 1u : 0u) || !faults_.empty()) {
    damage_.state = RecordingState::kDamaged;
    LimitToPieces();
  } else if (!has_last_block_) {
    damage_.state = RecordingState::kCutShort;
  }
  const bool bad_tail = !gaps.empty() && gaps.back().before_place == blocks_.places().size() && !torn;
  const bool is_of_seal = !has_last_block_ && blocks_.places().back().kind == BlockKind::kEnd;
  if (is_of_seal) {
    faults_.emplace_back(bad_tail ? "its seal is damaged" : "its seal is missing");
  } else if (bad_tail) {
    faults_.push_back(fmt::format("the last {} bytes are damaged", gaps.back().bytes));
  }
  damage_.sentence = Describe(damage_, faults_, duration_s_);
}

/// Reduces the number of replayable steps: a step in which a piece leaves cannot be replayed if the piece is missing.
void RecordingReader::LimitToPieces() {
  std::set<std::uint64_t> there;
  for (const BlockPlace& place : blocks_.places()) {
    if (place.kind != BlockKind::kPiece) continue;
    const std::string bytes = blocks_.Read(place);
    there.insert(ByteReader(bytes).GetNumber());
  }
  for (const auto& [number, at] : pieces_) {
    if (there.contains(number) || at.first_step >= damage_.whole_steps) continue;
    damage_.whole_steps = at.first_step;
    damage_.whole_s = at.from_s;
  }
}

std::map<std::string, std::string> RecordingReader::ReadFiles() {
  std::map<std::string, std::string> files;
  std::size_t total = 0;
  for (const BlockPlace& place : blocks_.places()) {
    if (place.kind != BlockKind::kFile) continue;
    const std::string bytes = blocks_.Read(place);
    ByteReader in(bytes);
    const std::string name = Printable(in.GetText());
    files[name] = std::string(in.GetText());
    total += bytes.size();
    if (total > kMaxBytesOfFiles) {
      throw Error(fmt::format("{}: has more than {} MiB of inputs, the maximum in a recording", path(),
                              kMaxBytesOfFiles >> 20));
    }
  }
  return files;
}

bool RecordingReader::ReadBlock(std::size_t i, RecordedBlock& block) {
  if (i >= steps_places_.size()) return false;
  try {
    block = DecodeBlock(blocks_.Read(steps_places_[i]));
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path(), e.what()));
  }
  return true;
}

std::string RecordingReader::ReadPiece(std::uint32_t number) {
  for (const BlockPlace& place : blocks_.places()) {
    if (place.kind != BlockKind::kPiece) continue;
    const std::string bytes = blocks_.Read(place);
    ByteReader in(bytes);
    if (in.GetNumber() == number) return std::string(in.GetText());
  }
  throw Error(fmt::format("{}: has no piece with number {}", path(), number));
}

}  // namespace kerf
