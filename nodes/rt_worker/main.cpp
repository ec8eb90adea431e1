#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <optional>

#include "nodes/rt_worker/worker.hpp"
#include "nodes/run_node/run_node.hpp"
#include "tiles/seats.hpp"
#include "view/scene_mirror.hpp"

namespace {

constexpr int kDrawingNice = 10;  // as visual_node's drawing

class WorkerBody final : public run_node::Body {
 public:
  core::Result<void> Build(const run_node::Setting& setting) override {
    const view::SceneMirror mirror(setting.scenario);
    auto drawer = rt_worker::Drawer::Create(
        mirror.scene(), [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
    if (!drawer) return tl::unexpected(drawer.error());
    drawer_.emplace(std::move(*drawer));
    return {};
  }
  core::Result<void> Connect(bus::Node* node, const bus::NodeOptions& /*options*/) override {
    const auto place = tiles::ReadWorkerName(node->name());
    if (!place) return tl::unexpected(place.error());
    worker_.emplace(place->viewer, place->seat, &*drawer_, node);
    return {};
  }
  // The force loop, and whoever shows the picture, come first.
  void OnStart() override {
    const sched_param none{};
    sched_setscheduler(0, SCHED_BATCH, &none);
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kDrawingNice);
  }
  void Run(const std::atomic<bool>& stop) override { worker_->Run(stop); }
  core::Result<void> WriteReport(bool /*is_realtime*/) override {
    std::printf("%llu tiles\n", static_cast<unsigned long long>(worker_->num_tiles()));
    return {};
  }

 private:
  std::optional<rt_worker::Drawer> drawer_;
  std::optional<rt_worker::Worker> worker_;
};

}  // namespace

int main(int argc, char** argv) {
  run_node::Program program;
  program.name = "rt_worker";
  program.summary = "draws tiles of the pictures of a viewer that traces rays (rt_visual_node), on one core";
  program.options = {{"--name", "rt_worker-VIEWER-SEAT", "whose tiles it draws, and on which of its seats, from 1 on",
                      tiles::WorkerName("visual_node", 1)}};
  program.can_record_steps = false;
  return run_node::RunNode(argc, argv, program, std::make_unique<WorkerBody>());
}
