"""Data sets that cannot be, by what is wrong with them: the files of each."""

DIVES = """kind: descent
name: dives
file: rows.csv
noise: {depth: 0.05 m}
runs:
  dive-1: {anchor_wet_weight: 12 N, line_length: 5 m, depth: 24 m}
"""
_DEPTHS = [0.0, 0.0, 1.0, 2.3, 3.6, 4.9, 6.2, 7.5, 8.8, 10.1, 11.4, 12.7, 14.0, 15.3, 16.6, 17.9, 19.0, 19.0]
ROWS = "run,t_s,depth_m\n" + "".join(f"dive-1,{t},{depth}\n" for t, depth in enumerate(_DEPTHS))
TABLE = """kind: summary
name: table
file: rows.csv
runs: {a: {depth: 30 ft}}
"""
VALUES = "run,quantity,value,sd\na,terminal_velocity_m_s,1.25,0.05\na,descent_time_s,9.8,0.2\n"
LEGS = "kind: transit\nname: legs\nfile: rows.csv\n"
_LEG = "{0},{1},{2},0,0,100,0,101,1\n"
LEG_ROWS = "leg,t_start_s,t_end_s,x_start_m,y_start_m,x_dr_m,y_dr_m,x_end_m,y_end_m\n" + "".join(
    _LEG.format(n, 100 * n, 100 * n + 90) for n in range(1, 8)
)

SILLY = {
    "a kind that there is not": (DIVES.replace("descent", "descnt"), ROWS),
    "a key of a run misspelt": (DIVES.replace("depth: 24 m", "dpeth: 24 m"), ROWS),
    "noise in seconds": (DIVES.replace("0.05 m", "0.05 s"), ROWS),
    "a negative noise": (DIVES.replace("0.05 m", "-0.05 m"), ROWS),
    "a weight without a unit": (DIVES.replace("12 N", "12"), ROWS),
    "a column misspelt": (DIVES, ROWS.replace("depth_m", "depht_m")),
    "a dive below the seafloor": (DIVES, ROWS.replace("19.0", "190")),
    "a dive 12 m above the water": (DIVES, ROWS.replace("dive-1,11,12.7", "dive-1,11,-12.7")),
    "a depth in words": (DIVES, ROWS.replace("12.7", "deep")),
    "a time twice": (DIVES, ROWS.replace("dive-1,9,", "dive-1,8,")),
    "a run that is not described": (DIVES, ROWS.replace("dive-1,17,", "dive-2,17,")),
    "a line longer than the water is deep": (DIVES.replace("line_length: 5 m", "line_length: 50 m"), ROWS),
    "a key of a run of a table misspelt": (TABLE.replace("depth: 30 ft", "dpeth: 60 ft"), VALUES),
    "a quantity misspelt": (TABLE, VALUES.replace("terminal_velocity", "terminal_velocty")),
    "a negative standard deviation": (TABLE, VALUES.replace("0.05", "-0.05")),
    "a negative time": (TABLE, VALUES.replace("9.8", "-9.8")),
    "a quantity twice": (TABLE, VALUES + "a,descent_time_s,11,0.2\n"),
    "a leg that ends before it starts": (LEGS, LEG_ROWS.replace("3,300,390", "3,300,290")),
    "no file": (LEGS.replace("rows.csv", "row.csv"), LEG_ROWS),
}


def write(folder, name):
    """Write one of them."""
    settings, rows = SILLY[name]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "dataset.yaml").write_text(settings, encoding="utf-8")
    (folder / "rows.csv").write_text(rows, encoding="utf-8")
    return folder
