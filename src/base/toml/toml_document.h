// TOML text as a tree in which every node has its line and column.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

struct TomlNode {
  enum class Kind { kTable, kArray, kText, kInteger, kReal, kBool, kOther };

  Kind kind = Kind::kTable;
  std::string key;  // empty for the root and for array items
  int line = 1;     // of the key, or of the value if there is no key; one-based
  int column = 1;
  std::string text;  // kText: the text; kOther: its kind, e.g. "a date"
  std::int64_t integer = 0;
  double real = 0;  // also set for kInteger
  bool boolean = false;
  std::vector<TomlNode> children;  // of a table, in the order of the file, or of an array

  const TomlNode* Find(const std::string& child_key) const;
  /// Returns the place of a key, or of this table if it lacks the key: `file:line:column`.
  std::string PlaceOf(const std::string& child_key, const std::string& file) const;
  /// Formats the value for a message: `"fast"`, `-0.1`, `a table`.
  std::string Show() const;
};

/// Throws kerf::Error `file:line:column: ...` if the text is not TOML 1.0.
TomlNode ParseToml(const std::string& text, const std::string& file);

}  // namespace kerf
