"""The registry with real distributions, written to a temporary path and imported elsewhere."""

import os
import subprocess
import sys
import textwrap

import pytest

import laserfeatures as lf
from laserfeatures import registry
from laserfeatures.registry import find_factory, near_names

PLUGIN = """
from dataclasses import dataclass
import numpy as np
from laserfeatures.data import LaserScan, Lines, LineSegments

@dataclass(frozen=True, kw_only=True)
class Nothing:
    patience: int = 3
    stages = {"segment_filter": {"min_points": 7}}

    def __call__(self, scan):
        none, pairs = np.zeros(0), np.zeros((0, 2, 2))
        return LineSegments(
            lines=Lines(theta=none, d=none, support=none, covariance=pairs),
            line=none, endpoints=pairs, support=none, rms=none, points=np.zeros((0, len(scan)))
        )

NUMBER = 5
"""


@pytest.fixture
def install(tmp_path):
    """Return a function that writes a real distribution: a module and its .dist-info."""

    def write(name, code, **entries):
        (tmp_path / f"{name}.py").write_text(code)
        info = tmp_path / f"{name}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        lines = [f"{key} = {value}" for key, value in entries.items()]
        (info / "entry_points.txt").write_text(
            "\n".join(["[laserfeatures.extractors]", *lines, ""])
        )

    return write


@pytest.fixture
def run(tmp_path):
    """Return a function that runs Python where those distributions are installed."""

    def python(code):
        paths = [str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])]
        done = subprocess.run(  # noqa: S603 - our own interpreter and code
            [sys.executable, "-c", "import laserfeatures as lf\n" + textwrap.dedent(code)],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return python


ERROR_OF = """
    try:
        {}
    except lf.LaserFeaturesError as error:
        print(type(error).__name__, error, type(error.__cause__).__name__, sep="|")
"""


def test_a_plugin_of_another_distribution_is_found_and_runs(install, run):
    install("faraway", PLUGIN, far="faraway:Nothing")
    out = run("""
        import sys
        print("far" in lf.list_extractors(), "faraway" in sys.modules)
        extractor = lf.get_extractor("far", patience=4)
        print(extractor.detector, extractor.segment_filter.min_points)
        features = extractor(lf.LaserScan(angles=[0.0, 0.1], ranges=[1, 1]))
        print(len(features.lines), len(features.corners), lf.list_extractors())
    """)
    names = tuple(sorted([*lf.list_extractors(), "far"]))
    assert out.splitlines() == ["True False", "Nothing(patience=4) 7", f"0 0 {names}"]


@pytest.mark.parametrize(
    ("code", "target", "cause"),
    [
        ("import no_such_module_anywhere", "broken:Nothing", "ModuleNotFoundError: No module"),
        (PLUGIN, "broken:Missing", "AttributeError: "),
        ("raise RuntimeError('out of order')", "broken:Nothing", "RuntimeError: out of order"),
        ("def", "broken:Nothing", "SyntaxError: "),
        ("raise SystemExit(3)", "broken:Nothing", "SystemExit: 3"),
        ("raise BaseException('skipped')", "broken:Nothing", "BaseException: skipped"),
    ],
)
def test_a_broken_plugin_hurts_neither_listing_nor_its_neighbours(
    install, run, code, target, cause
):
    install("broken", code, bad=target)
    install("faraway", PLUGIN, far="faraway:Nothing")
    out = run(
        'print({"bad", "far", "direct_hough"} <= set(lf.list_extractors()))\n'
        'print(lf.get_extractor("far").name, lf.get_extractor("direct_hough").name)\n'
        + textwrap.dedent(ERROR_OF.format('lf.get_extractor("bad")'))
    )
    listed, names, error = out.splitlines()
    assert (listed, names) == ("True", "far direct_hough")
    kind, message, chained = error.split("|")
    assert kind == "PluginError"
    start = f"extractor 'bad' of broken cannot be loaded from '{target}': {cause}"
    assert message.startswith(start)
    assert chained == cause.split(":")[0]


def test_ctrl_c_while_a_plugin_is_imported_is_no_fault_of_its(install, run):
    install("slow", "raise KeyboardInterrupt", slow="slow:Nothing")
    code = ERROR_OF.format('lf.get_extractor("slow")')
    assert run(f"{code}    except KeyboardInterrupt:\n        print('heard')") == "heard"


@pytest.mark.usefixtures("_clean_registry")
def test_a_plugin_that_ends_the_program_instead_of_making_a_detector_is_named():
    lf.register_extractor("mine", lambda: sys.exit("no licence"))
    with pytest.raises(lf.PluginError, match="'mine' cannot be made: SystemExit: no licence"):
        lf.get_extractor("mine")


def test_an_entry_point_that_is_no_callable_is_refused(install, run):
    install("broken", PLUGIN, bad="broken:NUMBER")
    out = run(ERROR_OF.format('lf.get_extractor("bad")'))
    expected = "PluginError|extractor 'bad' of broken: 'broken:NUMBER' must be callable, got int|"
    assert out == expected + "NoneType"


def test_a_name_that_two_other_distributions_offer_is_refused_with_both(install, run):
    install("second", PLUGIN, far="second:Nothing")
    install("first", PLUGIN, far="first:Nothing")
    out = run(ERROR_OF.format('lf.get_extractor("far")'))
    offers = "first (first:Nothing) and second (second:Nothing)"
    assert out == f"PluginError|extractor 'far' is offered by several packages: {offers}|NoneType"


def test_another_distribution_cannot_take_the_place_of_a_built_in_extractor(install, run):
    install("aaa_first_in_the_alphabet", PLUGIN, direct_hough="aaa_first_in_the_alphabet:Nothing")
    out = run("""
        print(type(lf.get_extractor("direct_hough").detector).__name__)
        print(lf.list_extractors().count("direct_hough"))
    """)
    assert out.split() == ["DirectHough", "1"]


def test_a_plugin_whose_detector_returns_something_else_is_named(install, run):
    install("odd", "class Odd:\n    def __call__(self, scan):\n        return 5\n", odd="odd:Odd")
    out = run(ERROR_OF.format('lf.get_extractor("odd")(lf.LaserScan(angles=[0.0], ranges=[1]))'))
    message = "extractor 'odd' must return LineSegments or PointFeatures, got int"
    assert out == f"PluginError|{message}|NoneType"


@pytest.fixture
def _clean_registry(monkeypatch):
    monkeypatch.setattr(registry, "_registered", {})


def detector_of(segments):
    """Return a factory with one parameter."""

    def factory(*, patience=3):  # noqa: ARG001 - its name is what is tested
        return lambda _: segments

    return factory


@pytest.mark.usefixtures("_clean_registry")
class TestRegister:
    def test_a_registered_extractor_is_listed_and_found(self):
        lf.register_extractor("mine", detector_of(None))
        assert lf.list_extractors() == tuple(sorted(lf.list_extractors()))
        assert "mine" in lf.list_extractors()
        assert lf.get_extractor("mine", patience=1).name == "mine"

    def test_a_taken_name_is_refused_unless_it_is_to_be_replaced(self):
        first, second = detector_of(1), detector_of(2)
        lf.register_extractor("mine", first)
        with pytest.raises(ValueError, match="'mine' exists already; pass replace=True"):
            lf.register_extractor("mine", second)
        assert find_factory("mine") is first
        lf.register_extractor("mine", second, replace=True)
        assert find_factory("mine") is second

    def test_a_built_in_name_is_taken(self):
        with pytest.raises(ValueError, match="'direct_hough' exists already"):
            lf.register_extractor("direct_hough", detector_of(None))
        mine = detector_of(None)
        lf.register_extractor("direct_hough", mine, replace=True)
        assert find_factory("direct_hough") is mine

    @pytest.mark.parametrize("name", ["", "my extractor", "2fast", "a-b"])
    def test_a_name_is_an_identifier(self, name):
        with pytest.raises(ValueError, match="must be a Python identifier, got "):
            lf.register_extractor(name, detector_of(None))

    def test_a_factory_is_callable(self):
        with pytest.raises(TypeError, match="the factory of 'mine' must be callable, got 5"):
            lf.register_extractor("mine", 5)

    def test_a_factory_of_any_keywords_checks_them_itself(self):
        lf.register_extractor("mine", lambda **_: print)
        assert lf.get_extractor("mine", whatever=1).detector is print


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (
            lambda: lf.get_extractor("direct_huogh"),
            lf.UnknownExtractorError,
            "no extractor is named 'direct_huogh'; did you mean 'direct_hough'?",
        ),
        (
            lambda: lf.get_extractor("xyz"),
            LookupError,
            "no extractor is named 'xyz'; there are: " + ", ".join(lf.list_extractors()),
        ),
        (
            lambda: lf.get_extractor("direct_hough", preset="papers"),
            ValueError,
            "direct_hough has no preset 'papers'; did you mean 'paper'?",
        ),
        (
            lambda: lf.get_extractor("direct_hough", theta_stepp=1),
            TypeError,
            "direct_hough has no parameter 'theta_stepp'; did you mean 'theta_step'?",
        ),
        (
            lambda: lf.get_extractor("direct_hough", segment_filtr=1),
            TypeError,
            "no parameter 'segment_filtr'; did you mean 'segment_filter'?",
        ),
        (
            lambda: lf.get_extractor("direct_hough", preset="paper", range_sigma=1),
            TypeError,
            "direct_hough has no parameter 'range_sigma'; ",
        ),
        (
            lambda: lf.get_extractor("direct_hough", segment_filter=5),
            TypeError,
            "segment_filter must be a SegmentFilter, got 5",
        ),
    ],
)
def test_a_wrong_name_is_an_error_that_names_the_near_ones(call, kind, message):
    with pytest.raises(kind) as caught:
        call()
    assert message in str(caught.value)


@pytest.mark.usefixtures("_clean_registry")
def test_an_extractor_without_presets_says_so():
    lf.register_extractor("mine", detector_of(None))
    with pytest.raises(ValueError, match="mine has no preset 'paper'; it has none"):
        lf.get_extractor("mine", preset="paper")


def test_near_names_are_the_near_ones_or_all():
    assert near_names("thata_step", ["theta_step", "d"]) == "did you mean 'theta_step'?"
    assert near_names("zzz", ["b", "a"]) == "there are: a, b"
    assert near_names("zzz", []) == ""
