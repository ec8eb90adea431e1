#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace bench {

// Rows of text and numbers, for CSV and JSON. An empty cell: the figure does not exist.
struct Table {
  std::string name;  // a file's name can be made of it
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;

  void Add(std::vector<std::string> row) { rows.push_back(std::move(row)); }
};

// Six significant digits; "" for NaN.
std::string Cell(double value);
// Three significant digits without exponents where they can be avoided, "-" for NaN: for people.
std::string Short(double value);

std::string ToCsv(const Table& table);
// An array of objects; numbers are written as numbers, empty cells as null.
std::string ToJson(const Table& table, const std::string& indent);
std::string QuoteJson(const std::string& text);

// Appears whole, by renaming, or not at all.
core::Result<void> WriteFile(const std::filesystem::path& file, const std::string& text);

}  // namespace bench
