"""What an effect says of itself to the operator who has it: its size in a clause, and what to do about it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """How the operator is told that an effect was found, and what to do about it.

    Attributes
    ----------
    positive, negative : str
        Clauses for either sign, with ``{size}``, and ``{at}`` for the moment or threshold from which it acts; a
        parameter that has one sign needs the first alone.
    """

    parameter: str
    """Whose size is told; empty where none is."""
    positive: str
    negative: str = ""
    remedy: str = ""
    """What to do about it."""
    in_percent: bool = False
    """Whether the size is a share, told in per cent."""
    toward: tuple[str, str] | None = None
    """Components east and north, where the size is that of a vector; the clause has ``{direction}`` too."""
    each: float = 1.0
    """Change of what it responds to for which the size is told [its unit]."""
    unit: str = ""
    """Unit of the size that is then told; empty: the parameter's."""
    beyond: float = 0.0
    """What is added to the size before it is told: 1 where nothing is meant by a share of all."""
