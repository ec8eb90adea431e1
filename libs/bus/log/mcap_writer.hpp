#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "bus/log/mcap_records.hpp"
#include "core/result.hpp"

namespace bus::log {

// Writes an MCAP file: indexed chunks of messages, and a summary. Not real-time, one thread.
//
// Flushed messages survive the writer's death: a file without a summary is read from the front, or repaired by
// RecoverMcap.
class McapWriter {
 public:
  // A chunk is closed above this size, or by Flush. Larger chunks need fewer indices, but cost more per random access.
  static constexpr std::size_t kChunkBytes = 512 * 1024;

  // The file must not exist. Errors: kIo.
  static core::Result<std::unique_ptr<McapWriter>> Create(const std::filesystem::path& path, const Header& header);
  ~McapWriter();  // without Close the file has no summary
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  // Schemas count from 1, channels from 0; schema 0: none.
  std::uint16_t AddSchema(const std::string& name, const std::string& encoding, const Bytes& data);
  std::uint16_t AddChannel(std::uint16_t schema, const std::string& topic, const std::string& message_encoding,
                           const TextMap& metadata);

  core::Result<void> Write(const Message& message);
  core::Result<void> Write(const Attachment& attachment);
  core::Result<void> Write(const Metadata& metadata);
  // Closes the chunk and hands everything to the kernel.
  core::Result<void> Flush();
  // Writes summary and footer; no further writes. kNow waits until all is on the disk (fsync).
  enum class ToDisk { kNow, kLater };
  core::Result<void> Close(ToDisk to_disk = ToDisk::kNow);

  [[nodiscard]] std::uint64_t num_messages() const;
  [[nodiscard]] std::uint64_t num_bytes() const;  // in the file so far

 private:
  struct Impl;
  explicit McapWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus::log
