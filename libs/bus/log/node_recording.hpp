#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bus/log/tap_recorder.hpp"
#include "bus/node.hpp"

namespace bus::log {

// What a node's recording says of where it comes from: host, versions, the table of topics.
std::vector<Metadata> DescribeProvenance(const std::string& node);

// Which recording of its own a node is asked for. As given on its command line.
struct RecordingOptions {
  std::string file;               // empty: none
  std::string split_MB, split_s;  // a new file at that size or age; empty: one file
  std::string scenario;           // its texts are attached; empty: none
};

// Null when none is wanted. `more`: further metadata, e.g. of the platform. Errors: kIo; kInvalidInput.
core::Result<std::unique_ptr<TapRecorder>> StartRecording(const std::string& node, const RecordingOptions& options,
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
