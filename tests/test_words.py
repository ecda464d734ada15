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


def test_docstrings_are_prose():
    """Those of a module, a class and a function, in order."""
    code = '"""One."""\nclass A:\n    """Two. Three."""\n    def f(self):\n        "Four."\n'
    text = words.docstrings(code)
    assert [s for p in words.paragraphs(text) for s in words.sentences(p)] == [
        "One.",
        "Two.",
        "Three.",
        "Four.",
    ]


@pytest.mark.parametrize("page", words.PAGES)
def test_pages_read_easily(page):
    """At most 15 words a sentence in the mean and 30 in the longest; 20 is the aim."""
    count = words.counted(words.ROOT / page)
    assert count.mean <= 15.0
    assert count.longer(30) == []
    assert count.banned == []
