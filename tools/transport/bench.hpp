#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/bench/run_studies.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

// Makes a channel of another library for messages of `num_bytes`; null if it does not work on this machine.
using ChannelMaker = std::function<std::unique_ptr<Channel>(std::size_t num_bytes)>;

struct Peer {
  std::string name;
  ChannelMaker make;
};

// Everything that `oos bench bus` measures (see bench::RunStudies). `effort` scales the number of messages: 1 for a
// whole run, less in tests.
int BenchMain(const bench::BenchOptions& options, const std::vector<Peer>& peers, double effort = 1.0);

}  // namespace transport
