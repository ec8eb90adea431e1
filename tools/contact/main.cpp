// `oos bench vps --pair training` alone, for constants.py: a program that is built with little else.

#include <cstdio>

#include "tools/bench/report.hpp"
#include "tools/contact/studies.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: contact_training PLOT_FOLDER\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  contact::Report report;
  contact::StudyTraining(argv[1], &report);
  const auto written = bench::WriteReport({}, argv[1], {"vps", "Training parts", ""}, report);
  if (!written) std::fprintf(stderr, "contact_training: %s\n", written.error().detail.c_str());
  return written && report.skipped.empty() ? 0 : 1;
}
