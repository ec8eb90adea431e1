#include "bus/bulk/bulk_folder.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "core/clock.hpp"

namespace bus {
namespace {

namespace fs = std::filesystem;

core::Result<std::vector<std::uint8_t>> ReadBytes(const fs::path& path) {
  std::error_code error;
  const bool is_file = fs::is_regular_file(path, error);  // reading a folder throws
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes;
  if (is_file) bytes.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  if (!is_file || !file.is_open() || file.bad()) {
    return core::Fail(core::ErrorCode::kIo, path.string() + " cannot be read; does it exist, and is it readable?");
  }
  return bytes;
}

core::Result<void> WriteBytes(const fs::path& path, const std::vector<std::uint8_t>& bytes) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) return {};
  return core::Fail(core::ErrorCode::kIo,
                    path.string() + " cannot be written; is there room, and may you write there?");
}

// The names come from another machine and become paths here: none may leave the folder.
bool StaysInside(const fs::path& path) {
  return !path.empty() && path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

}  // namespace

core::Result<void> OfferFolder(const fs::path& folder, const std::string& name, BulkServer* server) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator item(folder, error), end; !error && item != end; item.increment(error)) {
    if (item->is_regular_file(error)) files.push_back(fs::relative(item->path(), folder, error));
  }
  if (error) return core::Fail(core::ErrorCode::kIo, folder.string() + ": " + error.message());
  std::sort(files.begin(), files.end());
  std::string list;
  for (const fs::path& path : files) {
    auto bytes = ReadBytes(folder / path);
    if (!bytes) return tl::unexpected(bytes.error());
    if (auto offered = server->Offer(name + "/" + path.generic_string(), std::move(*bytes)); !offered) {
      return tl::unexpected(offered.error());
    }
    list += path.generic_string() + "\n";
  }
  auto offered = server->Offer(name, {list.begin(), list.end()});
  if (!offered) return tl::unexpected(offered.error());
  return {};
}

core::Result<std::size_t> FetchFolder(Node* node, const StateReader<BulkOffer>& offers, const NodeOptions& options,
                                      const std::string& owner, const std::string& name, const fs::path& folder,
                                      std::int64_t timeout_ns) {
  const std::int64_t deadline = core::MonotonicNow_ns() + timeout_ns;
  const auto fetch = [&](const std::string& wanted) -> core::Result<BulkOffer> {
    while (offers.values().count(wanted) == 0) {
      if (core::MonotonicNow_ns() > deadline) {
        return core::Fail(core::ErrorCode::kTimeout, owner + " does not offer '" + wanted + "'" +
                                                         (node->IsAlive(owner) ? "" : "; it is not alive"));
      }
      node->Wait(core::MonotonicNow_ns() + core::kTick_ns);
    }
    return offers.values().at(wanted);
  };
  const auto content = [&](const BulkOffer& offer) {
    return BulkFetch(offer, owner, options).Run(std::max<std::int64_t>(deadline - core::MonotonicNow_ns(), 1));
  };
  const auto list_offer = fetch(name);
  if (!list_offer) return tl::unexpected(list_offer.error());
  const auto list = content(*list_offer);
  if (!list) return tl::unexpected(list.error());
  std::istringstream lines(std::string(list->begin(), list->end()));
  std::size_t num_files = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!StaysInside(line)) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        owner + " offers '" + line + "', a path that leaves its folder");
    }
    const auto offer = fetch(name + "/" + line);
    if (!offer) return tl::unexpected(offer.error());
    ++num_files;
    if (const auto here = ReadBytes(folder / line); here && BulkHash(*here) == offer->hash) continue;
    const auto bytes = content(*offer);
    if (!bytes) return tl::unexpected(bytes.error());
    if (auto written = WriteBytes(folder / line, *bytes); !written) return tl::unexpected(written.error());
  }
  return num_files;
}

}  // namespace bus
