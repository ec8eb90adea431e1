#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "bus/log/mcap_writer.hpp"

namespace bus::log {

// Copies messages of several files into one. Identical channels become one, and so do identical schemas.
class ChannelCopier {
 public:
  explicit ChannelCopier(McapWriter* to) : to_(to) {}

  // `from`: number of the source file. `schema` null: the channel has none.
  core::Result<void> Copy(std::size_t from, const Channel& channel, const Schema* schema, Message message) {
    const auto [known, is_new] = by_file_.try_emplace({from, channel.id}, std::uint16_t{0});
    if (is_new) known->second = ChannelLike(channel, schema);
    message.channel_id = known->second;
    return to_->Write(message);
  }

 private:
  std::uint16_t ChannelLike(const Channel& channel, const Schema* schema) {
    std::uint16_t schema_id = 0;
    if (schema != nullptr) {
      const auto [place, is_new] =
          schemas_.try_emplace({schema->name, schema->encoding, schema->data}, std::uint16_t{0});
      if (is_new) place->second = to_->AddSchema(schema->name, schema->encoding, schema->data);
      schema_id = place->second;
    }
    const auto [place, is_new] =
        channels_.try_emplace({schema_id, channel.topic, channel.message_encoding, channel.metadata}, std::uint16_t{0});
    if (is_new) place->second = to_->AddChannel(schema_id, channel.topic, channel.message_encoding, channel.metadata);
    return place->second;
  }

  McapWriter* to_;
  std::map<std::tuple<std::string, std::string, Bytes>, std::uint16_t> schemas_;
  std::map<std::tuple<std::uint16_t, std::string, std::string, TextMap>, std::uint16_t> channels_;
  std::map<std::pair<std::size_t, std::uint16_t>, std::uint16_t> by_file_;
};

}  // namespace bus::log
