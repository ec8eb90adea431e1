#include "nodes/device_bridge/tactile/tactiles.hpp"

#include <algorithm>
#include <cstdio>

#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "scene/diagnostic.hpp"
#include "tactile/libusb_transport.hpp"

namespace device_bridge {

std::vector<scene::Diagnostic> CheckTactiles(const scene::Scenario& scenario) {
  std::vector<scene::Diagnostic> diagnostics;
  for (const scene::Tactile& tactile : scenario.tactiles) {
    const auto table = tactile::ReadUsbTable(tactile.device_file);
    if (!table) diagnostics.insert(diagnostics.end(), table.error().begin(), table.error().end());
  }
  return diagnostics;
}

core::Result<std::unique_ptr<Tactiles>> Tactiles::Create(const scene::Scenario& scenario) {
  std::unique_ptr<Tactiles> tactiles(new Tactiles(scenario));
  for (const scene::Tactile& tactile : scenario.tactiles) {
    if (const auto added = tactiles->Add(tactile); !added) return tl::unexpected(added.error());
  }
  return tactiles;
}

core::Result<void> Tactiles::Add(const scene::Tactile& tactile) {
  auto table = tactile::ReadUsbTable(tactile.device_file);
  if (!table) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(table.error().front()));
  auto worn = std::make_unique<Worn>(scenario_, tactile, *table);
  worn->state.tactile_index = static_cast<std::uint8_t>(worn_.size());
  worn->state.is_simulated = tactile.type == "simulated";
  worn->state.channels.resize(table->num_channels);
  std::unique_ptr<tactile::UsbTransport> transport;
  if (worn->state.is_simulated) {
    worn->simulated = std::make_unique<tactile::SimulatedUsb>(core::MonotonicNow_ns);
    transport = worn->simulated->Connect();
  } else {
    transport = tactile::MakeLibusbTransport();
  }
  worn->thread = std::make_unique<TactileThread>(tactile.name, std::move(*table), std::move(transport));
  worn_.push_back(std::move(worn));
  return {};
}

void Tactiles::Declare(bus::Node* node) {
  node_ = node;
  for (const auto& worn : worn_) {
    for (const std::size_t pair : worn->touch.pairs()) {
      const std::string topic = bus::ContactsTopic(scenario_.PairSource(pair), scenario_.PairName(pair));
      worn->readers.push_back(&node->ReadLatest<core::ContactSet>(topic));
    }
    worn->seen.resize(worn->readers.size());
    worn->writer = node->WriteLatest<core::TactileState>(bus::TactileStateTopic(worn->tactile->name));
  }
}

void Tactiles::Step(const Inputs& inputs) noexcept {
  if (worn_.empty() || ++ticks_ % kTicksPerTouch != 0) return;
  poses_.Update(inputs);
  for (const auto& worn : worn_) {
    Feel(inputs.now_ns, worn.get());
    if (ticks_ % kTicksPerState == 0) Publish(inputs.now_ns, worn.get());
    if (worn->thread->state().status != worn->reported) TellNews(inputs.now_ns, worn.get());
  }
}

void Tactiles::Feel(std::int64_t now_ns, Worn* worn) noexcept {
  for (std::size_t i = 0; i < worn->readers.size(); ++i) {
    const auto& reader = *worn->readers[i];
    worn->seen[i] = {reader.has_value() ? &reader.value() : nullptr, reader.received_ns()};
  }
  worn->touch.Step(now_ns, worn->seen, poses_);
  tactile::Strengths strengths;
  strengths.made_ns = now_ns;
  tactile::ShareRound(worn->touch.towards_B(), worn->touch.strength(),
                      std::span(strengths.levels).first(worn->table.num_channels));
  worn->thread->Set(strengths);
  worn->touching += worn->touch.strength() > 0.0 ? 1 : 0;
  worn->greatest = std::max(worn->greatest, worn->touch.strength());
}

void Tactiles::Publish(std::int64_t now_ns, Worn* worn) noexcept {
  const tactile::DriverState& device = worn->thread->state();
  core::TactileState& state = worn->state;
  state.sample_ns = now_ns;
  state.status = static_cast<std::uint8_t>(device.status);
  state.depth_m = worn->touch.touch().depth_m;
  state.force_N = worn->touch.touch().force_N;
  state.towards_B = worn->touch.towards_B();
  state.frames = device.frames;
  state.errors = device.errors;
  for (std::size_t i = 0; i < state.channels.size(); ++i) state.channels[i].level = device.levels[i];
  worn->writer.Send(state);
}

// Prints and allocates only when a device comes or goes.
void Tactiles::TellNews(std::int64_t now_ns, Worn* worn) {
  worn->reported = worn->thread->state().status;
  const bool is_found = worn->reported == tactile::DriverStatus::kAlive;
  const std::string detail = worn->tactile->name + ": " + worn->table.name + " is " + NameOf(worn->reported);
  node_->Emit({now_ns, "device_bridge", is_found ? "device_found" : "device_lost", detail});
  std::printf("%s\n", detail.c_str());
  std::fflush(stdout);
}

nlohmann::json Tactiles::Report() const {
  nlohmann::json report = nlohmann::json::array();
  for (const auto& worn : worn_) {
    const tactile::DriverState& device = worn->thread->state();
    report.push_back({{"name", worn->tactile->name},
                      {"device", worn->table.name},
                      {"is_simulated", worn->state.is_simulated},
                      {"status", NameOf(device.status)},
                      {"frames", device.frames},
                      {"errors", device.errors},
                      {"touching_s", 1e-3 * static_cast<double>(worn->touching * kTicksPerTouch)},
                      {"greatest_level", worn->greatest}});
  }
  return report;
}

}  // namespace device_bridge
