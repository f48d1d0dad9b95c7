// The folder of a study: its description, and a file for each record, so that what is done is never done again.
//
//   OUT/plan.json              what it is, made by which program on which machine
//   OUT/cases/ID.errors.json   a record each, written at once
//   OUT/cases/ID.costs.json
//   OUT/references/NAME.json   what is said of a reference; NAME.ref is the reference itself
//   OUT/shard-3-of-8/          the same again, for one shard
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiment/study/plan.h"
#include "experiment/study/records.h"

namespace kerf {

/// What cases/ID.errors.json or .costs.json holds.
struct WorkRecord {
  std::string id;
  CaseWork work = CaseWork::kErrors;
  std::string input;  // PlannedCase's
  CaseState state = CaseState::kDone;
  std::string why;
  std::string path_title;
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
  double seconds = 0;  // that the work took
  std::string commit;  // of the program
  std::string cpu;     // of the machine
};
std::string FormatWorkRecord(const WorkRecord& record);
/// Throws Error for what is none.
WorkRecord ParseWorkRecord(const std::string& text);
/// Whether both say the same, but for times, which differ each time.
bool AgreeInAllButTimes(const WorkRecord& a, const WorkRecord& b);

/// What references/NAME.json holds.
struct KeptReference {
  std::string name;   // PlannedCase::reference
  std::string input;  // of the path and the tolerance
  std::string why;    // it could not be made; empty: it was
  ReferenceRecord record;
};

/// What plan.json holds.
struct StudyDescription {
  StudySpec spec;
  std::uint64_t plan_hash = 0;
  std::optional<Shard> shard;
  bool errors = true;  // whether they are asked for
  bool costs = true;
  std::string command;
  std::string commit;
  std::string build;
  MachineState machine;
};

class StudyFolder {
 public:
  explicit StudyFolder(std::string path) : path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  bool HasDescription() const;
  /// Throws Error when it can't be read.
  StudyDescription ReadDescription() const;
  void WriteDescription(const StudyDescription& description) const;

  std::string FileOf(const std::string& id, CaseWork work) const;
  /// None when there is no such file. Throws Error, with the file's name, when it is damaged.
  std::optional<WorkRecord> Read(const std::string& id, CaseWork work) const;
  /// `copy`: not awaited to be on the disk, since it could be made again at once.
  void Write(const WorkRecord& record, bool copy = false) const;

  /// Where the reference itself is kept.
  std::string FileOfReference(const std::string& name) const;
  std::optional<KeptReference> ReadReference(const std::string& name) const;
  void WriteReference(const KeptReference& reference) const;

  /// Folders of shards in it, sorted.
  std::vector<std::string> ListShards() const;

 private:
  std::string path_;
};

/// "OUT/shard-3-of-8".
std::string FolderOfShard(const std::string& folder, Shard shard);

}  // namespace kerf
