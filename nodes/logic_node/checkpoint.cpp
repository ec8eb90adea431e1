#include "nodes/logic_node/checkpoint.hpp"

#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

#include "core/hash.hpp"
#include "core/read_file.hpp"

namespace logic_node {
namespace {

constexpr char kMagic[8] = {'O', 'O', 'S', 'L', 'O', 'G', 'I', '1'};

struct Head {
  char magic[8];
  std::uint64_t checksum = 0;  // of the bytes behind the head, and of the next field
  std::uint64_t state_bytes = 0;
};

std::uint64_t Checksum(const void* body, std::size_t size, std::uint64_t state_bytes) {
  const std::uint64_t both[2] = {core::Hash64(body, size), state_bytes};
  return core::Hash64(both, sizeof both);
}

}  // namespace

core::Result<void> WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file) {
  std::ostringstream text;
  text.precision(std::numeric_limits<double>::max_digits10);
  for (const AppliedChange& change : checkpoint.applied) {
    text << change.owner << ' ' << change.name << ' ' << change.value << '\n';
  }
  std::string body(checkpoint.state.begin(), checkpoint.state.end());
  body += text.str();
  Head head;
  std::memcpy(head.magic, kMagic, sizeof kMagic);
  head.state_bytes = checkpoint.state.size();
  head.checksum = Checksum(body.data(), body.size(), head.state_bytes);
  std::filesystem::path beside = file;
  beside += ".new";
  std::ofstream out(beside, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(&head), sizeof head);
  out.write(body.data(), static_cast<std::streamsize>(body.size()));
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, file, error);
  if (!out || error) return core::Fail(core::ErrorCode::kIo, file.string() + " cannot be written; is the disk full?");
  return {};
}

core::Result<Checkpoint> ReadCheckpoint(const std::filesystem::path& file) {
  const auto bytes = core::ReadFile(file);
  if (!bytes) return tl::unexpected(bytes.error());
  Head head;
  if (bytes->size() >= sizeof head) std::memcpy(&head, bytes->data(), sizeof head);
  const std::size_t body = bytes->size() - std::min(bytes->size(), sizeof head);
  if (bytes->size() < sizeof head || std::memcmp(head.magic, kMagic, sizeof kMagic) != 0 || head.state_bytes > body ||
      head.checksum != Checksum(bytes->data() + sizeof head, body, head.state_bytes)) {
    return core::Fail(core::ErrorCode::kDamaged, file.string() + " is not a checkpoint of logic_node, or is damaged");
  }
  Checkpoint checkpoint;
  const auto state = bytes->begin() + sizeof head;
  const auto text = state + static_cast<std::ptrdiff_t>(head.state_bytes);
  checkpoint.state.assign(state, text);
  std::istringstream lines(std::string(text, bytes->end()));
  for (AppliedChange change; lines >> change.owner >> change.name >> change.value;) {
    checkpoint.applied.push_back(change);
  }
  return checkpoint;
}

}  // namespace logic_node
