import sys

import pytest

from laserfeatures import MissingDependencyError
from laserfeatures.optional import optional


def test_a_module_that_is_there_is_imported():
    assert optional("json.decoder", "this needs JSON", "plots") is sys.modules["json.decoder"]


@pytest.mark.parametrize("module", ["no_such_package", "no_such_package.part"])
def test_a_missing_package_is_an_error_with_a_hint(module):
    with pytest.raises(MissingDependencyError) as caught:
        optional(module, "this needs it", "plots")
    assert str(caught.value) == "this needs it: pip install 'laserfeatures[plots]'"


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("raise OSError('libGL.so.1: cannot open shared object file')", "libGL.so.1: cannot open"),
        ("import no_such_part_of_it", "No module named 'no_such_part_of_it'"),
    ],
)
def test_a_package_that_lacks_something_itself_says_what(tmp_path, monkeypatch, code, why):
    (tmp_path / "half_installed.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingDependencyError) as caught:
        optional("half_installed", "this needs it", "sim")
    assert why in str(caught.value)
