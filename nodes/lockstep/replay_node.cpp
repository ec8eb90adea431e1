#include "nodes/lockstep/replay_node.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/step_log.hpp"
#include "bus/topics.hpp"
#include "core/parallel_for.hpp"
#include "nodes/haptic_node/haptic_node.hpp"
#include "nodes/haptic_node/step.hpp"
#include "nodes/logic_node/logic_node.hpp"
#include "nodes/logic_node/step.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "nodes/physics_node/step.hpp"
#include "replay/field_list.hpp"
#include "replay/open_step_log.hpp"

namespace lockstep {
namespace {

// "contacts[12].planes.size" is item 12 of "contacts", field "planes.size".
struct Path {
  std::string head;
  std::optional<std::size_t> index;
  std::string rest;
};

Path Split(const std::string& path) {
  Path split;
  const std::size_t end = std::min(path.find_first_of(".["), path.size());
  split.head = path.substr(0, end);
  std::size_t next = end;
  if (end < path.size() && path[end] == '[') {
    std::size_t index = 0;
    const auto [after, error] = std::from_chars(path.data() + end + 1, path.data() + path.size(), index);
    if (error == std::errc() && *after == ']') split.index = index;
    next = std::min(path.find(']', end) + 1, path.size());
  }
  if (next < path.size() && path[next] == '.') ++next;
  split.rest = path.substr(next);
  return split;
}

std::string RoleOf(const scene::Scenario& scenario, const Path& path) {
  return path.index && *path.index < scenario.devices.size() ? scenario.devices[*path.index].role : "*";
}

template <class StepType>
class TypedNode : public ReplayedNode {
 public:
  explicit TypedNode(const scene::Scenario& scenario) : scenario_(scenario) {}

  bool Read(std::span<const std::uint8_t> step) override {
    kind_ = replay::StepKind(step);
    if (kind_ >= num_kinds()) return false;
    replay::StepDecoder& decoder = decoders_[kind_];
    if (!decoder.Begin(step)) return false;
    decoder.includes_transport = true;
    VisitInputs(decoder, recorded_);
    decoder.includes_transport = false;
    VisitOutputs(decoder, recorded_);
    return decoder.Finish();
  }
  [[nodiscard]] std::uint64_t tick() const override { return decoders_[kind_].tick(); }
  [[nodiscard]] std::int64_t now_ns() const override { return recorded_.inputs.now_ns; }
  [[nodiscard]] std::uint64_t recorded_digest() const override { return decoders_[kind_].digest(); }
  [[nodiscard]] std::uint64_t digest() const override {
    replay::Digest digest;
    digest.includes_transport = false;
    VisitOutputs(digest, const_cast<StepType&>(got_));
    return digest.value();
  }
  std::vector<replay::Leaf> RecordedOutputs() override { return LeavesOf(recorded_); }
  std::vector<replay::Leaf> Outputs() override { return LeavesOf(got_); }

  [[nodiscard]] std::string ThingOf(const std::string& path) const override {
    const Path top = Split(path);
    if (top.head != "state") return "";
    const Path item = Split(top.rest);
    if (!item.index) return "";
    if (item.head == "mechanisms" && *item.index < scenario_.mechanisms.size()) {
      return scenario_.mechanisms[*item.index].name;
    }
    std::size_t body = 0;
    for (const scene::Object& object : scenario_.objects) {
      if (object.owner == scene::Owner::kPhysics && body++ == *item.index) return object.name;
    }
    return "";
  }

 protected:
  static constexpr std::uint8_t kMaxKinds = 2;
  [[nodiscard]] virtual std::uint8_t num_kinds() const { return 1; }

  static std::vector<replay::Leaf> LeavesOf(StepType& step) {
    replay::Leaves leaves;
    leaves.includes_transport = false;
    VisitOutputs(leaves, step);
    return leaves.all();
  }

  // Changes of parameters beside those that the step's inputs point to.
  template <class Inputs>
  static void Append(const core::ParameterChange& change, std::vector<core::ParameterChange>* memory, Inputs* inputs) {
    memory->push_back(change);
    inputs->changes = memory->data();
    inputs->num_changes = memory->size();
  }

  scene::Scenario scenario_;
  std::array<replay::StepDecoder, kMaxKinds> decoders_;
  std::uint8_t kind_ = replay::kUsualStep;
  StepType recorded_;  // inputs and outputs as they were
  StepType got_;       // outputs of the replay
};

class Physics final : public TypedNode<physics_node::Step> {
 public:
  using TypedNode::TypedNode;

  core::Result<void> Make(const RecordedNode& recorded, const ReplayOptions& options) {
    physics_node::Options physics_options;
    physics_options.collision.cache = options.cache;
    physics_options.collision.progress = options.say;
    auto physics = physics_node::PhysicsNode::Create(scenario_, physics_options);
    if (!physics) return tl::unexpected(physics.error());
    physics_ = std::move(*physics);
    physics_->sheets().set_runner(&sheets_);
    if (recorded.checkpoint.empty()) return {};
    const auto content = recorded.about.find("content");
    const std::uint64_t digest =
        content == recorded.about.end() ? 0 : std::strtoull(content->second.c_str(), nullptr, 10);
    // A scenario that was changed on purpose may still be tried, so the digest is the recording's; Restore looks
    // whether the state fits.
    physics_node::Snapshot snapshot;
    if (auto read = physics_node::DecodeSnapshot(recorded.checkpoint, digest, &snapshot); !read) return read;
    return physics_->Restore(&snapshot);
  }

  [[nodiscard]] std::string WhyNot() const override {
    if (physics_->tick() + 1 == tick()) return "";
    return "the recording goes on with tick " + std::to_string(tick()) + ", physics_node stands at tick " +
           std::to_string(physics_->tick());
  }
  void AddChange(const core::ParameterChange& change) override {
    Append(change, &recorded_.changes, &recorded_.inputs);
    ++num_added_;
  }
  void Step() override {
    sheets_.is_late = recorded_.is_sheet_late;
    physics_->Step(recorded_.inputs, &got_.outputs);
    // What came of changes that were added is not of the recording.
    auto& outcomes = got_.outputs.outcomes;
    outcomes.resize(outcomes.size() - std::min(std::exchange(num_added_, 0), outcomes.size()));
  }
  [[nodiscard]] std::string NameOf(const std::string& path) const override {
    const Path top = Split(path);
    const std::string topic = top.head == "state"       ? bus::kPhysicsStateTopic
                              : top.head == "reactions" ? bus::ReactionTopic(RoleOf(scenario_, top))
                              : top.head == "outcomes"  ? bus::kParameterTopic
                                                        : bus::kEventTopic;
    return topic + ":" + top.rest;
  }

 private:
  // Sheets' steps are done at once, but taken for late where they were late.
  class Sheets final : public physics_node::SheetRunner {
   public:
    void Start(void (*step)(void*), void* context) override { step(context); }
    [[nodiscard]] bool IsIdle() const override { return !is_late; }
    void WaitUntilIdle() override {}
    bool is_late = false;
  };
  Sheets sheets_;
  std::size_t num_added_ = 0;
  std::unique_ptr<physics_node::PhysicsNode> physics_;
};

class Haptic final : public TypedNode<haptic_node::Step> {
 public:
  using TypedNode::TypedNode;

  core::Result<void> Make(const RecordedNode&, const ReplayOptions& options) {
    haptic_node::Options haptic_options;
    haptic_options.collision.cache = options.cache;
    haptic_options.collision.progress = options.say;
    auto haptic = haptic_node::HapticNode::Create(scenario_, workers_, haptic_options);
    if (!haptic) return tl::unexpected(haptic.error());
    haptic_ = std::move(*haptic);
    haptic_->PrepareOutputs(&got_.outputs);
    haptic_->PrepareOutputs(&recorded_.outputs);
    return {};
  }

  [[nodiscard]] std::string WhyNot() const override {
    if (kind_ == haptic_node::kReevaluation && haptic_->cycle() == tick()) return "";
    if (kind_ == haptic_node::kReevaluation || haptic_->cycle() + 1 != tick()) {
      return "the recording goes on with cycle " + std::to_string(tick()) + ", haptic_node stands at cycle " +
             std::to_string(haptic_->cycle());
    }
    if (recorded_.pairs_late == 0) return "";
    return "in cycle " + std::to_string(tick()) + " time ran short and " + std::to_string(recorded_.pairs_late) +
           " pairs were left for later; what follows cannot be repeated";
  }
  void AddChange(const core::ParameterChange& change) override {
    Append(change, &recorded_.changes, &recorded_.inputs);
  }
  void Step() override {
    if (kind_ == haptic_node::kReevaluation) return haptic_->Reevaluate(recorded_.inputs, &got_.outputs);
    haptic_->Step(recorded_.inputs, &got_.outputs);
  }
  [[nodiscard]] std::string NameOf(const std::string& path) const override {
    const Path top = Split(path);
    const bool is_pair = top.index && *top.index < scenario_.pairs.size();
    const std::string topic =
        top.head == "commands"  ? bus::DeviceCommandTopic(RoleOf(scenario_, top))
        : top.head == "proxies" ? bus::HapticProxyTopic(RoleOf(scenario_, top))
        : top.head == "contacts" || top.head == "updated"
            ? bus::ContactsTopic("haptic_node", is_pair ? scenario_.PairName(*top.index) : std::string("*"))
            : "haptic_node";
    return topic + ":" + (top.rest.empty() ? top.head : top.rest);
  }

 protected:
  [[nodiscard]] std::uint8_t num_kinds() const override { return haptic_node::kReevaluation + 1; }

 private:
  core::SerialFor workers_;
  std::unique_ptr<haptic_node::HapticNode> haptic_;
};

class Logic final : public TypedNode<logic_node::Step> {
 public:
  using TypedNode::TypedNode;

  core::Result<void> Make(const RecordedNode& recorded, const ReplayOptions&) {
    auto logic = logic_node::LogicNode::Create(scenario_);
    if (!logic) return tl::unexpected(logic.error());
    logic_ = std::move(*logic);
    return recorded.checkpoint.empty() ? core::Result<void>{} : logic_->Restore(recorded.checkpoint);
  }

  [[nodiscard]] std::string WhyNot() const override {
    if (last_tick_ == 0 || last_tick_ + 1 == tick()) return "";
    return "steps are missing: step " + std::to_string(tick()) + " comes after step " + std::to_string(last_tick_);
  }
  void AddChange(const core::ParameterChange&) override {}
  void Step() override {
    last_tick_ = tick();
    logic_->Step(recorded_.inputs, &got_.outputs);
  }
  [[nodiscard]] std::string NameOf(const std::string& path) const override {
    const Path top = Split(path);
    const bool is_status = top.head == "status" || top.head == "is_status_changed";
    const std::string topic = is_status               ? bus::kLogicStatusTopic
                              : top.head == "changes" ? bus::kParameterTopic
                                                      : bus::kEventTopic;
    return topic + ":" + (top.rest.empty() ? top.head : top.rest);
  }

 private:
  std::unique_ptr<logic_node::LogicNode> logic_;
  std::uint64_t last_tick_ = 0;
};

template <class Node, class StepType>
core::Result<std::unique_ptr<ReplayedNode>> MakeNode(const RecordedNode& recorded, const scene::Scenario& scenario,
                                                     const ReplayOptions& options) {
  if (recorded.fields != replay::DescribeFields<StepType>()) {
    return core::Fail(
        core::ErrorCode::kUnsupported,
        "the steps of " + recorded.node +
            " were recorded by a version of this program whose messages had other fields; replay them with "
            "that version, or record again");
  }
  auto node = std::make_unique<Node>(scenario);
  if (auto made = node->Make(recorded, options); !made) return tl::unexpected(made.error());
  return node;
}

}  // namespace

core::Result<std::vector<RecordedNode>> ReadRecordedNodes(const std::filesystem::path& file) {
  const auto contents = bus::log::ReadMcap(file, [](const bus::log::Channel&, const bus::log::Message&) {});
  if (!contents) return tl::unexpected(contents.error());
  std::vector<RecordedNode> nodes;
  for (const auto& [id, channel] : contents->channels) {
    if (channel.message_encoding != "oos-step") continue;
    RecordedNode recorded;
    const auto writer = channel.metadata.find("writer");
    if (writer != channel.metadata.end()) recorded.node = writer->second;
    if (const auto schema = contents->schemas.find(channel.schema_id); schema != contents->schemas.end()) {
      recorded.fields.assign(schema->second.data.begin(), schema->second.data.end());
    }
    for (const bus::log::Metadata& metadata : contents->metadata) {
      if (metadata.name == "replay/" + recorded.node) recorded.about = metadata.entries;
    }
    for (const bus::log::Attachment& attachment : contents->attachments) {
      if (attachment.name == replay::CheckpointName(recorded.node)) recorded.checkpoint = attachment.data;
    }
    nodes.push_back(std::move(recorded));
  }
  return nodes;
}

core::Result<std::unique_ptr<ReplayedNode>> ReplayedNode::Create(const RecordedNode& recorded,
                                                                 const scene::Scenario& scenario,
                                                                 const ReplayOptions& options) {
  if (recorded.node == "physics_node") return MakeNode<Physics, physics_node::Step>(recorded, scenario, options);
  if (recorded.node == "haptic_node") return MakeNode<Haptic, haptic_node::Step>(recorded, scenario, options);
  if (recorded.node == "logic_node") return MakeNode<Logic, logic_node::Step>(recorded, scenario, options);
  return core::Fail(core::ErrorCode::kUnsupported, "'" + recorded.node +
                                                       "' cannot be replayed in lock-step; logic_node, physics_node "
                                                       "and haptic_node can");
}

}  // namespace lockstep
