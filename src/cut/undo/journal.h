// Checkpoints of a bone that is being cut, to go back to and forward again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bone/grid/leaf_history.h"
#include "cut/hand_sim/restore.h"
#include "cut/undo/leaf_pack.h"

namespace kerf {

struct UndoParams {
  double most_MB = 256;   // kept at most, compressed: 0.2 to 1e6. The oldest checkpoints go first
  int most_since = 1024;  // leaves that may change while a job is on its way, 0 to 65536: 2 kB of it each
};

/// A checkpoint that can be gone back to.
struct UndoCheckpoint {
  std::uint32_t number = 0;
  std::string name;
  std::size_t leaves = 0;  // that changed between it and the next
  std::size_t bytes = 0;   // that they take
};

/// A restore on its way, and what it needs. The simulation's until its state says otherwise.
struct UndoJob : RestoreJob {
  std::vector<std::unique_ptr<float[]>> blocks;  // of leaves' values
};

/// What history hands over is kept by checkpoints, compressed. Going back swaps what was there into the job, which is
/// what redo needs; a cut or a checkpoint after it drops that.
///
/// One thread, not the tick's. The same history read and the same calls give the same jobs, whenever it is read.
class UndoJournal {
 public:
  /// The history must outlive it and nobody else read it. Begins with a checkpoint "start" as number 0. Throws Error
  /// for a parameter out of range.
  explicit UndoJournal(LeafHistory& history, const UndoParams& params = {});

  /// The name of a checkpoint that is to be made by CoupledSimulation::Checkpoint() with this number. It is there once
  /// that has been read.
  std::uint32_t Name(std::string name);
  /// Reads what has come; now and then, before the history's ring is full. Nothing while a job is on its way.
  void Drain();

  /// Oldest first. The bone is at the last one when that has no leaves; otherwise it was cut since.
  std::vector<UndoCheckpoint> checkpoints() const;
  /// The newest of that name. Throws Error when there is none.
  std::uint32_t Find(std::string_view name) const;
  /// That one step back leads to: the last one when something was cut since. Throws Error when there is none.
  std::uint32_t FindOneBack() const;
  bool CanRedo() const { return !redo_.empty(); }

  /// What is to be put back to come to a checkpoint; drains first. Throws Error with the reason when there is no such
  /// checkpoint any more, or a job is on its way.
  UndoJob* PrepareUndo(std::uint32_t number);
  /// To where the last undo began. Throws Error likewise.
  UndoJob* PrepareRedo();
  /// The job on its way; null: none.
  UndoJob* job() const { return job_.get(); }
  /// The simulation has done with it, or will never get it. False: it was refused (WhyRefused()) and nothing has
  /// changed.
  bool Finish();

  std::size_t CalcMemoryBytes() const;  // that is held to most_MB
  std::size_t CountLeaves() const;      // kept, 2 kB each before compression

 private:
  struct Record {
    std::uint32_t number = 0;
    std::string name;
    std::uint32_t epoch = 0;  // in which the bone was last as it is at the checkpoint
    bool lost = false;        // it can't be gone back to
    LeafPack leaves;          // as they were then
    std::vector<std::pair<std::uint8_t, double>> taken_out_mm3;

    std::size_t CalcMemoryBytes() const;
  };
  /// What an undo took back.
  struct Undone {
    std::vector<Record> records;
    LeafPack base;  // of the checkpoint that it went to
    std::uint32_t base_epoch = 0;
    LeafPack after;
    std::vector<std::pair<std::uint8_t, double>> taken_out_mm3;
  };

  void Read(std::size_t end);
  void MarkLost();
  void HoldBound();
  std::size_t At(std::uint32_t number) const;
  UndoJob& Begin(bool redo);
  float* NewLeaf(const std::array<int, 3>& index);
  float* NewBlock();
  void FillSpare();

  LeafHistory& history_;
  UndoParams params_;
  float inside_mm_;
  std::size_t read_ = 0;  // messages
  std::uint32_t last_number_ = 0;
  std::uint32_t lost_seen_ = 0;
  std::vector<std::pair<std::uint32_t, std::string>> named_;  // not made yet
  std::vector<Record> records_;                               // oldest first
  std::string dropped_;                                       // the last one dropped; empty: none
  std::vector<Undone> redo_;                                  // the next last
  std::unique_ptr<UndoJob> job_;
  std::size_t used_in_block_ = 0;
};

/// For a thread that owns everything: between ticks, not in them.
void MakeCheckpoint(CoupledSimulation& simulation, UndoJournal& journal, std::string name);
/// The tool is set down at X_WT, null: where it is. Throws Error as PrepareUndo().
void UndoTo(CoupledSimulation& simulation, UndoJournal& journal, std::uint32_t number, const Pose* X_WT = nullptr);
void Redo(CoupledSimulation& simulation, UndoJournal& journal, const Pose* X_WT = nullptr);

}  // namespace kerf
