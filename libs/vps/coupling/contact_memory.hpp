#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "core/fixed_vector.hpp"
#include "core/pose.hpp"

namespace vps {

// A linearised contact of the tool, as collision found it.
struct ToolPlane {
  std::uint32_t id = 0;    // stable from cycle to cycle while the contact lasts
  std::uint16_t body = 0;  // of the environment: its object's index
  glm::dvec3 p_W{0.0};     // point of the tool
  glm::dvec3 n_W{0.0};     // unit, from the body to the tool
  double gap_m = 0.0;      // of the point from the body along n; negative: penetrating
  double friction = 0.0;
};

// Not derived: with more planes the first ones are taken. A third of that may fade. Together they are kMaxHalfSpaces,
// and the time for a cycle grows with them.
constexpr std::size_t kMaxToolPlanes = 96;
constexpr std::size_t kMaxFadingContacts = 32;

// What the tool may do at one place in this cycle.
struct HeldContact {
  std::uint32_t id = 0;
  std::uint16_t body = 0;
  glm::dvec3 p_W{0.0};
  glm::dvec3 n_W{0.0};
  double gap_m = 0.0;  // less than 0: the tool is to be moved out
  double friction = 0.0;
  glm::dvec3 slip_W{0.0};                                   // along the plane, from where it sticks to its body
  double most_N = std::numeric_limits<double>::infinity();  // of the normal force, while the contact fades out
  // On the tool: of the last cycle, until the solver puts this cycle's.
  double normal_N = 0.0;
  glm::dvec3 tangent_W_N{0.0};
  double limit_N = 0.0;  // of tangent_W_N, in this cycle

  // How it came about.
  bool is_turned = false;  // lies on the side of a wall that the tool came from, not on the one that collision found
  int cycles_lost = 0;     // since collision found it
  double fading_N = 0.0;   // the normal force with which it was lost
  double offset_m = 0.0;   // of gap_m from what collision found
};

// The tool's contacts from cycle to cycle, by id. It adds to what collision finds in one cycle
//   friction's anchors: a contact sticks to the place of its body where the last cycle has left it;
//   fading in: a plane that comes up inside the tool, or moves by itself, is taken at the place where it does not
//     change the force, and led to its own place within some milliseconds;
//   fading out: a contact that carried a force and is gone stays, with a falling limit of its force;
//   the side: a thin wall that the tool has just come to the other side of still pushes it back.
// Allocates nothing.
class ContactMemory {
 public:
  void Reset();

  // Contacts of this cycle, found with the tool at X_WC, where the last cycle has left it, and the bodies at X_WO.
  void Take(std::span<const ToolPlane> planes, const core::Pose& X_WC, std::span<const core::Pose> X_WO) noexcept;
  std::span<HeldContact> contacts() { return {now().begin(), now().size()}; }
  [[nodiscard]] std::span<const HeldContact> contacts() const { return {now().begin(), now().size()}; }
  // Once the contacts have their forces, and they and the tool have been moved from X_WC_found.
  void Keep(const core::Pose& X_WC_found, std::span<const core::Pose> X_WO) noexcept;

 private:
  static constexpr std::size_t kMost = kMaxToolPlanes + kMaxFadingContacts;
  using Contacts = core::FixedVector<HeldContact, kMost>;
  struct Body {
    std::uint16_t index = 0;
    core::Pose X_WE;    // in the last cycle
    core::Pose motion;  // since then
  };

  void MoveKept(std::span<const core::Pose> X_WO);
  [[nodiscard]] const Body* FindBody(std::uint16_t index) const;
  HeldContact* FindKept(std::uint32_t id);
  [[nodiscard]] const HeldContact* WallBetween(const ToolPlane& plane, const HeldContact* same,
                                               const core::Pose& X_WC) const;
  void AddFading();

  [[nodiscard]] const Contacts& now() const { return buffers_[now_]; }
  [[nodiscard]] Contacts& now() { return buffers_[now_]; }
  // Of the last cycle; once moved, where they are now.
  [[nodiscard]] const Contacts& kept() const { return buffers_[1 - now_]; }
  [[nodiscard]] Contacts& kept() { return buffers_[1 - now_]; }

  std::array<Contacts, 2> buffers_;
  std::size_t now_ = 0;
  core::FixedVector<Body, kMost> bodies_;
  core::Pose X_WC_found_;  // the tool, when collision found the kept ones
  std::array<bool, kMost> is_continued_{};
  std::size_t next_ = 0;  // where FindKept looks first: planes come in about the same order as in the last cycle
};

}  // namespace vps
