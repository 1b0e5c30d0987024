"""Results in a notebook: tables in which whatever a file says is text."""

import dataclasses
from html.parser import HTMLParser

import pytest

import loopelastica as le
from loopelastica._files import data_path
from loopelastica._html import html_line, html_table

HAIRPIN = data_path("hairpins/2koc.pdb")
EVIL = "<script>alert('x')</script>&"


class _Reader(HTMLParser):
    """Tags that are open, cells of each row, all text."""

    def __init__(self):
        super().__init__()
        self.open, self.rows, self.text, self.tags = [], [], "", set()

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)
        self.tags.add(tag)
        if tag == "tr":
            self.rows.append(0)
        elif tag in ("td", "th"):
            self.rows[-1] += 1

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def read(html):
    reader = _Reader()
    reader.feed(html)
    assert reader.open == []
    return reader


def test_text_stays_text():
    reader = read(html_table(EVIL, [EVIL, "b"], [[EVIL, None], [1, 2.5]]) + html_line(EVIL))
    assert reader.tags == {"table", "caption", "tr", "th", "td", "p"}
    assert reader.text.count(EVIL) == 4
    assert reader.rows == [2, 2, 2]


@pytest.fixture(scope="module")
def folds():
    return le.fold(HAIRPIN, all_models=False, shapes="rod")


@pytest.fixture(scope="module")
def results(folds):
    clamping = le.Clamping.from_parameters([-0.4, -0.1, 0.5, 4.8, 1.4, 2.2])
    (loop,) = le.scan(HAIRPIN, extend_5_max=0, extend_3_max=0)
    return {
        "folds": (folds, len(folds[0].candidates)),
        "hairpins": (le.find_hairpins(HAIRPIN), 1),
        "scan": (loop, len(loop.candidates)),
        "built": (le.build("GGC(GAA)GCC", rna=False, candidates=2), 2),
        "equilibria": (le.equilibria(clamping, energy_max=30), 3),
    }


@pytest.mark.parametrize("kind", ["folds", "hairpins", "scan", "built", "equilibria"])
def test_a_result_is_a_table_with_a_row_for_each_of_its_parts(results, kind):
    result, n = results[kind]
    reader = read(result._repr_html_())
    assert len(reader.rows) == n + 1
    assert len(set(reader.rows)) == 1


def test_names_of_a_file_are_no_tags(folds):
    (loop,) = folds
    hairpin = dataclasses.replace(loop.hairpin, name=EVIL, closing_pair=(EVIL, EVIL))
    odd = dataclasses.replace(loop, hairpin=hairpin)
    failed = dataclasses.replace(odd, candidates=(), failure=EVIL)
    scan = le.LoopScan(hairpin, (), failure=EVIL)
    for result in (odd, failed, le.Folds([odd, failed]), scan):
        reader = read(result._repr_html_())
        assert "script" not in reader.tags
        assert EVIL in reader.text


def test_no_loops_are_a_sentence():
    assert read(le.Folds()._repr_html_()).text == "no hairpin loop"
