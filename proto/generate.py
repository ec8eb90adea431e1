#!/usr/bin/env python3
"""Makes everything that follows from proto/*.proto and proto/topics.textproto.

    generate.py DESCRIPTORS TOPICS --cpp FOLDER     C++: core/messages/<file>[_fields].hpp, bus/topic_table.hpp
    generate.py DESCRIPTORS TOPICS --write ROOT     clients/topics.json, docs/reference/topics.md, the picture in
                                                    docs/architecture.md
    generate.py DESCRIPTORS TOPICS --check ROOT     fails when one of these three is stale

DESCRIPTORS is a FileDescriptorSet of all .proto files with source info. options_pb2, which protoc makes of options.proto,
is on PYTHONPATH.
"""

import argparse
import collections
import difflib
import json
import pathlib
import re
import sys
import textwrap

from google.protobuf import descriptor_pb2, text_format
from proto import options_pb2 as options

WIDTH = 120

# Wire type (core::Wire) and C++ type of each scalar type of proto3.
SCALARS = {
    "bool": ("kBool", "bool"), "uint32": ("kUint32", "std::uint32_t"), "uint64": ("kUint64", "std::uint64_t"),
    "sint32": ("kSint32", "std::int32_t"), "sint64": ("kSint64", "std::int64_t"),
    "fixed32": ("kFixed32", "std::uint32_t"), "fixed64": ("kFixed64", "std::uint64_t"),
    "sfixed64": ("kFixed64", "std::int64_t"), "float": ("kFloat", "float"), "double": ("kDouble", "double"),
    "string": ("kString", "std::string"), "bytes": ("kBytes", "std::string"),
}
CPP_TYPES = {"uint8": "std::uint8_t", "uint16": "std::uint16_t", "vec3": "glm::vec3", "dvec3": "glm::dvec3"}
INITIAL = {"bool": "false", "double": "0.0", "float": "0.0f", "glm::vec3": "{0.0f}", "glm::dvec3": "{0.0}",
           "ChangeManner": "{}"}

Field = collections.namedtuple("Field", "name number type cpp_type cpp_name init wire repeated options comment")
Message = collections.namedtuple("Message", "name struct number fields options comment file")


class Mistake(Exception):
    """What a person has to change in proto/."""


def type_name(field):
    if field.type_name:
        return field.type_name.rsplit(".", 1)[-1]
    return descriptor_pb2.FieldDescriptorProto.Type.Name(field.type)[5:].lower()


def comment_of(location):
    return " ".join((location.leading_comments + " " + location.trailing_comments).split()) if location else ""


def read_field(field, location):
    extensions = field.options.Extensions
    kind = type_name(field)
    wire, cpp_type = SCALARS.get(kind, ("kMessage", kind))
    words = extensions[options.cpp].split()
    if words:
        cpp_type = CPP_TYPES.get(words[0], words[0])
    return Field(field.name, field.number, kind, cpp_type, words[1] if len(words) > 1 else field.name,
                 extensions[options.init], wire, field.label == field.LABEL_REPEATED, extensions, comment_of(location))


def read_messages(descriptors):
    """Those that have a struct in C++, in the order of the files."""
    messages = []
    for file in descriptors.file:
        locations = {tuple(location.path): location for location in file.source_code_info.location}
        for index, message in enumerate(file.message_type):
            extensions = message.options.Extensions
            if not extensions[options.message_type] and not extensions[options.struct_name]:
                continue
            fields = [read_field(field, locations.get((4, index, 2, i))) for i, field in enumerate(message.field)]
            messages.append(Message(message.name, extensions[options.struct_name] or message.name,
                                    extensions[options.message_type], fields, extensions,
                                    comment_of(locations.get((4, index))), file.name))
    return messages


def check(messages, topics):
    by_name = {message.name: message for message in messages}
    numbers = sorted(message.number for message in messages if message.number)
    if numbers != list(range(1, len(numbers) + 1)):
        raise Mistake(f"message_type counts from 1 without gaps, and each message has its own; there are {numbers}")
    for topic in topics:
        if getattr(by_name.get(topic.message), "number", 0) == 0:
            raise Mistake(f"topic '{topic.pattern}' carries '{topic.message}', which is no message with a message_type; "
                          f"the next free number is {len(numbers) + 1}")
        if not re.fullmatch(r"([a-z_]+|<[a-z_]+>)(/([a-z_]+|<[a-z_]+>))*", topic.pattern):
            raise Mistake(f"topic pattern '{topic.pattern}' is not words and <words> between slashes")
    for message in messages:
        lists = {one.name for one in message.options[options.list]}
        for field in message.fields:
            for option in (options.size_of, options.first_of, options.item_of, options.row_of):
                if field.options[option] and field.options[option] not in lists:
                    raise Mistake(f"{message.name}.{field.name}: the message has no list '{field.options[option]}'")
            if field.repeated and field.wire not in ("kString", "kMessage") and field.cpp_type == SCALARS[field.type][1] \
                    and not field.options[options.item_of]:
                raise Mistake(f"{message.name}.{field.name}: say what the numbers are, e.g. [(cpp) = \"Pose X_WB\"], "
                              f"or of which list they are items")


# --- C++

def commented(text, indent=""):
    return textwrap.fill(text, WIDTH, initial_indent=f"{indent}// ", subsequent_indent=f"{indent}// ",
                         break_long_words=False, break_on_hyphens=False) + "\n" if text else ""


def declared(cpp_type, name, init, comment):
    line = f"  {cpp_type} {name}{init};"
    if comment and len(line) + 4 + len(comment) <= WIDTH:
        return f"{line}  // {comment}\n"
    return commented(comment, "  ") + line + "\n"


def member(field):
    cpp_type = field.cpp_type
    if field.repeated and field.wire in ("kString", "kMessage") and not field.options[options.item_of]:
        return declared(f"std::vector<{struct_of(cpp_type)}>", field.cpp_name, "", field.comment)
    initial = field.init or INITIAL.get(cpp_type, "0" if cpp_type.startswith("std::") and "int" in cpp_type else "")
    init = initial if initial.startswith("{") else f" = {initial}" if initial else ""
    return declared(cpp_type, field.cpp_name, init, field.comment)


STRUCTS = {}  # of messages whose struct has another name


def struct_of(name):
    return STRUCTS.get(name, name)


def capacity_of(one):
    return one.capacity.split("=")[0].strip()


def items_of(message, one):
    return [field for field in message.fields if field.options[options.item_of] == one.name]


def item_struct(message, one):
    """A list without a struct of its own has items of one field."""
    return one.item or items_of(message, one)[0].cpp_type


def members_of(message, has_header):
    """Members of the struct: a field each, or a list in place of all that belongs to it."""
    text = "  Header header;\n" if has_header else ""
    shown = set()
    for field in message.fields:
        name = field.options[options.item_of] or field.options[options.size_of] or field.options[options.first_of]
        if not name:
            text += member(field)
            continue
        if name in shown:
            continue
        shown.add(name)
        one = next(one for one in message.options[options.list] if one.name == name)
        item = item_struct(message, one)
        of = f"FixedVector<{item}, {capacity_of(one)}>" if one.capacity else f"std::vector<{item}>"
        text += declared(of, name, "", "")
    return text


def described(struct, field):
    may_lack = ", true" if field.options[options.may_lack] else ""
    return f'Field<{field.number}, Wire::{field.wire}, &{struct}::{field.cpp_name}{may_lack}>{{"{field.cpp_name}"}}'


def fields_of(message):
    """Initialisers of FieldsOf<struct>::kAll."""
    rows = []
    lists = {one.name: one for one in message.options[options.list]}
    shown = set()

    def number(option, name):
        return next((field.number for field in message.fields if field.options[option] == name), 0)

    for field in message.fields:
        name = field.options[options.item_of] or field.options[options.size_of] or field.options[options.first_of]
        if not name:
            rows.append(described(message.struct, field))
        elif name not in shown:
            shown.add(name)
            row = number(options.row_of, name)
            value = items_of(message, lists[name])[0]
            more = f", {row}, {value.number}, Wire::{value.wire}" if not lists[name].item else f", {row}" if row else ""
            rows.append(f"ListField<{number(options.size_of, name)}, {number(options.first_of, name)}, "
                        f'&{message.struct}::{name}{more}>{{"{name}"}}')
    return rows


def described_fields(struct, rows, spare_bytes):
    spare = f"  static constexpr std::size_t kSpareBytes = {spare_bytes};\n" if spare_bytes else ""
    separator = ",\n      "
    return (f"template <>\nstruct FieldsOf<{struct}> {{\n"
            f"  static constexpr auto kAll = std::tuple{{\n      {separator.join(rows)}}};\n{spare}}};\n")


def message_headers(file, messages, latest):
    """The structs, and apart from them their fields, which only the codec and the recorder of steps parse."""
    structs, fields = "", ""
    for message in messages:
        for one in message.options[options.list]:
            if "=" in one.capacity:
                structs += f"constexpr std::size_t {one.capacity};\n\n"
            if one.item:
                columns = items_of(message, one)
                structs += commented(one.what)
                structs += f"struct {one.item} {{\n{''.join(member(column) for column in columns)}}};\n\n"
                fields += described_fields(one.item, [described(one.item, column) for column in columns], 0) + "\n"
        structs += commented(message.comment)
        structs += f"struct {message.struct} {{\n{members_of(message, message.name in latest)}}};\n\n"
        fields += described_fields(message.struct, fields_of(message), message.options[options.spare_bytes]) + "\n"
    stem = pathlib.Path(file).stem
    top = f"// Made of {file} by proto/generate.py: change that file.\n#pragma once\n\n"
    return {
        f"{stem}.hpp": f"{top}#include <cstdint>\n#include <string>\n#include <vector>\n\n"
        '#include "core/fixed_vector.hpp"\n#include "core/messages/values.hpp"\n\n'
        f"namespace core {{\n\n{structs}}}  // namespace core\n",
        f"{stem}_fields.hpp": f"{top}#include <tuple>\n\n"
        f'#include "core/messages/{stem}.hpp"\n#include "core/messages/fields.hpp"\n\n'
        "// Number on the wire, wire type and member of each field, for the codec and for recorded steps.\n"
        f"namespace core {{\n\n{fields}}}  // namespace core\n"}


def name_function(topic):
    """DeviceStateTopic(role), or a constant where the name has no free part."""
    parameters = re.findall(r"<([a-z_]+)>", topic.pattern)
    if not parameters:
        return f'inline constexpr const char* k{topic.name}Topic = "{topic.pattern}";\n'
    pieces = []
    for piece in re.split(r"(<[a-z_]+>)", topic.pattern):
        if piece.startswith("<"):
            pieces.append(f"std::string({piece[1:-1]})")
        elif piece:
            pieces.append(f'"{piece}"')
    arguments = ", ".join(f"std::string_view {parameter}" for parameter in parameters)
    return f"inline std::string {topic.name}Topic({arguments}) {{\n  return {' + '.join(pieces)};\n}}\n"


def wildcard(pattern):
    """'*' stands for any text, so what stands between the first and the last free part is kept, '*' once for each."""
    return re.sub(r"\*(/\*)+$", "*", re.sub(r"<[a-z_]+>", "*", pattern))


def topic_table(messages, topics):
    numbered = sorted((message for message in messages if message.number), key=lambda message: message.number)
    of_class = {kind: [message for message in numbered if any(
        topic.message == message.name and options.TopicClass.Name(getattr(topic, "class")) == kind for topic in topics)]
        for kind in ("LATEST", "STATE")}
    reliable = [message for message in numbered if message not in of_class["LATEST"]]
    includes = "".join(f'#include "core/messages/{pathlib.Path(file).stem}.hpp"\n'
                       for file in sorted({message.file for message in numbered}))
    enumerators = "".join(f"  k{message.name} = {message.number},\n" for message in numbered)
    of = "".join(f"template <>\ninline constexpr MessageType kMessageTypeOf<core::{message.struct}> = "
                 f"MessageType::k{message.name};\n" for message in numbered)
    rules = "".join(
        f'    TopicRule{{"{wildcard(topic.pattern)}", TopicClass::k'
        f'{options.TopicClass.Name(getattr(topic, "class")).capitalize()}, MessageType::k{topic.message}, '
        f"{topic.max_age_ms * 1000000}}},\n" for topic in topics)

    def applied(name, some):
        return f"#define {name}(X) \\\n  " + " \\\n  ".join(f"X({message.name})" for message in some) + "\n"

    def listed(name, some):
        names = ",\n    ".join(f"core::{message.struct}" for message in some)
        return f"template <template <class...> class List>\nusing {name} = List<\n    {names}>;\n"

    return ("// Made of proto/topics.textproto and the .proto files by proto/generate.py: change those.\n#pragma once\n\n"
            f"#include <array>\n#include <string>\n#include <string_view>\n\n"
            f'#include "bus/topic_rule.hpp"\n{includes}\n'
            "namespace bus {\n\n"
            "// What a topic carries. Values are on the wire: append, never renumber.\n"
            f"enum class MessageType : std::uint8_t {{\n  kNone = 0,\n{enumerators}}};\n\n"
            f"constexpr MessageType kLastMessageType = MessageType::k{numbered[-1].name};\n\n"
            "template <class M>\nconstexpr MessageType kMessageTypeOf = MessageType::kNone;\n"
            f"{of}\n"
            "// The messages, those of LATEST topics, those of STATE topics, and all but those of LATEST topics: as X(name), or as\n"
            "// types in a List.\n"
            f"{applied('BUS_MESSAGES', numbered)}"
            f"{applied('BUS_LATEST_MESSAGES', of_class['LATEST'])}"
            f"{applied('BUS_STATE_MESSAGES', of_class['STATE'])}"
            f"{applied('BUS_RELIABLE_MESSAGES', reliable)}\n"
            f"{listed('LatestMessages', of_class['LATEST'])}{listed('StateMessages', of_class['STATE'])}"
            f"{listed('ReliableMessages', reliable)}\n"
            "// Every topic of the system. The first rule that matches counts.\n"
            f"inline constexpr std::array kTopicRules = {{\n{rules}}};\n\n"
            f"// Names of the topics.\n{''.join(name_function(topic) for topic in topics)}\n"
            "}  // namespace bus\n")


# --- Documents

def topics_json(messages, topics):
    numbers = {message.name: message.number for message in messages}
    rows = [json.dumps({"pattern": wildcard(topic.pattern), "class": getattr(topic, "class"),
                        "message_type": numbers[topic.message], "type": f"oos.{topic.message}",
                        "max_age_ms": topic.max_age_ms}) for topic in topics]
    return '{\n  "rules": [\n    ' + ",\n    ".join(rows) + "\n  ]\n}\n"


def escaped(text):
    return text.replace("<", "&lt;").replace(">", "&gt;")


def picture(table):
    """An arrow for each pair of processes of the table that topics lead between, events left out."""
    shown = {process.name for process in table.process}
    text = "```mermaid\nflowchart LR\n"
    for process in table.process:
        text += f"  {process.name}[{process.name}<br/>{process.what}]\n"
    for line in table.beside:
        text += f"  {line}\n"
    arrows = collections.defaultdict(list)
    for topic in table.topic:
        if getattr(topic, "class") == options.EVENT:
            continue
        for producer in getattr(topic, "from"):
            for consumer in topic.to:
                if producer != consumer and {producer, consumer} <= shown:
                    arrows[producer, consumer].append(escaped(topic.pattern))
    for (producer, consumer), patterns in arrows.items():
        text += f'  {producer} -- "{"<br/>".join(patterns)}" --> {consumer}\n'
    return text + "```\n"


MARKERS = ("<!-- begin of the picture made of proto/topics.textproto; cmake --build build/release --target topics -->\n",
           "<!-- end of the picture -->\n")


def with_picture(document, table):
    if any(document.count(marker) != 1 for marker in MARKERS):
        raise Mistake("docs/architecture.md must hold the two comments between which the picture stands, each once")
    before, rest = document.split(MARKERS[0])
    after = rest.split(MARKERS[1])[1]
    return before + MARKERS[0] + picture(table) + MARKERS[1] + after


def topics_md(messages, table):
    text = ("# Topics\n\n"
            "Made of `proto/topics.textproto` and the `.proto` files by `cmake --build build/release --target topics`. The first "
            "pattern that\nmatches a name counts; `<x>` stands for any text. Classes are explained in "
            "[libs/bus](../../libs/bus/README.md). A value older than its age is stale.\nHow to add one: "
            "[a field or a topic](../howto/add-a-field-or-a-topic.md).\n\n"
            "| topic | class | message | rate | age | from | to |\n|---|---|---|---|---|---|---|\n")
    for topic in table.topic:
        age = f"{topic.max_age_ms} ms" if topic.max_age_ms else ""
        text += (f"| `{topic.pattern}` | {options.TopicClass.Name(getattr(topic, 'class'))} | "
                 f"[{topic.message}](#{topic.message.lower()}) | {topic.rate} | {age} | "
                 f"{', '.join(getattr(topic, 'from'))} | {', '.join(topic.to)} |\n")
    text += ("\n## Messages\n\nSI units, radians, nanoseconds. A pose X_AB is 7 doubles (unit quaternion w, x, y, z, then position), "
             "a\ntwist 6 (angular, then linear velocity), a wrench 6 (force, then torque); W is the world frame. In C++ "
             "they are structs of the namespace\n`core`.\n")
    for message in sorted(messages, key=lambda one: one.number or len(messages)):
        text += f"\n### {message.name}\n\n{escaped(message.comment)}\n\n" if message.comment else f"\n### {message.name}\n\n"
        text += "| number | field | type | in C++ | |\n|---|---|---|---|---|\n"
        for field in message.fields:
            part = field.options[options.item_of]
            cpp = f"`{part}[].{field.cpp_name}`" if part else f"`{field.cpp_name}`"
            if part and not next(one.item for one in message.options[options.list] if one.name == part):
                cpp = f"`{part}[]`"
            if field.options[options.size_of]:
                cpp = f"`{field.options[options.size_of]}.size()`"
            if field.options[options.first_of]:
                cpp = ""
            text += (f"| {field.number} | {field.name} | {'repeated ' * field.repeated}{field.type} | {cpp} | "
                     f"{escaped(field.comment).replace('|', '&#124;')} |\n")
    return text


def documents(messages, table, root):
    """Path below the root -> content that it should have."""
    architecture = (root / "docs/architecture.md").read_text()
    return {"clients/topics.json": topics_json(messages, table.topic),
            "docs/reference/topics.md": topics_md(messages, table),
            "docs/architecture.md": with_picture(architecture, table)}


def write_if_changed(path, text):
    """Leaves the file's time alone where nothing changed, so that nothing is compiled again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("descriptors", type=pathlib.Path)
    parser.add_argument("topics", type=pathlib.Path)
    action = parser.add_mutually_exclusive_group(required=True)
    for name in ("--cpp", "--write", "--check"):
        action.add_argument(name, type=pathlib.Path)
    arguments = parser.parse_args()
    descriptors = descriptor_pb2.FileDescriptorSet.FromString(arguments.descriptors.read_bytes())
    table = text_format.Parse(arguments.topics.read_text(), options.TopicTable())
    messages = read_messages(descriptors)
    check(messages, table.topic)
    STRUCTS.update({message.name: message.struct for message in messages})
    if arguments.cpp:
        latest = {topic.message for topic in table.topic if getattr(topic, "class") == options.LATEST}
        for file in sorted({message.file for message in messages}):
            of_file = [message for message in messages if message.file == file]
            for name, text in message_headers(file, of_file, latest).items():
                write_if_changed(arguments.cpp / "core/messages" / name, text)
        write_if_changed(arguments.cpp / "bus/topic_table.hpp", topic_table(messages, table.topic))
        return 0
    root = arguments.write or arguments.check
    stale = 0
    for path, text in documents(messages, table, root).items():
        if arguments.write:
            write_if_changed(root / path, text)
            continue
        present = (root / path).read_text() if (root / path).exists() else ""
        if present != text:
            stale += 1
            print(f"{path} is stale: cmake --build build/release --target topics")
            sys.stdout.writelines(difflib.unified_diff(present.splitlines(True), text.splitlines(True), path, "should be"))
    return 1 if stale else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (Mistake, text_format.ParseError) as mistake:
        sys.exit(f"proto/generate.py: {mistake}")
