"""Pure functions of SI floats and arrays, with equation, units and source: one physical effect, one function.

Drag and descent: `water`, `drag`, `anchor`, `anchor_remedies`. On the line: `held_line`, `line_statics`. Propulsion:
`propeller`, `propulsion`. Hover and tank: `vehicle_dynamics`, `tunnel_thruster`, `tank`.
"""
