// Sending and receiving on the real-time thread must not allocate once warm.

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "bus/node.hpp"
#include "bus/registry.hpp"
#include "core/clock.hpp"

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

namespace {

thread_local std::size_t allocations = 0;

void* Allocate(std::size_t size) {
  ++allocations;
  void* const memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  return Allocate(size);
}
void* operator new[](std::size_t size) {
  return Allocate(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace bus {
namespace {

std::unique_ptr<Node> MakeNode(const std::string& name, const std::string& registry) {
  NodeOptions options;
  options.name = name;
  options.registry = registry;
  return std::move(*Node::Create(options));
}

TEST(Node, RealTimeCallsDoNotAllocateOnceWarm) {
  const auto registry = std::move(*Registry::Create({}));
  const auto haptic = MakeNode("haptic_node", registry->endpoint());
  const auto physics = MakeNode("physics_node", registry->endpoint());
  auto contacts_writer = haptic->WriteLatest<core::ContactSet>(ContactsTopic("haptic_node", "a/b"));
  auto state_writer = physics->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto& contacts_reader = physics->ReadLatest<core::ContactSet>(ContactsTopic("haptic_node", "a/b"));
  auto& state_reader = haptic->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  ASSERT_TRUE(haptic->Start().has_value());
  ASSERT_TRUE(physics->Start().has_value());
  while (!contacts_writer.has_subscribers() || !state_writer.has_subscribers()) {
  }
  core::ContactSet contacts;
  contacts.planes.resize(core::kMaxContactPlanes);
  core::PhysicsState state;
  state.bodies.resize(core::kMaxBodies);
  state.mechanisms.resize(core::kMaxMechanisms);
  const core::Event event{0, "physics_node", "attach", "module_old to gripper"};
  const auto cycle = [&] {
    contacts_writer.Send(contacts);
    physics->Wait(core::MonotonicNow_ns() + core::kNanosecondsPerSecond);
    state_writer.Send(state);
    haptic->Wait(core::MonotonicNow_ns() + core::kNanosecondsPerSecond);
    physics->Emit(event);
  };
  for (int i = 0; i < 10; ++i) cycle();
  const std::size_t before = allocations;
  for (int i = 0; i < 200; ++i) cycle();
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_EQ(contacts_reader.value().header.sequence, 210u);
  EXPECT_EQ(state_reader.value().header.sequence, 210u);
}

}  // namespace
}  // namespace bus

#endif
