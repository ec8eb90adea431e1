#pragma once

#include <zmq.hpp>

namespace bus::detail {

// The next message at a ROUTER, with its sender's routing id; false: none has arrived. Nodes send one frame after the
// id: messages without one are skipped, further frames are dropped.
inline bool ReceiveRouted(zmq::socket_t* router, zmq::message_t* routing, zmq::message_t* message) {
  while (router->recv(*routing, zmq::recv_flags::dontwait)) {
    if (!routing->more() || !router->recv(*message, zmq::recv_flags::dontwait)) continue;
    zmq::message_t rest;
    for (bool is_longer = message->more(); is_longer; is_longer = rest.more()) {
      if (!router->recv(rest, zmq::recv_flags::dontwait)) break;
    }
    return true;
  }
  return false;
}

}  // namespace bus::detail
