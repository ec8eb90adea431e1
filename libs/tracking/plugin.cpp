#include "tracking/plugin.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/wrench.hpp"
#include "device/say_why.hpp"
#include "scene/udp_address.hpp"
#include "tracking/dtrack.hpp"
#include "tracking/finger_angles.hpp"
#include "tracking/glove.hpp"
#include "tracking/listen.hpp"
#include "tracking/pinch.hpp"
#include "tracking/pseudo_grip.hpp"
#include "tracking/tactile.hpp"

namespace tracking {
namespace {

constexpr int kMostDatagrams = 64;         // that one step takes: a flood must not keep it
constexpr std::size_t kMostBytes = 65536;  // of a datagram
constexpr double kFullGrip_N = 10.0;  // assumed: of jaws on fingers, at which a motor vibrates with all its strength
constexpr std::int64_t kTactilePeriod_ns = 33'000'000;  // the controller forgets after seconds
constexpr std::int64_t kCommandAge_ns = 60'000'000;     // of device/plugin.h
constexpr std::uint64_t kTrigger = 1;                   // bit of the buttons
constexpr std::int64_t kFresh_ns = 50'000'000;          // a frame's age until which the jaws go on: three of 60 Hz
constexpr std::int64_t kPinchAge_ns = 100'000'000;      // what a sensor said is forgotten then

enum class Followed { kFlystick, kHand, kBody };

struct Setting {
  Followed followed = Followed::kFlystick;
  int id = 0;
  double opening_max_m = 0.08;
  double max_grip_N = kMaxGrip_N;
  double grip_stiffness_N_per_m = kGripStiffness_N_per_m;
  std::string pinch;                   // where a sensor of pinching sends to; empty: there is none
  std::string glove;                   // where a data glove sends to; empty: there is none
  std::optional<sockaddr_in> tactile;  // of the controller
};

// What a frame says of what is followed.
struct Follows {
  TrackedBody body;
  bool is_held = false;
  std::uint32_t buttons = 0;
  double stick = 0.0;      // of a Flystick, vertical
  double fingers_m = 0.0;  // of a hand: between the tips of thumb and index finger
  std::optional<FingerAngles> angles_rad;
};

std::optional<Follows> FindFlystick(const DtrackFrame& frame, const Setting& setting) {
  for (const TrackedFlystick& stick : frame.flysticks) {
    if (stick.body.id != setting.id) continue;
    return Follows{stick.body,    (stick.buttons & kTrigger) != 0,
                   stick.buttons, stick.num_controllers > 1 ? stick.controllers[1] : 0.0,
                   0.0,           {}};
  }
  return std::nullopt;
}

std::optional<Follows> FindHand(const DtrackFrame& frame, const Setting& setting) {
  for (const TrackedHand& hand : frame.hands) {
    if (hand.body.id != setting.id) continue;
    Follows follows{hand.body, true, 0, 0.0, setting.opening_max_m, AnglesOf(hand)};
    if (hand.fingers.size() > 1) {
      const TrackedFinger& thumb = hand.fingers[0];
      const TrackedFinger& index = hand.fingers[1];
      follows.fingers_m =
          glm::distance(thumb.X_BF.translation, index.X_BF.translation) - thumb.radius_m - index.radius_m;
    }
    return follows;
  }
  return std::nullopt;
}

// A limb, say: there is nothing to hold and nothing to grip with. DTrack leaves out those that it does not see.
std::optional<Follows> FindBody(const DtrackFrame& frame, const Setting& setting) {
  for (const TrackedBody& body : frame.bodies) {
    if (body.id == setting.id) return Follows{body, true, 0, 1.0, 0.0, {}};
  }
  if (!frame.number) return std::nullopt;
  return Follows{TrackedBody{}, false, 0, 1.0, 0.0, {}};
}

std::optional<Follows> Find(const DtrackFrame& frame, const Setting& setting) {
  switch (setting.followed) {
    case Followed::kHand:
      return FindHand(frame, setting);
    case Followed::kBody:
      return FindBody(frame, setting);
    case Followed::kFlystick:
      break;
  }
  return FindFlystick(frame, setting);
}

// Between two poses of a tracker.
core::Twist VelocityOf(const core::Pose& from, const core::Pose& to, double dt_s) {
  core::Twist V;
  if (!(dt_s > 0.0)) return V;
  V.linear_m_per_s = (to.translation - from.translation) / dt_s;
  V.angular_rad_per_s = core::RotationVector(to.rotation * glm::conjugate(from.rotation)) / dt_s;
  return V;
}

class DtrackDevice {
 public:
  // `pinch` is -1 without a sensor of pinching, `glove` without a glove.
  DtrackDevice(const Setting& setting, int socket, int pinch, int glove)
      : setting_(setting),
        socket_(socket),
        pinch_socket_(pinch),
        glove_socket_(glove),
        bytes_(kMostBytes),
        jaws_(setting.opening_max_m, setting.opening_max_m) {
    state_.X_BD[0] = 1.0;
    follows_.fingers_m = setting.opening_max_m;
  }
  ~DtrackDevice() {
    close(socket_);
    if (pinch_socket_ >= 0) close(pinch_socket_);
    if (glove_socket_ >= 0) close(glove_socket_);
  }
  DtrackDevice(const DtrackDevice&) = delete;
  DtrackDevice& operator=(const DtrackDevice&) = delete;

  [[nodiscard]] int fd() const { return socket_; }
  [[nodiscard]] bool is_there() const { return state_.sequence != 0; }
  [[nodiscard]] const Setting& setting() const { return setting_; }

  void Step(std::int64_t now_ns, const oos_device_command* command, oos_device_state* state) {
    ForEachDatagram(socket_, [&](std::string_view datagram) { Take(datagram, now_ns); });
    if (pinch_socket_ >= 0) {
      ForEachDatagram(pinch_socket_, [&](std::string_view datagram) { TakePinch(datagram, now_ns); });
    }
    if (glove_socket_ >= 0) {
      ForEachDatagram(glove_socket_, [&](std::string_view datagram) {
        if (const auto angles_rad = ParseGlove(datagram, setting_.id)) SetFingers(*angles_rad);
      });
    }
    if (command != nullptr) {
      reaction_N_ = command->grip_force_N;
      command_ns_ = now_ns;
    }
    if (now_ns - command_ns_ > kCommandAge_ns) reaction_N_ = 0.0;
    if (is_there()) MoveJaws(now_ns);
    if (setting_.tactile && is_there()) Vibrate(now_ns);
    state_.size = state->size;
    *state = state_;
  }

 private:
  template <class Use>
  void ForEachDatagram(int socket, Use&& use) {
    for (int i = 0; i < kMostDatagrams; ++i) {
      const ssize_t size = recv(socket, bytes_.data(), bytes_.size(), MSG_DONTWAIT);
      if (size < 0) break;
      use(std::string_view(bytes_.data(), static_cast<std::size_t>(size)));
    }
  }

  void SetFingers(const FingerAngles& angles_rad) {
    state_.num_finger_joints = OOS_DEVICE_FINGER_JOINTS;
    std::copy(angles_rad.begin(), angles_rad.end(), state_.finger_rad);
  }

  void TakePinch(std::string_view datagram, std::int64_t now_ns) {
    const std::optional<double> pinch = ParsePinch(datagram, setting_.id);
    if (!pinch) return;
    pinch_ = *pinch;
    pinch_ns_ = now_ns;
  }

  [[nodiscard]] GripWish Wish(std::int64_t now_ns) const {
    const Setting& s = setting_;
    if (s.followed != Followed::kHand) return WishOfStick(follows_.stick, s.opening_max_m, s.max_grip_N);
    if (pinch_socket_ >= 0) {
      const double pinch = now_ns - pinch_ns_ > kPinchAge_ns ? 0.0 : pinch_;
      return WishOfPinch(pinch, follows_.fingers_m, s.opening_max_m, s.max_grip_N);
    }
    return WishOfDistance(follows_.fingers_m, jaws_.opening_m(), s.opening_max_m, s.grip_stiffness_N_per_m,
                          s.max_grip_N);
  }

  // The jaws answer to what they hold a thousand times a second, and the cameras come sixty times: between two frames
  // each step is a sample, with the frame's pose. Not for long: a tracker that has fallen silent is lost.
  void MoveJaws(std::int64_t now_ns) {
    const double dt_s = std::clamp(1e-9 * static_cast<double>(now_ns - moved_ns_), 0.0, 0.01);
    moved_ns_ = now_ns;
    if (now_ns - frame_ns_ > kFresh_ns) return;
    const double before_m = jaws_.opening_m();
    state_.opening_m = jaws_.Step(Wish(now_ns), reaction_N_, dt_s);
    state_.opening_velocity_m_per_s = dt_s > 0.0 ? (state_.opening_m - before_m) / dt_s : 0.0;
    if (now_ns == frame_ns_) return;
    ++state_.sequence;
    state_.device_time_ns = frame_time_ns_ + now_ns - frame_ns_;
  }

  // While the cameras do not see it, it stays where it was and counts as let go; its buttons are those that it has.
  void Take(std::string_view datagram, std::int64_t now_ns) {
    std::vector<std::string> complaints;
    const DtrackFrame frame = ParseDtrack(datagram, &complaints);
    const std::optional<Follows> found = Find(frame, setting_);
    if (!found) return;
    ++state_.sequence;
    const std::int64_t time_ns = TimeOf(frame, now_ns);
    const double dt_s = 1e-9 * static_cast<double>(time_ns - frame_time_ns_);
    frame_time_ns_ = time_ns;
    frame_ns_ = now_ns;
    state_.device_time_ns = std::max(time_ns, state_.device_time_ns);
    state_.buttons = found->buttons;
    const Follows before = follows_;
    follows_ = *found;
    const bool is_seen = found->body.is_tracked();
    state_.flags = is_seen && found->is_held ? OOS_DEVICE_IS_ENGAGED : 0;
    SetVelocity(is_seen && before.body.is_tracked() ? VelocityOf(before.body.X_TB, found->body.X_TB, dt_s)
                                                    : core::Twist{});
    if (!is_seen) {
      follows_.stick = before.stick;
      follows_.fingers_m = before.fingers_m;
      return;
    }
    if (found->angles_rad && glove_socket_ < 0) SetFingers(*found->angles_rad);
    const core::Pose& X = found->body.X_TB;
    const std::array<double, 7> pose = {X.rotation.w,    X.rotation.x,    X.rotation.y,   X.rotation.z,
                                        X.translation.x, X.translation.y, X.translation.z};
    std::copy(pose.begin(), pose.end(), state_.X_BD);
  }

  void SetVelocity(const core::Twist& V) {
    for (int i = 0; i < 3; ++i) {
      state_.V_BD[i] = V.angular_rad_per_s[i];
      state_.V_BD[3 + i] = V.linear_m_per_s[i];
    }
  }

  // Of day, which begins anew at midnight; without one, when the frame came.
  std::int64_t TimeOf(const DtrackFrame& frame, std::int64_t now_ns) {
    if (!frame.time_s || *frame.time_s > 1e6) return now_ns;
    const auto time_ns = static_cast<std::int64_t>(1e9 * *frame.time_s);
    if (time_ns + day_ns_ < frame_time_ns_) day_ns_ += 86'400'000'000'000;
    return time_ns + day_ns_;
  }

  void Vibrate(std::int64_t now_ns) {
    if (now_ns < next_tactile_ns_) return;
    next_tactile_ns_ = now_ns + kTactilePeriod_ns;
    const double strength = std::abs(reaction_N_) / kFullGrip_N;
    const std::array<FingerVibration, 2> fingers = {FingerVibration{setting_.id, 0, strength},
                                                    FingerVibration{setting_.id, 1, strength}};
    const std::string text = TactileDatagram(fingers);
    // A datagram that cannot be sent is lost, as any may be.
    static_cast<void>(sendto(socket_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                             reinterpret_cast<const sockaddr*>(&*setting_.tactile), sizeof *setting_.tactile));
  }

  static constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::min() / 2;

  Setting setting_;
  int socket_, pinch_socket_, glove_socket_;
  std::vector<char> bytes_;
  oos_device_state state_{};
  Follows follows_;
  PseudoJaws jaws_;
  double pinch_ = 0.0;
  std::int64_t pinch_ns_ = kNever_ns;
  std::int64_t day_ns_ = 0;
  std::int64_t frame_ns_ = kNever_ns;       // when the newest frame came
  std::int64_t frame_time_ns_ = kNever_ns;  // its own time
  std::int64_t moved_ns_ = 0;
  double reaction_N_ = 0.0;  // of what is held on the jaws, positive opens
  std::int64_t command_ns_ = kNever_ns;
  std::int64_t next_tactile_ns_ = 0;
};

// Reads the options; the mistakes are sentences.
class DtrackOptions {
 public:
  explicit DtrackOptions(const oos_device_setting& setting) : setting_(setting) {}
  Setting Read() {
    Setting made;
    int num_followed = 0;
    for (const auto& [name, followed] :
         {std::pair{"flystick", Followed::kFlystick}, {"hand", Followed::kHand}, {"body", Followed::kBody}}) {
      if (Text(name).empty()) continue;
      made.followed = followed;
      made.id = Id(name);
      ++num_followed;
    }
    if (num_followed > 1) wrong_ += "give option flystick, option hand or option body, and not two of them; ";
    const bool is_hand = made.followed == Followed::kHand;
    if (const std::string text = Text("opening_max_m"); !text.empty()) {
      made.opening_max_m = Number("opening_max_m", text, 1.0, "a width in metres");
    }
    if (const std::string text = Text("max_grip_N"); !text.empty()) {
      made.max_grip_N = Number("max_grip_N", text, 1000.0, "a force in newton");
    }
    if (const std::string text = Text("grip_stiffness_N_per_m"); !text.empty()) {
      made.grip_stiffness_N_per_m = Number("grip_stiffness_N_per_m", text, 1e5, "a stiffness in newton per metre");
    }
    made.glove = Text("glove");
    made.pinch = Text("pinch");
    if (!made.pinch.empty() && !is_hand) wrong_ += "option pinch: fingers pinch, so give option hand as well; ";
    if (const std::string text = Text("tactile"); !text.empty()) made.tactile = Controller(text, is_hand);
    return made;
  }
  [[nodiscard]] const std::string& wrong() const { return wrong_; }

 private:
  [[nodiscard]] std::string Text(std::string_view name) const {
    for (std::uint32_t i = 0; i < setting_.num_options; ++i) {
      if (name == setting_.options[i].name) return setting_.options[i].value;
    }
    return "";
  }
  int Id(const std::string& name) {
    const std::string text = Text(name);
    if (text.empty()) return 0;
    int id = -1;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
    if (error != std::errc() || end != text.data() + text.size() || id < 0) {
      wrong_ += "option " + name + ": '" + text + "' is not the number of one, from 0; ";
    }
    return id;
  }
  double Number(const std::string& name, const std::string& text, double less_than, const std::string& what) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value > 0.0 && value < less_than)) {
      wrong_ += "option " + name + ": '" + text + "' is not " + what + "; ";
    }
    return value;
  }
  std::optional<sockaddr_in> Controller(const std::string& text, bool is_hand) {
    const auto parsed = scene::ParseUdpAddress(text);
    if (!is_hand || !parsed || parsed->ip == 0) {
      wrong_ += "option tactile: write the controller's address and its port, as 192.168.0.1:50110, for a hand; ";
      return std::nullopt;
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(parsed->ip);
    address.sin_port = htons(parsed->port);
    return address;
  }

  const oos_device_setting& setting_;
  std::string wrong_;
};

int Refuse(const oos_device_setting& setting, const core::Error& error) {
  device::SayWhy(setting, error.detail);
  return error.code == core::ErrorCode::kInvalidInput ? OOS_DEVICE_BAD_SETTING : OOS_DEVICE_GONE;
}

int OpenDtrack(const oos_device_setting* setting, void** device) {
  DtrackOptions options(*setting);
  const Setting read = options.Read();
  if (!options.wrong().empty()) {
    device::SayWhy(*setting, options.wrong().substr(0, options.wrong().size() - 2));
    return OOS_DEVICE_BAD_SETTING;
  }
  const auto listener = Listen(setting->address != nullptr ? setting->address : "");
  if (!listener) return Refuse(*setting, listener.error());
  int pinch = -1;
  if (!read.pinch.empty()) {
    const auto sensor = Listen(read.pinch);
    if (!sensor) {
      close(listener->fd);
      return Refuse(*setting, {sensor.error().code, "option pinch: " + sensor.error().detail});
    }
    pinch = sensor->fd;
  }
  int glove = -1;
  if (!read.glove.empty()) {
    const auto sender = Listen(read.glove);
    if (!sender) {
      close(listener->fd);
      if (pinch >= 0) close(pinch);
      return Refuse(*setting, {sender.error().code, "option glove: " + sender.error().detail});
    }
    glove = sender->fd;
  }
  *device = new DtrackDevice(read, listener->fd, pinch, glove);
  return OOS_DEVICE_OK;
}

const char* NameOf(Followed followed) {
  switch (followed) {
    case Followed::kHand:
      return "hand by ART DTrack";
    case Followed::kBody:
      return "body by ART DTrack";
    case Followed::kFlystick:
      break;
  }
  return "Flystick by ART DTrack";
}

int DescribeDtrack(void* device, oos_device_description* description) {
  const auto& self = *static_cast<const DtrackDevice*>(device);
  if (!self.is_there()) return OOS_DEVICE_GONE;
  const std::string id = std::to_string(self.setting().id);
  std::strncpy(description->name, NameOf(self.setting().followed), sizeof description->name - 1);
  std::strncpy(description->serial, id.c_str(), sizeof description->serial - 1);
  description->flags = OOS_DEVICE_TELLS_VELOCITY;
  description->sensed = OOS_DEVICE_TRANSLATION | OOS_DEVICE_ROTATION | OOS_DEVICE_GRIP;
  description->opening_max_m = self.setting().opening_max_m;
  return OOS_DEVICE_OK;
}

int StepDtrack(void* device, std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* /*hand*/,
               oos_device_state* state) {
  static_cast<DtrackDevice*>(device)->Step(now_ns, command, state);
  return OOS_DEVICE_OK;
}

void CloseDtrack(void* device) {
  delete static_cast<DtrackDevice*>(device);
}

int DtrackFd(void* device) {
  return static_cast<const DtrackDevice*>(device)->fd();
}

}  // namespace

const oos_device_plugin& Plugin() {
  static const oos_device_plugin plugin{OOS_DEVICE_ABI_VERSION,
                                        sizeof plugin,
                                        OpenDtrack,
                                        DescribeDtrack,
                                        StepDtrack,
                                        CloseDtrack,
                                        DtrackFd,
                                        nullptr,
                                        nullptr};
  return plugin;
}

}  // namespace tracking
