"""MCAP with messages in JSON, protobuf or ROS 2's CDR. It is read from its beginning on, as far as it goes."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import Any, ClassVar, NamedTuple, TypeAlias

from typing_extensions import override

from testbed.errors import InputError
from testbed.files import open_regular
from testbed.logs.extra import library
from testbed.logs.messages import LOOKED_AT, Collector, topic_of, undecoded, with_further
from testbed.logs.streams import Content, Log, Room, Topic, Wanted, WholeReads, parsing

MAGIC = b"\x89MCAP0\r\n"
LARGEST_RECORD = 256_000_000
"""Bytes of a chunk; writers make chunks of 1 to 10 MB, and a length that is damaged would fill the memory."""
_SURVEYED = 50_000_000
"""Bytes from the beginning in which topics are looked for."""

_SCHEMA, _CHANNEL, _MESSAGE = 3, 4, 5
"""Kinds of records: mcap.dev/spec, "Opcodes"."""
_RECORD = Struct("<BQ")
"""Kind and length that every record begins with."""
_MESSAGE_HEAD = Struct("<HIQQ")
"""Channel, sequence number, log time and publish time that a message begins with."""

Decoder: TypeAlias = Callable[[bytes], Any]


class _Message(NamedTuple):
    """A message: its channel, when the log took it (ns), and what it says."""

    channel_id: int
    log_time: int
    data: bytes


@dataclass(frozen=True)
class Mcap(Log):
    """An MCAP file."""

    format: ClassVar[str] = "MCAP"

    @override
    def survey(self) -> Mapping[str, Topic]:
        """Return the topics of the log, each by its first messages; those without one have no fields."""
        topics: dict[str, Topic] = {}
        seen: Counter[str] = Counter()
        scan = _Scan(self.path, most=_SURVEYED)
        for channel, message in scan.messages():
            name = channel.topic
            if seen[name] < LOOKED_AT and (decode := scan.decoder_of(channel)) is not None:
                seen[name] += 1
                known = topics.get(name) or topic_of(None, scan.kind_of(channel))
                topics[name] = with_further(known, _decoded(decode, message.data))
        return scan.silent | topics

    @override
    def read(self, wanted: Wanted) -> Content:
        """Read fields of topics."""
        scan, room = _Scan(self.path), Room(self.path)
        collectors: dict[str, Collector] = {}
        for channel, message in scan.messages():
            if channel.topic not in wanted:
                continue
            decode = scan.decoder_of(channel)
            if decode is None:
                raise InputError(
                    f"{self.path}: topic {channel.topic} is in {scan.encoding_of(channel)}, which is not read"
                )
            if channel.topic not in collectors:
                collectors[channel.topic] = Collector(wanted[channel.topic], room)
            collectors[channel.topic].add(_decoded(decode, message.data), message.log_time)
        return Content(
            streams={topic: collector.stream() for topic, collector in collectors.items()},
            unused=tuple(sorted(scan.topics - wanted.keys())),
            damage=(*scan.damage, *undecoded(collectors)),
        )


class _Scan:
    """One pass through a file."""

    def __init__(self, path: Path, most: int | None = None) -> None:
        self._path, self._most = path, most
        self._channels: dict[int, Any] = {}
        self._schemas: dict[int, Any] = {}
        self._decoders: dict[int, Decoder | None] = {}
        self.damage: list[str] = []

    @property
    def topics(self) -> set[str]:
        """Topics that the file names."""
        return {channel.topic for channel in self._channels.values()}

    @property
    def silent(self) -> dict[str, Topic]:
        """Topics that the file names, as they are without a message."""
        return {channel.topic: topic_of(None, self.kind_of(channel)) for channel in self._channels.values()}

    def messages(self) -> Iterator[tuple[Any, _Message]]:
        """Yield every message that is whole, with its channel."""
        records = library("mcap.records", "reading MCAP")
        for record in self._records():
            if isinstance(record, (_Message, records.Message)):
                if record.channel_id in self._channels:
                    yield self._channels[record.channel_id], record
            elif isinstance(record, records.Channel):
                self._channels[record.id] = record
            elif isinstance(record, records.Schema):
                self._schemas[record.id] = record

    def decoder_of(self, channel: Any) -> Decoder | None:  # noqa: ANN401
        """Return what decodes a channel's messages; None where nothing here does."""
        if channel.id not in self._decoders:
            with parsing(self._path, f"the schema of topic {channel.topic}"):
                self._decoders[channel.id] = _decoder(channel.message_encoding, self._schemas.get(channel.schema_id))
        return self._decoders[channel.id]

    def kind_of(self, channel: Any) -> str:  # noqa: ANN401
        """Return the name of the type of a channel's messages."""
        schema = self._schemas.get(channel.schema_id)
        return "" if schema is None else str(schema.name)

    def encoding_of(self, channel: Any) -> str:  # noqa: ANN401
        """Return how a channel's messages are encoded."""
        schema = self._schemas.get(channel.schema_id)
        return f"{channel.message_encoding} with {'no schema' if schema is None else schema.encoding}"

    def _records(self) -> Iterator[Any]:
        """Yield the records of the file, chunks taken apart."""
        reader = library("mcap.stream_reader", "reading MCAP")
        exceptions = library("mcap.exceptions", "reading MCAP")
        records = library("mcap.records", "reading MCAP")
        with parsing(self._path, "MCAP"), open_regular(self._path) as file:
            reads = WholeReads(file, self._most)
            stream = reader.StreamReader(reads, emit_chunks=True, record_size_limit=LARGEST_RECORD)
            try:
                for record in stream.records:
                    if isinstance(record, records.Chunk):
                        yield from self._chunk(reader, record)
                    else:
                        yield record
            except exceptions.EndOfFile:
                self.damage.append(
                    "the file has no end: the log was cut, or its recording never ended; what is whole was read"
                )
            except Exception as error:  # of damaged bytes, a parser raises whatever comes
                if isinstance(error, InputError) or not self._channels:
                    raise
                self.damage.append(f"the file is damaged ({error}): what stands before that place was read")

    def _chunk(self, reader: Any, chunk: Any) -> Iterator[Any]:  # noqa: ANN401
        """Yield the records of a chunk; of a damaged one nothing."""
        if chunk.uncompressed_size > LARGEST_RECORD:
            raise InputError(
                f"{self._path}: a chunk holds {chunk.uncompressed_size:,} bytes, at most {LARGEST_RECORD:,} are read"
            )
        try:
            stream, length = reader.get_chunk_data_stream(chunk, validate_crc=True)
            parts = list(_parts(stream.read(length)))
        except Exception as error:  # decompressors and parsers of damaged bytes raise whatever comes
            seconds = f"{chunk.message_start_time / 1e9:.6f} to {chunk.message_end_time / 1e9:.6f} s"
            self.damage.append(f"a chunk is damaged ({error}): its messages, received at {seconds}, were left out")
            return
        yield from parts


def _parts(data: bytes) -> Iterator[Any]:
    """Yield the records of a chunk; the library's own way through a message takes four times as long."""
    streams, records = library("mcap.data_stream", "reading MCAP"), library("mcap.records", "reading MCAP")
    kinds = {_CHANNEL: records.Channel, _SCHEMA: records.Schema}
    place, end = 0, len(data)
    while place < end:
        kind, length = _RECORD.unpack_from(data, place)
        begin = place + _RECORD.size
        place = begin + length
        if kind == _MESSAGE:
            channel, _, log_time, _ = _MESSAGE_HEAD.unpack_from(data, begin)
            yield _Message(channel, log_time, data[begin + _MESSAGE_HEAD.size : place])
        elif kind in kinds:
            yield kinds[kind].read(streams.ReadDataStream(BytesIO(data[begin:place])))


def _decoder(encoding: str, schema: Any) -> Decoder | None:  # noqa: ANN401
    if encoding == "json":
        return json.loads
    if encoding == "protobuf" and schema is not None and schema.encoding == "protobuf":
        factory = library("mcap_protobuf.decoder", "reading protobuf messages").DecoderFactory()
        decoder: Decoder = factory.decoder_for(encoding, schema)
        return decoder
    if encoding == "cdr" and schema is not None and schema.encoding in ("ros2msg", "ros2idl"):
        return _ros_decoder(schema)
    return None


def _ros_decoder(schema: Any) -> Decoder:  # noqa: ANN401
    """Return the decoder of rosbags, which takes a third of the time that the one of mcap-ros2-support takes."""
    types = library("rosbags.typesys", "reading ROS 2 messages")
    parse = types.get_types_from_msg if schema.encoding == "ros2msg" else types.get_types_from_idl
    text = schema.data.decode()
    store = types.get_typestore(types.Stores.EMPTY)
    store.register(parse(text, schema.name) if schema.encoding == "ros2msg" else parse(text))
    return lambda data: store.deserialize_cdr(data, schema.name)


def _decoded(decode: Decoder, data: bytes) -> Any:  # noqa: ANN401
    """Return a message; None of one that is damaged, which then holds no number."""
    try:
        return decode(data)
    except Exception:  # whatever a decoder says of damaged bytes
        return None
