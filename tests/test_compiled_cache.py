"""The cache of compiled kernels: it holds for all code and constants that a kernel compiles in."""

import json
import os
import re
import shutil
import subprocess
import sys
from enum import IntEnum
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from numba import config

from laserfeatures import compiled, compiled_cache

DECORATORS = f"from {compiled.__name__} import helper, inlined, kernel\n"
CODE = {
    "__init__": "",
    "limits": "STEP = 1.0\nSIZES = (2.0, 3.0)\n",
    "deep": DECORATORS + "@helper\ndef deepest(x):\n    return x + 10.0\n",
    "near": f"""
{DECORATORS}
from parts import limits
from parts.deep import deepest
from parts.limits import STEP

@helper
def nearest(x):
    return deepest(x) + STEP + limits.SIZES[1]

@inlined
def put_in(x):
    return x + 100.0
""",
    "top": f"""
{DECORATORS}
from parts.near import nearest, put_in

@kernel
def total(x):
    return put_in(nearest(x)) + 1000.0
""",
}
CALL = """
import json
from parts.top import total

value = total(0.0)
hits = sum(total.stats.cache_hits.values()) if hasattr(total, "stats") else None
print(json.dumps([value, hits]))
"""
TOTAL = 1114.0


@pytest.fixture
def parts(tmp_path):
    """Return the folder of a new package whose kernel calls helpers of other modules."""
    folder = tmp_path / "parts"
    folder.mkdir()
    for name, text in CODE.items():
        (folder / f"{name}.py").write_text(text)
    return folder


def run(parts, code=CALL, says=None, **settings):
    """Run code that imports the package in a process of its own; -B: Python caches nothing.

    It says one line on standard error, or nothing.
    """
    env = os.environ | {
        "NUMBA_CACHE_DIR": str(parts.parent / "cache"),
        "NUMBA_DISABLE_JIT": "0",
        "PYTHONPATH": os.pathsep.join([str(parts.parent), os.environ.get("PYTHONPATH", "")]),
    }
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-B", "-c", code],
        env=env | settings,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("\n") == (says is not None), done.stderr
    assert says is None or re.search(says, done.stderr), done.stderr
    return json.loads(done.stdout)


def edit(path, old, new):
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("name", "old", "new", "more", "age"),
    [
        ("near", "deepest(x) +", "deepest(x) + 1.0 +", 1.0, None),
        ("near", "x + 100.0", "x + 200.0", 100.0, -1e6),
        ("deep", "x + 10.0", "x + 20.0", 10.0, 0.0),
        ("limits", "STEP = 1.0", "STEP = 3.0", 2.0, -1e6),
        ("limits", "3.0)", "7.0)", 4.0, 0.0),
        ("top", "1000.0", "3000.0", 2000.0, 0.0),
    ],
    ids=["helper", "inlined", "helper's helper", "constant", "constant by module", "kernel"],
)
def test_a_change_counts_wherever_it_is_and_whatever_its_time(parts, name, old, new, more, age):
    assert run(parts) == [TOTAL, 0]
    path = parts / f"{name}.py"
    changed = path.stat().st_mtime
    edit(path, old, new)
    if age is not None:
        os.utime(path, (changed + age, changed + age))
    assert run(parts) == [TOTAL + more, 0]
    assert run(parts) == [TOTAL + more, 1]


def test_what_changes_no_code_leaves_the_cache_as_it_is(parts):
    assert run(parts) == [TOTAL, 0]
    edit(parts / "deep.py", "@helper", "# a comment\n\nUNUSED = 5.0\n\n@helper")
    os.utime(parts / "limits.py", (1e9, 1e9))
    files = sorted((parts.parent / "cache").rglob("*.nb?"))
    assert len(files) == 2
    assert run(parts) == [TOTAL, 1]
    edit(parts / "deep.py", "x + 10.0", "x + 20.0")
    assert run(parts) == [TOTAL + 10.0, 0]
    assert sorted((parts.parent / "cache").rglob("*.nb?")) == files


def files_of(folder):
    return [path for path in folder.rglob("*.nb?") if path.is_file()]


def elsewhere(**settings):
    """Return settings by which nothing is cached but in the folders given."""
    nowhere = dict.fromkeys(("NUMBA_CACHE_DIR", "TMPDIR", "TEMP", "TMP"), "")
    return {**nowhere, "XDG_CACHE_HOME": os.devnull, **settings}


def test_the_cache_of_the_user_is_outside_of_the_package_and_does_the_same(parts):
    user = {"NUMBA_CACHE_DIR": "", "XDG_CACHE_HOME": str(parts.parent / "user")}
    assert run(parts, **user) == [TOTAL, 0]
    assert len(files_of(parts.parent / "user")) == 2
    assert not files_of(parts)
    edit(parts / "deep.py", "x + 10.0", "x + 20.0")
    assert run(parts, **user) == [TOTAL + 10.0, 0]
    assert run(parts, **user) == [TOTAL + 10.0, 1]


def test_without_a_folder_of_the_user_a_temporary_one_is_taken_and_told(parts):
    temporary = parts.parent / "temporary"
    temporary.mkdir()
    settings = elsewhere(TMPDIR=str(temporary))
    assert run(parts, says="until that is cleared: set NUMBA_CACHE_DIR to", **settings) == [
        TOTAL,
        0,
    ]
    assert run(parts, **settings) == [TOTAL, 1]  # and not a word
    (own,) = temporary.glob("laserfeatures-*")
    assert own.stat().st_mode & 0o777 == 0o700
    own.chmod(0o777)  # anybody could put code there
    assert run(parts, says="each run compiles anew", **settings) == [TOTAL, 0]
    assert run(parts, says="each run compiles anew", **settings) == [TOTAL, 0]


def test_a_folder_that_was_chosen_but_cannot_be_written_to_is_told(parts):
    (parts.parent / "file").touch()
    (parts.parent / "temporary").mkdir()
    settings = {"TMPDIR": str(parts.parent / "temporary"), "XDG_CACHE_HOME": os.devnull}
    chosen = str(parts.parent / "file" / "folder")
    assert run(parts, says="set NUMBA_CACHE_DIR to", NUMBA_CACHE_DIR=chosen, **settings)[0] == TOTAL


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize(
    "damage", ["emptied", "cut", "flipped", "nonsense", "folder", "unreadable"]
)
def test_a_damaged_cache_is_made_anew(parts, ending, damage):
    assert run(parts) == [TOTAL, 0]
    (path,) = (parts.parent / "cache").rglob(f"*.{ending}")
    content = path.read_bytes()
    middle = len(content) // 2
    if damage == "folder":
        path.unlink()
        path.mkdir()
        assert run(parts, says="cannot be kept in .*: set NUMBA_CACHE_DIR to") == [TOTAL, 0]
        return
    if damage == "unreadable":
        path.unlink()
        path.symlink_to(path)
    else:
        flipped = content[:middle] + bytes([content[middle] ^ 64]) + content[middle + 1 :]
        damaged = {"emptied": b"", "cut": content[:middle], "flipped": flipped}
        path.write_bytes(damaged.get(damage, b"nonsense" * 100))
    assert run(parts)[0] == TOTAL
    assert run(parts) == [TOTAL, 1]


def test_a_full_disk_does_not_hurt_and_what_it_leaves_is_not_believed(parts):
    full = """
import errno
from numba.core.caching import IndexDataCacheFile

def no_room(self, data):
    if not isinstance(data, tuple) or len(data) == WHICH:
        raise OSError(errno.ENOSPC, "No space left on device")
    return dumps(data)

from numba.core.serialize import dumps
IndexDataCacheFile._dump = no_room
"""
    assert run(parts) == [TOTAL, 0]
    edit(parts / "deep.py", "x + 10.0", "x + 20.0")
    for which in (2, 3):  # no room for the index; for it, but not for the code
        code = full.replace("WHICH", str(which)) + CALL
        says = r"\(\[Errno 28\] No space left on device\): set NUMBA_CACHE_DIR to"
        assert run(parts, code, says=says) == [TOTAL + 10.0, 0]
    assert run(parts) == [TOTAL + 10.0, 0]  # the old code is still there, under its name
    assert run(parts) == [TOTAL + 10.0, 1]


def test_code_of_another_variant_under_a_name_is_not_believed(parts):
    """Two processes that save at once may write one name."""
    both = CALL.replace("total(0.0)", "total(0.0) + total(np.zeros(1))[0]", 1)
    both = "import numpy as np" + both
    assert run(parts, both) == [2 * TOTAL, 0]
    one, two = sorted((parts.parent / "cache").rglob("*.nbc"))
    shutil.copy(one, two)
    assert run(parts, both) == [2 * TOTAL, 1]
    assert run(parts, both) == [2 * TOTAL, 2]


def test_what_is_compiled_is_logged_once_for_who_asks():
    code = """
import json, logging
told = []
logging.basicConfig(level=logging.INFO, handlers=[logging.NullHandler()])
logging.getLogger("laserfeatures.compiled").addFilter(lambda r: told.append(r.getMessage()))
from laserfeatures.compiled import kernel
for function in (lambda x: x + 1.0, lambda x: x + 2.0):
    kernel(function)(1.0)
print(json.dumps(told))
"""
    assert run(Path(__file__).parent / "none", code)[0].startswith("compiling (once; ")


def test_without_jit_kernels_are_plain_functions(parts):
    assert run(parts, NUMBA_DISABLE_JIT="1") == [TOTAL, None]
    assert not (parts.parent / "cache").exists()


def test_a_kernel_can_be_sent_to_another_process(parts):
    dump = "import json, pickle; from parts.top import total; total(0.0)\n"
    sent = run(parts, dump + "print(json.dumps(pickle.dumps(total).hex()))")
    load = f"import json, pickle; total = pickle.loads(bytes.fromhex({sent!r}))\n"
    assert run(parts, load + "print(json.dumps(total(0.0)))") == TOTAL


needs_jit = pytest.mark.skipif(config.DISABLE_JIT, reason="without JIT there is no cache")


@needs_jit
def test_a_numba_that_is_made_otherwise_leaves_kernels_without_a_cache(monkeypatch):
    def fails(*_):
        raise AttributeError

    def twice(x):
        return 2 * x

    assert type(compiled.kernel(twice)._cache) is compiled.Cache
    monkeypatch.setattr(compiled, "Cache", fails)
    monkeypatch.setattr(compiled_cache, "_told", {"NUMBA_CACHE_DIR"})
    bare = compiled.kernel(twice)
    assert bare._cache.cache_path is None
    assert bare(2.0) == 4.0


def function(code, **scope):
    """Return the function f that this code makes."""
    exec(code, scope)  # noqa: S102 - our own code
    return scope["f"]


def user(a, code="def f(x):\n    return a.b.c(x)"):
    return function(code, a=a)


def module(**names):
    made = ModuleType("made")
    vars(made).update(names)
    return made


def own(value):
    def f(x):
        return x + value

    return f


def contents(value):
    return compiled._Contents(value).digest()


@pytest.mark.parametrize(
    ("one", "same", "other"),
    [
        (user(1), user(1), user(1.0)),
        (user(0.0), user(0.0), user(-0.0)),
        (user((1, (2.0, "a"))), user((1, (2.0, "a"))), user((1, (2.0, "b")))),
        (user(np.arange(2000)), user(np.arange(2000)), user(np.arange(2000)[::-1])),
        (user(np.zeros(2)), user(np.zeros(2)), user(np.zeros(2, np.int64))),
        (user(np.sin), user(np.sin), user(np.cos)),
        (user(module(b=1, d=2)), user(module(b=1, d=3)), user(module(b=2, d=2))),
        (user(module(b=module(c=1))), user(module(b=module(c=1))), user(module(b=module(c=2)))),
        (user(IntEnum("E", "B C")), user(IntEnum("E", "B C")), user(IntEnum("E", "C B"))),
        (user(own(1)), user(own(1)), user(own(2))),
        (own(1), own(1), own(2)),
        (user(frozenset("abc")), user(frozenset("cba")), user(frozenset("abd"))),
        *(
            (function(code), function(code), function(code.replace("1", "2")))
            for code in (
                "def f(x, y=1):\n    return x",
                "def f(x, *, y=1):\n    return x",
                "def f(x):\n    return [y + 1 for y in x]",
                "def f(x):\n    def g(y):\n        return y + 1\n    return g(x)",
                "def f(x1, y):\n    return y",
            )
        ),
    ],
)
def test_the_contents_are_what_is_compiled_in(one, same, other):
    assert contents(one) == contents(same) != contents(other)


@needs_jit
def test_the_options_of_a_helper_count():
    def f(x):
        return x

    one, same, other = (
        user(decorate(f)) for decorate in (compiled.helper, compiled.helper, compiled.inlined)
    )
    assert contents(one) == contents(same) != contents(other)


def test_functions_that_call_each_other_have_an_end():
    scope = {}
    exec("def f(x):\n    return g(x)\n\ndef g(x):\n    return f(x) + 1", scope)  # noqa: S102
    before = contents(scope["f"])
    exec("def g(x):\n    return f(x) + 2", scope)  # noqa: S102
    assert contents(scope["f"]) != before
