"""Plots of results that draw on given axes: `catalogue` lists them by the kind of result, the modules draw them."""
