#include "view/scene.hpp"

namespace view {

int FindCamera(const Assets& assets, const std::string& name) {
  for (std::size_t i = 0; i < assets.cameras.size(); ++i) {
    if (assets.cameras[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace view
