import base64
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from oracles import corners_at, oracle, tour

import laserfeatures as lf
from laserfeatures import registry
from laserfeatures.comparison import compare
from laserfeatures.comparison.document import Code, Document, Gallery, Paragraph, Picture, Table
from laserfeatures.comparison.report import report
from laserfeatures.comparison.to_html import to_html
from laserfeatures.comparison.to_markdown import to_markdown

VOID = {"meta", "img", "wbr", "br"}
PNG = b"\x89PNG\r\n\x1a\n"


class Page(HTMLParser):
    """Reads a page and holds it to be well formed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.images, self.text = [], [], [], ""
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        assert len(dict(attrs)) == len(attrs)
        assert not {"href", "srcset", "onload", "action"} & dict(attrs).keys()
        if tag == "img":
            self.images.append(dict(attrs))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.fixture
def extractors(monkeypatch):
    monkeypatch.setattr(registry, "_registered", {})
    lf.register_extractor("oracle", oracle)
    return {"direct_hough": lf.get_extractor("direct_hough"), "points": lf.get_extractor("oracle")}


@pytest.fixture
def document(extractors):
    scans = tour(9)
    source = {"source": "a|b.log", "scans": "9"}
    return report(compare(extractors, scans), extractors, scans, source=source, start=5)


def test_the_page_is_whole_and_refers_to_nothing_outside(document):
    html = to_html(document)
    page = Page(html)
    assert html.startswith("<!DOCTYPE html>\n")
    assert not {"script", "link", "iframe", "object"} & set(page.tags)
    assert not re.search(r"https?:|url\(|@import", html)
    assert 'name="viewport"' in html
    assert "prefers-color-scheme: dark" in html
    assert len(page.images) == 4
    for image in page.images:
        kind, data = image["src"].split(",")
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data, validate=True).startswith(PNG)
        assert len(image["alt"]) > 20
    assert page.tags.count("table") == 5


def test_the_report_says_what_was_run_and_on_what(document, extractors):
    for text in (Page(to_html(document)).text, to_markdown(document, lambda p: p.name)):
        flat = text.replace("\\", "")
        assert "Extractors compared on a|b.log" in flat
        assert "Scan 9 in the sensor's frame" in flat  # the middle one of 5 to 13
        assert f"numpy {np.__version__}" in flat
        assert re.search(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", flat)
        assert repr(extractors["direct_hough"]) in flat
        assert "within 0.2 m" in flat


def test_the_tables_of_both_hold_the_same_cells(document):
    page = Page(to_html(document)).text
    tables = [block for block in document.blocks if isinstance(block, Table)]
    assert len(tables) == 5
    lines = to_markdown(document, lambda p: p.name).splitlines()
    for table in tables:
        for row in [table.header, *table.rows]:
            assert len(row) == len(table.header)
            plain = "| " + " | ".join(row) + " |"
            assert plain.replace("a|b", "a.b") in [
                re.sub(r"\\(.)", r"\1", line.replace("a\\|b", "a.b")) for line in lines
            ]
            assert all(cell in page for cell in row)


def test_another_scan_can_be_drawn(extractors, monkeypatch):
    monkeypatch.setitem(
        registry._registered,
        "stamp",
        lambda: lambda scan: corners_at(np.ones((int(scan.stamp), 2))),
    )
    extractors = {"stamp": lf.get_extractor("stamp"), "points": extractors["points"]}
    scans = tour(3)
    comparison = compare(extractors, scans)
    document = report(comparison, extractors, scans, source={"source": "x"}, start=5, shown=7)
    assert [picture.alt.split()[0] for picture in document.pictures] == [
        *("Share", "Median", "Scan", "Scan")
    ]
    assert document.pictures[2].alt.startswith("Scan 7 ")
    assert document.pictures[2].caption == "stamp: 0 lines, 2 corners"
    with pytest.raises(IndexError, match="no scan 8 to draw, only 5 to 7"):
        report(comparison, extractors, scans, source={"source": "x"}, start=5, shown=8)


def test_one_that_failed_has_its_row_and_no_picture(extractors, monkeypatch):
    def broken(_scan):
        raise ValueError("the sample <is> larger | than the scan")

    monkeypatch.setitem(registry._registered, "broken", lambda: broken)
    extractors["broken"] = lf.get_extractor("broken")
    scans = tour(3)
    document = report(compare(extractors, scans), extractors, scans, source={"source": "x"})
    assert [picture.name for picture in document.pictures] == [
        "evidence",
        "speed",
        "scan-1-direct_hough",
        "scan-2-points",
    ]
    why = "failed at scan 0: ValueError: the sample <is> larger | than the scan"
    assert why in Page(to_html(document)).text
    markdown = to_markdown(document, lambda p: p.name)
    row = next(line for line in markdown.splitlines() if line.startswith("| broken |"))
    assert len(re.findall(r"(?<!\\)\|", row)) == 11
    assert row.endswith(r"the sample \<is\> larger \| than the scan |")


def test_corners_by_evidence_have_a_curve_each_and_a_row_for_each_kind():
    telling = oracle(evidence=lambda chosen: np.array(chosen, float))  # of each, its number
    told = {
        "untold": lf.Pipeline(name="untold", detector=oracle()),
        "told": lf.Pipeline(name="told", detector=telling),
    }
    scans = tour(9)
    comparison = compare(told, scans)
    document = report(comparison, told, scans, source={"source": "x"})
    table = next(b for b in document.blocks if isinstance(b, Table) and b.header[1] == "corners")
    assert table.header == [
        *("extractor", "corners", "all", "best 75 %", "best 50 %", "best 25 %", "best 10 %")
    ]
    untold, no_virtual = table.rows[0], table.rows[3]
    assert untold[:2] == ["untold", "real"]
    assert untold[2].endswith("≥ 0")
    assert untold[3:] == ["-"] * 4
    assert table.rows[2][2].startswith("1.00 of ")
    assert any(cell.endswith("≥ 3") for cell in table.rows[2])
    assert no_virtual == ["told", "virtual", *["-"] * 5]
    texts = [block.text for block in document.blocks if isinstance(block, Paragraph)]
    assert any("From right to left" in text and "--min-evidence" in text for text in texts)


def test_without_poses_the_report_says_so(extractors):
    scans = [lf.LaserScan(angles=s.angles, ranges=s.ranges, range_max=20.0) for s in tour(3)]
    ours = {"direct_hough": extractors["direct_hough"]}
    document = report(compare(ours, scans), ours, scans, source={"source": "x"})
    texts = [block.text for block in document.blocks if isinstance(block, Paragraph)]
    assert any("No two scans in a row have poses" in text for text in texts)
    assert "evidence" not in [picture.name for picture in document.pictures]


def test_markdown_keeps_signs_as_they_are():
    document = Document("a_b _c_", [Paragraph("1 < 2 [x](y) `z` *w* #1"), Code("n", "a_b | c")])
    assert to_markdown(document, str).splitlines() == [
        r"# a_b \_c\_",
        "",
        r"1 \< 2 \[x\](y) \`z\` \*w\* \#1",
        "",
        "n:",
        "",
        "```text",
        "a_b | c",
        "```",
    ]


def test_markdown_sets_pictures_two_abreast():
    pictures = [Picture(f"p{i}", f"c{i}", f"a{i}", PNG) for i in range(3)]
    text = to_markdown(Document("t", [Gallery(pictures)]), lambda picture: f"{picture.name}.png")
    assert text.splitlines()[2:] == [
        "| c0 | c1 |",
        "| --- | --- |",
        "| ![a0](<p0.png>) | ![a1](<p1.png>) |",
        "",
        "| c2 |",
        "| --- |",
        "| ![a2](<p2.png>) |",
    ]


def test_a_scan_without_returns_can_be_drawn(extractors):
    blank = lf.LaserScan(angles=np.linspace(-1, 1, 41), ranges=np.zeros(41))
    ours = {"direct_hough": extractors["direct_hough"]}
    document = report(compare(ours, [blank]), ours, [blank], source={"source": "x"})
    assert document.pictures[-1].caption == "direct_hough: 0 lines, 0 corners"
