import sys
import time
from importlib.metadata import EntryPoint
from pathlib import Path
from urllib.parse import quote

import pytest
from cli_runs import carmen_log, fails

import laserfeatures
from laserfeatures import MissingDependencyError, registry
from laserfeatures.optional import optional


def test_a_module_that_is_there_is_imported():
    assert optional("json.decoder", "this needs JSON", "plots") is sys.modules["json.decoder"]


@pytest.mark.parametrize("module", ["no_such_package", "no_such_package.part"])
def test_a_missing_package_is_an_error_with_a_hint(module):
    with pytest.raises(MissingDependencyError) as caught:
        optional(module, "this needs it", "plots")
    root = Path(laserfeatures.__file__).parents[1]
    assert str(caught.value) == f"this needs it: pip install -e '{root}[plots]'"


@pytest.mark.parametrize(
    ("code", "why"),
    [
        (
            "raise OSError('libGL.so.1: cannot open shared object file: No such file')",
            "this needs it, and that lacks libGL.so.1 of the system: apt-get install libgl1",
        ),
        (
            "raise ImportError('libusb-1.0.so.0: cannot open shared object file')",
            "libusb-1.0.so.0 of the system: apt-get install libusb-1.0-0",
        ),
        (
            "raise ImportError('/x/libgomp.so.1: cannot open shared object file')",
            "libgomp.so.1 of the system: apt-get install libgomp1",
        ),
        (
            "raise ImportError('libodd.so.3: cannot open shared object file')",
            "libodd.so.3 of the system: apt-file search libodd.so.3",
        ),
        ("import no_such_part_of_it", "No module named 'no_such_part_of_it'"),
    ],
)
def test_a_package_that_lacks_something_itself_says_what(tmp_path, monkeypatch, code, why):
    (tmp_path / "half_installed.py").write_text(code)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingDependencyError) as caught:
        optional("half_installed", "this needs it", "sim")
    assert why in str(caught.value)
    assert "pip" not in str(caught.value) or "No module" in why


class Installed:
    """What importlib.metadata tells of a distribution."""

    def __init__(self, told):
        self._told = told

    def read_text(self, name):
        return {"direct_url.json": self._told}.get(name)


@pytest.mark.parametrize(
    ("told", "line"),
    [
        (None, "pip install 'laserfeatures[sim]'"),
        ('{"url": "file://HERE", "dir_info": {}}', "pip install 'HERE[sim]'"),
        (
            '{"url": "file:///gone/away", "dir_info": {"editable": true}}',
            "pip install '.[sim]' in the checkout that it was installed from",
        ),
        (
            '{"url": "https://a.example/b.git", "vcs_info": {"vcs": "git", "commit_id": "1f"}}',
            "pip install 'laserfeatures[sim] @ git+https://a.example/b.git@1f'",
        ),
        (
            '{"url": "file:///a/laserfeatures-1.whl", "archive_info": {}}',
            "pip install 'laserfeatures[sim] @ file:///a/laserfeatures-1.whl'",
        ),
    ],
)
def test_the_hint_is_what_works_where_it_was_installed_from(told, line, tmp_path, monkeypatch):
    here = tmp_path / "a checkout"
    here.mkdir()
    told = told and told.replace("HERE", quote(str(here)))
    monkeypatch.setattr("importlib.metadata.distribution", lambda _: Installed(told))
    module = sys.modules["laserfeatures.optional"]
    monkeypatch.setattr(module, "__file__", str(tmp_path / "lib" / "laserfeatures" / "optional.py"))
    assert module.install_line("sim") == line.replace("HERE", str(here))


def test_a_plugin_that_lacks_a_library_of_the_system_says_which(tmp_path, monkeypatch):
    (tmp_path / "lacking.py").write_text(
        "raise ImportError('libGL.so.1: cannot open shared object file: No such file')"
    )
    monkeypatch.syspath_prepend(tmp_path)
    entry = EntryPoint("lacking", "lacking:X", "laserfeatures.extractors")
    with pytest.raises(laserfeatures.PluginError, match="apt-get install libgl1"):
        registry._load(entry)


NEEDS = [
    ("matplotlib", "plots", "plot {log} --scan 0 -o s.png"),
    ("matplotlib", "plots", "compare {log} -o r.html"),
    ("matplotlib", "plots", "testbench figures -o tb"),
    ("matplotlib", "plots", "testbench noise -o tb"),
    ("matplotlib", "plots", "testbench all -o tb"),
    ("scipy", "evaluation", "testbench table2 -o tb --data ."),
    ("matplotlib", "plots", "slam run {log} -o found"),
    ("evo", "slam", "slam run {log} --reference {log}"),
    ("evo", "slam", "slam simulate"),
    ("mujoco", "sim", "slam simulate"),
    ("mujoco", "sim", "simulate {plan} -o run.log"),
    ("mujoco", "sim", "extract {plan} -o o.jsonl"),
]


@pytest.mark.parametrize(("package", "extra", "command"), NEEDS)
def test_what_is_not_installed_is_told_before_anything_is_done(
    package, extra, command, tmp_path, monkeypatch
):
    plan = Path(__file__).parents[1] / "docs" / "office.toml"
    names = {"log": carmen_log(tmp_path / "a.log"), "plan": plan}
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    for name in [each for each in sys.modules if each.split(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)  # an import of it fails
    began = time.monotonic()
    line = fails(*command.format(**names).split())
    assert f"[{extra}]'" in line
    assert time.monotonic() - began < 10
    assert not list((tmp_path / "work").iterdir())
