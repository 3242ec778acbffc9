"""How examples are changed: keys and values of YAML, cells, rows and columns of CSV, and single bytes of anything."""

import math
from random import Random

NUMBERS = (0, 1, -1, 2.5, 1e-9, 1e9, 1e30, -1e30, 1e300, 1e-300, math.inf, -math.inf, math.nan, 10**40, True)
TEXTS = ("", " ", "0 m", "-1 m", "1e30 s", "1e300 m", "1e-300 m", "nan m", "inf s", "1 m/s", "5 parsec", "1 m m", "<a>",
         "10 kn", "1 kg", "12 N", "1 rad", "20 degC", "\x00", "\x1b[31m", "../x", "/etc/passwd", "a" * 300, "=1+1", "é\u202f",
         "null", "none", "sized", "1:2:3", "2025-01-01", "0x10", "1_000", "--force", "{}", "[", "%s", "\ud7ff", "1 1/0 m")  # fmt: skip
FACTORS = (0.0, -1.0, 1e-6, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e6, 1e12, 1e100)
CELLS = (*TEXTS, "nan", "inf", "-inf", "1e308", "1e-308", "0", "-1", "1,5", '"', "1e5", "NA", "#", "1 2")


def changed_tree(data: object, random: Random) -> object:
    """Change one to four places of a mission or a dataset.yaml, half of the time into what it might well be."""
    if random.random() < 0.5:
        _change_mildly(data, random)
        return data
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        places = list(_places(data))
        if not places:
            return data
        _change(*random.choice(places), random)
    return data


def _places(data: object):
    if isinstance(data, dict | list):
        for key in list(data) if isinstance(data, dict) else range(len(data)):
            yield data, key
            yield from _places(data[key])


def _change_mildly(data: object, random: Random) -> None:
    """Change some quantities by at most half of themselves, or make distributions of them."""
    places = [(parent, key) for parent, key in _places(data) if _number(parent[key]) is not None]
    for parent, key in random.sample(places, min(len(places), random.choice((1, 2, 5)))):
        text = parent[key]
        number, unit = _number(text), text.partition(" ")[2]
        other = f"{number * random.uniform(0.5, 1.5):g} {unit}"
        forms = (other, other, {"mean": text, "sd": f"{abs(number) * 0.2:g} {unit}"}, {"choices": [text, other]})
        parent[key] = random.choice(forms)


def _number(value: object) -> float | None:
    if not isinstance(value, str) or " " not in value:
        return None
    try:
        return float(value.partition(" ")[0])
    except ValueError:
        return None


def _change(parent, key, random: Random) -> None:
    value, kind = parent[key], random.randrange(12)
    if kind == 0:
        del parent[key]
    elif kind == 1:
        parent[key] = random.choice(NUMBERS)
    elif kind == 2:
        parent[key] = random.choice(TEXTS)
    elif kind == 3:
        parent[key] = random.choice((None, [], {}, [value], {"mean": value, "sd": value}, [value] * 50, {"a": value}))
    elif kind == 4 and isinstance(parent, dict):
        parent[random.choice((*TEXTS[8:14], "<x>", "name", str(key) + "s", "kind"))] = parent.pop(key)
    elif kind == 5 and isinstance(value, str):
        parent[key] = _distribution(value, random)
    elif kind == 6 and isinstance(parent, list):
        parent.insert(random.randrange(len(parent) + 1), value)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        parent[key] = value * random.choice(FACTORS) if abs(value) < 1e200 else 1
    elif isinstance(value, str):
        parent[key] = _other_quantity(value, random)
    else:
        parent[key] = random.choice(TEXTS)


def _other_quantity(text: str, random: Random) -> str:
    number, _, unit = text.partition(" ")
    try:
        return f"{float(number) * random.choice(FACTORS):g} {unit}"
    except ValueError:
        return random.choice(TEXTS)


def _distribution(text: str, random: Random) -> object:
    other = _other_quantity(text, random)
    return random.choice((
        {"mean": text, "sd": other},
        {"mean": text, "sd": other, "low": text},
        {"low": text, "high": other},
        {"median": text, "factor": random.choice((*FACTORS, 1.5, 2, 3))},
        {"choices": [text, other]},
        {"mean": text, "sd": text, "low": other, "high": text},
    ))  # fmt: skip


def changed_bytes(content: bytes, random: Random) -> bytes:
    """Flip, cut, repeat or insert bytes."""
    data = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 8))):
        at, kind = random.randrange(len(data) + 1), random.randrange(6)
        if kind == 0:
            del data[at:]
        elif kind == 1:
            data[at:at] = random.choice(
                (b"\x00", b"\xff", b"\t", b"{", b"- ", b": ", b"&a ", b"*a", b"!!int ", b"\n", b"\r", b"<<: ")
            )
        elif kind == 2:
            data[at:at] = data[at : at + random.randrange(1, 200)]
        elif kind == 3:
            del data[at : at + random.randrange(1, 40)]
        elif data and at < len(data):
            data[at] ^= 1 << random.randrange(8)
    return bytes(data)


def changed_table(text: str, random: Random) -> bytes:
    """Change cells, columns or rows of a CSV."""
    rows = [line.split(",") for line in text.splitlines()]
    for _ in range(random.choice((1, 1, 2, 5))):
        kind, at = random.randrange(9), random.randrange(len(rows))
        column = random.randrange(len(rows[0])) if rows[0] else 0
        if kind <= 1 and column < len(rows[at]):
            rows[at][column] = random.choice(CELLS)
        elif kind == 2:
            for row in rows[1:]:
                if column < len(row):
                    row[column] = _scaled(row[column], random.choice(FACTORS))
        elif kind == 3:
            same = random.choice(CELLS)
            for row in rows[1:]:
                if column < len(row):
                    row[column] = same
        elif kind == 4:
            del rows[random.randrange(len(rows)) :]
        elif kind == 5:
            rows.insert(at, list(rows[at]))
        elif kind == 6:
            random.shuffle(rows)
        elif kind == 7:
            for row in rows:
                row[column : column + 1] = row[column : column + 1] * random.choice((0, 2))
        else:
            del rows[1 + random.randrange(5) : len(rows)]
        rows = rows or [[""]]
    return ("\n".join(",".join(row) for row in rows) + "\n").encode("utf-8", "surrogatepass")


def _scaled(cell: str, factor: float) -> str:
    try:
        return f"{float(cell) * factor:g}"
    except ValueError:
        return cell
