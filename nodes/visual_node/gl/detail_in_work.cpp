#include "nodes/visual_node/gl/detail_in_work.hpp"

#include <utility>

namespace visual_node {

DetailInWork::DetailInWork(std::vector<vps::VisualMesh> meshes)
    : thread_([this, meshes = std::move(meshes)]() mutable {
        for (vps::VisualMesh& mesh : meshes) {
          if (is_stop_wanted_) return;
          Made& made = made_.emplace_back();
          made.mesh = std::move(mesh);
          made.pieces = MakePieces(&made.mesh, &is_stop_wanted_);
        }
        is_done_ = true;
      }) {}

DetailInWork::~DetailInWork() {
  is_stop_wanted_ = true;
  thread_.join();
}

std::optional<std::vector<DetailInWork::Made>> DetailInWork::Take() {
  if (!is_done_.exchange(false)) return std::nullopt;
  return std::exchange(made_, {});
}

}  // namespace visual_node
