#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "bus/figures.hpp"
#include "bus/testing/make_node.hpp"

// Readers that come and go at random while writers change their state all the time.
namespace bus::testing {

class Joins {
 public:
  struct Result {
    std::vector<double> complete_ms;  // from before the node was made until it had the whole state, sorted
  };

  explicit Joins(std::uint64_t seed) : random_(seed), registry_(MakeRegistry()) {
    for (std::size_t w = 0; w < kWriters; ++w) {
      Writer& writer = writers_[w];
      writer.name = "writer_" + std::to_string(w);
      writer.node = MakeNode(writer.name, registry_->endpoint());
      writer.figures = writer.node->WriteState<Figures>(FiguresTopic(writer.name));
      EXPECT_TRUE(writer.node->Start().has_value());
      for (std::size_t key = 0; key < kKeys; ++key) Change(writer, key);
    }
  }

  Result Run(std::size_t num_joins) {
    Result result;
    std::size_t joined = 0;
    while (joined < num_joins || !readers_.empty()) {
      for (Writer& writer : writers_) {
        if (random_() % 4 == 0) Change(writer, random_() % kKeys);
        if (random_() % 8 == 0 && writer.node->Emit({0, writer.name, "count", std::to_string(writer.emitted + 1)})) {
          ++writer.emitted;
        }
        Serve(*writer.node);
      }
      if (joined < num_joins && readers_.size() < kAtOnce) {
        Join(joined++);
      }
      for (std::size_t r = 0; r < readers_.size(); ++r) {
        Reader& reader = *readers_[r];
        CheckNews(reader);
        if (!reader.is_complete && IsComplete(reader)) {
          reader.is_complete = true;
          result.complete_ms.push_back(static_cast<double>(core::MonotonicNow_ns() - reader.born_ns) * 1e-6);
        }
        const std::int64_t age_ns = core::MonotonicNow_ns() - reader.born_ns;
        EXPECT_LT(age_ns, kLong_ns) << reader.node->name() << " has not got the whole state";
        const bool is_given_up = age_ns > kLong_ns;
        const bool leaves = reader.is_complete && random_() % 16 == 0;
        // Some leave before they have got everything.
        if (leaves || is_given_up || (reader.is_impatient && random_() % 64 == 0)) {
          readers_.erase(readers_.begin() + static_cast<std::ptrdiff_t>(r));
          break;
        }
      }
    }
    // At the end every remaining reader has exactly what was written, and all accounts agree.
    for (std::size_t i = 0; i < kAtOnce; ++i) Join(num_joins + i);
    EXPECT_TRUE(Until([&] {
      bool are_equal = true;
      for (Writer& writer : writers_) Serve(*writer.node);
      for (const auto& reader : readers_) {
        CheckNews(*reader);
        are_equal = are_equal && IsEqual(*reader);
      }
      return are_equal;
    }));
    std::vector<Node*> nodes;
    for (const Writer& writer : writers_) nodes.push_back(writer.node.get());
    for (const auto& reader : readers_) nodes.push_back(reader->node.get());
    ExpectAccountsClose(nodes);
    std::sort(result.complete_ms.begin(), result.complete_ms.end());
    return result;
  }

 private:
  static constexpr std::size_t kWriters = 3, kKeys = 8, kAtOnce = 3;

  struct Writer {
    std::string name;
    std::unique_ptr<Node> node;
    StateWriter<Figures> figures;
    std::array<double, kKeys> values{};
    std::uint64_t emitted = 0;
  };
  struct Reader {
    std::unique_ptr<Node> node;
    std::array<StateReader<Figures>*, kWriters> figures{};
    std::array<std::array<double, kKeys>, kWriters> at_birth{}, seen{};
    std::array<std::uint64_t, kWriters> version{};
    std::map<std::string, std::uint64_t> event;
    std::int64_t born_ns = 0;
    bool is_complete = false;
    bool is_impatient = false;
  };

  void Change(Writer& writer, std::size_t key) {
    if (writer.figures.Set({{{"n", writer.values[key] + 1}}}, "key " + std::to_string(key))) ++writer.values[key];
  }

  static void Serve(Node& node) {
    node.Wait(core::MonotonicNow_ns() + 200'000);
    core::Event event;
    while (node.PollEvent(&event)) {
    }
  }

  void Join(std::size_t number) {
    auto reader = std::make_unique<Reader>();
    reader->born_ns = core::MonotonicNow_ns();
    for (std::size_t w = 0; w < kWriters; ++w) reader->at_birth[w] = writers_[w].values;
    reader->is_impatient = random_() % 8 == 0;
    NodeOptions options;
    options.name = "viewer_" + std::to_string(number);
    options.registry = registry_->endpoint();
    options.session = 7;
    options.is_encrypted = false;
    options.is_observer = random_() % 2 == 0;
    // A node that dies without goodbye stays in the others' lists of dead peers, unless it was an observer.
    options.sends_goodbye = !options.is_observer || random_() % 2 == 0;
    reader->node = std::move(*Node::Create(options));
    reader->node->ReadEvents();
    for (std::size_t w = 0; w < kWriters; ++w) {
      reader->figures[w] = &reader->node->ReadState<Figures>(FiguresTopic(writers_[w].name));
    }
    EXPECT_TRUE(reader->node->Start(0).has_value());
    readers_.push_back(std::move(reader));
  }

  // Nothing arrives twice, no change is undone, no event is missing.
  static void CheckNews(Reader& reader) {
    reader.node->Wait(core::MonotonicNow_ns() + 200'000);
    for (std::size_t w = 0; w < kWriters; ++w) {
      if (!reader.figures[w]->is_fresh()) continue;
      EXPECT_GT(reader.figures[w]->version(), reader.version[w]) << "a change came twice";
      reader.version[w] = reader.figures[w]->version();
      for (std::size_t key = 0; key < kKeys; ++key) {
        const double now = Value(reader, w, key);
        EXPECT_GE(now, reader.seen[w][key]) << "a change was undone";
        reader.seen[w][key] = now;
      }
    }
    core::Event event;
    while (reader.node->PollEvent(&event)) {
      EXPECT_NE(event.name, "events_missed");
      if (event.name != "count") continue;
      std::uint64_t& last = reader.event[event.source];
      const std::uint64_t number = std::stoull(event.detail);
      if (last != 0) {
        EXPECT_EQ(number, last + 1) << "of " << event.source;
      }
      last = number;
    }
  }

  static double Value(const Reader& reader, std::size_t w, std::size_t key) {
    const auto& values = reader.figures[w]->values();
    const auto found = values.find("key " + std::to_string(key));
    return found == values.end() ? 0.0 : *FindFigure(found->second, "n");
  }
  static bool IsComplete(const Reader& reader) {
    for (std::size_t w = 0; w < kWriters; ++w) {
      for (std::size_t key = 0; key < kKeys; ++key) {
        if (Value(reader, w, key) < reader.at_birth[w][key]) return false;
      }
    }
    return true;
  }
  bool IsEqual(const Reader& reader) const {
    for (std::size_t w = 0; w < kWriters; ++w) {
      for (std::size_t key = 0; key < kKeys; ++key) {
        if (Value(reader, w, key) != writers_[w].values[key]) return false;
      }
    }
    return true;
  }

  std::mt19937_64 random_;
  std::unique_ptr<Registry> registry_;
  std::array<Writer, kWriters> writers_;
  std::vector<std::unique_ptr<Reader>> readers_;
};

}  // namespace bus::testing
