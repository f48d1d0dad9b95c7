// Helpers for HTML.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kerf::export_detail {

/// Encodes the bytes as in RFC 4648.
std::string Base64(std::string_view bytes);

/// Cell of a table.
struct TableCell {
  // NOLINTBEGIN(google-explicit-constructor)
  TableCell(std::string text_in, std::string technical_in = {})
      : text(std::move(text_in)), technical(std::move(technical_in)) {}
  TableCell(const char* text_in) : text(text_in) {}
  // NOLINTEND(google-explicit-constructor)
  std::string text;
  std::string technical;  // shown small after the text; empty: none
};
using TableRows = std::vector<std::vector<TableCell>>;
/// Returns an HTML table, with its text escaped. The first column is left-aligned, the others right-aligned unless
/// `text` is true.
std::string Table(const std::vector<std::string>& headers, const TableRows& rows, bool text = false);
/// As ReportLanguage::Show(), in English.
std::string Show(double value, int decimals);

}  // namespace kerf::export_detail
