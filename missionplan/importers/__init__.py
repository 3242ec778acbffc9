"""From a vehicle's own logs to a data set: `import`.

A reader (`readers`, one a format, with what they share in `sourcefiles`) turns files into a `track`. `legs` cuts a
track into legs between fixes and judges which count, `descents` makes dives of a depth record. `importing` has the
public function: it finds the sources, chooses the reader, and makes the result that is written as a data set with its
report and a starter mission.
"""
