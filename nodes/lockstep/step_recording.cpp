#include "nodes/lockstep/step_recording.hpp"

#include "replay/field_list.hpp"
#include "replay/open_step_log.hpp"

namespace lockstep {

bool StepRecording::Sink::Push(std::uint64_t tick, std::int64_t now_ns, std::span<const std::uint8_t> step) noexcept {
  if (done) done = file->Write(channel, tick, now_ns, step);
  return done.has_value();
}

core::Result<std::unique_ptr<StepRecording>> StepRecording::Create(const std::filesystem::path& path,
                                                                   const scene::Scenario& scenario,
                                                                   const physics_node::PhysicsNode& physics,
                                                                   const logic_node::LogicNode& logic) {
  auto file = bus::log::StepFile::Create(path);
  if (!file) return tl::unexpected(file.error());
  std::unique_ptr<StepRecording> recording(new StepRecording(std::move(*file)));
  bus::log::StepFile& to = *recording->file_;

  const bus::log::TextMap about = replay::DescribeRun(scenario);
  bus::log::TextMap about_physics = about;
  about_physics["content"] = std::to_string(physics.content_digest());
  recording->haptic_sink_.channel = to.AddNode("haptic_node", replay::DescribeFields<haptic_node::Step>(), about);
  recording->physics_sink_.channel =
      to.AddNode("physics_node", replay::DescribeFields<physics_node::Step>(), about_physics);
  recording->logic_sink_.channel = to.AddNode("logic_node", replay::DescribeFields<logic_node::Step>(), about);
  for (Sink* sink : {&recording->haptic_sink_, &recording->physics_sink_, &recording->logic_sink_}) sink->file = &to;

  if (physics.tick() == 0) return recording;
  physics_node::Snapshot snapshot;
  physics.Save(&snapshot);
  const auto encoded = physics_node::EncodeSnapshot(physics.content_digest(), snapshot);
  if (!encoded) return tl::unexpected(encoded.error());
  if (auto done = to.Attach(replay::CheckpointName("physics_node"), *encoded); !done) {
    return tl::unexpected(done.error());
  }
  if (auto done = to.Attach(replay::CheckpointName("logic_node"), logic.Save()); !done) {
    return tl::unexpected(done.error());
  }
  return recording;
}

core::Result<void> StepRecording::Close() {
  for (const Sink* sink : {&haptic_sink_, &physics_sink_, &logic_sink_}) {
    if (!sink->done) return sink->done;
  }
  return file_->Close();
}

}  // namespace lockstep
