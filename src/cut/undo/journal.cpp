#include "cut/undo/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <unordered_set>
#include <utility>

#include "cut/hand_sim/internals.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr std::size_t kBlock = 64;  // leaves per block of memory

using Figures = std::array<double, 256>;
using Sparse = std::vector<std::pair<std::uint8_t, double>>;

Sparse MakeSparse(const Figures& figures) {
  Sparse sparse;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (figures[i] != 0) sparse.emplace_back(static_cast<std::uint8_t>(i), figures[i]);
  }
  return sparse;
}

Figures MakeFull(const Sparse& sparse) {
  Figures figures{};
  for (const auto& [i, value] : sparse) figures[i] = value;
  return figures;
}

/// Returns a unique key for a leaf. All leaves are within 2^20 leaves of the world's origin along each axis
/// (docs/tick.md).
std::uint64_t KeyOf(const std::array<int, 3>& index) {
  std::uint64_t key = 0;
  for (const int i : index) key = key << 21 | (static_cast<std::uint64_t>(i) & 0x1fffff);
  return key;
}

}  // namespace

std::size_t UndoJournal::Record::CalcMemoryBytes() const {
  return sizeof(Record) + name.capacity() + leaves.CalcMemoryBytes() +
         taken_out_mm3.capacity() * sizeof(Sparse::value_type);
}

UndoJournal::UndoJournal(LeafHistory& history, const UndoParams& params)
    : history_(history), params_(params), inside_mm_(history.inside_mm()) {
  CheckParameters(params, "undo");
  records_.push_back({.number = 0, .name = "start", .epoch = 1, .lost = false, .leaves = {}, .taken_out_mm3 = {}});
  Drain();
}

std::uint32_t UndoJournal::Name(std::string name) {
  named_.emplace_back(++last_number_, std::move(name));
  return last_number_;
}

void UndoJournal::Drain() {
  if (job_) return;
  Read(static_cast<std::size_t>(-1));
  MarkLost();
  DropOldest();
}

/// Reads the history's entries up to, but not including, entry `end`.
void UndoJournal::Read(std::size_t end) {
  for (; read_ < end; ++read_) {
    const LeafBefore* before = history_.ring().Peek();
    if (before == nullptr) break;
    if (before->kind == LeafBefore::Kind::kCheckpoint && before->number == 0) {
      records_.back().epoch = before->epoch;
      records_.back().taken_out_mm3 = MakeSparse(before->figures());
    } else if (before->kind == LeafBefore::Kind::kCheckpoint) {
      redo_.clear();
      records_.back().leaves.Close();
      Record record;
      record.number = before->number;
      record.epoch = before->epoch;
      record.taken_out_mm3 = MakeSparse(before->figures());
      const auto named =
          std::find_if(named_.begin(), named_.end(), [&](const auto& n) { return n.first == record.number; });
      if (named != named_.end()) {
        record.name = std::move(named->second);
        named_.erase(named_.begin(), named + 1);  // numbers come in ascending order, but some may be skipped
      }
      records_.push_back(std::move(record));
    } else {
      redo_.clear();
      const bool inside = before->kind == LeafBefore::Kind::kInside;
      records_.back().leaves.Add(before->index, inside ? nullptr : before->values.data());
    }
    history_.ring().Pop();
  }
}

/// If the history lost values, marks the record to which they belong, the last one at that time, as lost, and drops all
/// older records.
void UndoJournal::MarkLost() {
  const std::uint32_t lost = history_.last_lost();
  if (lost == lost_seen_) return;
  lost_seen_ = lost;
  auto of = std::find_if(records_.rbegin(), records_.rend(), [&](const Record& r) { return r.epoch <= lost; });
  if (of == records_.rend()) return;  // already dropped
  of->lost = true;
  of->leaves = {};
  const auto first = of.base() - 1;
  dropped_ = true;
  redo_.clear();
  records_.erase(records_.begin(), first);
}

/// Drops the oldest records until the memory is within the bound.
void UndoJournal::DropOldest() {
  const auto max_bytes = static_cast<std::size_t>(1e6 * params_.max_MB);
  while (CalcMemoryBytes() > max_bytes) {
    if (records_.size() > 1) {
      dropped_ = true;
      records_.erase(records_.begin());
    } else if (!redo_.empty()) {
      redo_.erase(redo_.begin());
    } else if (!records_.back().lost) {
      records_.back().lost = true;
      records_.back().leaves = {};
      dropped_ = true;
    } else {
      records_.back().leaves = {};
      break;
    }
  }
}

std::vector<UndoCheckpoint> UndoJournal::checkpoints() const {
  std::vector<UndoCheckpoint> list;
  for (const Record& r : records_) {
    if (!r.lost) list.push_back({r.number, r.name, r.leaves.count(), r.CalcMemoryBytes()});
  }
  return list;
}

std::uint32_t UndoJournal::Find(std::string_view name) const {
  const auto found =
      std::find_if(records_.rbegin(), records_.rend(), [&](const Record& r) { return !r.lost && r.name == name; });
  if (found != records_.rend()) return found->number;
  const bool has_earliest = !records_.back().lost && !checkpoints().front().name.empty();
  throw Error(fmt::format("there is no checkpoint '{}' to go back to{}", name,
                          has_earliest ? fmt::format("; the earliest is '{}'", checkpoints().front().name) : ""));
}

std::uint32_t UndoJournal::FindOneBack() const {
  const Record& last = records_.back();
  if (!last.lost && !last.leaves.empty()) return last.number;
  if (!last.lost && records_.size() > 1 && !records_[records_.size() - 2].lost)
    return records_[records_.size() - 2].number;
  if (dropped_) throw Error("there is nothing left to undo: earlier cuts are no longer kept");
  throw Error("there is nothing to undo");
}

/// Returns the index of the record with that number. Throws Error if there is none, or it was lost.
std::size_t UndoJournal::At(std::uint32_t number) const {
  const auto found =
      std::find_if(records_.begin(), records_.end(), [&](const Record& r) { return r.number == number; });
  if (found != records_.end() && !found->lost) return static_cast<std::size_t>(found - records_.begin());
  const std::vector<UndoCheckpoint> kept = checkpoints();
  if (kept.empty()) {
    throw Error(
        "more has been cut since the last checkpoint than undo can keep; undo is possible again from the next "
        "checkpoint on");
  }
  if (!dropped_ || number > kept.front().number) {
    throw Error(fmt::format("there is no checkpoint {} to go back to", number));
  }
  const auto named = std::find_if(kept.begin(), kept.end(), [](const UndoCheckpoint& c) { return !c.name.empty(); });
  if (named == kept.end()) throw Error("that checkpoint is no longer kept");
  throw Error(fmt::format("that checkpoint is no longer kept: undo can go back to '{}' at the earliest", named->name));
}

UndoJob& UndoJournal::Begin(bool redo) {
  job_ = std::make_unique<UndoJob>();
  job_->redo = redo;
  job_->seen = read_;
  job_->lost = lost_seen_;
  used_in_block_ = kBlock;
  return *job_;
}

float* UndoJournal::NewBlock() {
  if (used_in_block_ == kBlock) {
    job_->blocks.emplace_back(new float[kBlock * 512]);
    used_in_block_ = 0;
  }
  return job_->blocks.back().get() + 512 * used_in_block_++;
}

float* UndoJournal::NewLeaf(const std::array<int, 3>& index) {
  float* values = NewBlock();
  job_->leaves.push_back({index, values});
  return values;
}

/// Adds blocks for leaves that change before the job begins. Writing to them once maps their memory before the tick.
void UndoJournal::FillSpare() {
  const auto count = static_cast<std::size_t>(params_.max_changed_leaves);
  job_->leaves.reserve(job_->leaves.size() + count);
  job_->spare.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    float* values = NewBlock();
    std::fill_n(values, 512, 0.0f);
    job_->spare.push_back(values);
  }
}

UndoJob* UndoJournal::PrepareUndo(std::uint32_t number) {
  if (job_) throw Error("an undo or redo is already in progress");
  Drain();
  const std::size_t base = At(number);
  UndoJob& job = Begin(false);
  job.number = number;
  job.taken_out_mm3 = MakeFull(records_[base].taken_out_mm3);
  std::size_t max_leaves = 0;
  for (std::size_t i = base; i < records_.size(); ++i) max_leaves += records_[i].leaves.count();
  job.leaves.reserve(max_leaves + static_cast<std::size_t>(params_.max_changed_leaves));
  std::unordered_set<std::uint64_t> have;
  have.reserve(max_leaves);
  try {
    for (std::size_t i = base; i < records_.size(); ++i) {
      records_[i].leaves.ForEachInside([&](const std::array<int, 3>& leaf) {
        if (have.insert(KeyOf(leaf)).second) std::fill_n(NewLeaf(leaf), 512, inside_mm_);
      });
      records_[i].leaves.ForEachWanted([&](const std::array<int, 3>& leaf) { return have.insert(KeyOf(leaf)).second; },
                                       [&](const std::array<int, 3>& leaf, const char* bytes) {
                                         std::memcpy(NewLeaf(leaf), bytes, LeafPack::kLeafBytes);
                                       });
    }
  } catch (...) {
    job_.reset();
    throw;
  }
  FillSpare();
  return job_.get();
}

UndoJob* UndoJournal::PrepareRedo() {
  if (job_) throw Error("an undo or redo is already in progress");
  Drain();
  if (redo_.empty()) throw Error("there is nothing to redo: nothing was undone, or bone was cut since");
  const RedoState& redo_state = redo_.back();
  UndoJob& job = Begin(true);
  job.number = records_.back().number;
  job.taken_out_mm3 = MakeFull(redo_state.taken_out_mm3);
  job.leaves.reserve(redo_state.after.count());
  try {
    redo_state.after.ForEachInside(
        [&](const std::array<int, 3>& leaf) { std::fill_n(NewLeaf(leaf), 512, inside_mm_); });
    redo_state.after.ForEachWanted([](const std::array<int, 3>&) { return true; },
                                   [&](const std::array<int, 3>& leaf, const char* bytes) {
                                     std::memcpy(NewLeaf(leaf), bytes, LeafPack::kLeafBytes);
                                   });
  } catch (...) {
    job_.reset();
    throw;
  }
  return job_.get();
}

bool UndoJournal::Finish() {
  const std::unique_ptr<UndoJob> job = std::exchange(job_, nullptr);
  if (!job || job->state.load(std::memory_order_acquire) != RestoreJob::State::kDone) {
    Drain();
    return false;
  }
  if (job->redo) {
    RedoState redo_state = std::move(redo_.back());
    redo_.pop_back();
    records_.back().leaves = std::move(redo_state.base);
    records_.back().epoch = redo_state.base_epoch;
    std::move(redo_state.records.begin(), redo_state.records.end(), std::back_inserter(records_));
  } else {
    Read(job->pushed);
    RedoState redo_state;
    const auto base = static_cast<std::ptrdiff_t>(At(job->number));
    Record& record = records_[static_cast<std::size_t>(base)];
    std::move(records_.begin() + base + 1, records_.end(), std::back_inserter(redo_state.records));
    records_.erase(records_.begin() + base + 1, records_.end());
    record.leaves.Close();
    redo_state.base = std::exchange(record.leaves, {});
    redo_state.base_epoch = record.epoch;
    redo_state.taken_out_mm3 = MakeSparse(job->taken_out_mm3);
    for (const RestoreJob::Leaf& leaf : job->leaves) redo_state.after.Add(leaf.index, leaf.values);
    redo_state.after.Close();
    redo_.push_back(std::move(redo_state));
  }
  records_.back().epoch = job->epoch;
  Drain();
  return true;
}

std::size_t UndoJournal::CalcMemoryBytes() const {
  std::size_t bytes = sizeof(*this);
  for (const Record& r : records_) bytes += r.CalcMemoryBytes();
  for (const RedoState& u : redo_) {
    bytes += sizeof(u) + u.base.CalcMemoryBytes() + u.after.CalcMemoryBytes();
    for (const Record& r : u.records) bytes += r.CalcMemoryBytes();
  }
  for (const auto& [number, name] : named_) bytes += sizeof(named_[0]) + name.capacity();
  return bytes;
}

std::size_t UndoJournal::CountLeaves() const {
  std::size_t count = 0;
  for (const Record& r : records_) count += r.leaves.count();
  for (const RedoState& u : redo_) {
    count += u.base.count() + u.after.count();
    for (const Record& r : u.records) count += r.leaves.count();
  }
  return count;
}

void MakeCheckpoint(CoupledSimulation& simulation, UndoJournal& journal, std::string name) {
  const std::uint32_t number = journal.Name(std::move(name));
  journal.Drain();
  if (!MakeCheckpoint(simulation, number)) throw Error("the simulation keeps no history: call KeepHistory()");
  journal.Drain();
}

namespace {

void RunJob(CoupledSimulation& simulation, UndoJournal& journal, const Pose* X_WT) {
  RunRestore(simulation, *journal.job(), X_WT);
  const RestoreJob::State state = journal.job()->state;
  if (!journal.Finish()) throw Error(fmt::format("nothing was undone: {}", WhyRefused(state)));
}

}  // namespace

void UndoTo(CoupledSimulation& simulation, UndoJournal& journal, std::uint32_t number, const Pose* X_WT) {
  journal.PrepareUndo(number);
  RunJob(simulation, journal, X_WT);
}
void Redo(CoupledSimulation& simulation, UndoJournal& journal, const Pose* X_WT) {
  journal.PrepareRedo();
  RunJob(simulation, journal, X_WT);
}

}  // namespace kerf
