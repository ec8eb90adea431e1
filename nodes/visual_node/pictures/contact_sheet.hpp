#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "picture/image.hpp"

namespace visual_node {

using picture::Image;

// One picture per procedure step, tiled in order of time with the steps' names below: a run on one page.
class ContactSheet {
 public:
  static constexpr int kColumns = 3;

  // A picture replaces the previous one of the same name, so a step that is entered again shows its last end.
  void Add(const std::string& name, const Image& picture);

  [[nodiscard]] std::size_t size() const { return tiles_.size(); }
  // Errors: kNotFound without a picture or when the font is missing.
  [[nodiscard]] core::Result<Image> Compose() const;
  // Composes and writes a PNG file.
  core::Result<void> Write(const std::filesystem::path& file) const;

 private:
  struct Tile {
    std::string name;
    Image picture;
  };
  std::vector<Tile> tiles_;
};

}  // namespace visual_node
