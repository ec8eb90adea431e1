#include "nodes/device_bridge/devices/threaded_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "bus/rt/periodic_loop.hpp"
#include "core/clock.hpp"
#include "device/testing/fake_udp_device.hpp"
#include "nodes/device_bridge/devices/conformance.hpp"
#include "nodes/device_bridge/devices/make_device.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"
#include "nodes/device_bridge/safety_filter.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kPatience_ns = 20'000'000'000;

scene::Device Faulty(const std::string& fault) {
  scene::Device device;
  device.role = "right";
  device.type = "plugin";
  device.address = VR_OOS_BINARY_DIR "/test_plugins/faulty_device.so";
  device.options = {{"fault", fault}};
  device.X_WD_start.translation = {1, 2, 3};
  return device;
}

// A device behind a filter that always wants 2 N along x and 0.1 Nm about it, ticked once a millisecond, as the bridge
// does.
struct Rig {
  std::unique_ptr<Device> device;
  SafetyFilter filter;
  DeviceReading reading;
  FilteredForce written;
  std::uint64_t num_commands = 0;
  bus::PeriodicLoop loop{core::kTick_ns};

  explicit Rig(const scene::Device& what, const ThreadedOptions& options = {})
      : filter(*SafetyFilter::Create([] {
          FilterLimits limits;
          limits.start_ramp_ns = 0;
          return limits;
        }())) {
    auto made = MakeDevice(what, options);
    if (!made) {
      ADD_FAILURE() << made.error().detail;
      return;
    }
    device = std::move(*made);
  }
  void Tick() {
    loop.WaitNext();
    const std::int64_t now_ns = core::MonotonicNow_ns();
    reading = device->Read(now_ns);
    core::DeviceCommand command;
    command.header.sequence = ++num_commands;
    command.F_Do_W = {{2, 0, 0}, {0.1, 0, 0}};
    filter.Accept(command, now_ns);
    written = filter.Apply(now_ns, reading);
    device->Write(now_ns, written);
  }
  bool Until(const std::function<bool()>& condition) {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    while (core::MonotonicNow_ns() - begin_ns < kPatience_ns) {
      Tick();
      if (condition()) return true;
    }
    return false;
  }
  bool UntilStatus(DeviceStatus status) {
    return Until([&] { return device->Health(core::MonotonicNow_ns()).status == status; });
  }
  [[nodiscard]] std::string why() const { return device->Health(core::MonotonicNow_ns()).why.data(); }
};

TEST(ThreadedDevice, GivesStatesAndAppliesFilteredForces) {
  Rig rig(Faulty(""));
  ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kAlive));
  EXPECT_STREQ(rig.device->description().name, "faulty");
  ASSERT_TRUE(rig.Until([&] { return rig.device->state().applied[0] == 2.0; }));
  EXPECT_TRUE(rig.reading.is_engaged);
  // Not calibrated: it goes on from where the scenario has the hand.
  EXPECT_EQ(rig.reading.X_WD.translation.y, 2.0);
  EXPECT_EQ(rig.reading.X_WD.translation.z, 3.0);
  ASSERT_TRUE(rig.Until([&] { return std::abs(rig.reading.V_WD.linear_m_per_s.x - 0.1) < 0.02; }))
      << "differentiated from the poses: " << rig.reading.V_WD.linear_m_per_s.x;
  ASSERT_TRUE(rig.Until([&] { return rig.device->Health(core::MonotonicNow_ns()).link.rate_hz > 0.0; }));
}

// It has motors for translation alone, and might do anything with a torque.
TEST(ThreadedDevice, AnAxisWithoutAMotorGetsNoForce) {
  Rig rig(Faulty(""));
  ASSERT_TRUE(rig.Until([&] { return rig.device->state().applied[0] == 2.0; }));
  EXPECT_EQ(rig.written.F_Do_W().torque_Nm.x, 0.1);
  EXPECT_EQ(rig.device->state().applied[3], 0.0);
}

// The joint stands 0.4 m above the base, and the base where the hand was taken up: (1, 2, 3) less the way since.
TEST(ThreadedDevice, GivesTheJointsOfARobotAndWhereItsBaseStands) {
  Rig rig(Faulty(""));
  EXPECT_TRUE(rig.device->is_robot());
  oos_device_joints joints{};
  ASSERT_TRUE(rig.Until([&] { return rig.device->Joints(&joints); }));
  ASSERT_EQ(joints.num_joints, 1U);
  EXPECT_EQ(joints.joints[0].position_rad, 0.5);
  ASSERT_TRUE(rig.Until([&] { return rig.reading.is_engaged; }));
  const core::Pose X_WL = rig.device->X_WB() * PoseOf(joints.joints[0].X_BL);
  EXPECT_NEAR(X_WL.translation.z, 3.4, 1e-12);
  EXPECT_NEAR(
      glm::distance(rig.device->X_WB() * PoseOf(rig.device->state().X_BD).translation, rig.reading.X_WD.translation),
      0.0, 1e-12);
}

// The bridge stands still, as if its process had been stopped: the thread takes the force away.
TEST(ThreadedDevice, TakesTheForceAwayWhenNobodyWrites) {
  Rig rig(Faulty(""));
  ASSERT_TRUE(rig.Until([&] { return rig.device->state().applied[0] == 2.0; }));
  const auto is_gone = [&] {
    rig.device->Read(core::MonotonicNow_ns());
    return rig.device->state().applied[0] == 0.0;
  };
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  while (!is_gone() && core::MonotonicNow_ns() - begin_ns < kPatience_ns) rig.loop.WaitNext();
  EXPECT_TRUE(is_gone());
}

struct FaultCase {
  const char* fault;
  DeviceStatus status;
  const char* why;  // a part of it
};
class ThreadedDeviceFault : public ::testing::TestWithParam<FaultCase> {};

TEST_P(ThreadedDeviceFault, IsNamedAndTheDeviceIsOffWhileTheBridgeGoesOn) {
  const FaultCase& fault = GetParam();
  Rig rig(Faulty(fault.fault));
  ASSERT_TRUE(rig.UntilStatus(fault.status)) << fault.fault;
  EXPECT_NE(rig.why().find(fault.why), std::string::npos) << rig.why();
  ASSERT_TRUE(rig.Until([&] { return glm::length(rig.written.F_Do_W().force_N) == 0.0; }));
  EXPECT_FALSE(rig.reading.is_engaged);
  EXPECT_TRUE(std::isfinite(rig.reading.X_WD.translation.y));
  EXPECT_EQ(rig.reading.V_WD.linear_m_per_s, glm::dvec3(0.0));
}

INSTANTIATE_TEST_SUITE_P(Each, ThreadedDeviceFault,
                         ::testing::Values(FaultCase{"hang", DeviceStatus::kHung, ""},
                                           FaultCase{"hang in open", DeviceStatus::kHung, ""},
                                           FaultCase{"throw", DeviceStatus::kBroken, "step() threw: the bus fell off"},
                                           FaultCase{"throw an int", DeviceStatus::kBroken, "unknown type"},
                                           FaultCase{"throw in open", DeviceStatus::kBroken, "open() threw"},
                                           FaultCase{"nan", DeviceStatus::kBroken, "not finite"},
                                           FaultCase{"throw in joints", DeviceStatus::kBroken, "joints() threw"},
                                           FaultCase{"nan in joints", DeviceStatus::kBroken, "not finite"},
                                           FaultCase{"no unit", DeviceStatus::kBroken, "not a unit"}),
                         [](const auto& fault) {
                           std::string name = fault.param.fault;
                           for (char& c : name) c = c == ' ' ? '_' : c;
                           return name;
                         });

// Of a device that is not calibrated, so B has the axes of W. It is told of no goal when the bridge
// falls silent.
TEST(ThreadedDevice, LeadsToAGoalAndLetsGoWhenTheBridgeFallsSilent) {
  Rig rig(Faulty("leads well"));
  ASSERT_TRUE(rig.Until([&] { return rig.reading.is_engaged; }));
  ASSERT_TRUE(rig.device->can_lead());
  LeadGoal goal{{rig.reading.X_WD.rotation, rig.reading.X_WD.translation + glm::dvec3(0.05, 0, 0)}, 3.0, 1.0};
  EXPECT_TRUE(rig.Until([&] {
    rig.device->Lead(&goal);
    return glm::distance(rig.reading.X_WD.translation, goal.X_WG.translation) < 1e-3;
  }));
  EXPECT_EQ(rig.device->state().applied[0], 2.5) << "command and guidance";
  EXPECT_EQ(rig.device->Felt().F_Do_W.force_N.x, 2.5);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  while (rig.device->state().applied[0] != 0.0 && core::MonotonicNow_ns() - begin_ns < kPatience_ns) {
    rig.loop.WaitNext();
    rig.device->Read(core::MonotonicNow_ns());
  }
  EXPECT_EQ(rig.device->state().applied[0], 0.0);
}

TEST(ThreadedDevice, IsToldNoGoalThatIsNowhere) {
  Rig rig(Faulty("leads well"));
  ASSERT_TRUE(rig.Until([&] { return rig.reading.is_engaged; }));
  LeadGoal goal{rig.reading.X_WD, 3.0, 1.0};
  ASSERT_TRUE(rig.Until([&] {
    rig.device->Lead(&goal);
    return rig.device->state().applied[0] == 2.5;
  }));
  goal.X_WG.translation.x = std::nan("");
  EXPECT_TRUE(rig.Until([&] {
    rig.device->Lead(&goal);
    return rig.device->state().applied[0] == 2.0;
  }));
  EXPECT_TRUE(std::isfinite(rig.reading.X_WD.translation.x));
}

TEST(ThreadedDevice, ThatThrowsWhenItIsToLeadIsOff) {
  Rig rig(Faulty("throw in lead"));
  ASSERT_TRUE(rig.Until([&] { return rig.reading.is_engaged; }));
  LeadGoal goal{rig.reading.X_WD, 3.0, 1.0};
  EXPECT_TRUE(rig.Until([&] {
    rig.device->Lead(&goal);
    return rig.device->Health(core::MonotonicNow_ns()).status == DeviceStatus::kBroken;
  }));
  EXPECT_NE(rig.why().find("lead() threw: no way"), std::string::npos) << rig.why();
}

TEST(ThreadedDevice, ComesBackAfterAHang) {
  Rig rig(Faulty("hang for a while"));
  ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kHung));
  ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kAlive));
  EXPECT_TRUE(rig.Until([&] { return rig.written.F_Do_W().force_N.x == 2.0; }));
}

// Unplugged after 0.2 s, replugged as another specimen, and again: the hand goes on from where it was. How soon, on a
// virtual clock: Replug.
TEST(ThreadedDevice, IsBackAfterItWasReplugged) {
  std::vector<std::string> asked;
  ThreadedOptions options;
  options.find_calibration = [&](const std::string& name, const std::string& serial) {
    asked.push_back(name + serial);
    return std::nullopt;
  };
  Rig rig(Faulty("unplugged"), options);
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kAlive));
    ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kGone));
    rig.Tick();
    const double x_m = rig.reading.X_WD.translation.x;
    ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kAlive));
    EXPECT_NEAR(rig.reading.X_WD.translation.x, x_m, 0.002);
  }
  EXPECT_EQ(rig.device->num_found(), 3U);
  EXPECT_EQ(asked.size(), 3U) << "each specimen may have a calibration of its own";
}

TEST(ThreadedDevice, ACalibratedDeviceIsWhereItIs) {
  ThreadedOptions options;
  options.find_calibration = [](const std::string&, const std::string&) {
    // B's x axis is W's y axis.
    return DeviceCalibration{{core::QuaternionFromRollPitchYaw({0, 0, 1.5707963267948966}), {0, 0, 0.5}}, 0.001};
  };
  Rig rig(Faulty(""), options);
  ASSERT_TRUE(rig.Until([&] { return rig.reading.is_engaged && rig.reading.X_WD.translation.y > 0.005; }));
  EXPECT_NEAR(rig.reading.X_WD.translation.x, 0.0, 1e-12);
  EXPECT_NEAR(rig.reading.X_WD.translation.z, 0.5, 1e-12);
  // 2 N along W's x axis are -2 N along B's y axis.
  ASSERT_TRUE(rig.Until([&] { return std::abs(rig.device->state().applied[1] + 2.0) < 1e-12; }));
  EXPECT_TRUE(rig.device->Health(core::MonotonicNow_ns()).is_calibrated);
}

TEST(ThreadedDevice, AbsentAtFirstItIsFoundWhenItComes) {
  Rig rig(Faulty("absent at first"));
  ASSERT_TRUE(rig.UntilStatus(DeviceStatus::kAlive));
}

TEST(MakeDevice, RefusesWhatCannotBeADeviceWithTheRemedy) {
  const auto Why = [](const scene::Device& device, bool has_threads = true) {
    const auto made = MakeDevice(device, has_threads ? std::optional(ThreadedOptions{}) : std::nullopt);
    return made ? std::string() : made.error().detail;
  };
  EXPECT_NE(Why(Faulty("bad setting")).find("no such port; choose another"), std::string::npos);
  EXPECT_NE(Why(Faulty(""), false).find("lock-step"), std::string::npos);
  scene::Device old = Faulty("");
  old.address = VR_OOS_BINARY_DIR "/test_plugins/old_device.so";
  EXPECT_NE(Why(old).find("version 77"), std::string::npos) << Why(old);
  old.address = "/no/such.so";
  EXPECT_NE(Why(old).find("/no/such.so"), std::string::npos);
  old.type = "hologram";
  EXPECT_NE(Why(old).find("unknown type 'hologram'"), std::string::npos);
}

// In virtual time. Not calibrated: the trigger is a clutch.
TEST(MakeDevice, AFlystickOfDtrackMovesTheHandWhileItsTriggerIsHeld) {
  scene::Device stick;
  stick.role = "right";
  stick.type = "dtrack";
  stick.address = std::to_string(device::FreeUdpPort());
  stick.X_WD_start.translation = {1, 2, 3};
  ThreadedOptions threadless;
  threadless.has_thread = false;
  auto made = MakeDevice(stick, threadless);
  ASSERT_TRUE(made) << made.error().detail;
  const device::FakeUdpDevice controller(static_cast<std::uint16_t>(std::stoi(stick.address)));
  std::int64_t now_ns = 1'000'000'000;
  const auto Frame = [&](const std::string& x_mm, const std::string& keys) {
    controller.Send("6df2 1 1 [0 1.0 6 2][" + x_mm + " 0 0][1 0 0 0 1 0 0 0 1][" + keys + "]\r\n");
    now_ns += 16'000'000;
    return (*made)->Read(now_ns);
  };
  EXPECT_FALSE(Frame("100", "0 0 0").is_engaged);
  EXPECT_EQ((*made)->Health(now_ns).status, DeviceStatus::kAlive);
  EXPECT_TRUE(Frame("500", "1 0 0").is_engaged);
  DeviceReading moved = Frame("550", "1 0 -1");
  EXPECT_NEAR(glm::distance(moved.X_WD.translation, glm::dvec3(1.05, 2, 3)), 0.0, 1e-12);
  for (int i = 0; i < 100; ++i) moved = Frame("550", "1 0 -1");
  EXPECT_EQ(moved.opening_m, 0.0);
  EXPECT_NEAR(Frame("900", "0 0 0").X_WD.translation.x, 1.05, 1e-12) << "let go";
  EXPECT_FALSE((*made)->can_lead());
}

TEST(MakeDevice, TheCommandLineChoosesDevices) {
  scene::Scenario scenario;
  scenario.name = "s";
  scenario.devices.resize(2);
  scenario.devices[0].role = "right";
  scenario.devices[1].role = "left";
  ASSERT_TRUE(ChooseDevices({"left=udp:0.0.0.0:7461"}, &scenario));
  EXPECT_EQ(scenario.devices[1].type, "udp");
  EXPECT_EQ(scenario.devices[1].address, "0.0.0.0:7461");
  for (const char* bad :
       {"udp:7460", "middle=udp:7460", "left=upd:7460", "left=udp", "left=simulated_arm:1", "=udp:1"}) {
    EXPECT_FALSE(ChooseDevices({bad}, &scenario)) << bad;
  }
}

// In virtual time, without a wait: of a simulated arm, or a plug-in without its thread.
std::vector<ConformanceFinding> CheckOf(const scene::Device& what,
                                        const std::function<void(std::int64_t)>& at_each_tick = {}) {
  ThreadedOptions threadless;
  threadless.has_thread = false;
  auto made = MakeDevice(what, threadless);
  if (!made) return {};
  std::int64_t now_ns = 1'000'000'000;
  ConformanceOptions options;
  options.clock = [&] { return now_ns; };
  options.wait_until = [&](std::int64_t time_ns) {
    now_ns = time_ns;
    if (at_each_tick) at_each_tick(now_ns);
  };
  options.is_interrupted = [] { return false; };
  return CheckConformance(made->get(), options);
}

Verdict VerdictOn(const std::vector<ConformanceFinding>& findings, const std::string& subject) {
  for (const ConformanceFinding& finding : findings) {
    if (finding.subject == subject) return finding.verdict;
  }
  ADD_FAILURE() << subject << " is not checked";
  return Verdict::kFails;
}

TEST(Conformance, TheExampleOfTheHowToHolds) {
  scene::Device own = Faulty("");
  own.address = VR_OOS_BINARY_DIR "/test_plugins/own_device.so";
  const auto findings = CheckOf(own);
  for (const char* subject :
       {"found", "rate", "jitter", "loss", "metres", "nanoseconds", "velocity", "push", "clamp", "watchdog"}) {
    EXPECT_EQ(VerdictOn(findings, subject), Verdict::kHolds) << subject;
  }
}

TEST(Conformance, TheExampleThatLeadsHolds) {
  scene::Device leading = Faulty("");
  leading.address = VR_OOS_BINARY_DIR "/test_plugins/leading_device.so";
  const auto findings = CheckOf(leading);
  for (const char* subject : {"found", "metres", "nanoseconds", "push", "lead", "clamp", "watchdog"}) {
    EXPECT_EQ(VerdictOn(findings, subject), Verdict::kHolds) << subject;
  }
}

TEST(Conformance, ADeviceThatLeadsNowhereOrWithTooMuchForceOrForeverIsFound) {
  for (const char* fault : {"leads nowhere", "leads too hard", "leads forever"}) {
    const auto findings = CheckOf(Faulty(fault));
    EXPECT_EQ(VerdictOn(findings, "push"), Verdict::kHolds) << fault;
    EXPECT_EQ(VerdictOn(findings, "lead"), Verdict::kFails) << fault;
  }
}

// Sixty frames a second are few for a device with motors, not for one without.
TEST(Conformance, AFlystickHolds) {
  scene::Device stick;
  stick.role = "right";
  stick.type = "dtrack";
  stick.address = std::to_string(device::FreeUdpPort());
  const device::FakeUdpDevice controller(static_cast<std::uint16_t>(std::stoi(stick.address)));
  const auto findings = CheckOf(stick, [&](std::int64_t now_ns) {
    if (now_ns / 1'000'000 % 16 == 0) controller.Send("6df2 1 1 [0 1.0 6 2][0 0 0][1 0 0 0 1 0 0 0 1][1 0 0]");
  });
  for (const char* subject : {"found", "rate", "jitter", "loss", "metres", "nanoseconds"}) {
    EXPECT_EQ(VerdictOn(findings, subject), Verdict::kHolds) << subject;
  }
  EXPECT_EQ(VerdictOn(findings, "push"), Verdict::kSkipped);
}

TEST(Conformance, ADeviceWithoutWatchdogAndClockIsFound) {
  const auto findings = CheckOf(Faulty(""));
  EXPECT_EQ(VerdictOn(findings, "push"), Verdict::kHolds);
  EXPECT_EQ(VerdictOn(findings, "nanoseconds"), Verdict::kFails);
  EXPECT_EQ(VerdictOn(findings, "watchdog"), Verdict::kFails);
  EXPECT_EQ(VerdictOn(findings, "velocity"), Verdict::kSkipped);
}

TEST(Conformance, TheSimulatedArmHolds) {
  scene::Device arm;
  arm.role = "right";
  const auto findings = CheckOf(arm);
  for (const char* subject : {"found", "metres", "nanoseconds", "push", "clamp", "watchdog"}) {
    EXPECT_EQ(VerdictOn(findings, subject), Verdict::kHolds) << subject;
  }
}

}  // namespace
}  // namespace device_bridge
