#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "bus/node.hpp"
#include "core/result.hpp"
#include "nodes/device_bridge/tactile/worn_device.hpp"

namespace device_bridge {

// What is wrong with the files that the scenario's tactile devices name.
std::vector<scene::Diagnostic> CheckTactiles(const scene::Scenario& scenario);

// The tactile devices of a scenario on the bus: contacts come in, what is felt goes to each device, its state goes out.
// `scenario` must outlive it.
class Tactiles {
 public:
  // Opens no device: their threads look for them. Error: a device's file is wrong.
  static core::Result<std::unique_ptr<Tactiles>> Create(const scene::Scenario& scenario);

  // Declares what is read and written; before bus::Node::Start.
  void Declare(bus::Node* node);
  // Once a tick, after what is urgent. Real-time, but for the report of a device that comes or goes.
  void Step(const Inputs& inputs) noexcept;
  [[nodiscard]] nlohmann::json Report() const;

  static constexpr std::uint64_t kTicksPerTouch = 4;   // 250/s, as the turns of motors
  static constexpr std::uint64_t kTicksPerState = 16;  // for people to watch

 private:
  struct Worn {
    const scene::Tactile* tactile;
    BodyTouch touch;
    std::unique_ptr<WornDevice> device;
    std::vector<const bus::LatestReader<core::ContactSet>*> readers;  // of touch.pairs()
    std::vector<SeenContacts> seen;
    bus::LatestWriter<core::TactileState> writer;
    core::TactileState state;    // as published
    std::uint64_t touching = 0;  // steps with a contact
    double greatest = 0.0;       // strength
    const char* told = "waiting";
    Worn(const scene::Scenario& scenario, const scene::Tactile& t, std::unique_ptr<WornDevice> d)
        : tactile(&t), touch(scenario, t), device(std::move(d)) {}
  };

  explicit Tactiles(const scene::Scenario& scenario) : scenario_(scenario), poses_(scenario) {}
  core::Result<void> Add(const scene::Tactile& tactile);
  [[nodiscard]] bool IsEngaged(const Inputs& inputs, const scene::Tactile& tactile) const noexcept;
  void Feel(const Inputs& inputs, Worn* worn) noexcept;
  void Publish(std::int64_t now_ns, Worn* worn) noexcept;
  void TellNews(std::int64_t now_ns, Worn* worn);

  const scene::Scenario& scenario_;
  BodyPoses poses_;
  std::vector<std::unique_ptr<Worn>> worn_;
  bus::Node* node_ = nullptr;
  std::uint64_t ticks_ = 0;
};

}  // namespace device_bridge
