#pragma once

#include <functional>
#include <memory>

#include "cli/arguments.hpp"
#include "core/result.hpp"
#include "nodes/visual_node/options.hpp"
#include "nodes/visual_node/surfaces.hpp"

namespace visual_node {

using MakeSurfaces =
    std::function<core::Result<std::unique_ptr<Surfaces>>(const cli::Arguments& arguments, const Options& options)>;

// The life of a viewer's process, from the command line to the exit status: pictures without a bus, or a live viewer,
// for whom `make_surfaces` makes who draws the surfaces (none: the viewer itself). `syntax` has all options of
// CommandLineSyntax. For main() alone: it sets signal handlers and prints. No RunNode: a viewer has no step, and the
// window's loop is its own. Command line, scenario and exit status are those of every node.
int RunProgram(int argc, char** argv, const cli::Syntax& syntax, const MakeSurfaces& make_surfaces = {});

}  // namespace visual_node
