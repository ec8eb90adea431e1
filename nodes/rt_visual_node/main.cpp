#include <memory>

#include "nodes/rt_visual_node/traced_surfaces.hpp"
#include "nodes/visual_node/program.hpp"

namespace {

tiles::Mirrors MirrorsOf(const cli::Arguments& arguments) {
  const std::string words = arguments.text("--mirrors");
  return words == "none" ? tiles::Mirrors::kNone : words == "half" ? tiles::Mirrors::kHalf : tiles::Mirrors::kAll;
}

core::Result<std::unique_ptr<visual_node::Surfaces>> StartTracing(const cli::Arguments& arguments,
                                                                  const visual_node::Options& options) {
  auto surfaces = std::make_unique<rt_visual_node::TracedSurfaces>(options.node, MirrorsOf(arguments));
  if (auto started = surfaces->Start(); !started) return tl::unexpected(started.error());
  return surfaces;
}

}  // namespace

int main(int argc, char** argv) {
  cli::Syntax syntax = visual_node::CommandLineSyntax();
  syntax.program = "rt_visual_node";
  syntax.summary = "shows the scenario as it runs, by rays that rt_worker processes follow";
  syntax.options.push_back({"--mirrors", "all|half|none", "mirror images: each, one for two by two pixels, none",
                            "half", cli::OneOf("all|half|none")});
  return visual_node::RunProgram(argc, argv, syntax, StartTracing);
}
