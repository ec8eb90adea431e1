"""A hand device by docs/reference/device_protocol.md, for a laboratory's own: see docs/howto/own-device.md.

    device = Device("my arm", "A1", port=7460)
    while True:
        force_N, torque_Nm, grip_N, brake = device.exchange(position_m=(x, y, z), engaged=True)
"""
import socket
import struct
import time
import zlib

HEADER, DESCRIPTION_BODY = struct.Struct("<4sBBHIIq"), struct.Struct("<48s32s4I10d")
STATE_BODY, COMMAND_BODY = struct.Struct("<II22d"), struct.Struct("<II9d")
FLAGS = 8 + 16  # the states tell the applied force and the velocity; +1: simulated
DESCRIPTION, STATE, OFF = 1, 2, [0.0] * 7 + [400.0, 4.0]  # kinds of frames; no force, brakes


class Device:
    def __init__(self, name, serial, host="127.0.0.1", port=7460, rate_hz=1000.0, max_force_N=20.0, max_torque_Nm=1.0,
                 max_grip_N=10.0, mass_kg=0.5, inertia_kg_m2=0.005, damping=(1.0, 0.01), reach_m=0.5, opening_m=0.0):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((host, port))
        self.socket.setblocking(False)
        self.sent, self.reflected, self.heard_s, self.command = {DESCRIPTION: 0, STATE: 0}, 0, 0.0, OFF
        self.description = DESCRIPTION_BODY.pack(name.encode(), serial.encode(), FLAGS, 3, 3, 0, rate_hz, max_force_N,
                                                 max_torque_Nm, max_grip_N, mass_kg, inertia_kg_m2, *damping, reach_m,
                                                 opening_m)

    def send(self, kind, body):
        self.sent[kind] += 1
        frame = HEADER.pack(b"OOSD", 1, kind, HEADER.size + len(body) + 4, self.sent[kind], self.reflected,
                            time.monotonic_ns()) + body
        try:
            self.socket.send(frame + struct.pack("<I", zlib.crc32(frame)))
        except OSError:
            pass  # nobody listens yet

    def receive(self):
        try:
            while True:
                frame = self.socket.recv(512)
                is_whole = len(frame) == HEADER.size + COMMAND_BODY.size + 4 and frame[:6] == b"OOSD\x01\x03"
                if not is_whole or zlib.crc32(frame[:-4]) != int.from_bytes(frame[-4:], "little"):
                    continue
                self.reflected, self.heard_s = HEADER.unpack_from(frame)[4], time.monotonic()
                flags, _, *self.command = COMMAND_BODY.unpack_from(frame, HEADER.size)
                if flags & 1:
                    self.send(DESCRIPTION, self.description)
        except OSError:
            pass  # nothing more
        if time.monotonic() - self.heard_s > 0.06:  # whoever commands may have died
            self.command = OFF

    def exchange(self, position_m, quaternion=(1, 0, 0, 0), velocity_m_per_s=(0, 0, 0), turning_rad_per_s=(0, 0, 0),
                 opening_m=0.0, opening_m_per_s=0.0, engaged=True, buttons=0):
        """Sends where the hand is; returns force [N], torque [Nm], grip force [N] and brakes [N s/m, Nm s/rad]."""
        self.receive()
        self.send(STATE, STATE_BODY.pack(int(engaged), buttons, *quaternion, *position_m, *turning_rad_per_s,
                                         *velocity_m_per_s, opening_m, opening_m_per_s, *self.command[:7]))
        return self.command[:3], self.command[3:6], self.command[6], self.command[7:]
