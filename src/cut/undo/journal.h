// Checkpoints of a bone that is being cut, with undo and redo.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bone/grid/leaf_history.h"
#include "cut/hand_sim/internals.h"
#include "cut/hand_sim/restore.h"
#include "cut/undo/leaf_pack.h"
#include "kerf/checkpoints.h"

namespace kerf {

struct UndoParams {
  double max_MB = 256;            // bound on the compressed memory
  int max_changed_leaves = 1024;  // 2 kB each per job
};

/// For all that have a memory for undo.
template <typename Params, typename V>
void DescribeUndoMemory(Params& p, V&& visit) {
  visit("max_MB", p.max_MB, Range{0.2, 1e6}, "memory for undo; the oldest checkpoints are dropped first");
}
template <typename V>
void Describe(UndoParams& p, V&& visit) {
  DescribeUndoMemory(p, visit);
  visit("max_changed_leaves", p.max_changed_leaves, Range{0, 65536},
        "leaves that may change before a prepared job begins");
}

/// Restore in progress, and its memory. The simulation uses it until `state` is done or refused.
struct UndoJob : RestoreJob {
  std::vector<std::unique_ptr<float[]>> blocks;  // memory of the leaves' values
};

/// Compressed old values of leaves, by checkpoint, as read from a history. Undo exchanges the restored leaves with the
/// bone's, so that the job then holds the values that redo needs. A cut or a checkpoint after undo discards redo.
///
/// Used by one thread, not the tick's. The same history and the same calls give the same jobs, independent of when the
/// history is read.
class UndoJournal {
 public:
  /// `history` must outlive the journal and have no other reader. Begins with a checkpoint "start", number 0. Throws
  /// Error if a parameter is out of range.
  explicit UndoJournal(LeafHistory& history, const UndoParams& params = {});

  /// Names the next checkpoint (the name may be empty) and returns its number, which must then be passed to
  /// CoupledSimulation::Checkpoint(). The checkpoint is listed after its entry in the history has been read.
  std::uint32_t Name(std::string name);
  /// Reads new entries of the history; must be called before its ring is full. Does nothing while a job is in progress.
  void Drain();

  /// Returns the checkpoints, oldest first. If the last one has no leaves, the bone is in that state; otherwise the
  /// bone has been cut since.
  std::vector<UndoCheckpoint> checkpoints() const;
  /// Returns the number of the newest checkpoint of that name. Throws Error if there is none.
  std::uint32_t Find(std::string_view name) const;
  /// Returns the checkpoint that is one step back: the last one if bone has been cut since, otherwise the one before
  /// it. Throws Error if there is none.
  std::uint32_t FindOneBack() const;
  bool CanRedo() const { return !redo_.empty(); }

  /// Prepares the leaves that must be restored to return to a checkpoint; reads the history first. Throws Error with
  /// the reason if the checkpoint is no longer kept, or a job is in progress.
  UndoJob* PrepareUndo(std::uint32_t number);
  /// Prepares the return to the state before the last undo. Throws Error if there is none, or a job is in progress.
  UndoJob* PrepareRedo();
  /// The job in progress; null: none.
  UndoJob* job() const { return job_.get(); }
  /// Ends the job after the simulation has finished with it, or if the simulation will never receive it. Returns false
  /// if it was refused (see WhyRefused()); then nothing has changed.
  bool Finish();

  std::size_t CalcMemoryBytes() const;  // the memory that max_MB bounds
  std::size_t CountLeaves() const;      // kept leaves, 2 kB each before compression

 private:
  struct Record {
    std::uint32_t number = 0;
    std::string name;
    std::uint32_t epoch = 0;  // last epoch in which the bone was in the state of the checkpoint
    bool lost = false;        // old values were lost: it cannot be restored
    LeafPack leaves;          // old values of leaves changed since the checkpoint
    std::vector<std::pair<std::uint8_t, double>> taken_out_mm3;

    std::size_t CalcMemoryBytes() const;
  };
  /// State that redo needs to reverse an undo.
  struct RedoState {
    std::vector<Record> records;
    LeafPack base;  // leaves of the checkpoint that undo returned to
    std::uint32_t base_epoch = 0;
    LeafPack after;
    std::vector<std::pair<std::uint8_t, double>> taken_out_mm3;
  };

  void Read(std::size_t end);
  void MarkLost();
  void DropOldest();
  std::size_t At(std::uint32_t number) const;
  UndoJob& Begin(bool redo);
  float* NewLeaf(const std::array<int, 3>& index);
  float* NewBlock();
  void FillSpare();

  LeafHistory& history_;
  UndoParams params_;
  float inside_mm_;
  std::size_t read_ = 0;  // number of entries read from the history
  std::uint32_t last_number_ = 0;
  std::uint32_t lost_seen_ = 0;
  std::vector<std::pair<std::uint32_t, std::string>> named_;  // named, not yet read from the history
  std::vector<Record> records_;                               // oldest first
  bool dropped_ = false;                                      // checkpoints were dropped
  std::vector<RedoState> redo_;                               // the last element is the next to redo
  std::unique_ptr<UndoJob> job_;
  std::size_t used_in_block_ = 0;
};

/// The following functions are for a thread that owns both the simulation and the journal; to be called between ticks.
/// Not tick-safe.
void MakeCheckpoint(CoupledSimulation& simulation, UndoJournal& journal, std::string name);
/// UndoTo() and Redo() then set the tool down at X_WT; null: at its current pose. They throw Error like PrepareUndo()
/// and PrepareRedo().
void UndoTo(CoupledSimulation& simulation, UndoJournal& journal, std::uint32_t number, const Pose* X_WT = nullptr);
void Redo(CoupledSimulation& simulation, UndoJournal& journal, const Pose* X_WT = nullptr);

}  // namespace kerf
