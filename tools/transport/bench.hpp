#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/bench/report.hpp"
#include "tools/transport/channel.hpp"

namespace transport {

struct BenchOptions {
  std::filesystem::path json;  // empty: none
  std::filesystem::path plot;  // folder; empty: none
  std::string only;            // names of studies, with commas; empty: all
  double effort = 1.0;         // part of the messages that a whole run sends: tests ask for less
};

// Another library's channel of so many bytes; null: not on this machine.
using ChannelMaker = std::function<std::unique_ptr<Channel>(std::size_t num_bytes)>;

struct Peer {
  std::string name;
  ChannelMaker make;
};

// Everything `oos bench bus` measures: prints it, writes JSON, and to the plot folder a CSV beside each SVG. Returns an
// exit status.
int BenchMain(const BenchOptions& options, const std::vector<Peer>& peers);

}  // namespace transport
