#include "base/core/message.h"

#include <fmt/args.h>
#include <fmt/format.h>

#include <cmath>

namespace kerf {

std::string FormatQuantity(const Quantity& quantity, std::string_view point) {
  const double half = 0.5 * std::pow(10.0, -quantity.digits);
  std::string text = fmt::format("{:.{}f}", std::abs(quantity.value) < half ? 0.0 : quantity.value, quantity.digits);
  if (const std::size_t at = text.find('.'); at != std::string::npos) text.replace(at, 1, point);
  const std::string_view unit = quantity.unit;
  if (unit.empty()) return text;
  return text + (unit == "°" ? "" : " ") + quantity.unit;
}

bool Message::operator==(const Message& other) const {
  return std::string_view(text) == other.text && values == other.values;
}

std::string FormatMessage(const Message& message) {
  return FormatMessage(
      message, [](const std::string& text) { return text; }, ".");
}

std::string FormatMessage(const Message& message, const std::function<std::string(const std::string&)>& translate,
                          std::string_view point) {
  fmt::dynamic_format_arg_store<fmt::format_context> values;
  for (const auto& value : message.values) {
    const Quantity* quantity = std::get_if<Quantity>(&value);
    values.push_back(quantity != nullptr ? FormatQuantity(*quantity, point) : translate(std::get<std::string>(value)));
  }
  try {
    return fmt::vformat(translate(message.text), values);
  } catch (const fmt::format_error&) {
    return fmt::vformat(message.text, values);
  }
}

}  // namespace kerf
