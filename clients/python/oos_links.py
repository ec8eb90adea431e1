"""A node's sockets, and sending and receiving envelopes through them, encrypted or not."""

import functools
import ipaddress
import os
import pathlib
import secrets
import socket
import time

import zmq
import zmq.utils.z85

import oos_topics  # noqa: F401 - knows where proto is
from oos_envelope import (CONTROL, EVENT, LATEST, SERVICE, STATE, Envelope, Keys, hash32, is_latest,
                          read_envelope)
from proto import bus_pb2

PROTOCOL_VERSION = 1


@functools.cache
def machine_id():
    """Nodes of one machine share a clock."""
    return os.environ.get("OOS_MACHINE_ID") or pathlib.Path("/proc/sys/kernel/random/boot_id").read_text().strip()


def udp_address(endpoint):
    """("127.0.0.1", 4000) of "127.0.0.1:4000"; ValueError when it is none."""
    host, _, port = endpoint.rpartition(":")
    if not 0 < int(port) < 65536:
        raise ValueError(f"no port in '{endpoint}'")
    return str(ipaddress.IPv4Address(host)), int(port)


class Links:
    def __init__(self, name, registry, session, keys, bind):
        self.name, self.session, self.refused = name, session, 0
        self.instance, self.boot = secrets.randbits(64), time.time_ns()
        self._keys = Keys(keys, name) if keys else None
        self._sealer = None  # of datagrams, from the registry's session key
        self._zmq = zmq.Context()
        self._data, self._beats = (self._udp(bind) for _ in range(2))
        self._router = self._socket(zmq.ROUTER, zmq.ROUTER_MANDATORY, zmq.ROUTER_HANDOVER)
        self._poller = zmq.Poller()
        if self._keys:
            self._router.curve_server, self._router.curve_secretkey = True, self._keys.secret
            self._router.zap_domain = b"bus"
            self._allow_list = self._socket(zmq.REP)
            self._allow_list.bind("inproc://zeromq.zap.01")
            self._poller.register(self._allow_list, zmq.POLLIN)
        self._router.bind(f"tcp://{bind}:*")
        self._registry = self._dealer(registry, self._keys and self._keys.registry)
        for each in (self._data, self._beats, self._router, self._registry):
            self._poller.register(each, zmq.POLLIN)

    def _close_links(self):
        self._zmq.destroy()
        self._data.close()
        self._beats.close()

    @staticmethod
    def _udp(bind):
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        udp.bind((bind, 0))
        udp.setblocking(False)
        return udp

    def _socket(self, kind, *switches):
        made = self._zmq.socket(kind)
        made.linger, made.maxmsgsize = 100, 16 << 20
        for switch in switches:
            made.setsockopt(switch, 1)
        return made

    def _dealer(self, endpoint, server_key):
        dealer = self._socket(zmq.DEALER, zmq.IMMEDIATE)
        if self._keys:
            dealer.curve_serverkey = server_key
            dealer.curve_publickey, dealer.curve_secretkey = self._keys.public, self._keys.secret
        dealer.routing_id = f"{self.name}#{self.instance}".encode()
        dealer.reconnect_ivl, dealer.reconnect_ivl_max = 20, 200
        dealer.connect(endpoint)
        return dealer

    def _answer_authentication(self):
        while self._allow_list.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            version, request, _, _, _, mechanism, key = self._allow_list.recv_multipart()
            owner = self._keys.allowed.get(zmq.utils.z85.encode(key)) if mechanism == b"CURVE" else None
            self._allow_list.send_multipart([version, request, b"200" if owner else b"400", b"",
                                             (owner or "").encode(), b""])

    @staticmethod
    def _send_udp(udp, data, address):
        """Whether it was sent. A datagram that cannot be (a pulled cable, a full buffer) is lost, as any may be."""
        try:
            udp.sendto(data, address)
            return True
        except OSError:
            return False

    @staticmethod
    def _receive_udp(udp):
        try:
            return udp.recv(65536)
        except BlockingIOError:
            return None

    def _open(self, data, unseal=None):
        """The Control in a sound envelope of this session; otherwise None, and `refused` counts it."""
        found = read_envelope(data, unseal)
        if found and found[0].session == self.session and found[0].topic_class != LATEST:
            try:
                return bus_pb2.Control.FromString(found[1])
            except Exception:  # DecodeError moves between versions of protobuf
                pass
        self.refused += 1
        return None

    def _take_from(self, dealer, take):
        while dealer.getsockopt(zmq.EVENTS) & zmq.POLLIN:
            data = dealer.recv_multipart()[-1]
            if is_latest(data):  # a datagram that came by ZeroMQ
                self._take_data(data)
            elif control := self._open(data):
                take(control)

    def _wrap(self, control, sealer=None):
        body = control.WhichOneof("body")
        topic_class = (STATE if body.startswith("sub") or body.startswith("state") else
                       EVENT if body.startswith("ev") else SERVICE if body.startswith("parameter") else CONTROL)
        return Envelope(topic_class, digest=PROTOCOL_VERSION, session=self.session, node=hash32(self.name),
                        boot=self.boot, publish_ns=time.monotonic_ns()).write(control.SerializeToString(), sealer)

    def _send(self, dealer, control):
        try:
            dealer.send(self._wrap(control), zmq.DONTWAIT)
            return True
        except zmq.ZMQError:  # not connected yet, or gone
            return False

    def _reply(self, routing, control):
        try:
            self._router.send_multipart([routing, self._wrap(control)], zmq.DONTWAIT)
            return True
        except zmq.ZMQError:
            return False
