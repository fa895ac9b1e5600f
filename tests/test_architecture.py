"""Imports point one way, files and functions are short."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
CORE = ROOT / "laserfeatures"
PLUGINS = ROOT / "plugins" / "laserfeatures_plugins"
FILES = sorted([*CORE.rglob("*.py"), *PLUGINS.rglob("*.py")])

# Each may import what stands before it; those of one row do not know each other.
LAYERS = [
    ("compiled_cache", "compiled_signals"),
    ("errors", "arrays", "growing_file", "compiled", "parameters"),
    ("scan", "optional"),
    ("data", "poses"),
    ("engine", "wheels"),
    ("segment_filter", "intersections", "registry", "point_clouds", "noise_model"),
    ("simulation",),
    ("slam", "evaluation", "drivers"),
    ("sources",),
    ("pipeline", "emulators", "figures", "records"),
    ("comparison", "mapping"),
    ("testbench",),
    ("__init__",),
    ("cli",),
    ("__main__",),
]
RANK = {name: rank for rank, names in enumerate(LAYERS) for name in names}
FOR_PLUGINS = {"arrays", "compiled", "data", "scan", "engine", "errors", "parameters"}
HEAVY = {"numba", "cv2", "matplotlib", "rosbags", "scipy", "open3d", "serial", "click", "mujoco"}
HEAVY |= {"evo", "pandas"}


def at_run_time(tree):
    """Yield the import statements of a module but those for the type checker."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        yield from at_run_time(node)


def imported(path):
    """Return the dotted names of all modules that a file imports."""
    names = set()
    for node in at_run_time(ast.parse(path.read_text())):
        assert not getattr(node, "level", 0), f"{path}: imports are absolute"
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif (CORE.parent / node.module.replace(".", "/")).is_dir():
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
        else:
            names.add(node.module)
    return names


def module_of(name):
    """Return the module of the core that a dotted name is in, or None."""
    parts = name.split(".")
    if parts[0] != "laserfeatures":
        return None
    return parts[1] if len(parts) > 1 and parts[1] in RANK else "__init__"


@pytest.mark.parametrize(
    "path", [p for p in FILES if CORE in p.parents], ids=lambda p: str(p.relative_to(CORE))
)
def test_the_core_imports_one_way_and_no_plugin(path):
    own = path.relative_to(CORE).parts[0].removesuffix(".py")
    for name in imported(path):
        assert not name.startswith("laserfeatures_plugins"), f"{path} imports the plugin {name}"
        module = module_of(name)
        if module is None or module == own:
            continue
        if (own, module) == ("registry", "pipeline"):  # get_extractor makes one, when called
            continue
        assert RANK[module] < RANK[own], f"{own} imports {module}, which stands after it"


@pytest.mark.parametrize(
    "path", [p for p in FILES if PLUGINS in p.parents], ids=lambda p: str(p.relative_to(PLUGINS))
)
def test_a_plugin_imports_only_data_engine_and_errors_and_itself(path):
    own = ".".join(
        ["laserfeatures_plugins", path.relative_to(PLUGINS).parts[0].removesuffix(".py")]
    )
    for name in imported(path):
        module = module_of(name)
        assert module is None or module in FOR_PLUGINS, f"{path} imports {name}"
        assert not name.startswith("laserfeatures_plugins") or name.startswith(own), name


def dotted(path):
    """Return the name under which a file is imported."""
    folder = PLUGINS.parent if PLUGINS in path.parents else ROOT
    return ".".join(path.relative_to(folder).with_suffix("").parts).removesuffix(".__init__")


def test_no_modules_import_each_other_in_a_circle():
    graph = {dotted(path): imported(path) for path in FILES}
    graph = {name: {n for n in needs if n in graph} for name, needs in graph.items()}
    graph["laserfeatures.registry"].discard("laserfeatures.pipeline")  # when called
    assert "laserfeatures.data" in graph["laserfeatures.pipeline"]
    while free := {name for name, needs in graph.items() if not needs & graph.keys()}:
        graph = {name: needs for name, needs in graph.items() if name not in free}
    assert not graph


def is_kernel(function):
    decorators = [ast.unparse(decorator) for decorator in function.decorator_list]
    return any(d.startswith(("njit", "kernel", "helper", "inlined")) for d in decorators)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_files_and_functions_are_short(path):
    text = path.read_text()
    assert path.stem not in {"utils", "util", "helpers", "common", "misc"}
    assert len(text.splitlines()) <= 300
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            body = node.body[ast.get_docstring(node) is not None :]
            lines = body[-1].end_lineno - body[0].lineno + 1 if body else 0
            assert lines <= (60 if is_kernel(node) else 40), f"{node.name} has {lines} lines"


def modules_after(code):
    code += "\nimport sys; print(*{name.split('.')[0] for name in sys.modules})"
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


@pytest.mark.parametrize(
    "code",
    [
        "import laserfeatures",
        "import laserfeatures; laserfeatures.list_extractors()",
        "import laserfeatures.simulation",
        "import laserfeatures.evaluation",
    ],
)
def test_importing_and_listing_bring_in_nothing_heavy_and_no_plugin(code):
    modules = modules_after(code)
    assert "numpy" in modules
    assert not modules & (HEAVY | {"laserfeatures_plugins"})
