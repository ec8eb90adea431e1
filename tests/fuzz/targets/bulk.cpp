#include <cerrno>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <zmq.hpp>

#include "bus/bulk/bulk_folder.hpp"
#include "bus/node_core.hpp"
#include "bus/wire/envelope.hpp"
#include "core/clock.hpp"
#include "proto/bulk.pb.h"
#include "tests/fuzz/bulk_blocks.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/quiet_protobuf.hpp"
#include "tests/fuzz/reader.hpp"
#include "tests/fuzz/scratch_folder.hpp"

namespace fuzz {
namespace {

namespace fs = std::filesystem;

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kSession = 7;
constexpr std::int64_t kPatience_ns = 10 * core::kNanosecondsPerSecond;
constexpr int kPatience_ms = 10'000;
constexpr int kMaxPieces = 6;  // fewer than would fill a socket's queue

bus::NodeOptions Options(const std::string& name) {
  bus::NodeOptions options;
  options.name = name;
  options.registry = "tcp://127.0.0.1:9";  // never used
  options.session = kSession;
  options.is_encrypted = false;
  return options;
}

Bytes InEnvelope(Input payload) {
  bus::Envelope envelope;
  envelope.topic_class = bus::TopicClass::kBulk;
  envelope.session = kSession;
  Bytes bytes(bus::kEnvelopeFixedBytes + payload.size());
  std::copy(payload.begin(), payload.end(), bytes.begin() + bus::kEnvelopeFixedBytes);
  bus::WriteEnvelope(envelope, payload.size(), bytes.data());
  return bytes;
}

Bytes InEnvelope(const oos::BulkMessage& message) {
  const std::string payload = message.SerializeAsString();
  return InEnvelope(Input(reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()));
}

// Repeats a call that the engine's timer signal has interrupted.
template <class Call>
auto Again(const Call& call) {
  for (;;) {
    try {
      return call();
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
    }
  }
}

// Offers a block to the code under test, which fetches it, and answers with the input's bytes.
class Owner {
 public:
  explicit Owner(const Bytes& block) : offer_{"block", bus::BulkHash(block), block.size(), {}} {
    router_.set(zmq::sockopt::linger, 0);
    router_.bind("tcp://127.0.0.1:*");
    offer_.endpoint = router_.get(zmq::sockopt::last_endpoint);
  }

  // The last message is a refusal with a unique text: when it arrives, all messages before have been processed.
  void Send(Reader* input) {
    if (!fetch_) Meet();
    for (int i = 0; i < kMaxPieces && !input->is_at_end(); ++i) {
      const Input piece = input->Piece();
      Send(Bytes(piece.begin(), piece.end()));
      Send(InEnvelope(piece));
    }
    oos::BulkMessage message;
    message.mutable_chunk()->set_hash(offer_.hash);
    message.mutable_chunk()->set_why("end of input " + std::to_string(++num_inputs_));
    Send(InEnvelope(message));
    const std::string end = message.chunk().why();
    for (;;) {
      const auto fetched = fetch_->Run(kPatience_ns);
      TakeRequests();
      if (fetched) {
        Claim(bus::BulkHash(*fetched) == offer_.hash, "what is fetched is what was offered");
        fetch_.reset();
        return;
      }
      Claim(fetched.error().code != core::ErrorCode::kTimeout, "every message is processed");
      if (fetched.error().detail.ends_with(end)) return;
    }
  }

 private:
  void Meet() {
    fetch_.emplace(offer_, "owner", Options("viewer"));
    asker_.clear();
    while (asker_.empty()) {
      (void)fetch_->Run(1'000'000);
      TakeRequests();
    }
  }
  void TakeRequests() {
    zmq::message_t routing, request;
    while (Again([&] { return router_.recv(routing, zmq::recv_flags::dontwait); }) &&
           Again([&] { return router_.recv(request); })) {
      asker_ = routing.to_string();
    }
  }
  void Send(const Bytes& bytes) {
    Again([&] { return router_.send(zmq::buffer(asker_), zmq::send_flags::sndmore); });
    Again([&] { return router_.send(zmq::buffer(bytes), zmq::send_flags::none); });
  }

  bus::BulkOffer offer_;
  zmq::context_t context_{1};
  zmq::socket_t router_{context_, zmq::socket_type::router};
  std::optional<bus::BulkFetch> fetch_;
  std::string asker_;
  std::uint64_t num_inputs_ = 0;
};

// Sends the input's bytes as requests to the code under test, which offers a block.
class Requester {
 public:
  Requester()
      : node_(*bus::Node::Create(Options("owner"))), server_(*bus::BulkServer::Create(node_.get(), Options("owner"))) {
    endpoint_ = server_->Offer("block", block_)->endpoint;
    dealer_.set(zmq::sockopt::linger, 0);
    dealer_.set(zmq::sockopt::rcvtimeo, kPatience_ms);
    dealer_.connect(endpoint_);
  }

  void SendRequests(Reader* input) {
    for (int i = 0; i < kMaxPieces && !input->is_at_end(); ++i) {
      const Input piece = input->Piece();
      Send(Bytes(piece.begin(), piece.end()));
      Send(InEnvelope(piece));
    }
    oos::BulkMessage message;
    message.mutable_request()->set_hash("end of input " + std::to_string(++num_inputs_));
    Send(InEnvelope(message));
    while (TakeChunk().hash() != message.request().hash()) {
    }
  }

  // Fetches a folder whose owner sends this list of files. Whatever their names, nothing may be written outside.
  void FetchFolder(const std::string& list) {
    static const ScratchFolder scratch;
    const fs::path inside = scratch.path() / "inside";
    const bus::BulkOffer nothing{"", bus::BulkHash({}), 0, endpoint_};
    list_.assign(list.begin(), list.end());
    (void)server_->Offer("folder", list_);  // served even if the announcement fails
    bus::StateReader<bus::BulkOffer> offers;
    const auto accept = [&offers](const std::string& name, const bus::BulkOffer& offer) {
      bus::detail::StateAccess::Accept(&offers, name, 1, offer);
    };
    accept("folder", {"folder", bus::BulkHash(list_), list_.size(), endpoint_});
    // Files outside are not offered: nothing there is overwritten even when the claim does not hold.
    bool is_all_inside = true;
    std::istringstream lines(list);
    for (std::string line; std::getline(lines, line);) {
      const fs::path place = (inside / line).lexically_normal().lexically_relative(inside);
      if (fs::path(line).is_absolute() || (!place.empty() && *place.begin() == "..")) {
        is_all_inside = false;
      } else {
        accept("folder/" + line, nothing);
      }
    }
    const auto fetched =
        bus::FetchFolder(node_.get(), offers, Options("viewer"), "owner", "folder", inside, kPatience_ns);
    Claim(fetched || fetched.error().code != core::ErrorCode::kTimeout,
          "a path that leaves its folder is not requested");
    Claim(!fetched || is_all_inside, "a path that leaves its folder is refused");
    fs::remove_all(inside);
    Claim(fs::is_empty(scratch.path()), "nothing is written beside the folder");
  }

 private:
  oos::BulkChunk TakeChunk() {
    zmq::message_t answer;
    Claim(Again([&] { return dealer_.recv(answer); }).has_value(), "a request is answered");
    bus::Envelope envelope;
    Input payload;
    oos::BulkMessage message;
    Claim(bus::ReadEnvelope({answer.data<std::uint8_t>(), answer.size()}, &envelope, &payload) ==
                  bus::EnvelopeStatus::kOk &&
              message.ParseFromArray(payload.data(), static_cast<int>(payload.size())) && message.has_chunk(),
          "an answer can be read");
    const std::string& data = message.chunk().data();
    const std::uint64_t offset = message.chunk().offset();
    const auto is_of = [&](const Bytes& block) {
      return message.chunk().hash() == bus::BulkHash(block) && offset + data.size() <= block.size() &&
             TextOf(Input(block).subspan(offset, data.size())) == data;
    };
    Claim(data.empty() || is_of(block_) || is_of(list_), "an answer is of the block");
    return message.chunk();
  }
  void Send(const Bytes& bytes) {
    Again([&] { return dealer_.send(zmq::buffer(bytes), zmq::send_flags::none); });
  }

  const Bytes block_ = LargeBlock();
  Bytes list_;  // the file list of the last folder; also offered as a block
  std::unique_ptr<bus::Node> node_;
  std::unique_ptr<bus::BulkServer> server_;
  std::string endpoint_;
  zmq::context_t context_{1};
  zmq::socket_t dealer_{context_, zmq::socket_type::dealer};
  std::uint64_t num_inputs_ = 0;
};

}  // namespace

// The input's first byte selects what a foreign machine sends: the chunks of a block (small or large), requests for
// one, an offer, or a folder's file list.
void FuzzBulk(Input input) {
  QuietProtobuf();
  static Owner small(SmallBlock());
  static Owner large(LargeBlock());
  static Requester requester;
  Reader reader(input);
  switch (reader.Byte() % 5) {
    case 0:
      return small.Send(&reader);
    case 1:
      return large.Send(&reader);
    case 2:
      return requester.SendRequests(&reader);
    case 3: {
      bus::BulkOffer offer, again;
      if (!bus::DecodeState(TextOf(reader.Rest()), &offer)) return;
      std::string bytes;
      bus::EncodeState(offer, &bytes);
      Claim(bus::DecodeState(bytes, &again) && again.name == offer.name && again.hash == offer.hash &&
                again.size == offer.size && again.endpoint == offer.endpoint,
            "an offer that was written can be read");
      return;
    }
    case 4:
      return requester.FetchFolder(TextOf(reader.Rest()));
  }
}

}  // namespace fuzz
