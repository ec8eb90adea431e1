#include "picture/measured.hpp"

#include <png.h>

#include <bit>
#include <fstream>
#include <system_error>

namespace picture {
namespace {

static_assert(std::endian::native == std::endian::little, "a float map is written as it is in memory");

void MakeFolderOf(const std::filesystem::path& file) {
  std::error_code ignored;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
}

}  // namespace

core::Result<void> WritePng(const Measured<std::uint16_t>& image, const std::filesystem::path& file) {
  MakeFolderOf(file);
  const auto fail = [&] {
    return core::Fail(core::ErrorCode::kIo, "cannot write picture " + file.string() +
                                                "; is the folder there, writable, and the disk not full?");
  };
  // libpng's simple interface takes 16 bits as linear light and writes another gamma, so this is the long one.
  std::FILE* out = std::fopen(file.c_str(), "wb");
  if (out == nullptr) return fail();
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  bool is_written = false;
  if (setjmp(png_jmpbuf(png)) == 0) {  // libpng comes back here after an error
    png_init_io(png, out);
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 16,
                 PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_set_swap(png);
    for (int y = 0; y < image.height; ++y) png_write_row(png, reinterpret_cast<png_const_bytep>(image.Pixel(0, y)));
    png_write_end(png, nullptr);
    is_written = true;
  }
  png_destroy_write_struct(&png, &info);
  const bool is_closed = std::fclose(out) == 0;
  if (!is_written || !is_closed) return fail();
  return {};
}

core::Result<void> WritePfm(const Measured<float>& image, const std::filesystem::path& file) {
  MakeFolderOf(file);
  std::ofstream out(file, std::ios::binary);
  out << (image.channels == 3 ? "PF" : "Pf") << "\n" << image.width << " " << image.height << "\n-1.0\n";
  const auto row_bytes = static_cast<std::streamsize>(sizeof(float)) * image.width * image.channels;
  for (int y = image.height - 1; y >= 0; --y) out.write(reinterpret_cast<const char*>(image.Pixel(0, y)), row_bytes);
  if (out.flush()) return {};
  return core::Fail(core::ErrorCode::kIo,
                    "cannot write " + file.string() + "; is the folder there, writable, and the disk not full?");
}

}  // namespace picture
