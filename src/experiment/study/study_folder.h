// The folder of a study: its description, and a file for each record, so that no work is done twice.
//
//   OUT/plan.json              description of the study, the program and the machine
//   OUT/cases/ID.errors.json   one record each, written immediately
//   OUT/cases/ID.costs.json
//   OUT/references/NAME.json   description of a reference; NAME.ref is the reference itself
//   OUT/shard-3-of-8/          the same contents for one shard
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiment/study/plan.h"
#include "experiment/study/records.h"

namespace kerf {

/// Contents of cases/ID.errors.json or .costs.json.
struct WorkRecord {
  std::string id;
  CaseWork work = CaseWork::kErrors;
  std::string input;  // as in PlannedCase
  CaseState state = CaseState::kDone;
  std::string why;
  std::string path_title;
  std::optional<ErrorFigures> errors;
  std::optional<CostFigures> costs;
  std::uint64_t force_hash = 0;
  std::uint64_t bone_hash = 0;
  double seconds = 0;  // duration of the work
  std::string commit;  // of the program
  std::string cpu;     // of the machine
};
std::string FormatWorkRecord(const WorkRecord& record);
/// Throws Error if the text is not a work record.
WorkRecord ParseWorkRecord(const std::string& text);
/// Returns true if the two records are equal except for times, which differ from run to run.
bool AgreeInAllButTimes(const WorkRecord& a, const WorkRecord& b);

/// Contents of references/NAME.json.
struct StoredReference {
  std::string name;   // PlannedCase::reference
  std::string input;  // text that identifies the path and the tolerance
  std::string why;    // why it could not be made; empty if it was made
  ReferenceRecord record;
};

/// Contents of plan.json.
struct StudyDescription {
  StudySpec spec;
  std::uint64_t plan_hash = 0;
  std::optional<Shard> shard;
  bool errors = true;  // whether errors are requested
  bool costs = true;
  std::string command;
  std::string commit;
  std::string build;
  RunInfo machine;
};

class StudyFolder {
 public:
  explicit StudyFolder(std::string path) : path_(std::move(path)) {}
  const std::string& path() const { return path_; }

  bool HasDescription() const;
  /// Throws Error if it cannot be read.
  StudyDescription ReadDescription() const;
  void WriteDescription(const StudyDescription& description) const;

  std::string FileOf(const std::string& id, CaseWork work) const;
  /// Returns nullopt if there is no such file. Throws Error with the file name if it is damaged.
  std::optional<WorkRecord> Read(const std::string& id, CaseWork work) const;
  /// If `copy` is true, does not wait until the data are on the disk, since the record can be copied again.
  void Write(const WorkRecord& record, bool copy = false) const;

  /// Returns the file of the reference itself.
  std::string FileOfReference(const std::string& name) const;
  std::optional<StoredReference> ReadReference(const std::string& name) const;
  void WriteReference(const StoredReference& reference) const;

  /// Returns the folders of the shards in this folder, sorted.
  std::vector<std::string> ListShards() const;

 private:
  std::string path_;
};

}  // namespace kerf
