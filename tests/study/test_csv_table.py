"""Rows of tables without a DataFrame."""

import pandas as pd

from varcontact.study.csv_table import as_json, completed, rows_as_json


def test_rows_are_completed_as_a_data_frame_has_them():
    """No entry is NaN; a column with floats, or without an entry, has no whole numbers."""
    rows = [
        {"patch": 1, "outcome": "solved", "Fx": 0, "Fy": 2.5, "elements": 7},
        {"patch": 2, "outcome": "solved", "Fx": -0.1, "Fy": 0, "elements": 9},
        {"patch": 0, "outcome": "refused", "Fx": 1},
    ]
    columns = ("patch", "Fx", "Fy", "elements", "outcome", "Mz")
    table = pd.DataFrame(rows, columns=list(columns))
    filled = completed(rows, columns)
    assert repr(filled) == repr(table.to_dict("records"))
    assert rows_as_json(filled) == as_json(table)
