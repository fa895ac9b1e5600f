"""Where in a TOML file a table or key stands: `tomllib` tells that of mistakes in syntax only."""

import tomllib
from collections import Counter
from typing import Any

KeyPath = tuple[str | int, ...]


class TomlLines:
    """The lines of a TOML file's tables and keys.

    Parameters
    ----------
    text : str
        The whole file; `tomllib` has accepted it.
    """

    def __init__(self, text: str) -> None:
        self._lines: dict[KeyPath, int] = {(): 1}
        self._tables: Counter[KeyPath] = Counter()
        table: KeyPath = ()
        for number, statement in _statements(text):
            content = tomllib.loads(statement)
            if statement.lstrip().startswith("["):
                table = self._enter(content)
                content = {}
            self._record(table, content, number)

    def of(self, *path: str | int) -> int:
        """Return the line of a key such as ``"wall", 2, "from"``, or of what holds it, from 1."""
        while path not in self._lines:
            path = path[:-1]
        return self._lines[path]

    def _enter(self, header: dict[str, Any]) -> KeyPath:
        """Return the path of the table that a header opens, as ``{"wall": [{}]}`` does."""
        path: KeyPath = ()
        inner: Any = header
        while inner:
            ((key, inner),) = inner.items()
            path = (*path, key)
            if isinstance(inner, list):  # one more of a list of tables
                self._tables[path] += 1
                inner = inner[0]
            if self._tables[path]:  # of such a list, the last is meant
                path = (*path, self._tables[path] - 1)
        return path

    def _record(self, path: KeyPath, content: Any, number: int) -> None:
        for length in range(1, len(path) + 1):
            self._lines.setdefault(path[:length], number)
        if isinstance(content, dict):
            for key, value in content.items():
                self._record((*path, key), value, number)


def _statements(text: str) -> list[tuple[int, str]]:
    """Return each header and each key with its value, and the line where it begins.

    A statement ends where `tomllib` accepts it on its own: it knows best what is a string, a
    comment or an array that goes on.
    """
    statements: list[tuple[int, str]] = []
    pending, begin = "", 1
    for number, line in enumerate(text.split("\n"), 1):
        begin = begin if pending else number
        goes_on = bool(pending) and _goes_on(line)
        pending += line + "\n"
        if goes_on:
            continue  # no need to try: a long array would be read once for each of its lines
        if _is_complete(pending):
            statements.append((begin, pending))
            pending = ""
    return statements


def _goes_on(line: str) -> bool:
    """Tell whether a statement that was not complete before `line` cannot be so after it."""
    if '"' in line or "'" in line:
        return False  # what is comment and what is text is for tomllib to say
    code = line.partition("#")[0].rstrip()
    return not code or code.endswith(",")


def _is_complete(statement: str) -> bool:
    try:
        tomllib.loads(statement)
    except (ValueError, RecursionError):
        return False
    return True
