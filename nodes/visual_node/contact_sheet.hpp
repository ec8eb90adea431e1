#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "picture/image.hpp"

namespace visual_node {

using picture::Image;

// One picture per procedure step, tiled in order of time with the steps' names below: the story of a run on one page.
class ContactSheet {
 public:
  static constexpr int kColumns = 3;

  // Pictures of the same name replace each other, so that a step which is entered again shows its last end.
  void Add(const std::string& name, const Image& picture);

  [[nodiscard]] std::size_t size() const { return tiles_.size(); }
  [[nodiscard]] core::Result<Image> Compose() const;  // the error names a missing font
  core::Result<void> Write(const std::filesystem::path& file) const;

 private:
  struct Tile {
    std::string name;
    Image picture;
  };
  std::vector<Tile> tiles_;
};

}  // namespace visual_node
