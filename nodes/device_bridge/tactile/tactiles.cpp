#include "nodes/device_bridge/tactile/tactiles.hpp"

#include <algorithm>
#include <cstdio>
#include <string>

#include "bus/topics.hpp"

namespace device_bridge {

std::vector<scene::Diagnostic> CheckTactiles(const scene::Scenario& scenario) {
  std::vector<scene::Diagnostic> all;
  for (const scene::Tactile& tactile : scenario.tactiles) {
    const std::vector<scene::Diagnostic> its = CheckWornDevice(tactile);
    all.insert(all.end(), its.begin(), its.end());
  }
  return all;
}

core::Result<std::unique_ptr<Tactiles>> Tactiles::Create(const scene::Scenario& scenario) {
  std::unique_ptr<Tactiles> tactiles(new Tactiles(scenario));
  for (const scene::Tactile& tactile : scenario.tactiles) {
    if (const auto added = tactiles->Add(tactile); !added) return tl::unexpected(added.error());
  }
  return tactiles;
}

core::Result<void> Tactiles::Add(const scene::Tactile& tactile) {
  auto device = MakeWornDevice(tactile);
  if (!device) return tl::unexpected(device.error());
  auto worn = std::make_unique<Worn>(scenario_, tactile, std::move(*device));
  worn->state.tactile_index = static_cast<std::uint8_t>(worn_.size());
  worn->state.is_simulated = worn->device->is_simulated();
  worn->state.channels.resize(worn->device->num_channels());
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
    Feel(inputs, worn.get());
    if (ticks_ % kTicksPerState == 0) Publish(inputs.now_ns, worn.get());
    TellNews(inputs.now_ns, worn.get());
  }
}

// Who wears a device on what is no part of a hand has no dead-man, and takes it off.
bool Tactiles::IsEngaged(const Inputs& inputs, const scene::Tactile& tactile) const noexcept {
  const scene::Object& body = scenario_.objects[static_cast<std::size_t>(tactile.body)];
  if (body.owner != scene::Owner::kHand) return true;
  const auto role = static_cast<std::size_t>(body.role);
  return role < inputs.proxies.size() && inputs.proxies[role].is_engaged;
}

void Tactiles::Feel(const Inputs& inputs, Worn* worn) noexcept {
  for (std::size_t i = 0; i < worn->readers.size(); ++i) {
    const auto& reader = *worn->readers[i];
    worn->seen[i] = {reader.has_value() ? &reader.value() : nullptr, reader.received_ns()};
  }
  worn->touch.Step(inputs.now_ns, worn->seen, poses_);
  worn->device->Feel(inputs.now_ns, worn->touch, IsEngaged(inputs, *worn->tactile));
  worn->touching += worn->touch.strength() > 0.0 ? 1 : 0;
  worn->greatest = std::max(worn->greatest, worn->touch.strength());
}

void Tactiles::Publish(std::int64_t now_ns, Worn* worn) noexcept {
  core::TactileState& state = worn->state;
  state.sample_ns = now_ns;
  state.depth_m = worn->touch.touch().depth_m;
  state.force_N = worn->touch.touch().force_N;
  state.towards_B = worn->touch.towards_B();
  worn->device->Fill(&state);
  worn->writer.Send(state);
}

// Prints and allocates only when a device comes or goes.
void Tactiles::TellNews(std::int64_t now_ns, Worn* worn) {
  const WornDevice::Condition condition = worn->device->condition();
  if (std::string_view(condition.text) == worn->told) return;
  worn->told = condition.text;
  const std::string detail = worn->tactile->name + ": " + worn->device->name() + " is " + condition.text;
  node_->Emit({now_ns, "device_bridge", condition.is_good ? "device_found" : "device_lost", detail});
  std::printf("%s\n", detail.c_str());
  std::fflush(stdout);
}

nlohmann::json Tactiles::Report() const {
  nlohmann::json report = nlohmann::json::array();
  for (const auto& worn : worn_) {
    core::TactileState state = worn->state;
    worn->device->Fill(&state);
    report.push_back({{"name", worn->tactile->name},
                      {"device", worn->device->name()},
                      {"is_simulated", worn->device->is_simulated()},
                      {"status", worn->device->condition().text},
                      {"frames", state.frames},
                      {"errors", state.errors},
                      {"touching_s", 1e-3 * static_cast<double>(worn->touching * kTicksPerTouch)},
                      {"greatest_level", worn->greatest}});
  }
  return report;
}

}  // namespace device_bridge
