#include "tactile/usb_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/messages/device.hpp"
#include "scene/element_reader.hpp"

namespace tactile {
namespace {

using scene::ValueKind;

const std::vector<scene::ElementRule>& TableRules() {
  static const std::vector<scene::ElementRule> rules = {
      {"usb_tactile",
       "a tactile USB device",
       {{"name", ValueKind::kText, true, {}},
        {"vendor", ValueKind::kText, true, {}},
        {"product", ValueKind::kText, true, {}},
        {"interface", ValueKind::kText, false, {}},
        {"endpoint", ValueKind::kText, true, {}},
        {"period_ms", ValueKind::kPositive, false, {}}},
       {{"setup", 0, 0}, {"frame", 1, 1}}},
      {"setup",
       "a vendor request without data, once the device is open",
       {{"request", ValueKind::kText, true, {}},
        {"value", ValueKind::kText, false, {}},
        {"index", ValueKind::kText, false, {}}},
       {}},
      {"frame", "the bytes of a frame, in their order", {}, {{"constant", 0, 0}, {"level", 1, 0}, {"xor", 0, 0}}},
      {"constant", "a byte that is always the same", {{"value", ValueKind::kText, true, {}}}, {}},
      {"level",
       "how strong a channel is: 0 to `most`",
       {{"channel", ValueKind::kCount, true, {}},
        {"bytes", ValueKind::kChoice, false, {"1", "2"}},
        {"most", ValueKind::kText, false, {}}},
       {}},
      {"xor", "all bytes before it, combined by exclusive or", {}, {}},
  };
  return rules;
}

class TableReader {
 public:
  TableReader(const std::filesystem::path& file, std::vector<scene::Diagnostic>* diagnostics)
      : file_(file), diagnostics_(*diagnostics) {}

  UsbTable Read(const scene::XmlElement& root) {
    UsbTable table;
    table.name = root.Get("name");
    table.vendor = Number(root, "vendor", 0xffff, 0);
    table.product = Number(root, "product", 0xffff, 0);
    table.interface = static_cast<std::uint8_t>(Number(root, "interface", 0xff, 0));
    table.endpoint = static_cast<std::uint8_t>(Number(root, "endpoint", 0xff, 0));
    if ((table.endpoint & 0x80) != 0) {
      Report(root.LineOf("endpoint"), "endpoint " + root.Get("endpoint") + " leads to the host",
             "frames go to the device", "write the number of its OUT endpoint, below 0x80");
    }
    double period_ms = static_cast<double>(table.period_ns) * 1e-6;
    scene::ElementReader(root).Number("period_ms", &period_ms);
    table.period_ns = static_cast<std::int64_t>(period_ms * 1e6);
    for (const scene::XmlElement& child : root.children) {
      if (child.name == "setup") table.setup.push_back(ReadSetup(child));
      if (child.name == "frame") ReadFrame(child, &table);
    }
    CheckFrame(root, table);
    return table;
  }

 private:
  void Report(int line, std::string what, std::string why, std::string fix) {
    diagnostics_.push_back({{file_, line}, std::move(what), std::move(why), std::move(fix)});
  }

  // Decimal, or hexadecimal after 0x.
  std::uint16_t Number(const scene::XmlElement& element, const char* name, unsigned most, unsigned otherwise) {
    const scene::XmlAttribute* attribute = element.Find(name);
    if (attribute == nullptr) return static_cast<std::uint16_t>(otherwise);
    std::string_view text = attribute->value;
    const bool is_hex = text.starts_with("0x");
    if (is_hex) text.remove_prefix(2);
    unsigned value = 0;
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value, is_hex ? 16 : 10);
    if (end.ec == std::errc() && end.ptr == text.data() + text.size() && !text.empty() && value <= most) {
      return static_cast<std::uint16_t>(value);
    }
    Report(attribute->line, std::string(name) + " is '" + attribute->value + "'",
           "it is a number from 0 to " + std::to_string(most), "write it as 26 or as 0x1a");
    return static_cast<std::uint16_t>(otherwise);
  }

  ControlRequest ReadSetup(const scene::XmlElement& element) {
    return {static_cast<std::uint8_t>(Number(element, "request", 0xff, 0)), Number(element, "value", 0xffff, 0),
            Number(element, "index", 0xffff, 0)};
  }

  void ReadFrame(const scene::XmlElement& element, UsbTable* table) {
    for (const scene::XmlElement& child : element.children) {
      FrameField field;
      if (child.name == "constant") field.value = Number(child, "value", 0xff, 0);
      if (child.name == "xor") field.kind = FrameField::Kind::kXor;
      if (child.name == "level") {
        field.kind = FrameField::Kind::kLevel;
        field.channel = scene::ElementReader(child).Count("channel", 0);
        field.num_bytes = child.Get("bytes", "1") == "2" ? 2 : 1;
        const unsigned most = field.num_bytes == 2 ? 0xffff : 0xff;
        field.value = Number(child, "most", most, most);
        table->num_channels = std::max(table->num_channels, field.channel + 1);
      }
      table->frame.push_back(field);
    }
  }

  void CheckFrame(const scene::XmlElement& root, const UsbTable& table) {
    if (table.num_channels > core::kMaxTactileChannels) {
      Report(root.line, "channel " + std::to_string(table.num_channels - 1) + " is too high",
             "a device has " + std::to_string(core::kMaxTactileChannels) + " channels at most, counted from 0",
             "number them anew");
      return;
    }
    if (table.num_bytes() > kMaxFrameBytes) {
      Report(root.line, "a frame of " + std::to_string(table.num_bytes()) + " bytes",
             "an endpoint takes " + std::to_string(kMaxFrameBytes) + " at once", "send fewer");
    }
    for (std::size_t channel = 0; channel < table.num_channels; ++channel) {
      const auto count = std::count_if(table.frame.begin(), table.frame.end(), [&](const FrameField& field) {
        return field.kind == FrameField::Kind::kLevel && field.channel == channel;
      });
      if (count == 1) continue;
      Report(root.line, "channel " + std::to_string(channel) + " has " + std::to_string(count) + " levels in the frame",
             "each channel has one, counted from 0", "correct the channels' numbers");
    }
  }

  const std::filesystem::path& file_;
  std::vector<scene::Diagnostic>& diagnostics_;
};

}  // namespace

std::size_t UsbTable::num_bytes() const {
  std::size_t sum = 0;
  for (const FrameField& field : frame) sum += field.num_bytes;
  return sum;
}

tl::expected<UsbTable, std::vector<scene::Diagnostic>> ReadUsbTable(const std::filesystem::path& file) {
  const auto root = scene::ReadXml(file);
  if (!root) return tl::unexpected(root.error());
  std::vector<scene::Diagnostic> diagnostics;
  scene::CheckAgainstRules(*root, file, &diagnostics, "usb_tactile", TableRules());
  UsbTable table;
  if (diagnostics.empty()) table = TableReader(file, &diagnostics).Read(*root);
  if (!diagnostics.empty()) return tl::unexpected(std::move(diagnostics));
  return table;
}

void EncodeFrame(const UsbTable& table, std::span<const float> levels, std::vector<std::uint8_t>* bytes) {
  bytes->clear();
  for (const FrameField& field : table.frame) {
    unsigned value = field.value;
    if (field.kind == FrameField::Kind::kXor) {
      value = 0;
      for (const std::uint8_t byte : *bytes) value ^= byte;
    }
    if (field.kind == FrameField::Kind::kLevel) {
      const float level = field.channel < levels.size() ? levels[field.channel] : 0.0f;
      const bool is_level = level >= 0.0f && level <= 1.0f;  // false for one that is not finite, too
      value = is_level ? static_cast<unsigned>(std::lround(level * static_cast<float>(field.value))) : 0;
    }
    for (std::size_t i = 0; i < field.num_bytes; ++i) bytes->push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
}

bool DecodeFrame(const UsbTable& table, std::span<const std::uint8_t> bytes, std::vector<float>* levels) {
  if (bytes.size() != table.num_bytes()) return false;
  levels->assign(table.num_channels, 0.0f);
  std::size_t at = 0;
  unsigned all = 0;
  for (const FrameField& field : table.frame) {
    unsigned value = 0;
    for (std::size_t i = 0; i < field.num_bytes; ++i) value |= static_cast<unsigned>(bytes[at + i]) << (8 * i);
    if (field.kind == FrameField::Kind::kConstant && value != field.value) return false;
    if (field.kind == FrameField::Kind::kXor && value != all) return false;
    if (field.kind == FrameField::Kind::kLevel) {
      if (value > field.value) return false;
      (*levels)[field.channel] = field.value == 0 ? 0.0f : static_cast<float>(value) / static_cast<float>(field.value);
    }
    for (std::size_t i = 0; i < field.num_bytes; ++i) all ^= bytes[at++];
  }
  return true;
}

}  // namespace tactile
