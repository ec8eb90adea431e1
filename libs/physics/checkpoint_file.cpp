#include "physics/checkpoint_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "core/hash.hpp"
#include "core/read_file.hpp"

namespace physics {
namespace {

constexpr char kMagic[8] = {'O', 'O', 'S', 'C', 'H', 'K', 'P', 'T'};

// Start of the file. The parts follow, each as its size (64 bit) and its bytes.
struct Header {
  char magic[8] = {};
  std::uint32_t format = 0;
  std::uint32_t num_parts = 0;
  std::uint64_t content = 0;
  std::uint64_t tick = 0;
  std::uint64_t checksum = 0;  // of all bytes that follow, seeded with the checksum of the fields above
};
static_assert(sizeof(Header) == 40, "without padding, so that the checksum covers values only");

std::uint64_t Checksum(const Header& header, const void* parts, std::size_t num_bytes) {
  return core::Hash64(parts, num_bytes, core::Hash64(&header, offsetof(Header, checksum)));
}

tl::unexpected<core::Error> Refuse(const std::filesystem::path& file, core::ErrorCode code, const std::string& why) {
  return core::Fail(code, "checkpoint " + file.string() + ": " + why);
}

bool ReadParts(const std::vector<std::uint8_t>& bytes, std::span<Checkpoint* const> parts) {
  std::size_t at = sizeof(Header);
  for (Checkpoint* part : parts) {
    std::uint64_t size = 0;
    if (bytes.size() - at < sizeof(size)) return false;
    std::memcpy(&size, &bytes[at], sizeof(size));
    at += sizeof(size);
    if (bytes.size() - at < size) return false;
    part->bytes().resize(size);
    if (size > 0) std::memcpy(part->bytes().data(), &bytes[at], size);
    at += size;
  }
  return at == bytes.size();
}

}  // namespace

core::Result<void> WriteCheckpointFile(const std::filesystem::path& file, std::uint64_t content, std::uint64_t tick,
                                       std::span<const Checkpoint* const> parts) {
  std::vector<char> bytes(sizeof(Header));
  const auto append = [&bytes](const void* data, std::size_t size) {
    const char* begin = static_cast<const char*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  };
  for (const Checkpoint* part : parts) {
    const std::uint64_t size = part->bytes().size();
    append(&size, sizeof(size));
    append(part->bytes().data(), size);
  }
  Header header;
  std::memcpy(header.magic, kMagic, sizeof(kMagic));
  header.format = kCheckpointFormat;
  header.num_parts = static_cast<std::uint32_t>(parts.size());
  header.content = content;
  header.tick = tick;
  header.checksum = Checksum(header, bytes.data() + sizeof(Header), bytes.size() - sizeof(Header));
  std::memcpy(bytes.data(), &header, sizeof(header));

  std::filesystem::path beside = file;
  beside += ".new";
  {
    std::ofstream out(beside, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.flush();
    if (!out.good()) {
      return Refuse(file, core::ErrorCode::kIo, std::string("cannot be written: ") + std::strerror(errno));
    }
  }
  std::error_code error;
  std::filesystem::rename(beside, file, error);
  if (error) return Refuse(file, core::ErrorCode::kIo, "cannot be written: " + error.message());
  return {};
}

core::Result<std::uint64_t> ReadCheckpointFile(const std::filesystem::path& file, std::uint64_t content,
                                               std::span<Checkpoint* const> parts) {
  const auto read = core::ReadFile(file);
  if (!read) return Refuse(file, core::ErrorCode::kNotFound, read.error().detail);
  const std::vector<std::uint8_t>& bytes = *read;
  Header header;
  if (bytes.size() >= sizeof(Header)) std::memcpy(&header, bytes.data(), sizeof(Header));
  if (std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0) {
    return Refuse(file, core::ErrorCode::kInvalidInput, "it is not a checkpoint of physics_node; name another file");
  }
  if (header.format != kCheckpointFormat) {
    return Refuse(file, core::ErrorCode::kInvalidInput,
                  "it has format " + std::to_string(header.format) + ", but this program reads format " +
                      std::to_string(kCheckpointFormat) + "; start without it");
  }
  if (header.checksum != Checksum(header, bytes.data() + sizeof(Header), bytes.size() - sizeof(Header))) {
    return Refuse(file, core::ErrorCode::kDamaged, "it is damaged (wrong checksum); start without it");
  }
  if (header.content != content) {
    return Refuse(file, core::ErrorCode::kInvalidInput,
                  "it is of another scenario, or the scenario has changed since; start without it");
  }
  if (header.num_parts != parts.size() || !ReadParts(bytes, parts)) {
    return Refuse(file, core::ErrorCode::kInvalidInput, "its parts are not those of this program; start without it");
  }
  return header.tick;
}

}  // namespace physics
