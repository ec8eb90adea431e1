"""A hand device that speaks docs/reference/device_protocol.md: what a laboratory's own device starts from.

    device = Device("my arm", "A1", port=7460)
    while True:
        force_N, torque_Nm, grip_N, brake = device.exchange(position_m=(x, y, z), engaged=True)
"""
import socket
import struct
import time
import zlib

DESCRIPTION, STATE, COMMAND = 1, 2, 3
HEADER, STATE_BODY, COMMAND_BODY = struct.Struct("<4sBBHIIq"), struct.Struct("<II22d"), struct.Struct("<II9d")
DESCRIPTION_BODY = struct.Struct("<48s32s4I10d")
IS_SIMULATED, TELLS_APPLIED, TELLS_VELOCITY = 1, 8, 16
SILENCE_S = 0.06  # without a command for this long the motors are off


class Device:
    def __init__(self, name, serial, host="127.0.0.1", port=7460, rate_hz=1000.0, max_force_N=20.0, max_torque_Nm=1.0,
                 max_grip_N=10.0, mass_kg=0.5, reach_m=0.5, opening_max_m=0.0):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect((host, port))
        self.socket.setblocking(False)
        self.sent, self.reflected, self.last_s, self.begin_s = {DESCRIPTION: 0, STATE: 0}, 0, -1.0, time.monotonic()
        self.command = [0.0] * 9  # force, torque, grip, two brakes
        self.max = (max_force_N, max_torque_Nm, max_grip_N)
        self.description = DESCRIPTION_BODY.pack(
            name.encode(), serial.encode(), IS_SIMULATED | TELLS_APPLIED | TELLS_VELOCITY, 3, 3, 0, rate_hz, *self.max,
            mass_kg, 0.005, 1.0, 0.01, reach_m, opening_max_m)
        self.send(DESCRIPTION, self.description)

    def send(self, kind, body):
        self.sent[kind] += 1
        size = HEADER.size + len(body) + 4
        frame = HEADER.pack(b"OOSD", 1, kind, size, self.sent[kind], self.reflected, time.monotonic_ns()) + body
        try:
            self.socket.send(frame + struct.pack("<I", zlib.crc32(frame)))
        except OSError:
            pass  # nobody listens yet

    def receive(self):
        try:
            while True:
                frame = self.socket.recv(512)
                if len(frame) != HEADER.size + COMMAND_BODY.size + 4 or frame[:6] != b"OOSD\x01\x03":
                    continue
                if zlib.crc32(frame[:-4]) != struct.unpack("<I", frame[-4:])[0]:
                    continue
                self.reflected, self.last_s = HEADER.unpack(frame[:HEADER.size])[4], time.monotonic()
                flags, _, *self.command = COMMAND_BODY.unpack(frame[HEADER.size:-4])
                if flags & 1:
                    self.send(DESCRIPTION, self.description)
        except OSError:
            pass  # nothing more
        if time.monotonic() - self.last_s > SILENCE_S:
            self.command = [0.0] * 7 + [400.0, 4.0]

    def exchange(self, position_m, quaternion=(1, 0, 0, 0), velocity_m_per_s=(0, 0, 0), turning_rad_per_s=(0, 0, 0),
                 opening_m=0.0, engaged=True, buttons=0):
        """Sends where the hand is; returns force [N], torque [Nm], grip force [N] and brakes [N s/m, Nm s/rad]."""
        self.receive()
        self.send(STATE, STATE_BODY.pack(int(engaged), buttons, *quaternion, *position_m, *turning_rad_per_s,
                                         *velocity_m_per_s, opening_m, 0.0, *self.command[:7]))
        return self.command[:3], self.command[3:6], self.command[6], self.command[7:]
