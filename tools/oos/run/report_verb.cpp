#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/oos/run/report/film.hpp"
#include "tools/oos/run/report/report_page.hpp"
#include "tools/oos/run/verbs.hpp"

namespace oos {
namespace {

int RunReport(const Arguments& arguments) {
  const std::filesystem::path folder = std::filesystem::absolute(arguments.positional()[0]).lexically_normal() / "";
  const std::filesystem::path run = folder.parent_path();
  std::ifstream in(run / "report.json");
  const auto report = in ? nlohmann::json::parse(in, nullptr, false) : nlohmann::json();
  if (!report.is_object() || !report.contains("scenario")) {
    return Complain("report", run.string() + " has no report.json of a run; 'oos run' leaves one in out/", kBadUsage);
  }
  int status = kHolds;
  if (!arguments.has("--no_film")) {
    std::printf("making the film; this takes minutes where there is no graphics card\n");
    std::fflush(stdout);
    if (const auto made = MakeFilm(run); !made) status = Complain("report", made.error().detail, kDoesNotHold);
  }
  if (!WriteReportPage(report, run)) return Complain("report", "cannot write " + run.string(), kDoesNotHold);
  std::printf("%s\n", (run / "report.html").c_str());
  return status;
}

}  // namespace

Verb ReportVerb() {
  return {
      "report",
      "makes a run's film and puts it into its page, report.html",
      "RUN",
      1,
      1,
      {{"--no_film", "", "only the page"}},
      RunReport,
      "RUN: a folder that 'oos run' left. The page is one file without links: contact sheet, steps, charts, figures,\n"
      "film. 'oos run' writes it too, after a run in a window with the film, otherwise only with --film. The film "
      "(film.mp4,\n"
      "20 s at most, by time lapse where the run is longer) needs ffmpeg; without it the page is made all the same,\n"
      "and the exit status is 1."};
}

}  // namespace oos
