// Reads a TOML table into a described struct, strictly: every key known, of the right type and in range.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/core/describe.h"
#include "base/toml/faults.h"
#include "base/toml/toml_document.h"
#include "kerf/geometry.h"

namespace kerf {

/// A visitor for Describe(). A key that is absent leaves its field as it is; a fault leaves it too and is noted.
class TableReader {
 public:
  /// `name` is the table as the file writes it, e.g. "[tool]". Both references must outlive the reader.
  TableReader(const TomlNode& table, std::string name, Faults& faults);

  void operator()(const char* key, double& value, Range range, const char* meaning);
  void operator()(const char* key, int& value, Range range, const char* meaning);
  void operator()(const char* key, bool& value, const char* meaning);
  void operator()(const char* key, Vec3& value, Range range, const char* meaning);
  void operator()(const char* key, Quat& value, const char* meaning);
  void operator()(const char* key, std::string& value, const Choices& choices, const char* meaning);
  void operator()(const char* key, std::string& value, TextLimit limit, const char* meaning);

  /// What stands at the key, whatever it is, for the caller to judge; nullptr when absent.
  const TomlNode* Node(const char* key) { return Take(key); }
  /// The sub-table, or nullptr when absent or not a table (noted).
  const TomlNode* Table(const char* key);
  /// The tables of `[[key]]`; empty when absent or not that (noted).
  std::vector<const TomlNode*> Tables(const char* key, std::size_t limit);
  bool Has(const char* key) const { return table_.Find(key) != nullptr; }
  /// Whether somebody asked for the key already.
  bool Known(const char* key) const;
  /// Notes a fault when the key is absent.
  void Require(const char* key);
  /// Notes a fault at the key, or at the table when it is absent.
  void Fault(const char* key, const std::string& what);
  /// Notes each key that nobody asked for, with the nearest that is valid or, when none is near, all that are. Call
  /// last.
  void Finish();

 private:
  const TomlNode* Take(const char* key);
  void WrongType(const TomlNode& node, const std::string& wanted);
  bool CheckNumber(const TomlNode& at, const std::string& shown_key, const TomlNode& node, Range range,
                   std::string_view unit);
  bool ReadNumbers(const char* key, double* values, std::size_t count, Range range, const std::string& wanted);

  const TomlNode& table_;
  std::string name_;
  Faults& faults_;
  std::vector<std::string> known_;
};

}  // namespace kerf
