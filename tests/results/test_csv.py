"""Tables as others open them: a spreadsheet computes nothing."""

import pandas as pd

from missionplan.results import to_csv


def test_text_that_looks_like_a_formula_is_quoted():
    frame = pd.DataFrame({"=name": ["=1+1", "+a", "-b", "@c", "\td", "plain", "-1.5", None], "value": range(-4, 4)})
    assert to_csv(frame).splitlines() == [
        "'=name,value", "'=1+1,-4", "'+a,-3", "'-b,-2", "'@c,-1", "'\td,0", "plain,1", "-1.5,2", ",3",
    ]  # fmt: skip


def test_columns_of_several_types_stay_as_they_are():
    frame = pd.DataFrame({"mixed": pd.Series([1, None, "x", 2.5], dtype=object)})
    assert to_csv(frame) == 'mixed\n1\n""\nx\n2.5\n'
