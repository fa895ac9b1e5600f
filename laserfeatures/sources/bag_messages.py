"""The messages of bags: of files that are walked through, and of databases with rosbags."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from laserfeatures.errors import SourceError
from laserfeatures.optional import optional
from laserfeatures.sources.bag_file import ZSTD_MAGIC, BagFile, Channel
from laserfeatures.sources.bag_mcap import walk_mcap
from laserfeatures.sources.bag_ros1 import walk_ros1
from laserfeatures.sources.log import Log

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

NEED = "reading bags needs rosbags"
WALK = {".bag": walk_ros1, ".mcap": walk_mcap}
ENCODINGS = {".bag": "ros1", ".mcap": "cdr"}


class Bag(Protocol):
    """A bag that is open."""

    def topics(self) -> list[tuple[str, str]]:
        """Return the topics, each with its type."""
        ...

    def messages(self, topic: str, kind: str) -> Iterator[tuple[int, bytes]]:
        """Yield a topic's messages: when each was recorded [ns], and its bytes."""
        ...

    def read(self, data: bytes) -> Any:
        """Return the message that bytes are."""
        ...


class Walked:
    """Files that are read without an index.

    Parameters
    ----------
    log : Log
        What is damaged is told there.
    files : list of Path
        The files, in order.

    Raises
    ------
    OSError, ValueError
        If one cannot be read or makes no sense.
    """

    def __init__(self, log: Log, files: list[Path]) -> None:
        self._log = log
        self._files = [WALK[file.suffix](file) for file in files]
        for file in self._files:
            file.find_channels()
        self._encoding = ENCODINGS[files[0].suffix]
        self._read: Any = None

    def topics(self) -> list[tuple[str, str]]:
        """Return the topics, each with its type."""
        return [
            (channel.topic, channel.kind)
            for file in self._files
            for channel in file.channels.values()
            if channel.encoding == self._encoding
        ]

    def messages(self, topic: str, kind: str) -> Iterator[tuple[int, bytes]]:
        """Yield a topic's messages; what is missing at the end is told to the log."""
        for file in self._files:
            wanted = {
                number: channel
                for number, channel in file.channels.items()
                if (channel.topic, channel.kind) == (topic, kind)
            }
            if not wanted:
                continue
            self._read = self._reader(kind, list(wanted.values()))

            def damaged(where: str, error: Exception, path: Path = file.path) -> None:
                self._log.broken(where, error, error, path)

            count = 0
            for message in file.messages({*wanted}, damaged):
                count += 1
                yield message.time, message.data
            self._tell(file, topic, {*wanted}, count)

    def read(self, data: bytes) -> Any:
        """Return the message that bytes are."""
        return self._read(data)

    def _tell(self, file: BagFile, topic: str, wanted: set[int], count: int) -> None:
        """Tell the log what the file lacks."""
        stated = sum((file.stated or {}).get(number, 0) for number in wanted)
        if file.cut:
            self._log.notice(f"cut {file.path}", file.cut, file.path)
        elif count < stated:
            said = f"expected {stated} messages of {topic} as the file says, got {count}"
            self._log.notice(f"count {file.path}", said, file.path)

    def _reader(self, kind: str, channels: list[Channel]) -> Any:
        """Return what makes messages of bytes, by the file's own definition of their type."""
        types = optional("rosbags.typesys", NEED, "ros")
        ros1 = self._encoding == "ros1"
        store = types.get_typestore(types.Stores.ROS1_NOETIC if ros1 else types.Stores.LATEST)
        channel = next((channel for channel in channels if channel.definition), None)
        if channel is not None:
            store = types.get_typestore(types.Stores.EMPTY)
            if "idl" in channel.form:
                for text in _definitions(channel.definition):
                    store.register(types.get_types_from_idl(text))
            else:
                store.register(types.get_types_from_msg(channel.definition, kind))
        read = store.deserialize_ros1 if ros1 else store.deserialize_cdr
        return lambda data: read(data, kind)


def _definitions(text: str) -> list[str]:
    """Return the parts of a definition in IDL, one for each type."""
    line = "=" * 80 + "\n"
    if text.startswith(f"{line}IDL: "):
        return [part.partition("\n")[2] for part in text.split(line)[1:]]
    return [text]


class Indexed:
    """A database, or a packed bag, that rosbags has opened."""

    def __init__(self, log: Log, reader: "AnyReader") -> None:
        self._log = log
        self._reader = reader
        self._kind = ""

    def topics(self) -> list[tuple[str, str]]:
        """Return the topics, each with its type."""
        return [(connection.topic, connection.msgtype) for connection in self._reader.connections]

    def messages(self, topic: str, kind: str) -> Iterator[tuple[int, bytes]]:
        """Yield a topic's messages; what is missing at the end is told to the log."""
        self._kind = kind
        wanted = [c for c in self._reader.connections if (c.topic, c.msgtype) == (topic, kind)]
        count = 0
        for _, time, data in self._reader.messages(wanted):
            count += 1
            yield time, data
        stated = sum(connection.msgcount for connection in wanted)
        if count < stated:
            said = f"expected {stated} messages of {topic} as the bag says, got {count}"
            self._log.notice("count", said)

    def read(self, data: bytes) -> Any:
        """Return the message that bytes are.

        Raises
        ------
        SourceError
            If it is packed, which only the bag's folder says.
        """
        if data.startswith(ZSTD_MAGIC):
            raise SourceError(
                f"{self._log.path}: the messages are packed with zstd, which only the "
                f"metadata.yaml beside the file says: pass the folder, {self._log.path.parent}"
            )
        return self._reader.deserialize(data, self._kind)
