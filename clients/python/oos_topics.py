"""Topics of the VR-OOS bus, their message types, and the types' shapes.

The package `proto` is what protoc makes of the repository's proto/: on PYTHONPATH, or where `./dev build` leaves it.
"""

import functools
import importlib
import json
import pathlib
import pkgutil
import sys

from google.protobuf import descriptor

from oos_envelope import hash32

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "build/release/clients/stubs"))
import proto  # noqa: E402

TOPICS = json.loads((ROOT / "clients/topics.json").read_text())["rules"]
TYPES = {m.DESCRIPTOR.full_name: m for module in pkgutil.iter_modules(proto.__path__)
         for m in vars(importlib.import_module(f"proto.{module.name}")).values() if hasattr(m, "FromString")}


@functools.lru_cache(maxsize=None)
def canonical(message):
    """The shape of a message type, whose hash is its schema digest: "1:uint64 6:repeated_uint32 7:{1:float}"."""
    kinds = {value: name[5:].lower() for name, value in vars(descriptor.FieldDescriptor).items()
             if name.startswith("TYPE_")}
    return " ".join(
        f"{field.number}:" + "repeated_" * (field.label == field.LABEL_REPEATED) +
        ("{" + canonical(field.message_type) + "}" if field.message_type else kinds[field.type])
        for field in sorted(message.fields, key=lambda field: field.number))


def matches(pattern, text):
    """'*' stands for any text, slashes included; every other character for itself."""
    first, *others = pattern.split("*")
    if not others:
        return text == pattern
    if not text.startswith(first) or len(text) < len(first) + len(others[-1]) or not text.endswith(others[-1]):
        return False
    at = len(first)
    for other in others[:-1]:
        at = text.find(other, at)
        if at < 0:
            return False
        at += len(other)
    return at <= len(text) - len(others[-1])


@functools.lru_cache(maxsize=None)
def rule_of(topic):
    """The first line of topics.json that matches."""
    for rule in TOPICS:
        if matches(rule["pattern"], topic):
            return rule
    raise ValueError(f"no rule in clients/topics.json matches topic '{topic}'")


@functools.lru_cache(maxsize=None)
def digest_of(topic):
    """The digest of the schema that this client expects on the topic; None if it does not know the topic."""
    try:
        return hash32(canonical(TYPES[rule_of(topic)["type"]].DESCRIPTOR))
    except (KeyError, ValueError):
        return None


def merge_parts(parts):
    """The message that was sent in parts: lists joined in order, the rest as in the first part."""
    whole = parts[0]
    for part in parts[1:]:
        for field, value in part.ListFields():
            if field.label == field.LABEL_REPEATED:
                getattr(whole, field.name).extend(value)
    return whole
