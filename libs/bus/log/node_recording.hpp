#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bus/log/tap_recorder.hpp"
#include "bus/node.hpp"

namespace bus::log {

// Provenance metadata of a node's recording: host, versions, the table of topics.
std::vector<Metadata> DescribeProvenance(const std::string& node);

// A node's recording of its own, as given on its command line.
struct RecordingOptions {
  std::string file;               // empty: none
  std::string split_MB, split_s;  // a new file at that size or age; empty: one file
  std::string scenario;           // its texts are attached; empty: none
};

// Null: no recording requested. `more`: further metadata, e.g. of the platform. Errors: kIo; kInvalidInput.
core::Result<std::unique_ptr<TapRecorder>> StartRecording(const std::string& node, const RecordingOptions& options,
                                                          std::vector<Metadata> more = {});

// Adds the recorder's tap to a node's options; null: unchanged. The recorder outlives the node.
inline NodeOptions WithTap(NodeOptions options, TapRecorder* recorder) {
  options.tap = recorder == nullptr ? nullptr : recorder->tap();
  return options;
}

// Null: does nothing. Errors: kIo, naming what could not be written.
core::Result<void> StopRecording(TapRecorder* recorder);

}  // namespace bus::log
