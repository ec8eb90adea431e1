#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace oos {

// A run as one HTML page that needs no other file and no network: what happened, the film and the contact sheet,
// steps with their times, charts, all figures of the report. What is missing is listed with how to get it.
std::string ReportPage(const nlohmann::json& report, const std::filesystem::path& folder);

// Writes it to report.html. False when the folder cannot be written.
bool WriteReportPage(const nlohmann::json& report, const std::filesystem::path& folder);

// The run's film, when one was made.
std::filesystem::path FilmFile(const std::filesystem::path& folder);

}  // namespace oos
