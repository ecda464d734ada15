"""The count of words, and the prose of the pages: short sentences, without banned words."""

import pytest

from tests.benchmarks import words

TEXT = """---
title: of the file
---
# A heading that does not count

A sentence of `some code` and [a link](address.md)
over two lines. Does Flores et al. (2010) end one? No, Fig. 3 does not.

| a table | does not |
|---|---|

- an item
- 3.5 mm is one word less than four words
<!-- a comment -->
<!-- bench: table -->
Made by a script.
<!-- end -->
```sh
clearance run one.  # Two. Three.
```
![a picture](picture.png)
"""


def test_sentences():
    """Five sentences; code and a number count as a word each, a unit too."""
    count = words.Count(tuple(s for p in words.paragraphs(TEXT) for s in words.sentences(p)))
    assert count.sentences == (
        "A sentence of Code and a link over two lines.",
        "Does Flores et al. (2010) end one?",
        "No, Fig. 3 does not.",
        "an item",
        "3.5 mm is one word less than four words",
    )
    assert count.lengths == [10, 7, 5, 2, 9]
    assert (count.mean, count.longest) == (33 / 5, 10)
    assert count.longer(9) == ["A sentence of Code and a link over two lines."]


def test_banned_words():
    """Verbs of people for code, in any case; not within other words or code."""
    count = words.Count(("It says so.", "Ask it.", "Wholesale foundations.", "Code knows nothing."))
    assert [word for word, _ in count.banned] == ["says", "Ask", "knows"]
    assert words.sentences("`asks` is a name.") == ["Code is a name."]


CODE = '''"""One."""
# ruff: noqa
LAW = 1.0  #: Two.


class A:
    """Three.

    y = a x,   x >= 0
    radius: of the pin [m]; width, depth: of it
        in the plane
    limit: see `b`
    """

    # a comment
    # of two lines
    def f(self):
        "Four. Five."
'''


def test_prose_of_code():
    """Docstrings, then comments; each definition apart; no equation, no pragma."""
    texts = words.docstrings(CODE) + words.comments(CODE)
    assert [s for t in texts for p in words.definitions(t) for s in words.sentences(p)] == [
        "One.",
        "Three.",
        "radius: of the pin [m];",
        "width, depth: of it in the plane",
        "limit: see Code",
        "Four.",
        "Five.",
        "Two.",
        "a comment of two lines",
    ]


def test_an_equation_is_no_sentence():
    """Lines of equations are not counted."""
    assert list(words.definitions("F = k x\nf(x) = 2 for x > 0\nThe force F.")) == ["The force F."]


@pytest.mark.parametrize("page", words.PAGES)
def test_pages_read_easily(page):
    """At most 15 words a sentence in the mean and 30 in the longest; 20 is the aim."""
    count = words.counted(words.ROOT / page)
    assert count.mean <= 15.0
    assert count.longer(30) == []
    assert count.banned == []


def test_docstrings_and_comments_read_easily():
    """The bound of the pages, in each folder; tests may have longer sentences."""
    packages = words.packages()
    assert len(packages) > 20
    assert {k: c.mean for k, c in packages.items() if c.mean > 16.0} == {}
    assert [hit for c in packages.values() for hit in c.banned] == []
    ours = [c for k, c in packages.items() if not k.startswith("tests")]
    assert max(c.mean for c in ours) <= 15.0
    assert [s for c in ours for s in c.longer(30)] == []
