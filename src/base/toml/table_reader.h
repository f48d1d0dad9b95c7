// Strict reader of a TOML table into a described struct: every key must be known, of the right type and in range.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/toml/faults.h"
#include "base/toml/toml_document.h"
#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

/// Visitor for Describe() that reads the fields. An absent key leaves its field unchanged. So does a fault, which is
/// recorded.
class TableReader {
 public:
  /// `name` is the table as written in the file, e.g. "[tool]". Both references must outlive the reader.
  TableReader(const TomlNode& table, std::string name, Faults& faults);

  void operator()(const char* key, double& value, Range range, const char* meaning);
  void operator()(const char* key, int& value, Range range, const char* meaning);
  void operator()(const char* key, bool& value, const char* meaning);
  void operator()(const char* key, Vec3& value, Range range, const char* meaning);
  void operator()(const char* key, Quat& value, const char* meaning);
  void operator()(const char* key, std::string& value, const Choices& choices, const char* meaning);
  void operator()(const char* key, std::string& value, TextLimit limit, const char* meaning);

  /// Returns the value of the key without any check, or nullptr if the key is absent.
  const TomlNode* Node(const char* key) { return Take(key); }
  /// Returns the sub-table, or nullptr if it is absent or not a table (recorded as a fault).
  const TomlNode* Table(const char* key);
  /// Returns the tables of `[[key]]`; empty if absent or not tables (recorded as a fault).
  std::vector<const TomlNode*> Tables(const char* key, std::size_t limit);
  bool Has(const char* key) const { return table_.Find(key) != nullptr; }
  /// Returns true if the key has already been requested.
  bool Known(const char* key) const;
  /// Records a fault if the key is absent.
  void Require(const char* key);
  /// Records a fault at the key, or at the table if the key is absent.
  void Fault(const char* key, const std::string& what);
  /// Records a fault for each key that was not requested. The message suggests the nearest valid key or, if none is
  /// near, lists all of them. Call last.
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
