// Sentences for the user as data, so that they can be translated as a whole and numbers written as the locale demands.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kerf {

/// Marks a text that is shown to the user, so that it is found for translation.
constexpr const char* MarkMessage(const char* text) {
  return text;
}

/// Number with its unit, and the number of decimals to show.
struct Quantity {
  double value = 0;
  int digits = 1;
  const char* unit = "";  // as shown: "mm", "mm³", "°"; empty: dimensionless

  bool operator==(const Quantity&) const = default;
};

/// Returns for example "3.1 mm", "5.2°" or "12". `point`: the decimal separator. A value that rounds to zero has no
/// sign.
std::string FormatQuantity(const Quantity& quantity, std::string_view point = ".");

/// Sentence with replacement fields, such as {}.
struct Message {
  const char* text = "";  // complete English sentences; {} stands for the next value, {0}, {1}, ... for that value
  std::vector<std::variant<Quantity, std::string>> values;

  bool operator==(const Message& other) const;
};

/// Returns the message in English.
std::string FormatMessage(const Message& message);
/// Returns the message in another language. `translate` is called for its text and for values that are texts. The
/// translation of the text has the same fields, in any order if they are numbered; if they do not fit the values, the
/// English text is used. `point`: the decimal separator.
std::string FormatMessage(const Message& message, const std::function<std::string(const std::string&)>& translate,
                          std::string_view point);

}  // namespace kerf
