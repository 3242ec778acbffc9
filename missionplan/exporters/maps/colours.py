"""Colours of what maps show, the same as in the reports' figures (Okabe and Ito's palette)."""

COLOURS = {
    "planned track": "#666666",
    "median track": "#d55e00",
    "sample track": "#56b4e9",
    "arrival circle": "#009e73",
    "mooring circle": "#e69f00",
    "CEP": "#0072b2",
    "mooring ellipse": "#cc79a7",
    "goal": "#222222",
    "waypoint": "#666666",
    "surfacing": "#d55e00",
    "mooring": "#cc79a7",
    "start": "#222222",
    "fix": "#009e73",
    "anchor": "#cc79a7",
    "hover": "#d55e00",
    "search area": "#d55e00",
    "land": "#8c7a3c",
    "keep-out": "#d55e00",
}
"""By kind, as #rrggbb."""
STYLES = ("marker-color", "marker-size", "stroke", "stroke-width", "stroke-opacity", "fill", "fill-opacity")
"""Properties of simplestyle."""
WIDTHS = {"planned track": 2.0, "median track": 3.0, "sample track": 1.0}
"""Of lines in pixels, where not 2."""


def kml_colour(kind: str, alpha: int = 255) -> str:
    """Return the colour of a kind as KML writes it: alpha, blue, green, red."""
    red, green, blue = COLOURS[kind][1:3], COLOURS[kind][3:5], COLOURS[kind][5:7]
    return f"{alpha:02x}{blue}{green}{red}"


def simplestyle(kind: str, geometry: str) -> dict[str, object]:
    """Return the properties by which GeoJSON viewers colour a feature (simplestyle 1.1)."""
    if geometry == "Point":
        return {"marker-color": COLOURS[kind], "marker-size": "small"}
    style: dict[str, object] = {"stroke": COLOURS[kind], "stroke-width": WIDTHS.get(kind, 2.0)}
    if kind == "sample track":
        style["stroke-opacity"] = 0.4
    return style if geometry != "Polygon" else {**style, "fill": COLOURS[kind], "fill-opacity": 0.05}
