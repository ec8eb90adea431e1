#include "nodes/device_bridge/head/dtrack_head.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <numbers>

#include "bus/rt/periodic_loop.hpp"
#include "core/clock.hpp"

namespace device_bridge {
namespace {

constexpr std::int64_t kPatienceForAHead_ns = 20'000'000'000;

scene::User UserAt(const std::string& address) {
  scene::User user;
  user.name = "operator";
  user.head = "dtrack";
  user.address = address;
  user.body = 3;
  return user;
}

// A controller that sends to a head.
class Controller {
 public:
  explicit Controller(std::uint16_t port) : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to_.sin_port = htons(port);
  }
  ~Controller() { close(socket_); }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  void Send(const std::string& text) const {
    EXPECT_EQ(sendto(socket_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_),
              static_cast<ssize_t>(text.size()));
  }

 private:
  int socket_;
  sockaddr_in to_{};
};

std::optional<core::Pose> WaitFor(DtrackHead* head) {
  bus::PeriodicLoop loop(core::kTick_ns);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  while (core::MonotonicNow_ns() - begin_ns < kPatienceForAHead_ns) {
    if (const auto X_RH = head->Read(core::MonotonicNow_ns())) return X_RH;
    loop.WaitNext();
  }
  return std::nullopt;
}

// The tracker's frame is a metre above the room's and turned by a quarter about z; the eyes are 80 mm before the body.
TEST(DtrackHead, StandsWhereTheBodyIsInTheRoom) {
  scene::User user = UserAt("127.0.0.1:0");
  user.X_RT = {core::QuaternionFromRotationVector({0, 0, std::numbers::pi / 2.0}), {0, 0, 1}};
  user.X_BH.translation = {0, 0.08, 0};
  auto head = DtrackHead::Create(user);
  ASSERT_TRUE(head) << head.error().detail;
  EXPECT_FALSE((*head)->Read(core::MonotonicNow_ns())) << "nothing has come";
  const Controller controller((*head)->port());
  controller.Send("fr 1\r\n6d 2 [0 1.0][9 9 9][1 0 0 0 1 0 0 0 1] [3 1.0][200 0 500][1 0 0 0 1 0 0 0 1]\r\n");
  const auto X_RH = WaitFor(head->get());
  ASSERT_TRUE(X_RH);
  // (0.2, 0.08, 0.5) of T, turned: (-0.08, 0.2, 0.5), and a metre up.
  EXPECT_NEAR(glm::distance(X_RH->translation, glm::dvec3(-0.08, 0.2, 1.5)), 0.0, 1e-12);
}

// A target that was clipped on with its x axis ahead and 20 degrees down: of a head that looks straight ahead, DTrack
// sends the target's turn; what is given is the head's, so both eyes are level and beside each other.
TEST(DtrackHead, LooksWhereTheHeadDoesHoweverItsTargetIsMounted) {
  constexpr double kHalf_m = 0.0315;  // between the eyes
  const double dip = 20.0 * std::numbers::pi / 180.0;
  scene::User user = UserAt("127.0.0.1:0");
  // Columns: the target's axes in the head's (x to the right, y ahead, z up).
  const glm::dvec3 ahead(0, std::cos(dip), -std::sin(dip)), left(-1, 0, 0);
  const glm::dmat3 R_HB(ahead, left, glm::cross(ahead, left));
  user.X_BH = {glm::quat_cast(glm::transpose(R_HB)), {0.05, 0, 0.01}};
  auto head = DtrackHead::Create(user);
  ASSERT_TRUE(head) << head.error().detail;
  const Controller controller((*head)->port());
  char text[256];
  std::snprintf(text, sizeof text, "6d 1 [3 1.0][100 200 1500][%.9f %.9f %.9f %.9f %.9f %.9f %.9f %.9f %.9f]\r\n",
                R_HB[0][0], R_HB[0][1], R_HB[0][2], R_HB[1][0], R_HB[1][1], R_HB[1][2], R_HB[2][0], R_HB[2][1],
                R_HB[2][2]);
  controller.Send(text);
  const auto X_RH = WaitFor(head->get());
  ASSERT_TRUE(X_RH);
  const glm::dvec3 middle_R = glm::dvec3(0.1, 0.2, 1.5) + 0.05 * ahead + 0.01 * glm::cross(ahead, left);
  EXPECT_LT(glm::distance(*X_RH * glm::dvec3(kHalf_m, 0, 0), middle_R + glm::dvec3(kHalf_m, 0, 0)), 1e-8);
  EXPECT_LT(glm::distance(X_RH->rotate({0, 1, 0}), glm::dvec3(0, 1, 0)), 1e-8) << "ahead";
}

// Each pose is given once; a frame in which the body is not tracked, or another one is, has none.
TEST(DtrackHead, GivesOnlyWhatIsTrackedAndNew) {
  auto head = DtrackHead::Create(UserAt("127.0.0.1:0"));
  ASSERT_TRUE(head) << head.error().detail;
  const Controller controller((*head)->port());
  controller.Send("6d 1 [3 1.0][1000 0 0][1 0 0 0 1 0 0 0 1]\r\n");
  const auto first = WaitFor(head->get());
  ASSERT_TRUE(first);
  EXPECT_EQ(first->translation.x, 1.0);
  EXPECT_FALSE((*head)->Read(core::MonotonicNow_ns())) << "it was given already";
  controller.Send("6d 1 [3 -1.0][0 0 0][0 0 0 0 0 0 0 0 0]\r\n");
  controller.Send("6d 1 [4 1.0][5000 0 0][1 0 0 0 1 0 0 0 1]\r\n");  // another body
  bus::PeriodicLoop loop(core::kTick_ns);
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  while ((*head)->num_read() < 3 && core::MonotonicNow_ns() - begin_ns < kPatienceForAHead_ns) loop.WaitNext();
  ASSERT_EQ((*head)->num_read(), 3U);
  EXPECT_FALSE((*head)->Read(core::MonotonicNow_ns()));
}

TEST(DtrackHead, SaysWhatIsWrongWithItsAddress) {
  for (const char* address : {"", "port", "300.1.1.1:5000", "127.0.0.1:99999", "5000x"}) {
    const auto head = DtrackHead::Create(UserAt(address));
    ASSERT_FALSE(head) << address;
    EXPECT_NE(head.error().detail.find("user 'operator': address is '" + std::string(address)), std::string::npos)
        << head.error().detail;
  }
  auto first = DtrackHead::Create(UserAt("127.0.0.1:0"));
  ASSERT_TRUE(first);
  const auto second = DtrackHead::Create(UserAt("127.0.0.1:" + std::to_string((*first)->port())));
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().detail.find("does another program listen there"), std::string::npos);
}

}  // namespace
}  // namespace device_bridge
