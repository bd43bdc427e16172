"""What numpydoc docstrings are read for."""

import pytest

from graphtex.docstrings import section, summary

TEXT = """Do it,
    and well.

    More.

    Parameters
    ----------
    image
        The picture
        of something.

        With a second paragraph.
    width, height : int
        Its size.
    bare

    Returns
    -------
    Image
        Another.
    """


def test_the_summary_is_the_first_paragraph_on_one_line():
    assert summary(TEXT) == "Do it, and well."
    assert summary(None) == summary("") == ""


def test_a_section_gives_its_text_to_each_name():
    found = section(TEXT, "Parameters")
    assert found == {
        "image": "The picture of something. With a second paragraph.",
        "width": "Its size.",
        "height": "Its size.",
        "bare": "",
    }


def test_a_section_ends_where_the_next_begins():
    assert section(TEXT, "Returns") == {"Image": "Another."}


@pytest.mark.parametrize("text", [None, "", "Parameters", "Parameters\n----------"])
def test_no_section_has_no_entries(text):
    assert section(text, "Parameters") == {}
