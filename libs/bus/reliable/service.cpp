// SERVICE: parameter calls, both ends. All on the bus thread, with the node's mutex held.
//
// A request without an answer is sent again. The owner recognizes a repetition by the caller's instance and request
// number: it repeats its answer and applies the change once. After the caller's deadline it does not apply it.

#include <algorithm>

#include "bus/bus_thread.hpp"
#include "core/clock.hpp"
#include "core/names.hpp"

namespace bus::detail {
namespace {

// Ten heartbeats: an owner in the roster that has just started becomes alive within that time.
constexpr std::int64_t kWaitForOwners_ns = 500 * core::kMillisecond_ns;
// Well above a round trip with an owner's tick in it; ten tries fit the default deadline of 1 s.
constexpr std::int64_t kRepeatAfter_ns = 100 * core::kMillisecond_ns;
// Answers kept for repetitions: with the default deadline of 1 s, all of them up to a thousand calls per second.
constexpr std::size_t kMaxServed = 1'024;

}  // namespace

// --- Owner's side

void BusThread::TakeRequest(const std::string& routing, const oos::ParameterRequest& request) {
  const auto [item, is_new] = served_.try_emplace({request.caller_instance(), request.request()});
  Served& served = item->second;
  served.routing = routing;
  if (!is_new) {
    if (served.is_answered) SendReply(served);
    return;
  }
  served_order_.push_back(item->first);
  if (served_order_.size() > kMaxServed) {
    served_.erase(served_order_.front());
    served_order_.pop_front();
  }
  Account& account =
      core_->book.Open(kParameterTopic, TopicClass::kService, request.caller(), request.caller_instance(), false, 0);
  ++account.sent;
  ++account.received;
  served.reply.set_request(request.request());
  const std::string why = FindFault(request);
  if (!why.empty()) {
    served.reply.set_why(why);
    SendReply(served);
    return;
  }
  ParameterItem* slot = core_->parameters_in.BeginPush();
  if (slot == nullptr) {
    served.reply.set_why(core_->options.name + " has too many changes waiting; is its loop running?");
    SendReply(served);
    return;
  }
  slot->ticket = next_ticket_++;
  DecodeState(request.change().SerializeAsString(), &slot->change);
  slot->deadline_ns = request.time_left_ns() == 0 ? 0 : core::MonotonicNow_ns() + request.time_left_ns();
  tickets_[slot->ticket] = {request.caller_instance(), request.request()};
  core_->parameters_in.EndPush();
}

// Why the request is refused without the step thread; empty: it is not.
std::string BusThread::FindFault(const oos::ParameterRequest& request) const {
  const std::vector<std::string>& names = core_->parameter_names;
  if (std::find(names.begin(), names.end(), request.change().name()) == names.end()) {
    return core_->options.name + (names.empty() ? " owns no parameters"
                                                : " has no parameter '" + request.change().name() + "'; " +
                                                      core::SuggestName(request.change().name(), names));
  }
  if (request.change().manner() > static_cast<std::uint32_t>(core::ChangeManner::kWhenSeparated)) {
    return core_->options.name + " does not know this manner of changing";
  }
  return {};
}

void BusThread::SendReply(Served& served) {
  served.is_answered = true;
  oos::Control control;
  *control.mutable_parameter_reply() = served.reply;
  SendToRouted(served.routing, control);  // if it is lost, the caller repeats its request
}

void BusThread::SendReplies() {
  while (const ParameterAnswer* answer = core_->answers_out.Front()) {
    const auto ticket = tickets_.find(answer->ticket);
    const auto served = ticket == tickets_.end() ? served_.end() : served_.find(ticket->second);
    if (served != served_.end()) {
      oos::ParameterReply& reply = served->second.reply;
      reply.set_is_accepted(answer->is_accepted);
      reply.set_tick(answer->tick);
      reply.set_why(answer->why);
      reply.set_injected_j(answer->injected_J);
      reply.set_is_pending(answer->is_pending);
      SendReply(served->second);
    }
    if (ticket != tickets_.end()) tickets_.erase(ticket);
    core_->answers_out.EndPop();
  }
}

// --- Caller's side

void BusThread::OpenParameterCall(const ParameterCall& call) {
  OpenCall& open = open_calls_[call.request];
  open.call = call;
  open.created_ns = core::MonotonicNow_ns();
}

// Sends a call when its owners are there, and ends it when all have answered or time is up.
void BusThread::ServeCalls() {
  const std::int64_t now = core::MonotonicNow_ns();
  for (auto item = open_calls_.begin(); item != open_calls_.end();) {
    OpenCall& open = item->second;
    const ParameterCall& call = open.call;
    if (open.requests.empty()) CallOwners(open);
    const bool is_late = now >= call.deadline_ns;
    for (auto& [name, request] : open.requests) {
      if (request.has_answered) continue;
      const auto peer = peers_.find(name);
      const bool is_dead = peer == peers_.end() || peer->second.record.instance() != request.instance ||
                           !StatusOf(peer->second).is_alive;
      if (is_dead || is_late) {
        oos::ParameterReply reply;
        reply.set_why(name + (is_dead ? " died before it answered" : " did not answer in time"));
        Account* account = core_->book.Find(TopicId(kParameterTopic), request.instance, true);
        if (account != nullptr) ++account->dropped[static_cast<std::size_t>(DropReason::kUnanswered)];
        AnswerCall(open, name, reply);
      } else if (now - request.sent_ns > kRepeatAfter_ns) {
        SendRequest(open.call, peer->second);
        request.sent_ns = now;
      }
    }
    if (open.requests.empty() && is_late) {
      std::string alive;
      for (const auto& [name, status] : core_->peers) {
        if (status.is_alive) alive += (alive.empty() ? "" : ", ") + name;
      }
      oos::ParameterReply reply;
      reply.set_why((call.owner.empty() ? "no live node owns parameters" : "no live node is called " + call.owner) +
                    "; alive: " + (alive.empty() ? "none" : alive));
      AnswerCall(open, call.owner, reply);
    }
    const bool is_done =
        !open.requests.empty() && std::all_of(open.requests.begin(), open.requests.end(),
                                              [](const auto& request) { return request.second.has_answered; });
    if (is_done && call.is_waited_for) core_->finished_calls[call.request] = open.result;
    item = is_done ? open_calls_.erase(item) : std::next(item);
  }
}

void BusThread::CallOwners(OpenCall& open) {
  const std::int64_t now = core::MonotonicNow_ns();
  bool are_all_alive = true;
  std::vector<Peer*> owners;
  for (auto& [name, peer] : peers_) {
    const bool is_owner = open.call.owner.empty() ? peer.record.owns_parameters() : open.call.owner == name;
    if (!is_owner || peer.has_left) continue;
    if (StatusOf(peer).is_alive) {
      owners.push_back(&peer);
    } else {
      are_all_alive = are_all_alive && peer.was_heard;  // known, but not heard yet
    }
  }
  if (!are_all_alive && now - open.created_ns <= kWaitForOwners_ns) return;
  for (Peer* owner : owners) {
    if (!SendRequest(open.call, *owner)) continue;
    open.requests[owner->record.name()] = {owner->record.instance(), now, false};
    ++core_->book.Open(kParameterTopic, TopicClass::kService, owner->record.name(), owner->record.instance(), true, 0)
          .sent;
  }
}

bool BusThread::SendRequest(const ParameterCall& call, Peer& owner) {
  oos::Control control;
  oos::ParameterRequest* request = control.mutable_parameter_request();
  request->set_request(call.request);
  request->set_caller(core_->options.name);
  request->set_caller_instance(core_->instance);
  request->set_time_left_ns(std::max<std::int64_t>(1, call.deadline_ns - core::MonotonicNow_ns()));
  std::string bytes;
  EncodeState(call.change, &bytes);
  request->mutable_change()->ParseFromString(bytes);
  return SendToPeer(owner, control);
}

void BusThread::TakeReply(const Peer& peer, const oos::ParameterReply& reply) {
  const auto open = open_calls_.find(reply.request());
  if (open == open_calls_.end()) return;
  const auto request = open->second.requests.find(peer.record.name());
  if (request == open->second.requests.end() || request->second.has_answered) return;
  Account* account = core_->book.Find(TopicId(kParameterTopic), peer.record.instance(), true);
  if (account != nullptr) ++account->received;
  AnswerCall(open->second, peer.record.name(), reply);
}

void BusThread::AnswerCall(OpenCall& open, const std::string& owner, const oos::ParameterReply& reply) {
  open.requests[owner].has_answered = true;
  const ParameterAck ack{open.call.request, owner, reply.is_accepted(), reply.tick(), reply.why(), reply.injected_j(),
                         reply.is_pending()};
  if (!open.call.is_waited_for) {
    acks_for_step_.push_back(ack);
    return;
  }
  // One acceptance is enough; otherwise all reasons are given.
  if (ack.is_accepted && !open.result.is_accepted) {
    open.result = ack;
  } else if (!ack.is_accepted && !open.result.is_accepted) {
    const std::string before = open.result.why.empty() ? std::string() : open.result.why + "; ";
    open.result = ack;
    open.result.why = before + ack.why;
  }
}

}  // namespace bus::detail
