#pragma once

#include <google/protobuf/stubs/logging.h>

namespace fuzz {

// Silences protobuf, which would report every malformed text on stderr: millions of lines.
inline void QuietProtobuf() {
  [[maybe_unused]] static const auto before = google::protobuf::SetLogHandler(nullptr);
}

}  // namespace fuzz
