// A TOML text as a tree of our own, in which everything knows its line and column.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace kerf {

struct TomlNode {
  enum class Kind { kTable, kArray, kText, kInteger, kReal, kBool, kOther };

  Kind kind = Kind::kTable;
  std::string key;  // empty for the root and for items of an array
  int line = 1;     // of the key, or of the value when there is no key; from 1
  int column = 1;
  std::string text;  // kText: the text; kOther: what it is, e.g. "a date"
  std::int64_t integer = 0;
  double real = 0;  // kInteger too
  bool boolean = false;
  std::vector<TomlNode> children;  // of a table in the order of the file, of an array

  const TomlNode* Find(const std::string& child_key) const;
  /// The value as a message shows it: `"fast"`, `-0.1`, `a table`.
  std::string Show() const;
};

/// Throws Error `file:line:column: ...` when the text is not TOML 1.0.
TomlNode ParseToml(const std::string& text, const std::string& file);

}  // namespace kerf
