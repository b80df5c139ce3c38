"""ROS bags: .bag files of ROS 1; folders or .db3 files of ROS 2."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from typing import Any, ClassVar

from typing_extensions import override

from testbed.errors import InputError
from testbed.files import FileStamp, stamped
from testbed.logs.extra import library
from testbed.logs.messages import LOOKED_AT, Collector, topic_of, undecoded, with_further
from testbed.logs.streams import Content, Log, Room, Topic, Wanted, parsing

MAGICS = (b"#ROSBAG V2.0", b"SQLite format 3\0")
_MOST_FILES = 1000
"""Files of a bag's folder that are hashed."""


@dataclass(frozen=True)
class Rosbag(Log):
    """A ROS bag."""

    format: ClassVar[str] = "ROS bag"

    @override
    def stamps(self) -> tuple[FileStamp, ...]:
        """Return the stamp of every file of the bag."""
        if not self.path.is_dir():
            return (stamped(self.path, "a ROS bag"),)
        files = sorted(path for path in self.path.iterdir() if path.is_file())
        if len(files) > _MOST_FILES:
            raise InputError(f"{self.path}: holds {len(files):,} files; give the folder of a ROS 2 bag")
        return tuple(stamped(path, "a ROS bag") for path in files)

    @override
    def survey(self) -> Mapping[str, Topic]:
        """Return the topics of the bag, each by its first messages; those without one have no fields."""
        with self._opened() as reader:
            topics = {connection.topic: topic_of(None, connection.msgtype) for connection in reader.connections}
            for connection in reader.connections:
                for _, _, data in islice(reader.messages(connections=[connection]), LOOKED_AT):
                    message = _decoded(reader, data, connection.msgtype)
                    topics[connection.topic] = with_further(topics[connection.topic], message)
            return topics

    @override
    def read(self, wanted: Wanted) -> Content:
        """Read fields of topics."""
        room, damage = Room(self.path), []
        collectors: dict[str, Collector] = {}
        with self._opened() as reader:
            held = [connection for connection in reader.connections if connection.topic in wanted]
            try:
                for connection, received, data in reader.messages(connections=held) if held else ():
                    if connection.topic not in collectors:
                        collectors[connection.topic] = Collector(wanted[connection.topic], room)
                    collectors[connection.topic].add(_decoded(reader, data, connection.msgtype), received)
            except InputError:
                raise
            except Exception as error:  # the database's own, or a parser's of damaged bytes
                damage.append(f"the bag is damaged ({error}): what stands before that place was read")
            unused = {connection.topic for connection in reader.connections} - wanted.keys()
        return Content(
            streams={topic: collector.stream() for topic, collector in collectors.items()},
            unused=tuple(sorted(unused)),
            damage=(*damage, *undecoded(collectors)),
        )

    @contextmanager
    def _opened(self) -> Iterator[Any]:
        if self.path.is_file() and self.path.suffix not in (".bag", ".db3"):
            raise InputError(f"{self.path}: the name of a ROS bag ends in .bag or .db3, by which it is read: rename it")
        if self.path.is_dir() and not (self.path / "metadata.yaml").is_file():
            raise InputError(f"{self.path}: is a folder without metadata.yaml, so no bag of ROS 2: name the log's file")
        highlevel = library("rosbags.highlevel", "reading ROS bags")
        types = library("rosbags.typesys", "reading ROS bags")
        with parsing(self.path, "a ROS bag"):
            # Bags of ROS 2 before Iron hold no definitions of their messages: those of its own packages are known.
            store = types.get_typestore(types.Stores.LATEST)
            with highlevel.AnyReader([self.path], default_typestore=store) as reader:
                yield reader


def _decoded(reader: Any, data: bytes, kind: str) -> Any:  # noqa: ANN401
    """Return a message; None of one that is damaged, which then holds no number."""
    try:
        return reader.deserialize(data, kind)
    except Exception:  # whatever a decoder says of damaged bytes
        return None
