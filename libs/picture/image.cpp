#include "picture/image.hpp"

#include <png.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <system_error>

namespace picture {

Image Shrink(const Image& image, int factor) {
  Image small(image.width / factor, image.height / factor);
  const int count = factor * factor;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      int sum[4] = {count / 2, count / 2, count / 2, count / 2};
      for (int j = 0; j < factor; ++j) {
        for (int i = 0; i < factor; ++i) {
          const std::uint8_t* pixel = image.Pixel(x * factor + i, y * factor + j);
          for (int k = 0; k < 4; ++k) sum[k] += pixel[k];
        }
      }
      std::uint8_t* out = small.Pixel(x, y);
      for (int k = 0; k < 4; ++k) out[k] = static_cast<std::uint8_t>(sum[k] / count);
    }
  }
  return small;
}

void Paste(const Image& from, int x, int y, Image& to) {
  const int first = std::max(0, -x);
  const int last = std::min(from.width, to.width - x);
  if (first >= last) return;
  for (int row = std::max(0, -y); row < std::min(from.height, to.height - y); ++row) {
    std::memcpy(to.Pixel(x + first, y + row), from.Pixel(first, row), 4 * static_cast<std::size_t>(last - first));
  }
}

core::Result<Image> ReadPng(std::span<const std::byte> bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) == 0) {
    return core::Fail(core::ErrorCode::kDamaged, std::string("no PNG picture: ") + png.message);
  }
  png.format = PNG_FORMAT_RGBA;
  Image image(static_cast<int>(png.width), static_cast<int>(png.height));
  if (png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr) == 0) {
    return core::Fail(core::ErrorCode::kDamaged, std::string("a damaged PNG picture: ") + png.message);
  }
  return image;
}

core::Result<void> WritePng(const Image& image, const std::filesystem::path& file) {
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGBA;
  if (png_image_write_to_file(&png, file.c_str(), 0, image.rgba.data(), 0, nullptr) == 0) {
    return core::Fail(core::ErrorCode::kIo, "cannot write picture " + file.string() + ": " + png.message +
                                                "; is the folder there, writable, and the disk not full?");
  }
  return {};
}

}  // namespace picture
