#include "nodes/haptic_physics_node/program.hpp"

#include <algorithm>
#include <memory>

#include "nodes/haptic_node/program.hpp"
#include "nodes/haptic_physics_node/pair_loop.hpp"
#include "nodes/physics_node/program.hpp"

namespace haptic_physics_node {
namespace {

// haptic_node, whose loop runs physics_node, too.
class Pair final : public haptic_node::Body {
 public:
  Pair(std::shared_ptr<HandOver> hand_over, physics_node::Body* physics)
      : haptic_node::Body(&hand_over->answer), hand_over_(std::move(hand_over)), physics_(physics) {}

  void Run(const std::atomic<bool>& stop) override { PairLoop(&loop(), &physics_->loop(), hand_over_.get()).Run(stop); }

 private:
  std::shared_ptr<HandOver> hand_over_;
  physics_node::Body* physics_;
};

}  // namespace

run_node::Program MakeProgram() {
  run_node::Program program = haptic_node::MakeProgram();
  program.name = "haptic_physics_node";
  program.summary = "haptic_node and physics_node in one process, one step after the other; 1 kHz";
  for (const cli::Option& option : physics_node::MakeProgram().options) {
    const bool is_known = std::any_of(program.options.begin(), program.options.end(),
                                      [&option](const cli::Option& known) { return known.name == option.name; });
    if (!is_known && option.name != "--name") program.options.push_back(option);
  }
  return program;
}

std::vector<run_node::Member> MakeMembers() {
  auto hand_over = std::make_shared<HandOver>();
  const run_node::Program haptic = haptic_node::MakeProgram(), physics = physics_node::MakeProgram();
  auto physics_body = std::make_unique<physics_node::Body>(&hand_over->cycle);
  auto pair = std::make_unique<Pair>(std::move(hand_over), physics_body.get());
  std::vector<run_node::Member> members;
  members.push_back({physics.name, physics.ready, std::move(physics_body)});
  members.push_back({haptic.name, haptic.ready, std::move(pair)});
  return members;
}

}  // namespace haptic_physics_node
