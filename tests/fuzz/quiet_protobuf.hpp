#pragma once

#include <google/protobuf/stubs/logging.h>

namespace fuzz {

// Protobuf tells of every refused text on stderr: millions of lines.
inline void QuietProtobuf() {
  [[maybe_unused]] static const auto before = google::protobuf::SetLogHandler(nullptr);
}

}  // namespace fuzz
