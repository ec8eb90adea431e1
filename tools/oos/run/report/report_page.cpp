#include "tools/oos/run/report/report_page.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tools/oos/run/report/report_charts.hpp"
#include "tools/oos/run/report/run_history.hpp"

namespace oos {
namespace {

using nlohmann::json;

constexpr const char* kStyle = R"(
body { font: 15px/1.45 "DejaVu Sans", sans-serif; color: #1c2430; background: #fff; margin: 0 auto; max-width: 1080px;
  padding: 24px; }
h1 { font-size: 24px; margin: 0; } h2 { font-size: 17px; margin: 32px 0 8px; } p { margin: 4px 0; }
.verdict { display: inline-block; padding: 2px 10px; border-radius: 4px; color: #fff; background: #1d7f3f; }
.verdict.failed { background: #b3261e; } .quiet { color: #5b6573; }
.figures { display: flex; flex-wrap: wrap; gap: 12px; margin: 16px 0; }
.figures div { border: 1px solid #d7dce3; border-radius: 6px; padding: 8px 14px; }
.figures b { display: block; font-size: 19px; }
img, video, svg { max-width: 100%; height: auto; } img, video { border-radius: 6px; background: #0e121a; }
table { border-collapse: collapse; } th, td { text-align: left; padding: 3px 14px 3px 0; border-bottom: 1px solid #e6e9ee; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; } .failed-row td { color: #b3261e; }
)";

std::string Escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string CellText(const json& value) {
  if (value.is_null()) return "–";
  if (value.is_string()) return Escape(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) {
    std::ostringstream out;
    out.precision(4);
    out << value.get<double>();
    return out.str();
  }
  return Escape(value.dump());
}

json Get(const json& object, const char* key) {
  return object.is_object() && object.contains(key) ? object.at(key) : json(nullptr);
}

std::string SecondsText(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", seconds);
  return text;
}

// The bytes of a file as a data URI; empty: there is no such file.
std::string DataUri(const std::filesystem::path& file, const char* type) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = std::string("data:") + type + ";base64,";
  uri.reserve(uri.size() + bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      uri += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63U];
    }
  }
  return uri;
}

class Page {
 public:
  Page(const json& report, const std::filesystem::path& folder)
      : report_(report), folder_(folder), history_(RunHistory::Read(folder)) {}

  std::string Write() {
    const std::string scenario = CellText(Get(report_, "scenario"));
    out_ << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>" << scenario
         << ", a run</title>\n<style>" << kStyle << "</style>\n</head>\n<body>\n<h1>" << scenario << "</h1>\n";
    WriteHead();
    WritePictures();
    WriteSteps();
    WriteCharts();
    WriteLatencies();
    WriteAllFigures();
    WriteMissing();
    out_ << "</body>\n</html>\n";
    return out_.str();
  }

 private:
  void WriteHead() {
    const json completed = Get(report_, "completed");
    const bool is_good = completed.is_boolean() && completed.get<bool>();
    out_ << "<p><span class=\"verdict" << (is_good ? "\">completed" : " failed\">not completed") << "</span> "
         << (is_good ? "" : CellText(Get(report_, "why"))) << "</p>\n<p class=\"quiet\">" << Escape(folder_.filename())
         << " · method " << CellText(Get(report_, "method")) << ", coupling " << CellText(Get(report_, "coupling"))
         << ", seed " << CellText(Get(report_, "seed")) << "</p>\n<div class=\"figures\">\n";
    const json haptic = Get(report_, "haptic");
    Figure("duration", Get(report_, "seconds"), "s");
    Figure("peak force on the hand", Get(report_, "peak_force_N"), "N");
    Figure("haptic step in contact, p50", Get(haptic, "contact_p50_us"), "µs");
    Figure("late haptic cycles", Get(haptic, "misses"), "of " + CellText(Get(haptic, "cycles")));
    Figure("hand to hand (t1), mean", Get(Get(report_, "t1_ms"), "mean"), "ms");
    Figure("hand to picture, mean", Get(Get(report_, "t2_image_ms"), "mean"), "ms");
    out_ << "</div>\n<p class=\"quiet\">Simulated: ";
    const json simulated = Get(report_, "simulated");
    for (std::size_t i = 0; i < simulated.size(); ++i) out_ << (i == 0 ? "" : "; ") << CellText(simulated[i]);
    out_ << ".</p>\n";
  }

  void Figure(const char* name, const json& value, const std::string& unit) {
    if (!value.is_null()) out_ << "<div><b>" << CellText(value) << " " << unit << "</b>" << name << "</div>\n";
  }

  void WritePictures() {
    const std::string film = IsFilmOfThisRun() ? DataUri(FilmFile(folder_), "video/mp4") : "";
    const std::string sheet = DataUri(folder_ / "contact_sheet.png", "image/png");
    if (!film.empty()) out_ << "<h2>Film</h2>\n<video controls muted src=\"" << film << "\"></video>\n";
    if (!sheet.empty()) out_ << "<h2>The end of each step</h2>\n<img alt=\"contact sheet\" src=\"" << sheet << "\">\n";
    std::error_code error;
    const bool has_scene = std::filesystem::exists(SceneRecording(folder_), error);
    if (film.empty() && has_scene) missing_.emplace_back("The film: oos report " + folder_.string());
    if (!has_scene) missing_.emplace_back("The film: no viewer ran, so nothing recorded what was seen.");
    if (sheet.empty())
      missing_.emplace_back("The contact sheet: no viewer ran to its end, or the procedure entered no step.");
  }

  // A folder may be used again: a film that is older than what it was made of is of another run.
  [[nodiscard]] bool IsFilmOfThisRun() const {
    std::error_code error;
    const auto film = std::filesystem::last_write_time(FilmFile(folder_), error);
    if (error) return false;
    const auto scene = std::filesystem::last_write_time(SceneRecording(folder_), error);
    return !error && film >= scene;
  }

  void WriteSteps() {
    const json steps = Get(report_, "steps");
    if (steps.empty()) return;
    out_ << "<h2>Steps</h2>\n<table>\n<tr><th>step</th><th class=\"number\">from, s</th><th class=\"number\">took, "
            "s</th>"
            "<th>result</th></tr>\n";
    for (const json& step : steps) {
      const bool is_good = Get(step, "completed").is_boolean() && Get(step, "completed").get<bool>();
      out_ << (is_good ? "<tr>" : "<tr class=\"failed-row\">") << "<td>" << CellText(Get(step, "name"))
           << "</td><td class=\"number\">" << BeginOf(Get(step, "name")) << "</td><td class=\"number\">"
           << CellText(Get(step, "seconds")) << "</td><td>" << (is_good ? "completed" : "missed");
      if (!Get(step, "why").is_null()) out_ << ": " << CellText(Get(step, "why"));
      out_ << "</td></tr>\n";
    }
    out_ << "</table>\n";
  }

  [[nodiscard]] std::string BeginOf(const json& name) const {
    for (const RunHistory::Step& step : history_.steps) {
      if (name.is_string() && step.name == name.get<std::string>()) return SecondsText(step.begin_s);
    }
    return "–";
  }

  void WriteCharts() {
    const std::string svg = DrawHistory(history_);
    if (!svg.empty()) out_ << "<h2>Over time</h2>\n" << svg;
    if (history_.force_N.empty())
      missing_.emplace_back("Force over time: device_bridge left no device_bridge_force.csv.");
    if (history_.latency_ms.empty()) missing_.emplace_back("Latency over time: no trace came back.");
    if (history_.late_cycles.points.empty()) {
      missing_.emplace_back("Late cycles over time: no viewer ran that recorded haptic_node's figures.");
    }
  }

  void WriteLatencies() {
    constexpr const char* kColumns[] = {"mean", "clock_bound", "p50", "p99", "max", "n"};
    std::ostringstream rows;
    for (const char* chain : {"direct_ms", "t1_ms", "t2_state_ms", "t2_image_ms"}) {
      const json figures = Get(report_, chain);
      if (!figures.is_object()) continue;
      rows << "<tr><td>" << chain << "</td>";
      for (const char* column : kColumns) rows << "<td class=\"number\">" << CellText(Get(figures, column)) << "</td>";
      rows << "</tr>\n";
    }
    if (rows.str().empty()) return;
    out_ << "<h2>Latency, ms</h2>\n<table>\n<tr><th></th>";
    for (const char* column : {"mean", "± by the clocks", "p50", "p99", "max", "n"}) {
      out_ << "<th class=\"number\">" << column << "</th>";
    }
    out_ << "</tr>\n" << rows.str() << "</table>\n";
  }

  void WriteAllFigures() {
    out_ << "<h2>All figures</h2>\n<details><summary>as in report.json</summary>\n<table>\n";
    const json flat = report_.flatten();
    for (const auto& [path, value] : flat.items()) {
      if (path.starts_with("/steps/")) continue;
      out_ << "<tr><td>" << Escape(path.substr(1)) << "</td><td>" << CellText(value) << "</td></tr>\n";
    }
    out_ << "</table>\n</details>\n";
  }

  void WriteMissing() {
    if (missing_.empty()) return;
    out_ << "<h2>What is missing</h2>\n<ul>\n";
    for (const std::string& what : missing_) out_ << "<li>" << Escape(what) << "</li>\n";
    out_ << "</ul>\n";
  }

  const json& report_;
  const std::filesystem::path& folder_;
  RunHistory history_;
  std::ostringstream out_;
  std::vector<std::string> missing_;
};

}  // namespace

std::filesystem::path FilmFile(const std::filesystem::path& folder) {
  return folder / "film.mp4";
}

std::string ReportPage(const json& report, const std::filesystem::path& folder) {
  return Page(report, folder).Write();
}

bool WriteReportPage(const json& report, const std::filesystem::path& folder) {
  std::ofstream out(folder / "report.html", std::ios::binary);
  out << ReportPage(report, folder);
  return out.flush().good();
}

}  // namespace oos
