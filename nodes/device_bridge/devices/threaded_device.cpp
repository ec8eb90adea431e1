#include "nodes/device_bridge/devices/threaded_device.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <string_view>
#include <thread>

#include "bus/rt/latest_value.hpp"
#include "core/clock.hpp"
#include "nodes/device_bridge/devices/link_meter.hpp"
#include "nodes/device_bridge/devices/plugin_values.hpp"

namespace device_bridge {
namespace {

// Without news for this long a device is not alive, a force not valid, a call hung: as the filter's own time of
// silence.
constexpr std::int64_t kDeviceSilence_ns = 60'000'000;
// A device that is not there is opened again this often, so that a replugged one is back within a second.
constexpr std::int64_t kRetry_ns = 250'000'000;
// Until the velocity of a device that gives poses only has followed to 63 %: five samples.
constexpr double kVelocityLag_s = 5e-3;
// After a shorter silence the same device goes on where it is.
constexpr std::int64_t kHiccup_ns = 1'000'000'000;
// For the first try to open, and for the thread to end.
constexpr std::int64_t kThreadPatience_ns = 1'000'000'000;

struct Sample {
  oos_device_state state{};
  std::int64_t arrival_ns = 0;
};
struct Order {
  oos_device_command command{};
  std::int64_t written_ns = 0;
};
// Where to lead the hand, if anywhere.
struct LeadOrder {
  oos_device_goal goal{};
  bool leads = false;
  std::int64_t written_ns = 0;
};
// Of a robot, for people to watch: 62 times a second.
constexpr std::uint64_t kTicksPerJointsCall = 16;

// What changes seldom, in one piece.
struct Report {
  DeviceStatus status = DeviceStatus::kWaiting;
  LinkFigures link;
  std::array<char, 200> why{};
  oos_device_description description{};
  std::uint64_t num_found = 0;
  std::uint64_t num_misses = 0;
  bool is_calibrated = false;
  DeviceCalibration calibration;
};

// Velocities of a device that does not give them: differences of its poses, smoothed.
//   V += (1 - exp(-dt / lag)) (difference - V)
class Differentiator {
 public:
  void Forget() { has_pose_ = false; }
  void Fill(std::int64_t now_ns, oos_device_state* state) {
    const core::Pose X = PoseOf(state->X_BD);
    const double dt_s = static_cast<double>(now_ns - last_ns_) * 1e-9;
    if (!has_pose_ || dt_s <= 0.0 || dt_s > 0.1) {
      V_ = {};
    } else {
      const double share = 1.0 - std::exp(-dt_s / kVelocityLag_s);
      const glm::dvec3 turn = core::RotationVector(X.rotation * glm::conjugate(X_.rotation));
      V_.linear_m_per_s += share * ((X.translation - X_.translation) / dt_s - V_.linear_m_per_s);
      V_.angular_rad_per_s += share * (turn / dt_s - V_.angular_rad_per_s);
    }
    has_pose_ = true;
    last_ns_ = now_ns;
    X_ = X;
    ToArray(V_, state->V_BD);
  }

 private:
  bool has_pose_ = false;
  std::int64_t last_ns_ = 0;
  core::Pose X_;
  core::Twist V_;
};

}  // namespace

// Shared by the device and its thread, so that it outlives whichever ends last.
class ThreadedDevice::Thread {
 public:
  Thread(PluginTable plugin, const scene::Device& device, const ThreadedOptions& options)
      : plugin_(std::move(plugin)),
        setting_(device),
        role_(device.role),
        options_(options),
        wake_fd_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
  ~Thread() {
    if (wake_fd_ >= 0) close(wake_fd_);
  }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  // The reason for which the run cannot begin; empty: none.
  std::string Begin(const std::shared_ptr<Thread>& self) {
    if (!options_.has_thread) {
      TryToOpen();
      return bad_setting_;
    }
    std::thread([self] { self->Run(); }).detach();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::nanoseconds(kThreadPatience_ns), [&] { return has_tried_; });
    return bad_setting_;
  }
  void End() {
    if (!options_.has_thread) {
      if (device_ != nullptr) Close();
      return;
    }
    is_stop_wanted_.store(true);
    Wake();
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::nanoseconds(kThreadPatience_ns), [&] { return has_ended_; });
  }

  // By the bridge's thread, where that is the only one.
  void TurnWithoutThread(std::int64_t now_ns) {
    if (!options_.has_thread) Turn(now_ns);
  }
  // Opens the device, or steps it once; retry_ns_ or next_tick_ns_ is when the next turn is due at the latest.
  void Turn(std::int64_t now_ns) {
    turn_ns_ = now_ns;
    if (report_.status == DeviceStatus::kBroken) return;
    if (device_ == nullptr) {
      if (now_ns < retry_ns_) return;
      if (!TryToOpen()) {
        retry_ns_ = Now() + kRetry_ns;
        return;
      }
    }
    if (StepOnce()) return;
    Close();
    retry_ns_ = Now() + kRetry_ns;
  }

  // By the bridge's thread.
  void Write(const Order& order) noexcept {
    orders_.Write(order);
    Wake();
  }
  void Lead(const LeadOrder& order) noexcept { lead_orders_.Write(order); }
  void SetMuted(bool is_muted) noexcept { is_muted_.store(is_muted); }
  bus::LatestValue<Sample>& samples() { return samples_; }
  bus::LatestValue<Report>& reports() { return reports_; }
  bus::LatestValue<oos_device_joints>& joints() { return joints_; }
  [[nodiscard]] bool is_robot() const { return GivesJoints(plugin_); }
  [[nodiscard]] bool has_lead() const { return CanLead(plugin_); }
  // When the call began that the thread is in; 0: none.
  [[nodiscard]] std::int64_t call_ns() const { return call_ns_.load(std::memory_order_acquire); }

 private:
  [[nodiscard]] std::int64_t Now() const { return options_.has_thread ? core::MonotonicNow_ns() : turn_ns_; }
  void Wake() const noexcept {
    const std::uint64_t one = 1;
    static_cast<void>(!write(wake_fd_, &one, sizeof one));
  }

  void Run() {
    bus::ThreadSetup setup;
    setup.name = "dev-" + role_;
    setup.mode = options_.rt == bus::RealTimeMode::kEnforce ? bus::RealTimeMode::kTry : options_.rt;
    setup.fifo_priority = options_.fifo_priority;
    setup.locks_memory = false;  // device-rt has
    bus::SetUpThread(setup);
    while (!is_stop_wanted_.load() && report_.status != DeviceStatus::kBroken) {
      Turn(core::MonotonicNow_ns());
      if (device_ == nullptr) SayTried();
      if (report_.status == DeviceStatus::kBroken) break;
      Pause(device_ != nullptr ? wait_fd_ : -1, device_ != nullptr ? next_tick_ns_ : retry_ns_);
    }
    if (device_ != nullptr) Close();
    std::lock_guard lock(mutex_);
    has_tried_ = has_ended_ = true;
    changed_.notify_all();
  }

  void SayTried() {
    std::lock_guard lock(mutex_);
    has_tried_ = true;
    changed_.notify_all();
  }

  // Calls a function of the plug-in, and notices how it goes wrong. False: it threw, and the device is off.
  template <class Call>
  bool Guard(const char* name, const Call& call) {
    call_ns_.store(Now(), std::memory_order_release);
    bool has_thrown = true;
    std::string what = "an exception of unknown type";
    try {
      call();
      has_thrown = false;
    } catch (const std::exception& exception) {
      what = exception.what();
    } catch (...) {
    }
    call_ns_.store(0, std::memory_order_release);
    if (has_thrown) Break(std::string(name) + "() threw: " + what);
    return !has_thrown;
  }

  void Break(const std::string& why) {
    report_.status = DeviceStatus::kBroken;
    SetWhy(why);
    reports_.Write(report_);
  }
  void SetWhy(std::string_view why) {
    report_.why.fill(0);
    why.copy(report_.why.data(), report_.why.size() - 1);
  }

  bool TryToOpen() {
    std::array<char, 200> why{};
    const oos_device_setting view = setting_.View(why.data(), static_cast<std::uint32_t>(why.size()));
    int result = OOS_DEVICE_GONE;
    device_ = nullptr;
    if (!Guard("open", [&] { result = plugin_.functions->open(&view, &device_); })) return false;
    why.back() = 0;
    if (result == OOS_DEVICE_OK) {
      meter_.Forget();
      differentiator_.Forget();
      sequence_ = 0;
      is_described_ = false;
      is_new_here_ = true;
      wait_fd_ = -1;
      if (plugin_.functions->wait_fd != nullptr) {
        Guard("wait_fd", [&] { wait_fd_ = plugin_.functions->wait_fd(device_); });
      }
      if (report_.status == DeviceStatus::kBroken) return false;
      next_tick_ns_ = Now();
      SayTried();
      return true;
    }
    if (result == OOS_DEVICE_BAD_SETTING) {
      Break(why[0] != 0 ? why.data() : "its plug-in refuses the setting");
      std::lock_guard lock(mutex_);
      bad_setting_ = report_.why.data();
      return false;
    }
    ++report_.num_misses;
    SetWhy(why.data());
    reports_.Write(report_);
    return false;
  }

  void Close() {
    Guard("close", [&] { plugin_.functions->close(device_); });
    device_ = nullptr;
    if (report_.status == DeviceStatus::kAlive) report_.status = DeviceStatus::kGone;
    reports_.Write(report_);
  }

  // Until the device has news, the bridge has a force, or the time has come.
  void Pause(int device_fd, std::int64_t until_ns) const {
    const std::int64_t left_ns = std::max<std::int64_t>(until_ns - core::MonotonicNow_ns(), 0);
    const timespec left{static_cast<time_t>(left_ns / 1'000'000'000), static_cast<long>(left_ns % 1'000'000'000)};
    pollfd fds[2] = {{wake_fd_, POLLIN, 0}, {device_fd, POLLIN, 0}};
    if (ppoll(fds, device_fd >= 0 ? 2 : 1, &left, nullptr) <= 0) return;
    std::uint64_t count = 0;
    if ((fds[0].revents & POLLIN) != 0) static_cast<void>(!read(wake_fd_, &count, sizeof count));
  }

  // False: the device has gone, or is broken.
  bool StepOnce() {
    const std::int64_t now_ns = turn_ns_;
    const bool is_tick = now_ns >= next_tick_ns_;
    if (is_tick) next_tick_ns_ = std::max(next_tick_ns_ + core::kTick_ns, now_ns);
    const bool is_new = orders_.Update();
    oos_device_command command = orders_.value().command;
    command.size = sizeof command;
    if (orders_.sequence() == 0 || now_ns - orders_.value().written_ns > kDeviceSilence_ns) {
      command = {};  // whoever commands has died
      command.size = sizeof command;
      command.brake_N_s_per_m = kDeadBrake_N_s_per_m;
      command.brake_Nm_s_per_rad = kDeadBrake_Nm_s_per_rad;
    }
    const bool sends = (is_tick || is_new) && !is_muted_.load();
    if (sends) {
      command.sequence = ++num_sent_;
      meter_.Sent(num_sent_, now_ns);
    }
    Sample& sample = samples_.BeginWrite();
    sample.state = {};
    sample.state.size = sizeof sample.state;
    int result = OOS_DEVICE_OK;
    if (!Guard("step", [&] {
          result = plugin_.functions->step(device_, now_ns, sends ? &command : nullptr, nullptr, &sample.state);
        })) {
      return false;
    }
    if (result != OOS_DEVICE_OK) return false;
    if (!TakeSample(&sample) || !Describe()) return false;
    return !is_tick || (TellGoal() && TakeJoints());
  }

  // A goal holds as long as a force. False: the device is broken.
  bool TellGoal() {
    lead_orders_.Update();
    if (lead_orders_.sequence() == 0 || (report_.description.flags & OOS_DEVICE_LEADS) == 0) return true;
    const LeadOrder& order = lead_orders_.value();
    const bool leads = order.leads && turn_ns_ - order.written_ns <= kDeviceSilence_ns && !is_muted_.load();
    return Guard("lead", [&] { plugin_.functions->lead(device_, leads ? &order.goal : nullptr); });
  }

  // False: the device is broken.
  bool TakeJoints() {
    if (!is_robot() || ++num_ticks_ % kTicksPerJointsCall != 0) return true;
    oos_device_joints& joints = joints_.BeginWrite();
    joints = {};
    joints.size = sizeof joints;
    int result = OOS_DEVICE_GONE;
    if (!Guard("joints", [&] { result = plugin_.functions->joints(device_, &joints); })) return false;
    if (result != OOS_DEVICE_OK) return true;  // it will say later
    if (!IsUsable(joints)) {
      Break("its joints have a number that is not finite, a quaternion that is not a unit, or are more than 16");
      return false;
    }
    joints_.EndWrite();
    return true;
  }

  bool TakeSample(Sample* sample) {
    const std::int64_t now_ns = Now();
    if (sample->state.sequence != 0 && sample->state.sequence != sequence_) {
      if (!IsUsable(sample->state)) {
        Break("its state has a number that is not finite, or a quaternion that is not a unit");
        return false;
      }
      const std::int64_t gap_ns = now_ns - last_sample_ns_;
      if (gap_ns > kDeviceSilence_ns) is_described_ = false;  // may be another specimen
      if (gap_ns > kHiccup_ns) is_new_here_ = true;
      sequence_ = sample->state.sequence;
      last_sample_ns_ = now_ns;
      if ((report_.description.flags & OOS_DEVICE_TELLS_VELOCITY) == 0) differentiator_.Fill(now_ns, &sample->state);
      sample->arrival_ns = now_ns;
      meter_.Received(sample->state, now_ns);
      samples_.EndWrite();
    }
    if (meter_.Update(now_ns)) {
      report_.link = meter_.figures();
      reports_.Write(report_);
    }
    return true;
  }

  bool Describe() {
    if (is_described_ || sequence_ == 0) return true;
    oos_device_description description{};
    description.size = sizeof description;
    int result = OOS_DEVICE_GONE;
    if (!Guard("describe", [&] { result = plugin_.functions->describe(device_, &description); })) return false;
    if (result != OOS_DEVICE_OK) return result == OOS_DEVICE_GONE;  // it will say later
    description.name[sizeof description.name - 1] = 0;
    description.serial[sizeof description.serial - 1] = 0;
    is_described_ = true;
    const bool is_other =
        report_.num_found == 0 || std::memcmp(&description, &report_.description, sizeof description) != 0;
    report_.status = DeviceStatus::kAlive;
    report_.why.fill(0);
    report_.description = description;
    if (is_other || is_new_here_) ++report_.num_found;
    is_new_here_ = false;
    if (is_other && options_.find_calibration) {
      const auto calibration = options_.find_calibration(description.name, description.serial);
      report_.is_calibrated = calibration.has_value();
      report_.calibration = calibration.value_or(DeviceCalibration{});
    }
    reports_.Write(report_);
    return true;
  }

  // As FilterLimits' brakes.
  static constexpr double kDeadBrake_N_s_per_m = 400.0;
  static constexpr double kDeadBrake_Nm_s_per_rad = 4.0;

  PluginTable plugin_;
  DeviceSetting setting_;
  std::string role_;
  ThreadedOptions options_;
  int wake_fd_;
  std::atomic<bool> is_stop_wanted_{false};
  std::atomic<bool> is_muted_{false};
  std::atomic<std::int64_t> call_ns_{0};
  bus::LatestValue<Sample> samples_;
  bus::LatestValue<Order> orders_;
  bus::LatestValue<LeadOrder> lead_orders_;
  bus::LatestValue<Report> reports_;
  bus::LatestValue<oos_device_joints> joints_;

  std::mutex mutex_;
  std::condition_variable changed_;
  bool has_tried_ = false;
  bool has_ended_ = false;
  std::string bad_setting_;

  // Of the thread alone.
  void* device_ = nullptr;
  int wait_fd_ = -1;
  Report report_;
  LinkMeter meter_;
  Differentiator differentiator_;
  std::uint64_t sequence_ = 0;
  std::uint64_t num_sent_ = 0;
  std::uint64_t num_ticks_ = 0;
  std::int64_t last_sample_ns_ = 0;
  std::int64_t next_tick_ns_ = 0;
  std::int64_t retry_ns_ = 0;  // to open the device
  std::int64_t turn_ns_ = 0;   // when the present turn began
  bool is_described_ = false;
  bool is_new_here_ = true;  // opened anew, or back after a long time: its hand may be elsewhere
};

core::Result<std::unique_ptr<ThreadedDevice>> ThreadedDevice::Create(PluginTable plugin, const scene::Device& device,
                                                                     const ThreadedOptions& options) {
  auto thread = std::make_shared<Thread>(std::move(plugin), device, options);
  std::unique_ptr<ThreadedDevice> made(new ThreadedDevice(thread, device.X_WD_start));
  if (const std::string why = thread->Begin(thread); !why.empty()) {
    return core::Fail(core::ErrorCode::kInvalidInput, why);
  }
  return made;
}

ThreadedDevice::~ThreadedDevice() {
  thread_->End();
}

void ThreadedDevice::TakeNews(std::int64_t now_ns) noexcept {
  if (thread_->reports().Update()) {
    const Report& report = thread_->reports().value();
    health_.status = report.status;
    health_.link = report.link;
    health_.quality = QualityOf(report.link);
    health_.why = report.why;
    health_.num_misses = report.num_misses;
    health_.is_calibrated = report.is_calibrated;
    health_.residual_m = report.calibration.residual_m;
    if (report.num_found != num_found_) {
      description_ = report.description;
      // An ABI of the future may know more; these two are not for what runs in a thread.
      description_.flags &= ~static_cast<std::uint32_t>(OOS_DEVICE_IS_IMMEDIATE | OOS_DEVICE_TAKES_HAND);
      num_found_ = report.num_found;
      map_.SetCalibration(report.is_calibrated ? std::optional(report.calibration.X_WB) : std::nullopt);
      is_taken_up_ = false;
    }
  }
  if (thread_->samples().Update()) {
    state_ = thread_->samples().value().state;
    sample_ns_ = thread_->samples().value().arrival_ns;
  }
  const std::int64_t call_ns = thread_->call_ns();
  if (call_ns != 0 && now_ns - call_ns > kDeviceSilence_ns) {
    health_.status = DeviceStatus::kHung;
  } else if (health_.status == DeviceStatus::kHung || health_.status == DeviceStatus::kSilent) {
    health_.status = thread_->reports().value().status;
  }
  if (health_.status == DeviceStatus::kAlive && now_ns - sample_ns_ > kDeviceSilence_ns)
    health_.status = DeviceStatus::kSilent;
  if (health_.status != DeviceStatus::kAlive) health_.quality = LinkQuality::kOff;
}

DeviceReading ThreadedDevice::Read(std::int64_t now_ns) noexcept {
  thread_->TurnWithoutThread(now_ns);
  TakeNews(now_ns);
  read_ns_ = now_ns;
  DeviceReading reading;
  const bool is_alive = health_.status == DeviceStatus::kAlive;
  reading.is_engaged =
      is_alive && (state_.flags & OOS_DEVICE_IS_ENGAGED) != 0 && (state_.flags & OOS_DEVICE_IS_OFF) == 0;
  reading.opening_m = state_.opening_m;
  reading.finger_rad = FingersOf(state_);
  reading.sample_ns = sample_ns_;
  const core::Pose X_BD = sample_ns_ != 0 ? PoseOf(state_.X_BD) : core::Pose{};
  if (reading.is_engaged && !is_taken_up_) map_.TakeUp(X_BD);
  // A link that failed for a moment is no letting go.
  is_taken_up_ = reading.is_engaged || (is_taken_up_ && !is_alive);
  // A calibrated device shows where it is, also when it is not held; another one's hand waits where it was let go.
  const bool moves = reading.is_engaged || (is_alive && map_.is_calibrated());
  reading.X_WD = moves ? map_.Map(X_BD) : map_.X_WD();
  if (!moves) return reading;
  reading.V_WD = map_.Map(TwistOf(state_.V_BD));
  reading.opening_velocity_m_per_s = state_.opening_velocity_m_per_s;
  return reading;
}

void ThreadedDevice::Write(std::int64_t now_ns, const FilteredForce& force) noexcept {
  Order order;
  order.written_ns = now_ns;
  order.command.size = sizeof order.command;
  order.command.sequence = ++num_written_;
  ToArray(map_.ToBase(OfMotors(description_.actuated, force.F_Do_W())), order.command.F_Do_B);
  order.command.grip_force_N = force.grip_force_N();
  order.command.brake_N_s_per_m = force.brake_N_s_per_m();
  order.command.brake_Nm_s_per_rad = force.brake_Nm_s_per_rad();
  thread_->Write(order);
}

FeltForce ThreadedDevice::Felt() const noexcept {
  FeltForce felt;
  felt.opening_m = state_.opening_m;
  if (health_.status != DeviceStatus::kAlive) return felt;
  felt.F_Do_W = map_.Map(WrenchOf(state_.applied));
  felt.grip_force_N = state_.applied[6];
  return felt;
}

bool ThreadedDevice::can_lead() const noexcept {
  return (description_.flags & OOS_DEVICE_LEADS) != 0 && thread_->has_lead();
}

void ThreadedDevice::Lead(const LeadGoal* goal) noexcept {
  if (!can_lead()) return;
  LeadOrder order;
  order.written_ns = read_ns_;
  order.leads =
      goal != nullptr && FillGoal(map_.ToBase(goal->X_WG), goal->max_force_N, goal->max_torque_Nm, &order.goal);
  thread_->Lead(order);
}

bool ThreadedDevice::is_robot() const noexcept {
  return thread_->is_robot();
}

bool ThreadedDevice::Joints(oos_device_joints* joints) noexcept {
  if (health_.status != DeviceStatus::kAlive) return false;
  thread_->joints().Update();
  *joints = thread_->joints().value();
  return joints->num_joints > 0;
}

void ThreadedDevice::SetMuted(bool is_muted) noexcept {
  thread_->SetMuted(is_muted);
}

const DeviceHealth& ThreadedDevice::Health(std::int64_t now_ns) noexcept {
  TakeNews(now_ns);
  return health_;
}

}  // namespace device_bridge
