from cli_runs import fails, run

import laserfeatures as lf


def test_names_one_a_line():
    result = run("extractors")
    assert result.exit_code == 0
    assert tuple(result.stdout.split()) == lf.list_extractors()


def test_a_name_shows_default_unit_and_meaning_of_every_parameter():
    text = run("extractors", "direct_hough").stdout
    detector = lf.get_extractor("direct_hough").detector
    assert all(f"  {name} = " in text for name in vars(detector))
    assert "theta_step = " in text
    assert " rad (" in text
    assert "segment_filter" in text
    assert "intersections" in text
    assert "paper" in text


def test_a_preset_shows_its_own_defaults():
    plain = run("extractors", "direct_hough").stdout
    preset = run("extractors", "direct_hough", "--preset", "paper").stdout
    assert preset.startswith("direct_hough, preset paper: ")
    assert preset != plain


def test_a_wrong_name_is_one_line():
    assert "did you mean 'direct_hough'" in fails("extractors", "direct_hugh")
    assert "paper" in fails("extractors", "direct_hough", "--preset", "papr")
    assert "NAME" in fails("extractors", "--preset", "paper")
