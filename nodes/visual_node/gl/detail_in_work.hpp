#pragma once

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "nodes/visual_node/gl/detail_levels.hpp"

namespace visual_node {

// Makes the levels of detail of meshes in a thread, so that the first picture does not wait for them.
class DetailInWork {
 public:
  struct Made {
    vps::VisualMesh mesh;  // with the vertices of all levels
    std::vector<Piece> pieces;
  };
  explicit DetailInWork(std::vector<vps::VisualMesh> meshes);
  ~DetailInWork();
  DetailInWork(const DetailInWork&) = delete;
  DetailInWork& operator=(const DetailInWork&) = delete;

  // Once, when it is done: by mesh.
  std::optional<std::vector<Made>> Take();

 private:
  std::atomic<bool> is_stop_wanted_{false};
  std::atomic<bool> is_done_{false};
  std::vector<Made> made_;  // belongs to the thread until it is done
  std::thread thread_;
};

}  // namespace visual_node
