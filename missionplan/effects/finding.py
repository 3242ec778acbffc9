"""What an effect says of itself to the operator who has it: its size in a clause, and what to do about it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """How the operator is told that an effect was found, and what to do about it.

    Attributes
    ----------
    parameter : str
        Whose size is told; empty where none is.
    positive, negative : str
        Clauses for either sign, with ``{size}``; a parameter that has one sign needs the first alone.
    remedy : str
        What to do about it.
    in_percent : bool
        Whether the size is a share, told in per cent.
    toward : (str, str)
        Components east and north, where the size is that of a vector; the clause has ``{direction}`` too.
    """

    parameter: str
    positive: str
    negative: str = ""
    remedy: str = ""
    in_percent: bool = False
    toward: tuple[str, str] | None = None
