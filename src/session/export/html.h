// Helpers for HTML.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kerf::export_detail {

/// Encodes the bytes as in RFC 4648.
std::string Base64(std::string_view bytes);

/// Returns an HTML table, with its text escaped. The first column is left-aligned, the others right-aligned unless
/// `text` is true.
std::string Table(const std::vector<std::string>& headers, const std::vector<std::vector<std::string>>& rows,
                  bool text = false);
/// As ReportLanguage::Show(), in English.
std::string Show(double value, int decimals);

}  // namespace kerf::export_detail
