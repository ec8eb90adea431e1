#pragma once

#include <csignal>
#include <filesystem>
#include <string>

#include "bus/node.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"

namespace headset_node {

struct Options {
  std::filesystem::path scenario;
  bus::NodeOptions node;
  std::filesystem::path out = ".";
  std::string view;  // camera that carries the room; empty: that of the procedure's step
  std::string show;  // see view::ReadChoices
};

// Shows the scenario live in a headset until a stop signal or the headset's end. Writes latency_visual.csv to OUT.
core::Result<void> RunHeadset(const Options& options, const scene::Scenario& scenario,
                              const volatile std::sig_atomic_t& is_stop_wanted);

}  // namespace headset_node
