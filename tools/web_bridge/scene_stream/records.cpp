#include "tools/web_bridge/scene_stream/records.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace scene_stream {

core::Result<void> WriteRecord(int file, RecordKind kind, const std::string& bytes) {
  const auto length = static_cast<std::uint32_t>(bytes.size() + 1);
  std::string record(sizeof length, '\0');
  std::memcpy(record.data(), &length, sizeof length);
  record += static_cast<char>(kind);
  record += bytes;
  for (std::size_t done = 0; done < record.size();) {
    const ssize_t num = write(file, record.data() + done, record.size() - done);
    if (num < 0 && errno == EINTR) continue;
    if (num <= 0) return core::Fail(core::ErrorCode::kIo, "whoever reads the scene has gone");
    done += static_cast<std::size_t>(num);
  }
  return {};
}

bool IsWritable(int file) {
  pollfd output{file, POLLOUT, 0};
  return poll(&output, 1, 0) == 1;
}

}  // namespace scene_stream
