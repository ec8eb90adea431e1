#include "nodes/physics_node/snapshot.hpp"

#include <unistd.h>

#include <atomic>
#include <fstream>
#include <iterator>
#include <string>

#include "physics/checkpoint_file.hpp"

namespace physics_node {
namespace {

// A temporary file with a unique name, removed at the end.
struct TemporaryFile {
  TemporaryFile() {
    static std::atomic<int> count{0};
    path = std::filesystem::temp_directory_path() /
           ("vr_oos_checkpoint_" + std::to_string(::getpid()) + "_" + std::to_string(count.fetch_add(1)));
  }
  ~TemporaryFile() {
    std::error_code error;
    std::filesystem::remove(path, error);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  std::filesystem::path path;
};

}  // namespace

core::Result<void> WriteSnapshot(const std::filesystem::path& file, std::uint64_t content, const Snapshot& snapshot) {
  const physics::Checkpoint* const parts[] = {&snapshot.node, &snapshot.world, &snapshot.inputs};
  return physics::WriteCheckpointFile(file, content, snapshot.tick, parts);
}

core::Result<void> ReadSnapshot(const std::filesystem::path& file, std::uint64_t content, Snapshot* snapshot) {
  physics::Checkpoint* const parts[] = {&snapshot->node, &snapshot->world, &snapshot->inputs};
  const auto tick = physics::ReadCheckpointFile(file, content, parts);
  if (!tick) return core::Fail(tick.error().code, tick.error().detail);
  snapshot->tick = *tick;
  return {};
}

core::Result<std::vector<std::uint8_t>> EncodeSnapshot(std::uint64_t content, const Snapshot& snapshot) {
  const TemporaryFile file;
  if (auto done = WriteSnapshot(file.path, content, snapshot); !done) return tl::unexpected(done.error());
  std::ifstream stream(file.path, std::ios::binary);
  return std::vector<std::uint8_t>(std::istreambuf_iterator<char>(stream), {});
}

core::Result<void> DecodeSnapshot(const std::vector<std::uint8_t>& bytes, std::uint64_t content, Snapshot* snapshot) {
  const TemporaryFile file;
  std::ofstream stream(file.path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) return core::Fail(core::ErrorCode::kIo, file.path.string() + ": cannot be written");
  return ReadSnapshot(file.path, content, snapshot);
}

}  // namespace physics_node
