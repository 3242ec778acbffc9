"""A museum of faults: legs of vehicles and of simulators with a fault and without it, and effects in no catalogue.

Nothing of the package makes the data. `sailing` integrates legs; `faults` has pairs, before a mend and after it, by
recipes whose equations of both sides are written out; `outside` has twenty effects that the catalogue does not name.
"""
