#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/bench/run_studies.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

// Another library's channel of so many bytes; null: not on this machine.
using ChannelMaker = std::function<std::unique_ptr<Channel>(std::size_t num_bytes)>;

struct Peer {
  std::string name;
  ChannelMaker make;
};

// Everything `oos bench bus` measures, see bench::RunStudies. `effort` is the part of the messages that a whole run
// sends: tests ask for less.
int BenchMain(const bench::BenchOptions& options, const std::vector<Peer>& peers, double effort = 1.0);

}  // namespace transport
