#include "tools/bench/table.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

namespace bench {
namespace {

bool IsNumber(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

std::string QuoteCsv(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

}  // namespace

std::string Cell(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof(text), "%.6g", value);
  return text;
}

std::string Short(double value) {
  if (!std::isfinite(value)) return "-";
  char text[32];
  const double size = std::abs(value);
  std::snprintf(text, sizeof(text), size >= 1000.0 && size < 1e7 ? "%.0f" : "%.3g", value);
  return text;
}

std::string ToCsv(const Table& table) {
  std::string text;
  const auto add = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) text += (i ? "," : "") + QuoteCsv(row[i]);
    text += "\n";
  };
  add(table.columns);
  for (const auto& row : table.rows) add(row);
  return text;
}

std::string QuoteJson(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string ToJson(const Table& table, const std::string& indent) {
  std::string text = "[\n";
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    text += indent + "  {";
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      const std::string& cell = table.rows[r][i];
      text += (i ? ", " : "") + QuoteJson(table.columns[i]) + ": ";
      text += cell.empty() ? "null" : IsNumber(cell) ? cell : QuoteJson(cell);
    }
    text += r + 1 < table.rows.size() ? "},\n" : "}\n";
  }
  return text + indent + "]";
}

core::Result<void> WriteFile(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path partial = file.string() + ".partial";
  std::error_code error;
  {
    std::ofstream stream(partial, std::ios::binary | std::ios::trunc);
    stream << text;
    stream.close();
    if (stream) std::filesystem::rename(partial, file, error);
    if (stream && !error) return {};
  }
  std::filesystem::remove(partial, error);
  return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot be written");
}

}  // namespace bench
