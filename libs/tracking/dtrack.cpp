#include "tracking/dtrack.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <span>

namespace tracking {
namespace {

constexpr double kMetre_per_mm = 1e-3;
constexpr double kRad_per_deg = std::numbers::pi / 180.0;
constexpr int kMostBodies = 256;         // of a line; a datagram has no room for more
constexpr double kTurnTolerance = 1e-2;  // of R^T R from the identity: three digits are sent
constexpr int kButtonsPerNumber = 32;

// Reads a line from left to right. After a mistake every read fails, and `why` says what was wrong.
class LineReader {
 public:
  explicit LineReader(std::string_view line) : rest_(line) {}

  bool Number(double* value) {
    SkipBlanks();
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), *value);
    if (error != std::errc() || !std::isfinite(*value)) return Fail("a number is missing or is none");
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return true;
  }
  bool Count(int most, int* value) {
    double number = 0.0;
    if (!Number(&number)) return false;
    if (number < 0.0 || number > most || number != std::floor(number)) {
      return Fail("a count is not a whole number from 0 to " + std::to_string(most));
    }
    *value = static_cast<int>(number);
    return true;
  }
  // "[1 2 3]"; numbers beyond those asked for are passed over.
  bool Block(std::span<double> numbers) {
    SkipBlanks();
    const std::size_t end = rest_.find(']');
    if (rest_.empty() || rest_.front() != '[' || end == std::string_view::npos) return Fail("a block is cut off");
    LineReader inside(rest_.substr(1, end - 1));
    for (double& number : numbers) {
      if (!inside.Number(&number)) return Fail("a block has too few numbers, or one that is none");
    }
    rest_.remove_prefix(end + 1);
    return true;
  }
  bool Fail(std::string why) {
    if (why_.empty()) why_ = std::move(why);
    rest_ = {};
    return false;
  }
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  void SkipBlanks() {
    while (!rest_.empty() && rest_.front() == ' ') rest_.remove_prefix(1);
  }

  std::string_view rest_;
  std::string why_;
};

// "[x y z][b0 .. b8]": mm, and the rotation matrix by columns.
bool ReadPose(LineReader* line, bool is_tracked, core::Pose* X) {
  std::array<double, 3> p{};
  std::array<double, 9> b{};
  if (!line->Block(p) || !line->Block(b)) return false;
  if (!is_tracked) return true;  // zeros
  const glm::dmat3 R(b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7], b[8]);
  const glm::dmat3 off = glm::transpose(R) * R - glm::dmat3(1.0);
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(off[i][j]));
  }
  if (!(largest < kTurnTolerance) || glm::determinant(R) < 0.0) return line->Fail("a matrix is no rotation");
  *X = {glm::normalize(glm::quat_cast(R)), kMetre_per_mm * glm::dvec3(p[0], p[1], p[2])};
  return true;
}

bool IsId(double number) {
  return number >= 0.0 && number <= 1e6 && number == std::floor(number);
}

// The rest of a line that begins with the number of its entries.
template <class Entry>
void ReadEntries(LineReader* line, std::vector<Entry>* entries, bool (*read)(LineReader*, Entry*)) {
  int count = 0;
  if (!line->Count(kMostBodies, &count)) return;
  for (int i = 0; i < count; ++i) {
    Entry entry;
    if (!read(line, &entry)) return;
    entries->push_back(std::move(entry));
  }
}

// "[id qu]" and a pose.
bool ReadBody(LineReader* line, TrackedBody* body) {
  std::array<double, 2> head{};
  if (!line->Block(head)) return false;
  if (!IsId(head[0])) return line->Fail("an id is no count");
  body->id = static_cast<int>(head[0]);
  body->quality = head[1];
  return ReadPose(line, body->is_tracked(), &body->X_TB);
}

// "[id st er]" and a pose, of a body that may have an inertial sensor: 0 if neither cameras nor sensor track it, and
// the sensor's drift.
bool ReadHybrid(LineReader* line, TrackedBody* body) {
  std::array<double, 3> head{};
  if (!line->Block(head)) return false;
  if (!IsId(head[0])) return line->Fail("an id is no count");
  body->id = static_cast<int>(head[0]);
  body->quality = head[1] > 0.0 ? 1.0 : -1.0;
  return ReadPose(line, body->is_tracked(), &body->X_TB);
}

// "[id qu nbt nct]", a pose, and "[bt.. ct..]": each number bt has 32 buttons.
bool ReadFlystick(LineReader* line, TrackedFlystick* stick) {
  std::array<double, 4> head{};
  if (!line->Block(head)) return false;
  const auto most_controllers = static_cast<double>(stick->controllers.size());
  if (!IsId(head[0]) || !IsId(head[2]) || head[2] > kMostBodies || !IsId(head[3]) || head[3] > most_controllers) {
    return line->Fail("id, buttons or controllers of a Flystick are no counts, or too many");
  }
  stick->body.id = static_cast<int>(head[0]);
  stick->body.quality = head[1];
  stick->num_buttons = static_cast<int>(head[2]);
  stick->num_controllers = static_cast<int>(head[3]);
  if (!ReadPose(line, stick->body.is_tracked(), &stick->body.X_TB)) return false;
  const int num_words = (stick->num_buttons + kButtonsPerNumber - 1) / kButtonsPerNumber;
  std::vector<double> state(static_cast<std::size_t>(num_words + stick->num_controllers));
  if (!line->Block(state)) return false;
  // Signed or not, it is 32 bits.
  if (num_words > 0 && std::abs(state[0]) < 4294967296.0) {
    stick->buttons = static_cast<std::uint32_t>(static_cast<std::int64_t>(state[0]));
  }
  for (int i = 0; i < stick->num_controllers; ++i) {
    stick->controllers[static_cast<std::size_t>(i)] = state[static_cast<std::size_t>(num_words + i)];
  }
  return true;
}

// A pose, and "[radius outer angle middle angle inner]".
bool ReadFinger(LineReader* line, bool is_tracked, TrackedFinger* finger) {
  std::array<double, 6> sizes{};
  if (!ReadPose(line, is_tracked, &finger->X_BF) || !line->Block(sizes)) return false;
  finger->radius_m = kMetre_per_mm * sizes[0];
  finger->outer_m = kMetre_per_mm * sizes[1];
  finger->outer_middle_rad = kRad_per_deg * sizes[2];
  finger->middle_m = kMetre_per_mm * sizes[3];
  finger->middle_inner_rad = kRad_per_deg * sizes[4];
  finger->inner_m = kMetre_per_mm * sizes[5];
  return true;
}

// "[id qu lr nf]", a pose, and the fingers.
bool ReadHand(LineReader* line, TrackedHand* hand) {
  constexpr double kMostFingers = 5.0;
  std::array<double, 4> head{};
  if (!line->Block(head)) return false;
  if (!IsId(head[0]) || (head[2] != 0.0 && head[2] != 1.0) || !IsId(head[3]) || head[3] > kMostFingers) {
    return line->Fail("id, side or fingers of a hand are not what they may be");
  }
  hand->body.id = static_cast<int>(head[0]);
  hand->body.quality = head[1];
  hand->is_right = head[2] == 1.0;
  if (!ReadPose(line, hand->body.is_tracked(), &hand->body.X_TB)) return false;
  hand->fingers.resize(static_cast<std::size_t>(head[3]));
  for (TrackedFinger& finger : hand->fingers) {
    if (!ReadFinger(line, hand->body.is_tracked(), &finger)) return false;
  }
  return true;
}

void ReadLine(std::string_view kind, LineReader* line, DtrackFrame* frame) {
  double number = 0.0;
  int count = 0;
  if (kind == "fr") {
    if (line->Number(&number) && number >= 0.0 && number < 4294967296.0) {
      frame->number = static_cast<std::uint32_t>(number);
    }
  } else if (kind == "ts") {
    if (line->Number(&number) && number >= 0.0) frame->time_s = number;
  } else if (kind == "6dcal") {
    if (line->Count(kMostBodies, &count)) frame->num_calibrated = count;
  } else if (kind == "6d") {
    ReadEntries<TrackedBody>(line, &frame->bodies, ReadBody);
  } else if (kind == "6di") {
    ReadEntries<TrackedBody>(line, &frame->bodies, ReadHybrid);
  } else if (kind == "6df2") {
    // The number of calibrated ones comes before that of the entries.
    if (line->Count(kMostBodies, &count)) ReadEntries<TrackedFlystick>(line, &frame->flysticks, ReadFlystick);
  } else if (kind == "gl") {
    ReadEntries<TrackedHand>(line, &frame->hands, ReadHand);
  }
}

}  // namespace

DtrackFrame ParseDtrack(std::string_view datagram, std::vector<std::string>* complaints) {
  DtrackFrame frame;
  for (int number = 1; !datagram.empty(); ++number) {
    const std::size_t end = std::min(datagram.find('\n'), datagram.size());
    std::string_view text = datagram.substr(0, end);
    datagram.remove_prefix(std::min(end + 1, datagram.size()));
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    const std::size_t blank = std::min(text.find(' '), text.size());
    LineReader line(text.substr(blank));
    ReadLine(text.substr(0, blank), &line, &frame);
    if (!line.why().empty()) {
      complaints->push_back("line " + std::to_string(number) + " (" + std::string(text.substr(0, blank)) +
                            "): " + line.why());
    }
  }
  return frame;
}

}  // namespace tracking
