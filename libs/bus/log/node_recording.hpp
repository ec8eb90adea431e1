#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bus/log/tap_recorder.hpp"
#include "bus/node.hpp"

namespace bus::log {

// What a node's recording says of where it comes from: host, versions, the table of topics.
std::vector<Metadata> DescribeProvenance(const std::string& node);

// A node's command line asks for a recording by --record FILE, with --split_MB N and --split_s N for files of that size
// or age; the scenario's texts (--scenario) are attached. Null when it does not ask. `more`: what else is to be said,
// e.g. of the platform. Errors: kIo; kInvalidInput.
core::Result<std::unique_ptr<TapRecorder>> StartRecording(const std::string& node,
                                                          const std::map<std::string, std::string>& arguments,
                                                          std::vector<Metadata> more = {});

// The options of a node that leaves what it does in the recorder's tap; null: as they are. The recorder outlives the
// node.
inline NodeOptions WithTap(NodeOptions options, TapRecorder* recorder) {
  options.tap = recorder == nullptr ? nullptr : recorder->tap();
  return options;
}

// Null is fine. Errors: kIo, with what could not be written.
core::Result<void> StopRecording(TapRecorder* recorder);

}  // namespace bus::log
