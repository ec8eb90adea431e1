#include "nodes/visual_node/window/gamepad.hpp"

#include <gtest/gtest.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {
namespace {

constexpr const char* kName = "Microsoft X-Box 360 pad";
constexpr int kStickEnd = 32767;
constexpr int kTriggerEnd = 255;

// The kernel's side of /dev/input/event9: a pad with two sticks, two triggers and two motors. umockdev calls it from a
// thread of its own.
class EmulatedPad {
 public:
  EmulatedPad() : testbed_(umockdev_testbed_new()), handler_(umockdev_ioctl_base_new()) {
    g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(HandleIoctl), this);
    g_signal_connect(handler_, "handle-read", G_CALLBACK(HandleRead), this);
    g_signal_connect(handler_, "handle-write", G_CALLBACK(HandleWrite), this);
    GError* error = nullptr;
    EXPECT_TRUE(umockdev_testbed_add_from_string(testbed_,
                                                 "P: /devices/pad/input/input9/event9\nN: input/event9\n"
                                                 "E: DEVNAME=/dev/input/event9\nE: SUBSYSTEM=input\n",
                                                 &error));
    EXPECT_TRUE(umockdev_testbed_attach_ioctl(testbed_, "/dev/input/event9", handler_, &error));
  }
  ~EmulatedPad() {
    umockdev_testbed_detach_ioctl(testbed_, "/dev/input/event9", nullptr);
    g_object_unref(testbed_);
    g_object_unref(handler_);
  }
  EmulatedPad(const EmulatedPad&) = delete;
  EmulatedPad& operator=(const EmulatedPad&) = delete;

  void Move(int axis, int value) {
    const std::lock_guard lock(mutex_);
    axes_[static_cast<std::size_t>(axis)] = value;
    Queue(EV_ABS, axis, value);
  }
  void Press(int button, bool is_down) {
    const std::lock_guard lock(mutex_);
    Queue(EV_KEY, button, is_down ? 1 : 0);
  }
  // Strengths of the effects that were played, in their order; 0: stopped.
  std::vector<double> played() {
    const std::lock_guard lock(mutex_);
    return played_;
  }
  int longest_ms() {
    const std::lock_guard lock(mutex_);
    return longest_ms_;
  }

 private:
  void Queue(int type, int code, int value) {
    input_event event{};
    event.type = static_cast<__u16>(type);
    event.code = static_cast<__u16>(code);
    event.value = value;
    events_.push_back(event);
    events_.push_back({});  // SYN_REPORT
  }

  // Answer of the kernel's interface (linux/input.h) to the request of that number; none: it does not know it.
  bool Answer(unsigned number, std::vector<unsigned char>* bytes) {
    const auto put = [bytes](const auto& value) {
      std::memcpy(bytes->data(), &value, std::min(sizeof value, bytes->size()));
    };
    const auto bits = [bytes](std::initializer_list<int> set) {
      for (const int bit : set) {
        const auto at = static_cast<std::size_t>(bit) / 8;
        if (at < bytes->size()) (*bytes)[at] = static_cast<unsigned char>((*bytes)[at] | 1 << (bit % 8));
      }
    };
    if (number == _IOC_NR(EVIOCGID))
      put(input_id{BUS_USB, 0x045e, 0x028e, 0x0114});
    else if (number == _IOC_NR(EVIOCGNAME(0)))
      std::strncpy(reinterpret_cast<char*>(bytes->data()), kName, bytes->size() - 1);
    else if (number == _IOC_NR(EVIOCGBIT(0, 0)))
      bits({EV_KEY, EV_ABS, EV_FF});
    else if (number == _IOC_NR(EVIOCGBIT(EV_KEY, 0)))
      bits({BTN_A, BTN_B, BTN_X, BTN_Y, BTN_TL, BTN_TR, BTN_SELECT, BTN_START, BTN_MODE, BTN_THUMBL, BTN_THUMBR});
    else if (number == _IOC_NR(EVIOCGBIT(EV_ABS, 0)))
      bits({ABS_X, ABS_Y, ABS_Z, ABS_RX, ABS_RY, ABS_RZ, ABS_HAT0X, ABS_HAT0Y});
    else if (number == _IOC_NR(EVIOCGBIT(EV_FF, 0)))
      bits({FF_RUMBLE});
    else if (number >= _IOC_NR(EVIOCGABS(0)) && number <= _IOC_NR(EVIOCGABS(ABS_MAX))) {
      const auto axis = number - static_cast<unsigned>(_IOC_NR(EVIOCGABS(0)));
      const bool is_trigger = axis == ABS_Z || axis == ABS_RZ;
      const bool is_hat = axis >= ABS_HAT0X;
      input_absinfo info{};
      info.value = axes_[axis];
      info.minimum = is_trigger ? 0 : is_hat ? -1 : -kStickEnd;
      info.maximum = is_trigger ? kTriggerEnd : is_hat ? 1 : kStickEnd;
      put(info);
    } else if (number == _IOC_NR(EVIOCSFF)) {
      ff_effect effect{};
      std::memcpy(&effect, bytes->data(), sizeof effect);
      EXPECT_EQ(effect.type, FF_RUMBLE);
      if (effect.id < 0) effect.id = num_effects_++;
      strength_ = effect.u.rumble.strong_magnitude / 65535.0;
      longest_ms_ = std::max<int>(longest_ms_, effect.replay.length);
      put(effect);
    } else {
      return false;
    }
    return true;
  }

  static gboolean HandleIoctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, EmulatedPad* self) {
    const std::lock_guard lock(self->mutex_);
    const unsigned long request = umockdev_ioctl_client_get_request(client);
    UMockdevIoctlData* data =
        umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), nullptr);
    std::vector<unsigned char> bytes(_IOC_SIZE(request));
    const bool is_setting = _IOC_NR(request) == _IOC_NR(EVIOCSFF);
    if (is_setting) std::memcpy(bytes.data(), data->data, bytes.size());
    if (!self->Answer(_IOC_NR(request), &bytes)) {
      umockdev_ioctl_client_complete(client, -1, ENOTTY);
    } else {
      umockdev_ioctl_data_update(data, 0, bytes.data(), static_cast<int>(bytes.size()));
      umockdev_ioctl_client_complete(client, 0, 0);
    }
    umockdev_ioctl_data_unref(data);
    return TRUE;
  }
  static gboolean HandleRead(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, EmulatedPad* self) {
    const std::lock_guard lock(self->mutex_);
    if (self->events_.empty()) {
      umockdev_ioctl_client_complete(client, -1, EAGAIN);
      return TRUE;
    }
    input_event event = self->events_.front();
    self->events_.pop_front();
    umockdev_ioctl_data_update(umockdev_ioctl_client_get_arg(client), 0, reinterpret_cast<guint8*>(&event),
                               sizeof event);
    umockdev_ioctl_client_complete(client, sizeof event, 0);
    return TRUE;
  }
  static gboolean HandleWrite(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, EmulatedPad* self) {
    const std::lock_guard lock(self->mutex_);
    const UMockdevIoctlData* data = umockdev_ioctl_client_get_arg(client);
    input_event event{};
    EXPECT_EQ(data->data_len, static_cast<int>(sizeof event));
    std::memcpy(&event, data->data, sizeof event);
    EXPECT_EQ(event.type, EV_FF);
    self->played_.push_back(event.value != 0 ? self->strength_ : 0.0);
    umockdev_ioctl_client_complete(client, data->data_len, 0);
    return TRUE;
  }

  UMockdevTestbed* testbed_;
  UMockdevIoctlBase* handler_;
  std::mutex mutex_;
  std::array<int, ABS_CNT> axes_{};
  std::deque<input_event> events_;
  std::vector<double> played_;
  double strength_ = 0.0;
  int longest_ms_ = 0;
  short num_effects_ = 0;
};

class GamepadTest : public testing::Test {
 protected:
  void SetUp() override {
    const char* preload = std::getenv("LD_PRELOAD");
    if (preload == nullptr || std::string(preload).find("umockdev") == std::string::npos) {
      GTEST_SKIP() << "libumockdev-preload.so is not preloaded (ctest does, but not with a sanitizer)";
    }
    pad_ = std::make_unique<EmulatedPad>();
    if (glfwInit() == GLFW_FALSE) GTEST_SKIP() << "no display";
  }
  void TearDown() override {
    glfwTerminate();
    pad_.reset();
  }
  view::SteeringWish Read() {
    view::SteeringWish wish;
    gamepad_.Read(&wish);
    return wish;
  }

  std::unique_ptr<EmulatedPad> pad_;
  Gamepad gamepad_;
};

TEST_F(GamepadTest, SticksPushTheHandAndWithTheShoulderTurnIt) {
  EXPECT_EQ(Read().push, glm::dvec3(0.0));
  EXPECT_TRUE(gamepad_.is_there());
  pad_->Move(ABS_X, kStickEnd);   // to the right
  pad_->Move(ABS_Y, -kStickEnd);  // up: the kernel's y points down
  view::SteeringWish wish = Read();
  EXPECT_NEAR(wish.push.x, 1.0, 1e-6);
  EXPECT_NEAR(wish.push.y, 1.0, 1e-6);
  EXPECT_EQ(wish.turn, glm::dvec3(0.0));
  EXPECT_TRUE(wish.is_held);
  pad_->Press(BTN_TR, true);
  wish = Read();
  EXPECT_EQ(wish.push, glm::dvec3(0.0));
  EXPECT_NEAR(wish.turn.y, 1.0, 1e-6);
  EXPECT_NEAR(wish.turn.x, -1.0, 1e-6);
}

TEST_F(GamepadTest, AStickThatIsLetGoDoesNotDrift) {
  Read();
  pad_->Move(ABS_X, static_cast<int>(0.14 * kStickEnd));
  const view::SteeringWish wish = Read();
  EXPECT_EQ(wish.push, glm::dvec3(0.0));
  EXPECT_FALSE(wish.is_held);
}

TEST_F(GamepadTest, ButtonsCountOncePerPressAndTheTriggerClosesTheJaws) {
  Read();
  pad_->Press(BTN_A, true);
  pad_->Move(ABS_RZ, kTriggerEnd);
  Read();
  EXPECT_TRUE(gamepad_.TakeGrip());
  EXPECT_FALSE(gamepad_.TakeGrip());
  Read();
  EXPECT_FALSE(gamepad_.TakeGrip()) << "it is held down";
  EXPECT_FALSE(gamepad_.TakeNext());
  EXPECT_NEAR(gamepad_.trigger(), 1.0, 1e-6);
}

TEST_F(GamepadTest, ShakesWithTheForceAndStopsWithIt) {
  Read();
  ASSERT_TRUE(gamepad_.has_motors());
  gamepad_.Shake(0.0, 0.0);
  EXPECT_TRUE(pad_->played().empty());
  gamepad_.Shake(0.5, 0.01);
  gamepad_.Shake(0.51, 0.02);  // not to be felt
  ASSERT_EQ(pad_->played().size(), 1u);
  EXPECT_NEAR(pad_->played()[0], 0.5, 1e-4);
  gamepad_.Shake(0.51, 0.30);  // goes on
  ASSERT_EQ(pad_->played().size(), 2u);
  EXPECT_NEAR(pad_->played()[1], 0.51, 1e-4);
  gamepad_.Shake(2.0, 0.31);  // no more than all
  gamepad_.Shake(0.0, 0.32);
  ASSERT_EQ(pad_->played().size(), 4u);
  EXPECT_EQ(pad_->played()[2], 1.0);
  EXPECT_EQ(pad_->played()[3], 0.0);
  EXPECT_LE(pad_->longest_ms(), 500) << "a viewer that has died shakes nobody";
}

}  // namespace
}  // namespace visual_node
