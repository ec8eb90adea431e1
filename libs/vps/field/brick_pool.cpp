#include "vps/field/brick_pool.hpp"

#include <algorithm>
#include <utility>

#include "core/hash.hpp"

namespace vps {

std::uint64_t BrickPool::HashOf(Brick brick) {
  return core::Hash64(brick.data(), brick.size_bytes());
}

std::uint32_t BrickPool::Add(Brick brick, std::uint64_t hash) {
  const auto [entry, is_new] = first_of_hash_.try_emplace(hash, static_cast<std::uint32_t>(words_.size()));
  // Two bricks of one hash that differ are both kept; later ones are compared with the first only.
  if (!is_new && std::equal(brick.begin(), brick.end(), &words_[entry->second])) return entry->second;
  return AddDistinct(brick);
}

std::uint32_t BrickPool::AddDistinct(Brick brick) {
  const auto first = static_cast<std::uint32_t>(words_.size());
  words_.insert(words_.end(), brick.begin(), brick.end());
  return first;
}

std::vector<std::uint32_t> BrickPool::TakeWords() {
  first_of_hash_ = {};
  return std::move(words_);
}

}  // namespace vps
