#include "bus/bulk/bulk.hpp"

#include <pthread.h>
#include <sodium.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <map>
#include <mutex>
#include <thread>
#include <zmq.hpp>

#include "bus/node_impl.hpp"
#include "bus/reliable/routed.hpp"
#include "bus/security/gate.hpp"
#include "bus/wire/control.hpp"
#include "bus/wire/envelope.hpp"
#include "core/clock.hpp"
#include "proto/bulk.pb.h"
#include "proto/bus.pb.h"

namespace bus {
namespace {

constexpr std::uint64_t kChunkBytes = std::uint64_t{64} << 10;
constexpr std::size_t kChunkCredit = 8;  // requested and not here yet: 512 KiB in flight fill a gigabit link over 4 ms
// Long against 512 KiB on a slow link, so that chunks that are only late do not travel twice.
constexpr std::int64_t kRequestAgainAfter_ns = 300'000'000;
constexpr int kLinger_ms = 0;

std::vector<std::uint8_t> Encode(const detail::Identity& identity, const oos::BulkMessage& message) {
  Envelope envelope;
  envelope.topic_class = TopicClass::kBulk;
  envelope.session = identity.session;
  envelope.node = identity.node;
  const std::size_t payload = message.ByteSizeLong();
  std::vector<std::uint8_t> bytes(kEnvelopeFixedBytes + payload);
  message.SerializeWithCachedSizesToArray(bytes.data() + kEnvelopeFixedBytes);
  WriteEnvelope(envelope, payload, bytes.data());
  return bytes;
}

bool Decode(const zmq::message_t& bytes, std::uint64_t session, oos::BulkMessage* message) {
  Envelope envelope;
  std::span<const std::uint8_t> payload;
  return bytes.size() <= detail::kMaxMessageBytes &&
         ReadEnvelope({bytes.data<std::uint8_t>(), bytes.size()}, &envelope, &payload) == EnvelopeStatus::kOk &&
         envelope.session == session && envelope.topic_class == TopicClass::kBulk &&
         message->ParseFromArray(payload.data(), static_cast<int>(payload.size()));
}

core::Result<std::optional<Keys>> KeysOf(const NodeOptions& options) {
  if (!options.is_encrypted) return std::optional<Keys>();
  auto keys = LoadKeys(options.keys, options.name);
  if (!keys) return tl::unexpected(keys.error());
  return std::optional<Keys>(std::move(*keys));
}

}  // namespace

std::string BulkHash(std::span<const std::uint8_t> bytes) {
  std::array<std::uint8_t, 32> hash;
  crypto_generichash(hash.data(), hash.size(), bytes.data(), bytes.size(), nullptr, 0);
  std::array<char, 2 * hash.size() + 1> text;
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  return text.data();
}

// --- Server

struct BulkServer::Impl {
  using Block = std::shared_ptr<const std::vector<std::uint8_t>>;
  ~Impl() {
    if (thread.joinable()) {
      is_stopping.store(true);
      const std::uint64_t one = 1;
      [[maybe_unused]] const ssize_t written = write(wake_fd, &one, sizeof(one));
      thread.join();
    }
    if (wake_fd >= 0) close(wake_fd);
  }
  void Run();
  void Serve();
  void Answer(const std::string& routing, const oos::BulkRequest& request);

  NodeOptions options;
  detail::Identity identity;
  std::optional<Keys> keys;
  StateWriter<BulkOffer> offers;
  zmq::context_t context{1};
  detail::Gate gate;
  zmq::socket_t router;
  std::string endpoint;
  int wake_fd = -1;
  std::thread thread;
  std::atomic<bool> is_stopping{false};
  std::atomic<std::uint64_t> num_chunks{0};
  std::uint64_t refused_messages = 0;
  std::shared_ptr<std::atomic<std::uint64_t>> refused;  // connections and messages; the node shows them
  std::mutex mutex;
  std::map<std::string, Block> blocks;         // by hash
  std::map<std::string, std::string> by_name;  // name -> hash
};

BulkServer::BulkServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BulkServer::~BulkServer() = default;

core::Result<std::unique_ptr<BulkServer>> BulkServer::Create(Node* node, const NodeOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->identity = {options.session, TopicId(options.name), 0};
  auto keys = KeysOf(options);
  if (!keys) return tl::unexpected(keys.error());
  impl->keys = std::move(*keys);
  impl->offers = node->WriteState<BulkOffer>(BulkTopic(options.name));
  impl->refused = node->impl_->core.refused_bulk;
  try {
    impl->gate.Open(&impl->context, impl->keys);
    impl->router = zmq::socket_t(impl->context, zmq::socket_type::router);
    impl->router.set(zmq::sockopt::router_mandatory, true);
    impl->router.set(zmq::sockopt::linger, kLinger_ms);
    // Far more than one reader's credit: libzmq notices late which messages have left its queue, and a chunk that finds
    // the queue full is lost until its repeated request.
    impl->router.set(zmq::sockopt::sndhwm, static_cast<int>(16 * kChunkCredit));
    impl->gate.GuardListener(&impl->router);
    impl->router.bind("tcp://" + options.bind_address + ":*");
    impl->endpoint = impl->router.get(zmq::sockopt::last_endpoint);
  } catch (const zmq::error_t& error) {
    return core::Fail(core::ErrorCode::kIo, "node " + options.name + ": BULK socket on " + options.bind_address + ": " +
                                                error.what() + "; is that an address of this machine?");
  }
  impl->wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (impl->wake_fd < 0) return core::Fail(core::ErrorCode::kResource, "eventfd: too many open files");
  sigset_t all, before;  // signals go to the node's other threads
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  impl->thread = std::thread([raw = impl.get()] { raw->Run(); });
  pthread_setname_np(impl->thread.native_handle(), "bulk-io");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return std::unique_ptr<BulkServer>(new BulkServer(std::move(impl)));
}

core::Result<BulkOffer> BulkServer::Offer(const std::string& name, std::vector<std::uint8_t> bytes) {
  if (bytes.size() > kMaxBulkBytes) {
    return core::Fail(core::ErrorCode::kInvalidInput, name + " has " + std::to_string(bytes.size()) +
                                                          " bytes; a block may have " + std::to_string(kMaxBulkBytes) +
                                                          "; split it");
  }
  const BulkOffer offer{name, BulkHash(bytes), bytes.size(), impl_->endpoint};
  {
    const std::lock_guard lock(impl_->mutex);
    std::string& hash = impl_->by_name[name];
    const std::string before = std::exchange(hash, offer.hash);
    const bool is_still_offered = std::any_of(impl_->by_name.begin(), impl_->by_name.end(),
                                              [&](const auto& other) { return other.second == before; });
    if (!is_still_offered) impl_->blocks.erase(before);
    impl_->blocks[offer.hash] = std::make_shared<const std::vector<std::uint8_t>>(std::move(bytes));
  }
  if (impl_->offers.Set(offer, name)) return offer;
  return core::Fail(core::ErrorCode::kResource, name +
                                                    " is not announced: the queue to the bus thread is full; offer it "
                                                    "again a moment later");
}

std::uint64_t BulkServer::num_chunks() const {
  return impl_->num_chunks.load(std::memory_order_relaxed);
}

std::uint64_t BulkServer::num_refused() const {
  return impl_->refused->load(std::memory_order_relaxed);
}

void BulkServer::Impl::Run() {
  std::vector<zmq::pollitem_t> items;
  while (!is_stopping.load()) {
    items.clear();
    items.push_back({router.handle(), 0, ZMQ_POLLIN, 0});
    items.push_back({nullptr, wake_fd, ZMQ_POLLIN, 0});
    gate.AddPollItems(&items);
    zmq_poll(items.data(), static_cast<int>(items.size()), -1);
    gate.Serve();
    Serve();
    refused->store(gate.refused() + refused_messages, std::memory_order_relaxed);
  }
  router.close();
  gate.Close();
}

void BulkServer::Impl::Serve() {
  zmq::message_t routing, bytes;
  while (detail::ReceiveRouted(&router, &routing, &bytes)) {
    oos::BulkMessage message;
    if (Decode(bytes, options.session, &message) && message.has_request()) {
      Answer(routing.to_string(), message.request());
    } else {
      ++refused_messages;
    }
  }
}

void BulkServer::Impl::Answer(const std::string& routing, const oos::BulkRequest& request) {
  Block block;
  {
    const std::lock_guard lock(mutex);
    const auto found = blocks.find(request.hash());
    if (found != blocks.end()) block = found->second;
  }
  oos::BulkMessage message;
  oos::BulkChunk* chunk = message.mutable_chunk();
  chunk->set_hash(request.hash());
  chunk->set_offset(request.offset());
  if (block == nullptr) {
    chunk->set_why(options.name + " does not offer it (any more)");
  } else if (request.offset() < block->size()) {
    const std::uint64_t size = std::min(kChunkBytes, block->size() - request.offset());
    chunk->set_data(block->data() + request.offset(), size);
  }
  const auto bytes = Encode(identity, message);
  try {  // a reader that is too slow requests it again
    if (!router.send(zmq::buffer(routing), zmq::send_flags::sndmore | zmq::send_flags::dontwait)) return;
    if (router.send(zmq::buffer(bytes), zmq::send_flags::dontwait)) num_chunks.fetch_add(1, std::memory_order_relaxed);
  } catch (const zmq::error_t&) {
  }
}

// --- Fetching

struct BulkFetch::Impl {
  struct Chunk {
    std::int64_t requested_ns = 0;  // 0: not yet
    bool is_here = false;
  };
  core::Result<void> Connect();
  void RequestChunks();
  std::string Take();  // the owner's reason when it refuses
  std::string DescribeRefused() const;

  BulkOffer offer;
  std::string owner;
  NodeOptions options;
  std::optional<Keys> keys;
  detail::Identity identity;
  std::optional<zmq::context_t> context;
  zmq::socket_t dealer;
  std::vector<std::uint8_t> bytes;
  std::vector<Chunk> chunks;
  std::size_t num_here = 0;
  std::uint64_t num_refused = 0;
  Account account;
};

BulkFetch::BulkFetch(BulkOffer offer, const std::string& owner, const NodeOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->offer = std::move(offer);
  impl_->owner = owner;
  impl_->options = options;
  impl_->identity = {options.session, TopicId(options.name), 0};
  impl_->account.topic = impl_->offer.name;
  impl_->account.topic_class = TopicClass::kBulk;
  impl_->account.peer = owner;
}

BulkFetch::~BulkFetch() {
  impl_->dealer.close();
}

const Account& BulkFetch::account() const {
  return impl_->account;
}

std::uint64_t BulkFetch::num_refused() const {
  return impl_->num_refused;
}

void BulkFetch::MoveTo(const std::string& endpoint) {
  impl_->dealer.close();
  impl_->offer.endpoint = endpoint;
}

core::Result<void> BulkFetch::Impl::Connect() {
  auto loaded = KeysOf(options);
  if (!loaded) return tl::unexpected(loaded.error());
  try {
    keys = std::move(*loaded);
    if (!context) context.emplace(1);
    dealer = zmq::socket_t(*context, zmq::socket_type::dealer);
    dealer.set(zmq::sockopt::linger, kLinger_ms);
    dealer.set(zmq::sockopt::immediate, true);
    dealer.set(zmq::sockopt::reconnect_ivl, 20);
    dealer.set(zmq::sockopt::reconnect_ivl_max, 500);
    detail::GuardConnection(&dealer, keys, keys ? keys->PublicKeyOf(owner) : "");
    dealer.connect(offer.endpoint);
  } catch (const zmq::error_t& error) {
    return core::Fail(core::ErrorCode::kIo, "BULK of " + owner + " at '" + offer.endpoint + "': " + error.what());
  }
  return {};
}

core::Result<std::vector<std::uint8_t>> BulkFetch::Run(std::int64_t timeout_ns) {
  Impl& it = *impl_;
  const std::string what = it.offer.name + " of " + it.owner;
  if (it.offer.size > kMaxBulkBytes) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      what + ": " + std::to_string(it.offer.size) + " bytes are too many");
  }
  it.bytes.resize(it.offer.size);
  it.chunks.resize((it.offer.size + kChunkBytes - 1) / kChunkBytes);
  if (!it.dealer) {
    if (auto connected = it.Connect(); !connected) return tl::unexpected(connected.error());
    for (Impl::Chunk& chunk : it.chunks) chunk.requested_ns = chunk.is_here ? chunk.requested_ns : 0;
    it.account.dropped[static_cast<std::size_t>(DropReason::kLost)] = it.account.sent - it.account.received;
  }
  const std::int64_t deadline = core::MonotonicNow_ns() + timeout_ns;
  while (it.num_here < it.chunks.size()) {
    const std::int64_t left = deadline - core::MonotonicNow_ns();
    if (left <= 0) {
      return core::Fail(core::ErrorCode::kTimeout, what + ": " + std::to_string(it.num_here) + " of " +
                                                       std::to_string(it.chunks.size()) + " chunks came within " +
                                                       std::to_string(timeout_ns / 1'000'000) + " ms" +
                                                       it.DescribeRefused());
    }
    it.RequestChunks();
    zmq::pollitem_t item{it.dealer.handle(), 0, ZMQ_POLLIN, 0};
    zmq_poll(&item, 1, static_cast<long>(std::clamp<std::int64_t>(left / 1'000'000, 1, 20)));
    if (const std::string why = it.Take(); !why.empty()) return core::Fail(core::ErrorCode::kIo, what + ": " + why);
  }
  if (BulkHash(it.bytes) != it.offer.hash) {
    it.chunks.assign(it.chunks.size(), {});  // none of it can be trusted
    it.num_here = 0;
    return core::Fail(core::ErrorCode::kIo, what + ": its content does not match its hash; fetch it again");
  }
  return it.bytes;
}

std::string BulkFetch::Impl::DescribeRefused() const {
  return num_refused == 0 ? "" : "; " + std::to_string(num_refused) + " messages from there were not chunks of a block";
}

void BulkFetch::Impl::RequestChunks() {
  const std::int64_t now = core::MonotonicNow_ns();
  std::size_t on_their_way = 0;
  for (std::size_t i = 0; i < chunks.size() && on_their_way < kChunkCredit; ++i) {
    Chunk& chunk = chunks[i];
    if (chunk.is_here) continue;
    ++on_their_way;
    if (chunk.requested_ns != 0 && now - chunk.requested_ns < kRequestAgainAfter_ns) continue;
    oos::BulkMessage message;
    message.mutable_request()->set_hash(offer.hash);
    message.mutable_request()->set_offset(i * kChunkBytes);
    const auto request = Encode(identity, message);
    try {
      if (!dealer.send(zmq::buffer(request), zmq::send_flags::dontwait)) return;  // not connected yet
    } catch (const zmq::error_t&) {
      return;
    }
    if (chunk.requested_ns != 0) ++account.dropped[static_cast<std::size_t>(DropReason::kLost)];
    ++account.sent;
    chunk.requested_ns = now;
  }
}

std::string BulkFetch::Impl::Take() {
  zmq::message_t received;
  while (dealer.recv(received, zmq::recv_flags::dontwait)) {
    oos::BulkMessage message;
    if (!Decode(received, options.session, &message) || !message.has_chunk()) {
      ++num_refused;
      continue;
    }
    const oos::BulkChunk& chunk = message.chunk();
    const std::size_t place = static_cast<std::size_t>(chunk.offset() / kChunkBytes);
    const bool is_of_block = chunk.hash() == offer.hash;
    if (is_of_block && !chunk.why().empty()) return chunk.why();
    if (!is_of_block || chunk.offset() % kChunkBytes != 0 || place >= chunks.size() ||
        chunk.data().size() != std::min(kChunkBytes, offer.size - chunk.offset())) {
      ++num_refused;
      continue;
    }
    if (chunks[place].is_here) continue;
    std::copy(chunk.data().begin(), chunk.data().end(), bytes.begin() + static_cast<std::ptrdiff_t>(chunk.offset()));
    chunks[place].is_here = true;
    ++num_here;
    ++account.received;
  }
  return {};
}

}  // namespace bus
