import doctest
import inspect
import pydoc
import re
import subprocess
import sys
from pathlib import Path

import pytest

import laserfeatures as lf
from laserfeatures import errors, intersections, pipeline, segment_filter

ROOT = Path(__file__).parents[1]
NAMES = [name for name in lf.__all__ if name != "__version__"]
STAGES_AND_DATA = {
    "Features", "Intersections", "LaserScan", "LineSegments", "Lines", "Pipeline", "PointFeatures",
    "SegmentFilter",
}  # fmt: skip
TREE = {
    "LaserFeaturesError": (Exception,),
    "UnknownExtractorError": (errors.LaserFeaturesError, LookupError),
    "PluginError": (errors.LaserFeaturesError,),
    "MissingDependencyError": (errors.LaserFeaturesError, ImportError),
    "SourceError": (errors.LaserFeaturesError, OSError),
    "DriveError": (errors.LaserFeaturesError, RuntimeError),
    "DriverError": (errors.LaserFeaturesError, OSError),
    "DeviceLostError": (errors.DriverError,),
    "DriverTimeoutError": (errors.DriverError, TimeoutError),
    "ProtocolError": (errors.DriverError,),
}


def test_all_is_sorted_and_without_repeats():
    assert sorted(set(lf.__all__)) == lf.__all__


@pytest.mark.parametrize("name", NAMES)
def test_a_public_name_exists_and_says_what_it_is(name):
    doc = inspect.getdoc(getattr(lf, name))
    assert doc
    first = doc.splitlines()[0]
    assert first.endswith(".")
    assert len(first) <= 100


@pytest.mark.parametrize("name", NAMES)
def test_a_docstring_tells_parameters_and_errors(name):
    value = getattr(lf, name)
    doc = inspect.getdoc(value)
    if inspect.isfunction(value) and inspect.signature(value).parameters:
        assert "\nParameters\n" in doc
        assert "\nRaises\n" in doc
        for parameter in inspect.signature(value).parameters:
            assert f"{parameter} : " in doc or f"**{parameter}" in doc
    if name in STAGES_AND_DATA - {"Features"}:
        assert "\nParameters\n" in doc
        section = doc.split("\nParameters\n")[1]
        for field in inspect.signature(value).parameters:
            assert field in section, f"{name} does not tell of {field}"


def test_a_name_that_does_not_exist_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'laserfeatures' has no attribute 'Pipe'"):
        lf.Pipe  # noqa: B018 - the access is what fails
    assert isinstance(lf.__version__, str)


def test_dir_and_help_show_the_public_names_and_nothing_of_our_own():
    assert [name for name in dir(lf) if name[:2] != "__"] == NAMES
    page = pydoc.plain(pydoc.render_doc(lf))
    for name in ("open_source", "Pipeline", "get_extractor"):
        assert re.search(rf"^    (class )?{name}\(", page, re.MULTILINE), name
    for name in ("Any", "TYPE_CHECKING", "import_module", "_LAZY"):
        assert not re.search(rf"^    (class |)?{name}\b", page, re.MULTILINE), name


def test_a_type_checker_takes_what_the_examples_and_the_plugin_page_pass(tmp_path):
    example = doctest.DocTestParser().get_examples(lf.LaserScan.__doc__)
    page = (ROOT / "docs/writing-a-plugin.md").read_text()
    detector, trial = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "one_wall.py").write_text(detector)
    code = [
        "import laserfeatures as lf",
        "from laserfeatures import LaserScan, Lines, LineSegments, PointFeatures",
        *(each.source for each in example),
        "no: list[list[list[float]]] = []",
        "lines = Lines(theta=[0], d=(1.0,), support=[3], covariance=[[[0.0] * 2] * 2])",
        "segments = LineSegments(",
        "    lines=lines, line=[], endpoints=no, support=[], rms=[], points=[[True]]",
        ")",
        "PointFeatures(positions=[[1, 2]], covariance=no, lines=[[0, 1]], angles=[1], real=[True])",
        "length: float = lines.theta[0] + scan.points[0, 0]",
        "first: float = LaserScan.uniform([1], 0, 1).ranges[0]",
        trial,
    ]
    path = tmp_path / "typed.py"
    path.write_text("\n".join(code))
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), str(path)],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
        timeout=300,
    )
    assert done.stdout.startswith("Success"), done.stdout


def test_the_lazy_names_are_the_ones_of_their_modules():
    assert lf.Pipeline is pipeline.Pipeline
    assert lf.SegmentFilter is segment_filter.SegmentFilter
    assert lf.Intersections is intersections.Intersections


@pytest.mark.parametrize("name", TREE)
def test_the_tree_of_errors_is_as_drawn(name):
    kind = getattr(errors, name)
    assert kind.__bases__ == TREE[name]
    assert getattr(lf, name) is kind
    assert f" {name} " in errors.__doc__.replace("\n", " ")


def test_there_are_no_other_errors():
    kinds = {n for n, kind in vars(errors).items() if isinstance(kind, type)}
    assert kinds == set(TREE)


def test_a_star_import_brings_just_the_public_names():
    code = "from laserfeatures import *; print(*sorted(n for n in dir() if n[:2] != '__'))"
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == NAMES
