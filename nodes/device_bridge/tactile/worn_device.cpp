#include "nodes/device_bridge/tactile/worn_device.hpp"

#include <utility>

#include "core/clock.hpp"
#include "nodes/device_bridge/tactile/tactile_thread.hpp"
#include "scene/xml.hpp"
#include "tactile/electro/stimulator.hpp"
#include "tactile/libusb_transport.hpp"
#include "tactile/simulated_usb.hpp"
#include "tactile/usb_driver.hpp"

namespace device_bridge {
namespace {

class WornMotors final : public WornDevice {
 public:
  WornMotors(const scene::Tactile& tactile, const tactile::UsbTable& table) : table_(table) {
    std::unique_ptr<tactile::UsbTransport> transport;
    if (tactile.type == "simulated") {
      simulated_ = std::make_unique<tactile::SimulatedUsb>(core::MonotonicNow_ns);
      transport = simulated_->Connect();
    } else {
      transport = tactile::MakeLibusbTransport();
    }
    thread_.emplace(tactile.name, std::make_unique<tactile::UsbDriver>(table, std::move(transport)));
  }

  void Feel(std::int64_t now_ns, const BodyTouch& touch, bool /*is_engaged*/) noexcept override {
    tactile::Strengths strengths;
    strengths.made_ns = now_ns;
    tactile::ShareRound(touch.towards_B(), touch.strength(), std::span(strengths.levels).first(table_.num_channels));
    thread_->Set(strengths);
  }
  void Fill(core::TactileState* state) noexcept override {
    const tactile::DriverState& device = thread_->state();
    state->status = static_cast<std::uint8_t>(device.status);
    state->frames = device.frames;
    state->errors = device.errors;
    for (std::size_t i = 0; i < state->channels.size(); ++i) state->channels[i].level = device.levels[i];
  }
  Condition condition() noexcept override {
    const tactile::DriverStatus status = thread_->state().status;
    return {NameOf(status), status == tactile::DriverStatus::kAlive};
  }
  [[nodiscard]] const std::string& name() const override { return table_.name; }
  [[nodiscard]] bool is_simulated() const override { return simulated_ != nullptr; }
  [[nodiscard]] std::size_t num_channels() const override { return table_.num_channels; }

 private:
  tactile::UsbTable table_;
  std::unique_ptr<tactile::SimulatedUsb> simulated_;  // outlives the thread
  std::optional<TactileThread<tactile::UsbDriver>> thread_;
};

class WornElectrodes final : public WornDevice {
 public:
  WornElectrodes(const scene::Tactile& tactile, const tactile::StimulatorTable& table, const tactile::Limiter& limiter)
      : name_(table.name), thread_(tactile.name, std::make_unique<tactile::Stimulator>(table, &skin_, limiter)) {}

  void Feel(std::int64_t now_ns, const BodyTouch& touch, bool is_engaged) noexcept override {
    thread_.Set({touch.finger(), touch.strength(), is_engaged, now_ns});
  }
  void Fill(core::TactileState* state) noexcept override {
    const tactile::Stimulator::State& device = thread_.state();
    state->status = static_cast<std::uint8_t>(tactile::DriverStatus::kAlive);
    state->frames = device.pulses;
    state->errors = device.refused;
    state->pattern = static_cast<std::uint8_t>(device.kind);
    state->stopped_by = static_cast<std::uint8_t>(device.stopped_by);
    for (std::size_t i = 0; i < state->channels.size(); ++i) state->channels[i].level = device.levels[i];
  }
  Condition condition() noexcept override {
    const tactile::StopCause cause = thread_.state().stopped_by;
    const bool is_good = cause == tactile::StopCause::kNothing || cause == tactile::StopCause::kSilence;
    return is_good ? Condition{"alive", true} : Condition{NameOf(cause), false};
  }
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] bool is_simulated() const override { return true; }
  [[nodiscard]] std::size_t num_channels() const override { return tactile::kNumElectrodes; }

 private:
  std::string name_;
  tactile::SimulatedSkin skin_;  // outlives the thread
  TactileThread<tactile::Stimulator> thread_;
};

bool IsStimulator(const scene::Tactile& tactile) {
  const auto root = scene::ReadXml(tactile.device_file);
  return root && root->name == "stimulator";
}

}  // namespace

std::vector<scene::Diagnostic> CheckWornDevice(const scene::Tactile& tactile) {
  if (!IsStimulator(tactile)) {
    const auto table = tactile::ReadUsbTable(tactile.device_file);
    return table ? std::vector<scene::Diagnostic>{} : table.error();
  }
  if (tactile.type != "simulated") {
    return {{tactile.location, "tactile '" + tactile.name + "': a stimulator of type " + tactile.type,
             "no driver of real electrodes is here: it would need one that a laboratory has proved safe",
             "write type=\"simulated\""}};
  }
  const auto table = tactile::ReadStimulatorTable(tactile.device_file);
  return table ? std::vector<scene::Diagnostic>{} : table.error();
}

core::Result<std::unique_ptr<WornDevice>> MakeWornDevice(const scene::Tactile& tactile) {
  const std::vector<scene::Diagnostic> diagnostics = CheckWornDevice(tactile);
  if (!diagnostics.empty()) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(diagnostics.front()));
  if (!IsStimulator(tactile)) return std::make_unique<WornMotors>(tactile, *tactile::ReadUsbTable(tactile.device_file));
  const auto limiter = tactile::Limiter::Create({});
  if (!limiter) return tl::unexpected(limiter.error());
  return std::make_unique<WornElectrodes>(tactile, *tactile::ReadStimulatorTable(tactile.device_file), *limiter);
}

}  // namespace device_bridge
