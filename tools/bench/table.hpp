#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace bench {

// Rows of text and numbers, for CSV and JSON. An empty cell means that there is no value.
struct Table {
  std::string name;  // valid as a file's name
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;

  void Add(std::vector<std::string> row) { rows.push_back(std::move(row)); }
};

// Six significant digits; "" for NaN.
std::string Cell(double value);
// For people: three significant digits, without an exponent where possible; "-" for NaN.
std::string Short(double value);

std::string ToCsv(const Table& table);
// An array of objects; numbers are written as numbers, empty cells as null.
std::string ToJson(const Table& table, const std::string& indent);
std::string QuoteJson(const std::string& text);

// Writes a temporary file and renames it: readers see the whole file or none.
core::Result<void> WriteFile(const std::filesystem::path& file, const std::string& text);

}  // namespace bench
