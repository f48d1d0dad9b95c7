// Texts of a language, from a catalogue of GNU gettext.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace kerf {

/// Immutable after its construction, so that any thread may use it.
class Catalogue {
 public:
  /// English: without texts.
  Catalogue() = default;
  /// Reads a file (.mo) with the byte order of x86. Throws Error if it cannot be read or is not such a file.
  explicit Catalogue(const std::string& file);
  Catalogue(const Catalogue&) = delete;
  Catalogue& operator=(const Catalogue&) = delete;

  /// Returns the translation of a text; null if there is none. It is valid as long as the catalogue.
  const char* Find(std::string_view text) const;
  /// Returns the decimal separator, "." or ",".
  std::string_view point() const;
  /// Translates a text that was made elsewhere with values in it, such as a note in a bone's file: finds the text with
  /// replacement fields, such as {}, that it was made of, and puts the values into the translation, numbers with the
  /// decimal separator. A text that is not found stays as it is.
  std::string Translate(const std::string& text) const;

 private:
  /// Text with replacement fields.
  struct Form {
    std::vector<std::string> parts;  // between the fields: one more than these
    std::size_t letters = 0;         // in the parts
    std::string translated;          // its fields have no formats
  };

  std::string bytes_;
  std::unordered_map<std::string_view, const char*> texts_;
  std::vector<Form> forms_;  // those with the most letters first
};

}  // namespace kerf
